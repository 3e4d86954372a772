//! Files that say only what differs from another one: `base = "NAME"`.
//!
//! A file with a base is put on the text of that base, statement by statement, comments and all.
//! What comes out is one complete text: every reader of configurations takes it as any other. Lines
//! know where they stand by comments like `#line 12 gscore`: the next line is line 12 of `gscore`,
//! the ones after it follow. [`Place`] reads them, so that errors name the file and the line in
//! which a value was written.
//!
//! The rules: a value takes the place of that of the base; tables are merged key by key, inline
//! ones too; lists are replaced whole. `name` and `description` are never those of the base. A
//! table that is set to `"none"` is absent.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::Embedded;
use super::error::{ConfigError, Place, Problem};
use super::suggest::nearest;

/// The key that names the base of a file.
pub const BASE: &str = "base";

/// What a table is set to that a base has and a machine has not.
pub const NONE: &str = "none";

/// Bases of bases at most.
pub const DEPTH_MAX: usize = 8;

/// Keys and heads of a file that is merged: the time grows with their square.
const STATEMENTS_MAX: usize = 2000;

/// The beginning of a comment that says where the next line stands.
pub(super) const LINE: &str = "#line ";

/// What a file is, in one line; of a file that does not say it, what it is based on.
const DESCRIPTION: &str = "description";

/// Keys that a file has for itself.
const OWN: [&str; 2] = ["name", DESCRIPTION];

/// The base that a text names; `None` where it has none, or is no TOML: its reader says so.
pub fn base_of(text: &str) -> Option<String> {
    // Most files have none, and a parse of each would cost more than the search.
    if !text.contains(BASE) {
        return None;
    }
    let table = DeTable::parse(text).ok()?;
    table.get_ref().get(BASE)?.get_ref().as_str().map(str::to_owned)
}

/// A text on those that come with the program; any other text as it is.
///
/// # Errors
/// A base that is not among them, or goes round in a circle.
pub fn on_embedded(text: &str, files: &[Embedded]) -> Result<String, ConfigError> {
    let Some(base) = base_of(text) else { return Ok(text.to_owned()) };
    let wrong = |message: String| {
        let line = text.lines().scan(0, |at, line| {
            let start = *at;
            *at += line.len() + 1;
            Some((start, line))
        });
        let mut own = line.filter(|(_, line)| line.trim_start().starts_with(BASE));
        let (start, line) = own.next().unwrap_or((0, ""));
        let place = Place::of(text, start..start + line.len());
        ConfigError::new(vec![Problem { place, key: BASE.to_owned(), message }])
    };
    let mut chain: Vec<Embedded> = Vec::new();
    let mut next = Some(base);
    while let Some(name) = next {
        let found = files.iter().find(|file| file.name == name);
        let file = found.ok_or_else(|| {
            let near = nearest(&name, files.iter().map(|file| file.name));
            let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            wrong(format!("`{BASE}` = \"{name}\" does not come with the program{near}"))
        })?;
        if chain.len() == DEPTH_MAX || chain.iter().any(|known| known.name == name) {
            return Err(wrong(circle(chain.iter().map(|file| file.name), &name)));
        }
        next = base_of(file.text);
        chain.push(*file);
    }
    let mut whole = String::new();
    for (i, file) in chain.iter().enumerate().rev() {
        whole = match chain.get(i + 1) {
            None => file.text.to_owned(),
            Some(base) => on(base.name, &whole, file.name, file.text).map_err(wrong)?,
        };
    }
    on(chain[0].name, &whole, "", text).map_err(wrong)
}

/// What is wrong with a chain of bases that comes back to `again`.
pub fn circle<'a>(chain: impl Iterator<Item = &'a str>, again: &'a str) -> String {
    let chain: Vec<&str> = chain.chain([again]).collect();
    format!("`{BASE}` goes round in a circle: {}", chain.join(" -> "))
}

