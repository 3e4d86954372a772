//! Errors of configuration files: every problem with its place and the remedy.

use std::fmt;
use std::ops::Range;

use super::layer;

/// The longest excerpt that is shown, characters.
const EXCERPT_MAX: usize = 100;

/// Problems that are reported at most.
pub const PROBLEMS_MAX: usize = 100;

/// So many of them are shown; who mends these sees the next.
const SHOWN_MAX: usize = 20;

/// Everything that is wrong with one configuration file, in the order of its lines.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct ConfigError {
    /// At least one problem.
    pub problems: Vec<Problem>,
    /// Changes (`key=value`) that would end all of them together; empty where none are known.
    pub remedy: Vec<String>,
}

impl ConfigError {
    /// Of all `problems`, which it brings into the order of the file.
    pub fn new(mut problems: Vec<Problem>) -> ConfigError {
        problems.sort_by_key(|p| match &p.place {
            Place::File { line, column, .. } => (0, *line, *column),
            Place::Set(_) => (1, 0, 0),
        });
        ConfigError { problems, remedy: Vec::new() }
    }
}

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Where.
    pub place: Place,
    /// The dotted key that it is about (`vru.cores`); empty where the file is not TOML at all.
    pub key: String,
    /// What is wrong and what to do.
    pub message: String,
}

/// Where a problem is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// In the file, or in a file that it is based on.
    File {
        /// The other file; `None` for the one that is read.
        file: Option<String>,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// The text of the line.
        excerpt: String,
        /// Characters to underline.
        width: usize,
    },
    /// In a `--set key=value`.
    Set(String),
}

impl Place {
    /// The place of a byte range of `text`. A range beyond the end is the end.
    pub fn of(text: &str, range: Range<usize>) -> Place {
        let mut start = range.start.min(text.len());
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
        let line_text = text[line_start..].lines().next().unwrap_or("");
        // What says where lines stand was written by nobody: the beginning is meant.
        if layer::directive(line_text).is_some() {
            return Place::of("", 0..0);
        }
        let column = text[line_start..start].chars().count() + 1;
        let left = line_text.chars().count().saturating_sub(column - 1).max(1);
        let mut end = range.end.clamp(start, text.len());
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        // Lines of other files say so.
        let before = text[..line_start].lines().rev().enumerate();
        let mut stands = before.filter_map(|(i, line)| Some((i, layer::directive(line)?)));
        let (file, line) = match stands.next() {
            Some((i, (number, name))) => {
                (Some(name.to_owned()).filter(|name| !name.is_empty()), number + i)
            }
            None => (None, text[..start].matches('\n').count() + 1),
        };
        Place::File {
            file,
            line,
            column,
            excerpt: line_text.to_owned(),
            width: text[start..end].chars().count().clamp(1, left),
        }
    }

    /// Line in the file, from 1; `None` for a `--set`.
    pub fn line(&self) -> Option<usize> {
        match self {
            Place::File { line, .. } => Some(*line),
            Place::Set(_) => None,
        }
    }
}

impl Problem {
    /// Where it is and what it is, without the line of the file.
    fn words(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Place::Set(set) => write!(f, "in --set {set}: {}", self.message),
            Place::File { file: None, line, column, .. } => {
                write!(f, "line {line}, column {column}: {}", self.message)
            }
            Place::File { file: Some(file), line, column, .. } => {
                write!(f, "line {line} of {file}, column {column}: {}", self.message)
            }
        }
    }
}

impl fmt::Display for Place {
    /// The line of the file, with what it is about underlined; nothing for other places.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Set(_) => Ok(()),
            Place::File { line, column, excerpt, width, .. } => {
                if excerpt.chars().count() > EXCERPT_MAX || excerpt.trim().is_empty() {
                    return Ok(());
                }
                let number = line.to_string();
                let gutter = " ".repeat(number.len());
                let under = " ".repeat(column - 1) + &"^".repeat(*width);
                let shown = excerpt.replace('\t', " ");
                write!(f, "\n{gutter} |\n{number} | {shown}\n{gutter} | {under}")
            }
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.words(f)?;
        self.place.fmt(f)
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let [one] = self.problems.as_slice() {
            one.fmt(f)?;
            return self.fmt_remedy(f);
        }
        let all = self.problems.len();
        let more = if all >= PROBLEMS_MAX { " or more" } else { "" };
        write!(f, "{all}{more} problems")?;
        let shown = &self.problems[..all.min(SHOWN_MAX)];
        // What several problems are about is shown once.
        shown.chunk_by(|a, b| a.place == b.place).try_for_each(|same| {
            for problem in same {
                writeln!(f)?;
                problem.words(f)?;
            }
            same[0].place.fmt(f)
        })?;
        match all - shown.len() {
            0 => self.fmt_remedy(f),
            rest => write!(f, "\nand {rest}{more}"),
        }
    }
}

impl ConfigError {
    fn fmt_remedy(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.remedy.is_empty() {
            return Ok(());
        }
        write!(f, "\nit would fit with")?;
        self.remedy.iter().try_for_each(|set| match set.contains(' ') {
            true => write!(f, " --set '{set}'"),
            false => write!(f, " --set {set}"),
        })
    }
}
