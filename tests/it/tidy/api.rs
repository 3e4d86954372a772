//! What the library hands on: `docs/api.txt` lists it, and a difference in that file is a change of
//! the public interface, to be weighed as one.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use expect_test::expect_file;

use super::lexer::without_text;
use super::root;

const HEAD: &str = "\
# The modules of src/lib.rs with their public items, and the public members of types. Written from
# the sources by UPDATE_EXPECT=1 cargo test --test it api. Left out: what macros expand to, trait
# implementations, signatures.
";

/// What an item may be.
const KINDS: [&str; 8] = ["struct", "enum", "trait", "fn", "const fn", "const", "static", "type"];

#[test]
fn the_public_interface_is_the_one_on_record() {
    let mut listing = Listing::default();
    let source = Source::read(&root().join("src/lib.rs"));
    source.uses("", &mut |module, path| listing.add(module, path));
    let mut text = HEAD.to_owned();
    for (module, items) in &listing.modules {
        text += &format!("\n{module}\n");
        items.iter().for_each(|item| text += &format!("  {item}\n"));
    }
    assert!(listing.modules.contains_key("run") && listing.modules.len() > 50, "modules are read");
    expect_file![root().join("docs/api.txt")].assert_eq(&text);
}

/// A source file whose items begin lines, as rustfmt has it.
struct Source {
    path: PathBuf,
    lines: Vec<String>,
}

impl Source {
    fn of_crate(folder: &str) -> Source {
        Source::read(&root().join(format!("crates/{folder}/src/lib.rs")))
    }

    fn read(path: &Path) -> Source {
        let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let lines = without_text(&text).lines().map(|line| line.trim_end().to_owned()).collect();
        Source { path: path.to_owned(), lines }
    }

    /// Where its modules are.
    fn folder(&self) -> PathBuf {
        let is_root = self.path.ends_with("lib.rs");
        if is_root { self.path.with_file_name("") } else { self.path.with_extension("") }
    }

    /// The file of a module of it, public or not.
    fn module(&self, name: &str) -> Option<Source> {
        let path = self.folder().join(name).with_extension("rs");
        path.exists().then(|| Source::read(&path))
    }

    /// Every path that is handed on, with the module in whose braces that is; hidden ones are not.
    fn uses(&self, at: &str, found: &mut dyn FnMut(&str, &str)) {
        let (mut module, mut statement, mut is_hidden) = (vec![at], None::<String>, false);
        for line in self.lines.iter().map(|line| line.trim()) {
            if let Some(whole) = &mut statement {
                *whole += line;
            } else if let Some(rest) = line.strip_prefix("pub use ") {
                statement = Some(rest.to_owned());
            } else if let Some(name) = line.strip_prefix("pub mod ") {
                module.extend(name.strip_suffix(" {"));
            } else if line == "}" && module.len() > 1 {
                module.pop();
            }
            match statement.take() {
                Some(whole) if !whole.ends_with(';') => statement = Some(whole),
                Some(whole) if !is_hidden => {
                    let module: Vec<&str> =
                        module.iter().copied().filter(|m| !m.is_empty()).collect();
                    expand("", whole.trim_end_matches(';'), &mut |path| {
                        found(&module.join("::"), path);
                    });
                }
                _ => {}
            }
            let goes_on = statement.is_some() || line.starts_with("#[");
            is_hidden = goes_on && (is_hidden || line == "#[doc(hidden)]");
        }
    }

    /// The item that a path in this file leads to, through what other files hand on. Modules, and
    /// what gets another name, are none.
    fn find(&self, path: &str) -> Option<String> {
        let (first, rest) = path.split_once("::").unwrap_or(("", path));
        match first.strip_prefix("powergs_") {
            Some(folder) => return Source::of_crate(folder).find(rest),
            None if first.is_empty() && path == "*" => return None,
            None if first.is_empty() => {}
            None if first == "self" => return self.find(rest),
            None if first == "crate" => {
                let is_root = |path: &&Path| path.ends_with("src");
                let src = self.path.ancestors().find(is_root).expect("the sources of a crate");
                return Source::read(&src.join("lib.rs")).find(rest);
            }
            None => return self.module(first)?.find(rest),
        }
        self.item(path).or_else(|| {
            let mut used = Vec::new();
            self.uses("", &mut |_, inner| used.push(inner.to_owned()));
            let end = format!("::{path}");
            self.find(used.iter().find(|inner| inner.ends_with(&end))?)
        })
    }