/// The text of `over`, found at `at`, on that of its base; each may be complete or have lines of
/// other files in it. An `over` that is no TOML is left to its reader.
///
/// # Errors
/// A base that is no TOML, or files with more keys than are merged.
pub fn on(base_at: &str, base: &str, at: &str, over: &str) -> Result<String, String> {
    let Ok(parsed) = DeTable::parse(over) else { return Ok(over.to_owned()) };
    let below = DeTable::parse(base).map_err(|e| {
        let place = Place::of(base, e.span().unwrap_or(0..0));
        let line = place.line().map_or(String::new(), |line| format!("line {line} of "));
        format!("{line}{base_at}: not valid TOML: {}", e.message())
    })?;
    let below = Statements::of(base_at, base, below.get_ref());
    let above = Statements::of(at, over, parsed.get_ref());
    for (at, statements) in [(base_at, &below), (at, &above)] {
        if statements.all.len() > STATEMENTS_MAX {
            let at = if at.is_empty() { "the file" } else { at };
            return Err(format!("{at} has more than {STATEMENTS_MAX} keys: too many for `{BASE}`"));
        }
    }
    Ok(below.with(above).text())
}

/// The text without the keys and tables that `is_out`, with their comments. What is no TOML stays.
pub fn without(text: &str, is_out: impl Fn(&str) -> bool) -> String {
    let Ok(parsed) = DeTable::parse(text) else { return text.to_owned() };
    let mut statements = Statements::of("", text, parsed.get_ref());
    statements.all.retain(|statement| !is_out(&statement.path().join(".")));
    without_places(&statements.text())
}

/// The text with the keys of `more`, each in its table. What is no TOML stays.
pub fn plus(text: &str, more: &str) -> String {
    let (Ok(parsed), Ok(keys)) = (DeTable::parse(text), DeTable::parse(more)) else {
        return text.to_owned();
    };
    let mut statements = Statements::of("", text, parsed.get_ref());
    for statement in Statements::of("", more, keys.get_ref()).all {
        statements.put(statement);
    }
    without_places(&statements.text())
}

/// A key with its value, or the head of a table, with the comments above it.
#[derive(Debug, Clone)]
struct Statement {
    /// The comments above, and the statement itself.
    lines: Vec<LayerLine>,
    /// Where the table is that it stands in.
    table: Vec<String>,
    kind: LayerKind,
}

#[derive(Debug, Clone)]
enum LayerKind {
    /// `[a.b]` or `[[a.b]]`.
    Head,
    /// A key below `table`, with dots where it has some.
    Value(Vec<String>, Tree),
}

/// A value as it is written; inline tables key by key.
#[derive(Debug, Clone)]
enum Tree {
    Leaf(String),
    Table(Vec<(String, Tree)>),
}

/// A line and where it was written.
#[derive(Debug, Clone)]
struct LayerLine {
    text: String,
    file: String,
    number: usize,
}

/// A file as statements.
struct Statements {
    /// Comments at the top.
    head: Vec<LayerLine>,
    all: Vec<Statement>,
}

impl Tree {
    fn of(value: &Spanned<DeValue<'_>>, text: &str) -> Tree {
        match value.get_ref() {
            DeValue::Table(table) => Tree::Table(
                table.iter().map(|(k, v)| (k.get_ref().to_string(), Tree::of(v, text))).collect(),
            ),
            _ => Tree::Leaf(text[value.span()].to_owned()),
        }
    }

    /// Puts `other` on it.
    fn take(&mut self, other: Tree) {
        match (self, other) {
            (Tree::Table(mine), Tree::Table(theirs)) => {
                for (key, value) in theirs {
                    match mine.iter_mut().find(|(known, _)| *known == key) {
                        Some((_, old)) => old.take(value),
                        None => mine.push((key, value)),
                    }
                }
            }
            (mine, other) => *mine = other,
        }
    }

    fn text(&self) -> String {
        match self {
            Tree::Leaf(text) => text.clone(),
            Tree::Table(keys) if keys.is_empty() => "{}".to_owned(),
            Tree::Table(keys) => {
                let key =
                    |(key, value): &(String, Tree)| format!("{} = {}", quoted(key), value.text());
                format!("{{ {} }}", keys.iter().map(key).collect::<Vec<_>>().join(", "))
            }
        }
    }

    fn is_none(&self) -> bool {
        matches!(self, Tree::Leaf(text) if text.trim_matches(['"', '\'']) == NONE)
    }
}

/// A key as it is written.
fn quoted(key: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    if !key.is_empty() && key.chars().all(is_bare) { key.to_owned() } else { format!("{key:?}") }
}

