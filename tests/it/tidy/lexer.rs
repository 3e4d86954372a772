//! Just enough of Rust's grammar to look at code without its comments and strings.

/// `text` with comments and the contents of strings and characters blanked; lines stay in place.
pub fn without_text(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = token(rest, out.chars().next_back());
        if length == 0 {
            out.push(c);
            rest = &rest[c.len_utf8()..];
        } else {
            // A blanked token still separates its neighbours.
            out.push(' ');
            out.extend(rest[..length].chars().filter(|c| *c == '\n'));
            rest = &rest[length..];
        }
    }
    out
}

/// Length of the comment, string or character that `rest` begins with, or 0.
fn token(rest: &str, before: Option<char>) -> usize {
    if rest.starts_with("//") {
        return rest.find('\n').unwrap_or(rest.len());
    }
    if rest.starts_with("/*") {
        return rest.find("*/").map_or(rest.len(), |end| end + 2);
    }
    if rest.starts_with('"') {
        return string(rest);
    }
    let in_word = before.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let raw = rest.strip_prefix('b').unwrap_or(rest);
    if !in_word && let Some(hashes) = raw.strip_prefix('r') {
        let n = hashes.len() - hashes.trim_start_matches('#').len();
        if hashes[n..].starts_with('"') {
            let end = format!("\"{}", "#".repeat(n));
            let start = rest.len() - hashes.len() + n + 1;
            return rest[start..].find(&end).map_or(rest.len(), |e| start + e + end.len());
        }
    }
    if rest.starts_with('\'') { character(rest) } else { 0 }
}

fn string(rest: &str) -> usize {
    let mut escaped = false;
    for (i, c) in rest.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return i + 1,
            _ => {}
        }
    }
    rest.len()
}

/// `'a'`, `'\n'`, `'\u{1f}'`; a lifetime has length 0.
fn character(rest: &str) -> usize {
    let mut chars = rest.char_indices().skip(1);
    match chars.next() {
        Some((_, '\\')) => rest[2..].find('\'').map_or(0, |end| {
            // `'\''`: the first quote is the escaped one.
            if rest[2..].starts_with('\'') { 4 } else { end + 3 }
        }),
        Some(_) => match chars.next() {
            Some((i, '\'')) => i + 1,
            _ => 0,
        },
        None => 0,
    }
}

/// Name, first line and number of lines of every function with a body.
pub fn functions(code: &str) -> Vec<(String, usize, usize)> {
    let mut found = Vec::new();
    for (start, _) in code.match_indices("fn ") {
        if code[..start].chars().next_back().is_some_and(|c| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let name: String =
            code[start + 3..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let Some(lines) = body_lines(&code[start..]).filter(|_| !name.is_empty()) else { continue };
        found.push((name, code[..start].matches('\n').count() + 1, lines));
    }
    found
}

/// Lines from `fn` to the closing brace; `None` for a declaration without a body.
fn body_lines(code: &str) -> Option<usize> {
    let mut depth = 0;
    let mut brackets = 0;
    for (i, c) in code.char_indices() {
        match c {
            '(' | '[' => brackets += 1,
            ')' | ']' => brackets -= 1,
            ';' if depth == 0 && brackets == 0 => return None,
            '{' => depth += 1,
            '}' => {
                depth -= 1;
                if depth == 0 {
                    return Some(code[..i].matches('\n').count() + 1);
                }
            }
            _ => {}
        }
    }
    None
}

/// The first names of all `crate::` paths, groups included.
pub fn crate_paths(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (start, path) in code.match_indices("crate::") {
        let rest = &code[start + path.len()..];
        let Some(group) = rest.strip_prefix('{') else {
            found.push(first_name(rest));
            continue;
        };
        let mut depth = 0;
        let mut fresh = true;
        for (i, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => fresh = true,
                c if fresh && (c.is_alphanumeric() || c == '_') => {
                    found.push(first_name(&group[i..]));
                    fresh = false;
                }
                _ => {}
            }
        }
    }
    found
}

fn first_name(code: &str) -> String {
    code.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// The names of the types that are declared, whoever sees them.
pub fn types(code: &str) -> Vec<String> {
    let name = |line: &str| {
        let line = line.trim_start();
        let rest = line.strip_prefix("pub").map_or(line, |rest| {
            let inside = rest.strip_prefix('(').and_then(|rest| rest.split_once(')'));
            inside.map_or(rest, |(_, rest)| rest).trim_start()
        });
        let kinds = ["struct ", "enum ", "trait ", "union "];
        kinds.iter().find_map(|kind| rest.strip_prefix(kind)).map(first_name)
    };
    code.lines().filter_map(name).collect()
}

/// Whether `word` is in `line` and not the end of a longer word.
pub fn has_word(line: &str, word: &str) -> bool {
    line.match_indices(word).any(|(i, _)| {
        let before = line[..i].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || c == '_')
    })
}

#[test]
fn comments_strings_and_characters_are_blanked() {
    let text = "a /* x */ \"b\\\"c\" 'd' '\\'' &'life r#\"e\"f\"# g // h\ni";
    let blank = without_text(text);
    let words: Vec<&str> = blank.split_whitespace().collect();
    assert_eq!(words, ["a", "&'life", "g", "i"]);
    assert_eq!(blank.matches('\n').count(), 1);
}

#[test]
fn functions_are_measured() {
    let code = "fn a(x: [u8; 2]) {\n if x { y }\n}\ntrait T { fn b(); }\n";
    assert_eq!(functions(code), [("a".to_owned(), 1, 3)]);
}

#[test]
fn types_are_found() {
    let code =
        "pub struct A<T>(T);\npub(in a::b) struct B;\n  pub enum C {}\nstruct D;\nlet e = 1;\n";
    assert_eq!(types(code), ["A", "B", "C", "D"]);
}

#[test]
fn paths_are_found_in_groups() {
    let code = "use crate::{a::{x, y}, b}; crate::c::f(); pub(crate) fn g() {}";
    assert_eq!(crate_paths(code), ["a", "b", "c"]);
    assert!(has_word("x println!()", "println!") && !has_word("eprintln!()", "println!"));
}
