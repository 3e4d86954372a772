//! Text for a terminal: wrapped sentences, columns side by side, nothing wider than the terminal.

use super::{Block, Column, Document, Table};
use crate::format::{shortened, shortened_inside, wrapped};

/// Blanks between two columns.
const GAP: usize = 2;
/// Words in a column are not shortened to less than this many characters.
const NARROWEST: usize = 12;

impl Document {
    /// The text, with lines of at most `width` characters. Control characters, which names from
    /// files may have, become `?`.
    pub fn terminal(&self, width: usize) -> String {
        let mut text = String::new();
        let mut before: Option<&Block> = None;
        for (_, block) in self.blocks.iter().filter(|(shown, _)| shown.on_terminal()) {
            if matches!(block, Block::Chart(_)) {
                continue;
            }
            let is_close = match before {
                None | Some(Block::Title(_) | Block::Heading(_)) => true,
                Some(before) => {
                    std::mem::discriminant(before) == std::mem::discriminant(block)
                        && !matches!(block, Block::Table(_))
                }
            };
            if !is_close {
                text.push('\n');
            }
            text += &terminal(block, width);
            before = Some(block);
        }
        text.replace(|c: char| c.is_control() && c != '\n', "?")
    }
}

fn terminal(block: &Block, width: usize) -> String {
    match block {
        Block::Title(text) | Block::Heading(text) | Block::Paragraph(text) | Block::Quote(text) => {
            wrapped(&text.plain(), width) + "\n"
        }
        Block::List(items) => {
            items.iter().map(|item| hanging("  ", &item.plain(), 4, width)).collect()
        }
        Block::Facts(facts) => {
            let indent =
                facts.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0) + GAP;
            let line = |(name, text): &(String, super::Text)| {
                hanging(&format!("{name:<indent$}"), &text.plain(), indent, width)
            };
            facts.iter().map(line).collect()
        }
        Block::Verbatim(text) => format!("{}\n", text.trim_end()),
        Block::Table(table) => table.terminal(width),
        Block::Chart(_) | Block::Designs(_) | Block::BeforeAfter(_) => String::new(),
    }
}

/// `text` after `first`, its further lines after `indent` blanks.
fn hanging(first: &str, text: &str, indent: usize, width: usize) -> String {
    let room = width.saturating_sub(first.chars().count().max(indent)).max(NARROWEST);
    let lines: Vec<String> = text.lines().map(|line| wrapped(line, room)).collect();
    let blanks = " ".repeat(indent);
    format!("{first}{}\n", lines.join("\n").replace('\n', &format!("\n{blanks}")))
}

impl Table {
    /// The table, with lines of at most `width` characters. Words beyond the leading ones are
    /// shortened; if that is not enough, the last columns go below, after the leading words again.
    pub fn terminal(&self, width: usize) -> String {
        let shown: Vec<usize> =
            (0..self.columns.len()).filter(|&i| self.columns[i].shown.on_terminal()).collect();
        let most = self.most.unwrap_or(self.rows.len());
        let cells: Vec<Vec<String>> = self
            .rows
            .iter()
            .take(most)
            .map(|row| shown.iter().map(|&i| self.columns[i].words(&row[i]).plain()).collect())
            .collect();
        let columns: Vec<&Column> = shown.iter().map(|&i| &self.columns[i]).collect();
        if columns.is_empty() {
            return String::new();
        }
        let mut widths: Vec<usize> = (0..columns.len())
            .map(|i| {
                let cells = cells.iter().map(|row| row[i].chars().count());
                let head = columns[i].head.chars().count();
                cells.fold(head, usize::max).min(columns[i].at_most)
            })
            .collect();
        shrink(&mut widths, &columns, width);
        let mut text = String::new();
        for (n, part) in folded(&widths, &columns, width).into_iter().enumerate() {
            if n > 0 {
                text.push('\n');
            }
            text += &groups(&part, &columns, &widths);
            let heads: Vec<&str> = columns.iter().map(|c| c.head.as_str()).collect();
            text += &line(&part, &heads, &columns, &widths);
            for row in &cells {
                let row: Vec<&str> = row.iter().map(String::as_str).collect();
                text += &line(&part, &row, &columns, &widths);
            }
        }
        if !self.more.is_empty() {
            text += &format!("{}\n", self.more);
        }
        text
    }
}