impl Statements {
    fn of(at: &str, text: &str, parsed: &DeTable<'_>) -> Statements {
        let lines = numbered(at, text);
        let starts: Vec<usize> = text
            .split_inclusive('\n')
            .scan(0, |at, line| Some(std::mem::replace(at, *at + line.len())))
            .collect();
        let line_of = |byte: usize| starts.partition_point(|start| *start <= byte) - 1;
        let mut values: BTreeMap<usize, (usize, Vec<String>, Tree)> = BTreeMap::new();
        collect(parsed, &[], text, &mut |range, path, tree| {
            let end = line_of(range.end.max(1) - 1);
            values.insert(line_of(range.start), (end, path, tree));
        });
        let mut statements = Statements { head: Vec::new(), all: Vec::new() };
        let (mut table, mut before, mut i) = (Vec::new(), Vec::new(), 0);
        while i < lines.len() {
            let (end, kind) = match values.remove(&i) {
                Some((end, path, tree)) => {
                    // A key of another table than that of the last head cannot be.
                    let own = path.strip_prefix(&table[..]).unwrap_or(&path);
                    (end, LayerKind::Value(own.to_vec(), tree))
                }
                None => match head_of(&lines[i].text) {
                    Some(path) => {
                        table = path;
                        (i, LayerKind::Head)
                    }
                    None => {
                        before.extend((!is_directive(&lines[i])).then(|| lines[i].clone()));
                        i += 1;
                        continue;
                    }
                },
            };
            if statements.all.is_empty() {
                // Comments up to the last empty line are of the file, not of its first key.
                let own = before.iter().rposition(|l: &LayerLine| l.text.trim().is_empty());
                statements.head = before.drain(..own.map_or(0, |i| i + 1)).collect();
            }
            before.extend(lines[i..=end].iter().cloned());
            let lines = std::mem::take(&mut before);
            statements.all.push(Statement { lines, table: table.clone(), kind });
            i = end + 1;
        }
        statements
    }

    /// Those of `above` on these.
    fn with(mut self, above: Statements) -> Statements {
        self.head = above.head;
        let is_own = |s: &Statement| match &s.kind {
            LayerKind::Value(key, _) => {
                s.table.is_empty() && key.len() == 1 && OWN.contains(&key[0].as_str())
            }
            LayerKind::Head => false,
        };
        self.all.retain(|s| !is_own(s));
        let is_described = above.all.iter().any(|s| is_own(s) && s.path() == [DESCRIPTION]);
        let base =
            above.all.iter().find(|s| s.path() == [BASE]).map(Statement::description_by_base);
        if let Some(line) = base.filter(|_| !is_described) {
            let kind = LayerKind::Value(vec![DESCRIPTION.to_owned()], Tree::Leaf(String::new()));
            self.all.insert(0, Statement { lines: vec![line], table: Vec::new(), kind });
        }
        // Lists of tables are replaced whole.
        let lists: BTreeSet<Vec<String>> =
            above.all.iter().filter(|s| s.is_list()).map(|s| s.table.clone()).collect();
        self.all.retain(|s| !lists.iter().any(|list| s.is_in(list) || s.path() == *list));
        let mut first = 0;
        for statement in above.all {
            let path = statement.path();
            match &statement.kind {
                LayerKind::Value(key, _) if statement.table.is_empty() && key[0] == BASE => {}
                LayerKind::Value(..) if is_own(&statement) => {
                    self.all.insert(first, statement);
                    first += 1;
                }
                LayerKind::Head if statement.is_list() => self.all.push(statement),
                LayerKind::Head => {
                    // The base may have the table, or write it on one line.
                    let has = |s: &Statement| {
                        s.is_in(&path)
                            || matches!(s.kind, LayerKind::Value(..)) && path.starts_with(&s.path())
                    };
                    if !self.all.iter().any(has) {
                        self.all.push(statement);
                    }
                }
                LayerKind::Value(..)
                    if lists.iter().any(|list| statement.table.starts_with(list)) =>
                {
                    self.all.push(statement);
                }
                LayerKind::Value(_, tree) if tree.is_none() && self.has_table(&path) => {
                    self.all.retain(|s| !s.is_in(&path) && s.path() != path);
                }
                LayerKind::Value(..) => self.put(statement),
            }
        }
        self
    }

    fn has_table(&self, path: &[String]) -> bool {
        self.all.iter().any(|s| s.is_in(path))
            || self
                .all
                .iter()
                .any(|s| s.path() == path && matches!(s.kind, LayerKind::Value(_, Tree::Table(_))))
    }

