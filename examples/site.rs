//! The documentation as a site, into a folder: `cargo run --example site -- target/site`, then
//! `mdbook build target/site`.
//!
//! Pages of the repository keep their places, so that their links stay. What can be looked up is
//! written from the program: commands, terms, statistics, assumptions, sources. A link of a page to
//! nothing ends it with exit code 1; one to a file of the repository that is no page becomes words.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use clap::CommandFactory;
use powergs_sim::cli::Cli;
use powergs_sim::cli::arch::Kind;
use powergs_sim::report;
use powergs_sim::report::explain::{Entry, entries};

/// Pages outside of `docs/` and `evidence/`.
const OTHERS: [&str; 8] = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "arch-configs/README.md",
    "traces/README.md",
    "rtl/README.md",
    "lab/README.md",
];

/// Pages that are written from the program: file, title, kinds of entries.
const LOOK_UP: [(&str, &str, &[&str]); 4] = [
    ("terms", "Terms", &["term"]),
    ("statistics", "Statistics", &["statistic"]),
    ("assumptions", "Assumptions", &["assumption"]),
    ("sources", "Sources", &["source of numbers"]),
];

const BOOK: &str = "\
[book]
title = \"powergs-sim\"
description = \"A cycle-approximate simulator of 3D Gaussian Splatting accelerators\"
language = \"en\"
src = \"src\"

[output.html]
default-theme = \"light\"
preferred-dark-theme = \"navy\"
no-section-label = true

[output.html.search]
limit-results = 20
boost-title = 3
";

fn main() -> io::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let out: PathBuf =
        std::env::args_os().nth(1).map_or_else(|| root.join("target/site"), Into::into);
    let mut pages: Vec<String> = OTHERS.map(str::to_owned).to_vec();
    for folder in ["docs", "evidence"] {
        for entry in fs::read_dir(root.join(folder))? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            if name.ends_with(".md") && name != "SUMMARY.md" {
                pages.push(format!("{folder}/{name}"));
            }
        }
    }
    pages.sort();
    let source = out.join("src");
    let (mut links, mut broken) = (0, Vec::new());
    let known: BTreeSet<&str> = pages.iter().map(String::as_str).collect();
    for page in &pages {
        let text = fs::read_to_string(root.join(page))?;
        let site = Site { root, known: &known, page };
        let text = site.linked(&text, &mut links, &mut broken);
        put(&source.join(page), &text)?;
    }
    for entry in fs::read_dir(root.join("docs/images"))? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default();
        fs::create_dir_all(source.join("docs/images"))?;
        fs::copy(&path, source.join("docs/images").join(name))?;
    }
    let all = entries([]);
    for (file, title, kinds) in LOOK_UP {
        let own: Vec<&Entry> = all.iter().filter(|entry| kinds.contains(&entry.kind)).collect();
        assert!(!own.is_empty(), "{file}: no entry of {kinds:?}");
        put(&source.join(format!("look-up/{file}.md")), &look_up(title, &own))?;
    }
    put(&source.join("look-up/commands.md"), &commands())?;
    for kind in Kind::ALL {
        put(
            &source.join(format!("schema/{}.json", kind.name())),
            &format!("{:#}\n", kind.schema()),
        )?;
    }
    put(&source.join("schema/report.json"), &format!("{:#}\n", report::schema::schema()))?;
    let summary = fs::read_to_string(root.join("docs/SUMMARY.md"))?;
    let listed = summary_of_site(&summary);
    for page in &pages {
        if !listed.contains(&format!("({page})")) {
            broken.push(format!("docs/SUMMARY.md: {page} is not in it"));
        }
    }
    put(&source.join("SUMMARY.md"), &listed)?;
    put(&out.join("book.toml"), BOOK)?;
    println!("{} pages, {links} links", pages.len() + LOOK_UP.len() + 1);
    println!("next: mdbook build {}", out.display());
    if !broken.is_empty() {
        eprintln!("{}", broken.join("\n"));
        std::process::exit(1);
    }
    Ok(())
}

fn put(path: &Path, text: &str) -> io::Result<()> {
    fs::create_dir_all(path.parent().unwrap_or(Path::new("")))?;
    fs::write(path, text)
}

/// A page among the others.
struct Site<'a> {
    root: &'a Path,
    known: &'a BTreeSet<&'a str>,
    page: &'a str,
}

