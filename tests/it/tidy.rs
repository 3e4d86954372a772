//! The rules of the house, as tests.

mod lexer;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use lexer::without_text;

/// Who may import whom. `cli` may use everything.
const MAY_USE: &[(&str, &[&str])] = &[
    ("quantity", &[]),
    ("action", &["quantity"]),
    ("picture", &[]),
    // Words and errors of TOML files; knows no table.
    ("config", &["quantity"]),
    ("scene", &["quantity"]),
    ("splat", &["quantity", "scene"]),
    // Where somebody looks; knows no picture and no model.
    ("fovea", &["splat"]),
    ("trace", &["quantity", "scene", "splat", "fovea"]),
    ("raster", &["scene", "splat", "fovea", "trace", "picture"]),
    ("workload", &["quantity", "splat", "fovea", "trace"]),
    ("accel", &["quantity", "action", "workload", "config", "splat", "dram", "fovea"]),
    ("energy", &["quantity", "action", "config"]),
    ("display", &["quantity", "config", "picture", "fovea"]),
    ("dram", &["quantity", "config"]),
    // A display is a term of the training loss.
    ("quality", &["picture", "display", "fovea"]),
    // `dram`: what the commands of a device cost becomes prices.
    (
        "sim",
        &[
            "quantity", "action", "workload", "accel", "energy", "display", "config", "splat",
            "dram", "fovea",
        ],
    ),
    // It takes the values that `sim` returns apart; it never calls anything that counts.
    ("report", &["sim", "accel", "action", "energy", "workload", "optimize", "analysis", "fovea"]),
    (
        "sweep",
        &["quantity", "action", "workload", "accel", "energy", "display", "config", "dram", "sim"],
    ),
    // Makes scenes, frames and workloads, and puts machines on them.
    ("validate", &["scene", "raster", "trace", "workload", "accel", "action", "energy", "sim"]),
    // A trainer with a price tag: it renders, measures quality and asks `sim` for watts.
    (
        "optimize",
        &[
            "scene", "raster", "workload", "accel", "action", "energy", "display", "picture",
            "quality", "sim", "fovea",
        ],
    ),
    // Reads tables of results; knows no machine.
    ("analysis", &["config", "sweep"]),
    ("lib", &[]),
    ("main", &["cli"]),
];

/// A file above this fails.
const MOST_LINES: usize = 600;
/// A file above this is printed: it should be looked at.
const MANY_LINES: usize = 400;
/// A function above this fails.
const MOST_FUNCTION_LINES: usize = 70;
/// A line above this fails.
const MOST_COLUMNS: usize = 100;

struct Source {
    /// Relative to the package.
    path: PathBuf,
    text: String,
    /// The text without comments and the contents of strings; same lines.
    code: String,
}

impl Source {
    /// The module under `src` that the file belongs to.
    fn module(&self) -> Option<String> {
        let inside = self.path.strip_prefix("src").ok()?;
        let first = inside.components().next()?.as_os_str().to_string_lossy().into_owned();
        Some(first.trim_end_matches(".rs").to_owned())
    }
}

fn sources(folders: &[&str]) -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    for folder in folders {
        collect(&root.join(folder), &mut paths);
    }
    paths.sort();
    assert!(!paths.is_empty());
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("a source file");
        let path = path.strip_prefix(root).expect("in the package").to_owned();
        Source { path, code: without_text(&text), text }
    };
    paths.into_iter().map(read).collect()
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

const ALL: [&str; 4] = ["src", "tests", "benches", "fuzz/fuzz_targets"];

#[test]
fn files_are_short() {
    let mut findings = Vec::new();
    for source in sources(&ALL) {
        let lines = source.text.lines().count();
        if lines > MOST_LINES {
            findings
                .push(format!("{}: {lines} lines, at most {MOST_LINES}", source.path.display()));
        } else if lines > MANY_LINES {
            eprintln!("{}: {lines} lines; can it be two files?", source.path.display());
        }
    }
    none(findings);
}

#[test]
fn lines_fit() {
    let mut findings = Vec::new();
    for source in sources(&ALL) {
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

#[test]
fn functions_fit_a_screen() {
    let mut findings = Vec::new();
    for source in sources(&["src", "benches"]) {
        for (name, first, lines) in lexer::functions(&source.code) {
            if lines > MOST_FUNCTION_LINES {
                let place = format!("{}:{first}", source.path.display());
                findings.push(format!("{place}: fn {name} has {lines} lines"));
            }
        }
    }
    none(findings);
}

#[test]
fn modules_import_only_what_they_may() {
    let mut findings = Vec::new();
    for source in sources(&["src"]) {
        let module = source.module().expect("in src");
        if module == "cli" {
            continue;
        }
        let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| *name == module) else {
            findings.push(format!("{module}: a new module; give it a row in the table"));
            continue;
        };
        for other in lexer::crate_paths(&source.code) {
            if other != module && !allowed.contains(&other.as_str()) {
                findings.push(format!("{}: uses {other}", source.path.display()));
            }
        }
    }
    none(findings);
}

#[test]
fn the_table_names_modules_that_exist() {
    let modules: BTreeSet<String> = sources(&["src"]).iter().filter_map(Source::module).collect();
    for (name, allowed) in MAY_USE {
        for other in allowed.iter().chain([name]) {
            assert!(modules.contains(*other), "{other} is not a module");
        }
    }
}

/// Words that must not be in code (comments and strings aside), and where they may be.
const FORBIDDEN: [(&str, &[&str]); 12] = [
    ("todo!", &[]),
    ("unimplemented!", &[]),
    ("dbg!", &[]),
    ("println!", &["tests", "benches"]),
    ("print!", &["tests", "benches"]),
    ("#[ignore", &[]),
    ("unsafe ", &[]),
    ("static mut", &[]),
    ("std::fs", &["src/cli", "tests", "benches"]),
    ("std::env", &["src/cli", "tests", "benches"]),
    ("std::time", &["src/cli", "tests", "benches"]),
    ("anyhow", &["src/cli"]),
];

#[test]
fn forbidden_words_are_absent() {
    let mut findings = Vec::new();
    for source in sources(&ALL) {
        for (i, line) in source.code.lines().enumerate() {
            for (word, places) in FORBIDDEN {
                let allowed = places.iter().any(|p| source.path.starts_with(p));
                if lexer::has_word(line, word) && !allowed {
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
    for source in sources(&["src", "benches"]) {
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
    for source in sources(&ALL) {
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

#[test]
fn the_accelerator_never_says_joule_and_energy_never_sees_a_tile() {
    let mut findings = Vec::new();
    for source in sources(&["src"]) {
        let words: &[&str] = match source.module().as_deref() {
            Some("accel") => &["joule", "picojoule", "watt"],
            Some("energy") => &["tile"],
            Some("raster") => &["machine"],
            _ => &[],
        };
        let code = source.code.to_lowercase();
        for word in words {
            // `tile_list` is the name of a buffer.
            if code.replace("tile_list", "").replace("tilelist", "").contains(word) {
                findings.push(format!("{}: says {word}", source.path.display()));
            }
        }
    }
    none(findings);
}