    /// Puts a value where the base has it, or at the end of its table.
    fn put(&mut self, statement: Statement) {
        let path = statement.path();
        let LayerKind::Value(_, tree) = &statement.kind else { return };
        // A table that the base writes with a head takes the keys one by one.
        if let Tree::Table(keys) = tree
            && self.all.iter().any(|s| s.is_in(&path))
        {
            for (key, tree) in keys {
                let key = vec![key.clone()];
                let one = statement.of_key(path.clone(), key, tree.clone());
                self.put(one);
            }
            return;
        }
        // A value, or a list on one line, in the place of a table or of tables with heads.
        if matches!(tree, Tree::Leaf(_)) {
            self.all.retain(|s| !s.is_in(&path));
        }
        // The base may have it, or an inline table that it is in.
        let holder = self
            .all
            .iter()
            .position(|s| matches!(s.kind, LayerKind::Value(..)) && path.starts_with(&s.path()));
        if let Some(i) = holder {
            let old = &mut self.all[i];
            let inner = path[old.path().len()..].to_vec();
            let LayerKind::Value(key, mut whole) = old.kind.clone() else { return };
            let nested = inner
                .into_iter()
                .rev()
                .fold(tree.clone(), |tree, key| Tree::Table(vec![(key, tree)]));
            whole.take(nested);
            let table = old.table.clone();
            *old = statement.of_key(table, key, whole);
            return;
        }
        // The last statement of the innermost table that is there.
        let known = |n: usize| self.all.iter().rposition(|s| s.table == path[..n]);
        let found = (0..path.len()).rev().find_map(|n| Some((n, known(n)?)));
        match found {
            Some((n, i)) => {
                let (table, key) = (path[..n].to_vec(), path[n..].to_vec());
                self.all.insert(i + 1, statement.of_key(table, key, tree.clone()));
            }
            None => {
                let one = statement.of_key(Vec::new(), path, tree.clone());
                self.all.insert(0, one);
            }
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        // Where the next line would be, if it followed.
        let mut at: Option<(&str, usize)> = None;
        let lines = self.head.iter().chain(self.all.iter().flat_map(|s| &s.lines));
        for line in lines {
            if at != Some((line.file.as_str(), line.number)) {
                // A path may have what no comment may.
                let file: String = line.file.chars().filter(|c| !c.is_control()).collect();
                text.push_str(&format!("{LINE}{} {file}\n", line.number));
            }
            text.push_str(&line.text);
            text.push('\n');
            at = Some((&line.file, line.number + 1));
        }
        text
    }
}

impl Statement {
    /// The table of a head, or the whole key of a value.
    fn path(&self) -> Vec<String> {
        match &self.kind {
            LayerKind::Head => self.table.clone(),
            LayerKind::Value(key, _) => [&self.table[..], &key[..]].concat(),
        }
    }

    /// The description of a file that says only what it is based on.
    fn description_by_base(&self) -> LayerLine {
        let base = match &self.kind {
            LayerKind::Value(_, tree) => tree.text(),
            LayerKind::Head => String::new(),
        };
        // A path may have what a text in quotes may not.
        let plain = |c: &char| c.is_alphanumeric() || "-_./ ".contains(*c);
        let base: String = base.chars().filter(plain).collect();
        let text = format!("{DESCRIPTION} = \"on {base}\"");
        let (file, number) = self
            .lines
            .last()
            .map_or_else(Default::default, |line| (line.file.clone(), line.number));
        LayerLine { text, file, number }
    }

    fn is_list(&self) -> bool {
        let last = self.lines.last().map_or("", |line| line.text.trim_start());
        matches!(self.kind, LayerKind::Head) && last.starts_with("[[")
    }

    /// Whether it stands in the table at `path`, or is its head.
    fn is_in(&self, path: &[String]) -> bool {
        !path.is_empty() && self.table.starts_with(path)
    }

