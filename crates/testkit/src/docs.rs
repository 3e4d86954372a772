//! The commands of pages: fenced blocks with lines that begin with a prompt or the name of a
//! program.
//!
//! A block runs unless the line before it says `<!-- not run: REASON -->`. A line
//! `<!-- first: COMMAND -->` before a block prepares what its readers have from another page.

use std::fs;
use std::path::{Path, PathBuf};

/// A fenced block with commands of ours.
pub struct Block {
    /// Page and line.
    pub place: String,
    /// Commands that come before, for readers of this page only.
    pub first: Vec<String>,
    /// One a line; continued lines are joined.
    pub commands: Vec<String>,
    /// Whether the page says that they are not run.
    pub skipped: bool,
}

/// The pages in `docs/` under `root`, and `more`.
pub fn pages(root: &Path, more: &[&str]) -> Vec<PathBuf> {
    let folders =
        ["docs", "evidence"].map(|folder| fs::read_dir(root.join(folder)).expect("pages"));
    let mut pages: Vec<PathBuf> =
        folders.into_iter().flatten().map(|e| e.expect("an entry").path()).collect();
    pages.retain(|p| p.extension().is_some_and(|e| e == "md"));
    pages.extend(more.iter().map(|p| root.join(p)));
    pages.sort();
    pages
}

/// The blocks of a page with commands of `program`.
pub fn blocks(root: &Path, page: &Path, program: &str) -> Vec<Block> {
    let text = fs::read_to_string(page).expect("a page");
    let name = page.strip_prefix(root).expect("a page of ours").display().to_string();
    let (mut all, mut first, mut skipped) = (Vec::new(), Vec::new(), false);
    let mut lines = text.lines().enumerate();
    while let Some((i, line)) = lines.next() {
        if let Some(comment) = line.strip_prefix("<!-- ").and_then(|l| l.strip_suffix(" -->")) {
            first.extend(comment.strip_prefix("first: ").map(str::to_owned));
            skipped |= comment.starts_with("not run: ");
            continue;
        }
        if !line.starts_with("```") {
            (first, skipped) = (Vec::new(), false);
            continue;
        }
        let inside: Vec<&str> =
            lines.by_ref().map(|(_, l)| l).take_while(|l| !l.starts_with("```")).collect();
        let commands = commands(&inside.join("\n"), program);
        if !commands.is_empty() {
            let place = format!("{name}:{}", i + 1);
            all.push(Block { place, first: std::mem::take(&mut first), commands, skipped });
        }
        (first, skipped) = (Vec::new(), false);
    }
    all
}

/// Lines that begin with a prompt or with the name of `program`; nothing if none is ours.
pub fn commands(text: &str, program: &str) -> Vec<String> {
    let program = format!("{program} ");
    let joined = text.replace("\\\n", " ");
    let line = |line: &str| {
        let command = line.trim_start_matches("$ ");
        let command = command.replace("cargo run --release -- ", "powergs-sim ");
        let command = command.replace("cargo run --release -p powergs-lab -- ", "powergs-lab ");
        let is_command = line.starts_with("$ ") || command.starts_with(&program);
        (is_command && !line.contains("...")).then_some(command)
    };
    let commands: Vec<String> = joined.lines().filter_map(line).collect();
    if commands.iter().any(|c| c.starts_with(&program)) { commands } else { Vec::new() }
}

/// The words of the program in a shell line, up to a pipe, a redirection or a comment.
pub fn words(command: &str) -> Vec<String> {
    let (mut words, mut word, mut quote, mut begun) = (Vec::new(), String::new(), None, false);
    for c in command.chars() {
        match (c, quote) {
            (c, Some(q)) if c == q => quote = None,
            (c, Some(_)) => word.push(c),
            ('\'' | '"', None) => (quote, begun) = (Some(c), true),
            ('|' | '>' | '<' | '&' | ';', None) => break,
            ('#', None) if !begun => break,
            (' ', None) => {
                words.extend(begun.then(|| std::mem::take(&mut word)));
                begun = false;
            }
            (c, None) => {
                word.push(c);
                begun = true;
            }
        }
    }
    words.extend((!word.is_empty()).then_some(word));
    words
}