/// Leading columns of words, which say what a row is: they stay whole and are repeated.
fn lead(columns: &[&Column]) -> usize {
    columns.iter().take_while(|c| !c.is_number()).count().min(columns.len() - 1)
}

/// Makes lines fit by shortening words. Those beyond the lead give way first; the lead itself only
/// to the widest single column beside it, as the others can go below.
fn shrink(widths: &mut [usize], columns: &[&Column], width: usize) {
    let (lead, n) = (lead(columns), columns.len());
    let line = |widths: &[usize]| widths.iter().sum::<usize>() + GAP * (widths.len() - 1);
    let over = line(widths).saturating_sub(width);
    shorten(widths, (lead..n).filter(|&i| !columns[i].is_number()), over);
    let widest = widths[lead..].iter().copied().max().unwrap_or(0);
    let first: usize = widths[..lead].iter().map(|w| w + GAP).sum();
    shorten(widths, 0..lead, (first + widest).saturating_sub(width));
}

/// Takes `over` characters from some columns, the widest first.
fn shorten(widths: &mut [usize], columns: impl Iterator<Item = usize> + Clone, mut over: usize) {
    while over > 0 {
        let widest = columns.clone().max_by_key(|&i| widths[i]);
        let Some(i) = widest.filter(|&i| widths[i] > NARROWEST) else { return };
        let step = over.min(widths[i] - NARROWEST);
        widths[i] -= step;
        over -= step;
    }
}

/// Columns that fit beside each other: the leading words, and as many others as there is room for.
/// A group stays together where it fits.
fn folded(widths: &[usize], columns: &[&Column], width: usize) -> Vec<Vec<usize>> {
    let lead = lead(columns);
    let of = |part: &[usize]| part.iter().map(|&i| widths[i] + GAP).sum::<usize>() - GAP;
    let first: Vec<usize> = (0..lead).collect();
    let rest: Vec<usize> = (lead..columns.len()).collect();
    let mut parts: Vec<Vec<usize>> = Vec::new();
    let mut place = |together: &[usize]| match parts.last_mut() {
        Some(part) if of(part) + GAP + of(together) <= width => part.extend(together),
        _ => parts.push([first.as_slice(), together].concat()),
    };
    let is_same = |a: &usize, b: &usize| {
        !columns[*a].group.is_empty() && columns[*a].group == columns[*b].group
    };
    for group in rest.chunk_by(is_same) {
        match of(&[first.as_slice(), group].concat()) <= width {
            true => place(group),
            false => group.chunks(1).for_each(&mut place),
        }
    }
    parts
}

/// The line above the heads; empty without groups.
fn groups(part: &[usize], columns: &[&Column], widths: &[usize]) -> String {
    let mut text = String::new();
    for (n, same) in part.chunk_by(|&a, &b| columns[a].group == columns[b].group).enumerate() {
        let width = same.iter().map(|&i| widths[i] + GAP).sum::<usize>() - GAP;
        let group = shortened(&columns[same[0]].group, width);
        text += if n > 0 { "  " } else { "" };
        text += &format!("{group:>width$}");
    }
    match text.trim_end() {
        "" => String::new(),
        line => format!("{line}\n"),
    }
}

/// A row: one line, or as many as its longest sentence needs.
fn line(part: &[usize], cells: &[&str], columns: &[&Column], widths: &[usize]) -> String {
    let lines = |&i: &usize| -> Vec<String> {
        let text = match columns[i].wraps {
            true => wrapped(cells[i], widths[i]),
            false => cells[i].to_owned(),
        };
        let lines = if columns[i].wraps { text.split('\n').collect() } else { vec![&*text] };
        let cut = if columns[i].keeps_ends { shortened_inside } else { shortened };
        lines.into_iter().map(|line| cut(line, widths[i])).collect()
    };
    let cells: Vec<Vec<String>> = part.iter().map(lines).collect();
    let high = cells.iter().map(Vec::len).max().unwrap_or(1);
    let line = |n: usize| {
        let cell = |(lines, &i): (&Vec<String>, &usize)| {
            let (text, width) = (lines.get(n).map_or("", String::as_str), widths[i]);
            match columns[i].is_number() {
                true => format!("{text:>width$}"),
                false => format!("{text:<width$}"),
            }
        };
        let cells: Vec<String> = cells.iter().zip(part).map(cell).collect();
        format!("{}\n", cells.join(&" ".repeat(GAP)).trim_end())
    };
    (0..high).map(line).collect()
}