    /// A value at the place of this one, with its comments.
    fn of_key(&self, table: Vec<String>, key: Vec<String>, tree: Tree) -> Statement {
        let is_whole = matches!(&self.kind, LayerKind::Value(old, value)
            if *old == key && value.text() == tree.text());
        if is_whole {
            return Statement { table, ..self.clone() };
        }
        let above = self.lines.iter().take_while(|l| is_comment(&l.text)).count();
        let mut lines = self.lines[..above].to_vec();
        let names: Vec<String> = key.iter().map(|key| quoted(key)).collect();
        let mut text = format!("{} = {}", names.join("."), tree.text());
        if let Some(comment) = self.comment() {
            text = format!("{text:<32} {comment}");
        }
        let first = &self.lines[above.min(self.lines.len() - 1)];
        lines.extend(text.lines().enumerate().map(|(i, line)| LayerLine {
            text: line.to_owned(),
            file: first.file.clone(),
            number: first.number + i,
        }));
        Statement { lines, table, kind: LayerKind::Value(key, tree) }
    }

    /// The comment behind it.
    fn comment(&self) -> Option<String> {
        let line = &self.lines.last()?.text;
        // A `#` in a text is none.
        let mut quote = None;
        for (i, c) in line.char_indices() {
            match (quote, c) {
                (Some(open), _) if c == open => quote = None,
                (Some(_), _) => {}
                (None, '"' | '\'') => quote = Some(c),
                (None, '#') => return Some(line[i..].to_owned()),
                (None, _) => {}
            }
        }
        None
    }
}

fn is_comment(line: &str) -> bool {
    line.trim().is_empty() || line.trim_start().starts_with('#')
}

/// The path of `[a.b]` or `[[a.b]]`.
fn head_of(line: &str) -> Option<Vec<String>> {
    let line = line.trim_start();
    if !line.starts_with('[') {
        return None;
    }
    let table = DeTable::parse(line).ok()?;
    let mut path = Vec::new();
    let mut at = table.get_ref();
    loop {
        let (key, value) = at.iter().next()?;
        path.push(key.get_ref().to_string());
        at = match value.get_ref() {
            DeValue::Table(table) if !table.is_empty() => table,
            DeValue::Array(items) => match items.iter().next()?.get_ref() {
                DeValue::Table(table) if !table.is_empty() => table,
                _ => return Some(path),
            },
            _ => return Some(path),
        };
    }
}

/// Hands on every value that is written with a key of its own: from its key to its end, its whole
/// path, and what it is.
fn collect(
    table: &DeTable<'_>,
    path: &[String],
    text: &str,
    each: &mut impl FnMut(Range<usize>, Vec<String>, Tree),
) {
    for (key, value) in table.iter() {
        let full = [path, &[key.get_ref().to_string()]].concat();
        let written = text.get(value.span()).unwrap_or_default();
        match value.get_ref() {
            DeValue::Table(inner) if !written.starts_with('{') => {
                collect(inner, &full, text, each);
            }
            DeValue::Array(items) if written.starts_with("[[") && is_list(items, text) => {
                let tables = items.iter().filter_map(|item| item.get_ref().as_table());
                tables.for_each(|inner| collect(inner, &full, text, each));
            }
            _ => each(key.span().start..value.span().end, full, Tree::of(value, text)),
        }
    }
}

/// Whether a list is written as tables with heads.
fn is_list(items: &DeArray<'_>, text: &str) -> bool {
    items.iter().all(|item| {
        matches!(item.get_ref(), DeValue::Table(_))
            && text.get(item.span()).is_none_or(|t| !t.starts_with('{'))
    })
}

/// The lines of a text with the places that they were written at.
fn numbered(at: &str, text: &str) -> Vec<LayerLine> {
    let (mut file, mut number) = (at.to_owned(), 1);
    text.lines()
        .map(|line| {
            if let Some((n, name)) = directive(line) {
                // Without a name it is the file that is read here.
                let name = if name.is_empty() { at } else { name };
                (file, number) = (name.to_owned(), n);
                return LayerLine { text: line.to_owned(), file: file.clone(), number };
            }
            let line = LayerLine { text: line.to_owned(), file: file.clone(), number };
            number += 1;
            line
        })
        .collect()
}

/// The text without what says where its lines stand.
pub fn without_places(text: &str) -> String {
    let lines = text.split_inclusive('\n').filter(|line| !line.starts_with(LINE));
    lines.collect()
}

fn is_directive(line: &LayerLine) -> bool {
    line.text.starts_with(LINE)
}

/// What a `#line` comment says. Anybody may write one: lines beyond `u32` are none.
pub(super) fn directive(line: &str) -> Option<(usize, &str)> {
    let (number, name) = line.strip_prefix(LINE)?.split_once(' ')?;
    Some((number.parse::<u32>().ok()? as usize, name))
}