impl Site<'_> {
    /// The text with links that lead somewhere.
    fn linked(&self, text: &str, links: &mut usize, broken: &mut Vec<String>) -> String {
        let mut done = String::with_capacity(text.len());
        let mut is_code = false;
        for (number, line) in text.lines().enumerate() {
            is_code ^= line.starts_with("```");
            let mut rest = line;
            while let Some((before, after)) = rest.split_once("](").filter(|_| !is_code) {
                let Some((target, after)) = after.split_once(')') else { break };
                *links += 1;
                match self.target(target) {
                    Ok(Some(target)) => done += &format!("{before}]({target})"),
                    // Words in place of a link to a file that no page is.
                    Ok(None) => match before.rsplit_once('[') {
                        Some((start, words)) => done += &format!("{start}{words}"),
                        None => done += &format!("{before}]({target})"),
                    },
                    Err(why) => {
                        broken.push(format!("{}:{}: {target}: {why}", self.page, number + 1));
                    }
                }
                rest = after;
            }
            done += rest;
            done.push('\n');
        }
        done
    }

    /// Where a link leads in the site; `None` to a file that is no page.
    fn target(&self, target: &str) -> Result<Option<String>, String> {
        if target.starts_with("http") || target.starts_with("mailto:") || target.starts_with('<') {
            return Ok(Some(target.to_owned()));
        }
        let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
        let folder = Path::new(self.page).parent().unwrap_or(Path::new(""));
        let place = match path {
            "" => self.page.to_owned(),
            path => plain(&folder.join(path)).ok_or("leads out of the repository")?,
        };
        if !self.root.join(&place).exists() {
            return Err("no such file".into());
        }
        if place.starts_with("docs/images/") {
            return Ok(Some(target.to_owned()));
        }
        if !self.known.contains(place.as_str()) {
            return Ok(None);
        }
        let text = fs::read_to_string(self.root.join(&place)).map_err(|e| e.to_string())?;
        let headings = text.lines().filter(|line| line.starts_with('#'));
        if !anchor.is_empty() && !headings.into_iter().any(|line| slug(line) == anchor) {
            return Err(format!("no heading `#{anchor}` there"));
        }
        Ok(Some(target.to_owned()))
    }
}

/// A path without `..`; `None` if it leads out.
fn plain(path: &Path) -> Option<String> {
    let mut parts: Vec<String> = Vec::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => parts.push(name.to_string_lossy().into_owned()),
            Component::ParentDir => drop(parts.pop()?),
            Component::CurDir => {}
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(parts.join("/"))
}

/// The anchor of a heading.
fn slug(heading: &str) -> String {
    let words = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = words.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// The table of contents, with links from the root of the site.
fn summary_of_site(summary: &str) -> String {
    let from_root = |line: &str| match line.split_once("](") {
        Some((words, target)) if target.starts_with("../") => format!("{words}]({}", &target[3..]),
        Some((words, target)) => format!("{words}](docs/{target}"),
        None => line.to_owned(),
    };
    summary.lines().map(|line| from_root(line) + "\n").collect()
}

/// A page of entries, each with a heading that the search finds.
fn look_up(title: &str, all: &[&Entry]) -> String {
    let mut page = format!("# {title}\n");
    for entry in all {
        let unit = match entry.unit.as_str() {
            "" => String::new(),
            unit => format!(" ({unit})"),
        };
        page += &format!("\n## {}{unit}\n\n{}\n", safe(&entry.name), safe(&entry.definition));
        let facts = entry.value.iter().map(|value| ("value", value));
        let facts = facts.chain(entry.facts.iter().map(|(name, value)| (*name, value)));
        for (i, (name, value)) in facts.enumerate() {
            let value = match value.starts_with("http") {
                true => format!("<{value}>"),
                false => safe(value),
            };
            page += &format!("{}- {name}: {value}\n", if i == 0 { "\n" } else { "" });
        }
    }
    page
}

/// Text in which nothing is HTML.
fn safe(text: &str) -> String {
    let escaped = |(i, part): (usize, &str)| match i % 2 {
        0 => part.replace('<', "&lt;").replace('*', "\\*").replace('_', "\\_"),
        _ => format!("`{part}`"),
    };
    text.split('`').enumerate().map(escaped).collect()
}

/// What every command says about itself.
fn commands() -> String {
    let mut page = "# Commands\n".to_owned();
    let mut program = Cli::command();
    program.build();
    let mut open = vec![program];
    while let Some(mut command) = open.pop() {
        let name = command.get_bin_name().unwrap_or("powergs-sim").to_owned();
        page += &format!("\n## {name}\n\n```text\n{}```\n", command.render_long_help());
        let inner: Vec<_> = command.get_subcommands().filter(|c| c.get_name() != "help").collect();
        open.extend(inner.into_iter().rev().cloned());
    }
    page
}
