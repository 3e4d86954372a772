//! The rules of the house, as tests. What compilers and Clippy check is not repeated here.

mod api;
mod crates;
mod lexer;
mod one_build;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use lexer::without_text;

/// A file above this is printed: can it be two?
const MANY_LINES: usize = 400;
/// A function above this is printed.
const MANY_FUNCTION_LINES: usize = 70;
/// A line above this fails, as in rustfmt.toml.
const MOST_COLUMNS: usize = 100;

/// A Rust file of the workspace.
struct Source {
    /// Relative to the root package.
    path: PathBuf,
    text: String,
    /// The text without comments and the contents of strings; same lines.
    code: String,
}

impl Source {
    /// The folder under `crates` or `lab` that the file belongs to; `None` in the root package.
    fn folder(&self) -> Option<&str> {
        let mut parts = self.path.iter().map(|name| name.to_str().expect("a name in UTF-8"));
        let in_crate = matches!(parts.next(), Some("crates" | "lab"));
        if in_crate { parts.next() } else { None }
    }

    /// The path inside the package: `src/…`, `tests/…`.
    fn inside(&self) -> &Path {
        let mut parts = self.path.components();
        if self.folder().is_some() {
            parts.nth(1);
        }
        parts.as_path()
    }

    /// The modules that the file is in, outermost first: `["trace", "codec"]`.
    fn modules(&self) -> Vec<&str> {
        let Ok(path) = self.inside().strip_prefix("src") else { return Vec::new() };
        let names = path.iter().map(|name| name.to_str().expect("a name in UTF-8"));
        names.map(|name| name.trim_end_matches(".rs")).collect()
    }

    /// Whether it is of a program: of this one, or of the laboratory.
    fn is_program(&self) -> bool {
        self.folder().is_none_or(|folder| folder == "powergs-lab")
    }

    /// Whether users get it: neither a test nor the test kit.
    fn is_library(&self) -> bool {
        let library = self.folder().is_some_and(|folder| folder != "testkit");
        library && self.inside().starts_with("src")
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The Rust files of all packages, tests and benches included.
fn sources() -> &'static [Source] {
    static SOURCES: OnceLock<Vec<Source>> = OnceLock::new();
    SOURCES.get_or_init(read_all)
}

fn read_all() -> Vec<Source> {
    let mut paths = Vec::new();
    for folder in
        ["src", "tests", "benches", "examples", "fuzz/fuzz_targets", "crates", "lab", "python/src"]
    {
        collect(&root().join(folder), &mut paths);
    }
    paths.sort();
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("a source file");
        let path = path.strip_prefix(root()).expect("in the workspace").to_owned();
        Source { path, code: without_text(&text), text }
    };
    let sources: Vec<Source> = paths.into_iter().map(read).collect();
    assert!(sources.iter().any(Source::is_library) && sources.iter().any(|s| s.folder().is_none()));
    sources
}

fn collect(folder: &Path, paths: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(&path, paths);
        } else if path.extension().is_some_and(|e| e == "rs") {
            paths.push(path);
        }
    }
}

/// Fails with all findings at once.
#[track_caller]
fn none(findings: Vec<String>) {
    assert!(findings.is_empty(), "\n  {}\n", findings.join("\n  "));
}

/// Sizes are advice: they are shown with `--nocapture` and fail nothing.
#[test]
fn long_files_and_functions_are_named() {
    for source in sources() {
        let path = source.path.display();
        let lines = source.text.lines().count();
        if lines > MANY_LINES {
            eprintln!("{path}: {lines} lines; can it be two files?");
        }
        for (name, first, lines) in lexer::functions(&source.code) {
            if lines > MANY_FUNCTION_LINES && !source.inside().starts_with("tests") {
                eprintln!("{path}:{first}: fn {name} has {lines} lines");
            }
        }
    }
}

/// Types of the house that share their name with another one, at most: such types are hard to talk
/// about and to find.
const SHARED_NAMES: usize = 300;

#[test]
fn few_types_share_a_name() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let is_of_house = |source: &&Source| {
        let in_library = source.is_library() && source.path.starts_with("crates");
        in_library || source.path.starts_with("src")
    };
    for source in sources().iter().filter(is_of_house) {
        for name in lexer::types(&source.code) {
            places.entry(name).or_default().push(source.path.display().to_string());
        }
    }
    places.retain(|_, places| places.len() > 1);
    let shared: usize = places.values().map(Vec::len).sum();
    let all = places.iter().map(|(name, places)| format!("{name}: {}", places.join(", ")));
    let all = all.collect::<Vec<String>>().join("\n  ");
    assert!(shared <= SHARED_NAMES, "{shared} types share a name with another:\n  {all}");
}

#[test]
fn lines_fit() {
    let mut findings = Vec::new();
    for source in sources() {
        for (i, line) in source.text.lines().enumerate() {
            let columns = line.chars().count();
            let place = format!("{}:{}", source.path.display(), i + 1);
            if columns > MOST_COLUMNS {
                findings.push(format!("{place}: {columns} columns, at most {MOST_COLUMNS}"));
            }
            if line.ends_with([' ', '\t']) {
                findings.push(format!("{place}: space at the end"));
            }
        }
    }
    none(findings);
}