    /// The kind of a public item, and the public members of its blocks.
    fn item(&self, name: &str) -> Option<String> {
        let is_end = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric() && c != '_');
        let begins = |line: &str, start: &str| {
            line.strip_prefix(start).is_some_and(|rest| is_end(rest.chars().next()))
        };
        let kind = KINDS.iter().find(|kind| {
            self.lines.iter().any(|line| begins(line, &format!("pub {kind} {name}")))
        })?;
        let mut members = BTreeSet::new();
        let mut block = "";
        for line in &self.lines {
            let is_own = ["pub struct", "pub enum", "pub trait"]
                .iter()
                .any(|kind| begins(line, &format!("{kind} {name}")));
            let is_impl = line.starts_with("impl")
                && !line.contains(" for ")
                && line.split([' ', '<', '>']).any(|word| word == name);
            if is_own || is_impl {
                block = if is_impl { "impl" } else { kind };
            } else if line == "}" {
                block = "";
            }
            let Some(inner) = line.strip_prefix("    ").filter(|l| !l.starts_with(' ')) else {
                continue;
            };
            let member = match block {
                "struct" | "impl" => inner.strip_prefix("pub "),
                "enum" => Some(inner).filter(|l| l.starts_with(char::is_uppercase)),
                "trait" => Some(inner).filter(|l| l.starts_with("fn ") || l.starts_with("const ")),
                _ => None,
            };
            let words = member.iter().flat_map(|member| member.split([' ', '(', '<', ':', ',']));
            let mut words = words.filter(|word| !["fn", "const", ""].contains(word));
            members.extend(words.next().map(str::to_owned));
        }
        let members: Vec<String> = members.into_iter().collect();
        let colon = if members.is_empty() { "" } else { ": " };
        Some(format!("{kind} {name}{colon}{}", members.join(", ")))
    }
}

/// All paths of what stands behind `use`.
fn expand(before: &str, tree: &str, found: &mut dyn FnMut(&str)) {
    let Some((path, group)) = tree.trim().split_once('{') else {
        return found(&format!("{before}{}", tree.trim()));
    };
    let (mut depth, mut start) = (0, 0);
    let group = group.strip_suffix('}').expect("the end of the group");
    for (i, c) in group.char_indices().chain([(group.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !group[start..i].trim().is_empty() {
                    expand(&format!("{before}{}", path.trim()), &group[start..i], found);
                }
                start = i + 1;
            }
            _ => {}
        }
    }
}

/// Items by the module under which they are reached.
#[derive(Default)]
struct Listing {
    modules: BTreeMap<String, BTreeSet<String>>,
}

impl Listing {
    /// Adds what `path` leads to, to `module` of the facade.
    fn add(&mut self, module: &str, path: &str) {
        let (path, name) = path.split_once(" as ").unwrap_or((path, ""));
        let (start, rest) = path.split_once("::").unwrap_or((path, ""));
        let folder = start.strip_prefix("powergs_").expect("a crate of ours");
        self.follow(module, &Source::of_crate(folder), rest, name);
    }

    fn follow(&mut self, module: &str, source: &Source, path: &str, name: &str) {
        let (first, rest) = path.split_once("::").unwrap_or((path, ""));
        let name = if name.is_empty() { path.rsplit("::").next().unwrap_or("") } else { name };
        let below = [module, name].iter().filter(|m| !m.is_empty()).copied().collect::<Vec<_>>();
        match (first, source.module(first)) {
            ("*", _) => self.whole(module, source),
            ("", _) => self.whole(&below.join("::"), source),
            (_, Some(inner)) => self.follow(module, &inner, rest, name),
            (_, None) => {
                let items = self.modules.entry(module.to_owned()).or_default();
                items.insert(source.find(path).unwrap_or_else(|| format!("use {path}")));
            }
        }
    }

    /// Every public item of a file, and of its public modules.
    fn whole(&mut self, module: &str, source: &Source) {
        let items = self.modules.entry(module.to_owned()).or_default();
        for line in source.lines.iter().filter_map(|line| line.strip_prefix("pub ")) {
            let name = line
                .split([' ', '(', '<', ':', ';', '='])
                .find(|word| !KINDS.iter().any(|kind| kind.split(' ').any(|kind| kind == *word)));
            items.extend(name.and_then(|name| source.item(name)));
        }
        let public = source.lines.iter().filter_map(|line| line.strip_prefix("pub mod "));
        for name in public.filter_map(|name| name.strip_suffix(';')) {
            let inner = source.module(name).unwrap_or_else(|| panic!("{module}: no file {name}"));
            self.whole(&format!("{module}::{name}"), &inner);
        }
        let mut used = Vec::new();
        source.uses("", &mut |_, path| used.push(path.to_owned()));
        for path in used {
            let item = source.find(&path).unwrap_or_else(|| format!("use {path}"));
            self.modules.entry(module.to_owned()).or_default().insert(item);
        }
    }
}