/// Where a word may be, besides tests, benches and examples.
#[derive(Clone, Copy, PartialEq)]
enum Allowed {
    /// Not even in tests.
    Nowhere,
    /// Only there.
    Checks,
    /// In the program as well: it prints, and asks for the time and the environment.
    Program,
    /// In the program, and in the modules of a library that open files.
    Files,
}

/// Words of code (comments and strings aside) that are bound to places.
const WORDS: [(&str, Allowed); 17] = [
    ("todo!", Allowed::Nowhere),
    ("unimplemented!", Allowed::Nowhere),
    ("dbg!", Allowed::Nowhere),
    ("#[ignore", Allowed::Nowhere),
    ("unsafe ", Allowed::Nowhere),
    ("static mut", Allowed::Nowhere),
    ("cfg(test)", Allowed::Nowhere),
    ("println!", Allowed::Checks),
    ("print!", Allowed::Checks),
    ("eprintln!", Allowed::Checks),
    ("eprint!", Allowed::Checks),
    ("stdout()", Allowed::Program),
    ("stderr()", Allowed::Program),
    ("std::process", Allowed::Program),
    ("std::fs", Allowed::Files),
    ("std::env", Allowed::Files),
    ("std::time", Allowed::Files),
];

/// Modules of a library that may open files. They never print.
const FILE_MODULES: [&str; 3] = ["run", "store", "files"];

impl Allowed {
    fn covers(self, source: &Source) -> bool {
        if !source.inside().starts_with("src") || source.folder() == Some("testkit") {
            return self != Allowed::Nowhere;
        }
        match self {
            Allowed::Nowhere | Allowed::Checks => false,
            Allowed::Program => source.is_program(),
            Allowed::Files => {
                let mut modules = source.modules().into_iter();
                source.is_program() || modules.any(|name| FILE_MODULES.contains(&name))
            }
        }
    }
}

#[test]
fn words_are_where_they_may_be() {
    let mut findings = Vec::new();
    for source in sources() {
        for (i, line) in source.code.lines().enumerate() {
            for (word, allowed) in WORDS {
                if lexer::has_word(line, word) && !allowed.covers(source) {
                    findings.push(format!("{}:{}: {word}", source.path.display(), i + 1));
                }
            }
        }
    }
    none(findings);
}

#[test]
fn markers_of_unfinished_work_are_absent() {
    let mut findings = Vec::new();
    for source in sources().iter().filter(|s| !s.inside().starts_with("tests")) {
        for (i, line) in source.text.lines().enumerate() {
            if ["TODO", "FIXME", "XXX", "HACK"].iter().any(|m| line.contains(m)) {
                findings.push(format!("{}:{}: {line}", source.path.display(), i + 1));
            }
        }
    }
    none(findings);
}

#[test]
fn every_file_begins_with_its_doc_and_none_is_mod_rs() {
    let mut findings = Vec::new();
    for source in sources() {
        let fuzz = source.path.starts_with("fuzz");
        if !source.text.starts_with("//!") && !fuzz {
            findings.push(format!("{}: no module doc", source.path.display()));
        }
        if source.path.ends_with("mod.rs") {
            findings.push(format!("{}: put it beside its folder", source.path.display()));
        }
    }
    none(findings);
}

/// Words that `docs/words.md` asks to avoid, and how often they may still be there.
const AVOIDED: [(&str, usize); 10] = [
    ("nobody", 106),
    ("somebody", 29),
    ("so many", 110),
    ("of ours", 36),
    ("in vain", 10),
    ("is believed", 8),
    ("bears", 5),
    ("beside", 346),
    ("on its way", 18),
    ("stands for", 28),
];

/// How often words stand in a text, in any case, not as parts of others.
fn times(text: &str, words: &str) -> usize {
    let is_part = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
    let at = text.match_indices(words).map(|(at, _)| at);
    at.filter(|&at| !is_part(text[..at].chars().next_back()))
        .filter(|&at| !is_part(text[at + words.len()..].chars().next()))
        .count()
}

#[test]
fn words_to_avoid_become_fewer() {
    let read = |name: &str| fs::read_to_string(root().join(name)).expect("a page");
    let vocabulary = read("docs/words.md").to_lowercase();
    let others = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "arch-configs/README.md"];
    let pages = powergs_testkit::docs::pages(root(), &others).into_iter();
    let pages = pages.filter(|path| !path.ends_with("words.md") && !path.ends_with("claims.md"));
    let mut texts: Vec<String> =
        pages.map(|path| fs::read_to_string(path).expect("a page")).collect();
    let is_shipped = |s: &&Source| s.is_library() || s.path.starts_with("src");
    texts.extend(sources().iter().filter(is_shipped).map(|s| s.text.clone()));
    texts.iter_mut().for_each(|text| *text = text.to_lowercase());
    let mut found = Vec::new();
    for (words, most) in AVOIDED {
        assert!(vocabulary.contains(words), "docs/words.md lacks `{words}`");
        let n: usize = texts.iter().map(|text| times(text, words)).sum();
        if n > most {
            found.push(format!("`{words}`: {n} times, at most {most}; docs/words.md has others"));
        }
    }
    none(found);
}
