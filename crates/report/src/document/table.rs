//! Tables: columns that know what they hold, rows of values. People read rounded numbers, programs
//! get them exact.

use super::{Shown, Text};
use powergs_base::format::spreadsheet_safe;

/// What a column holds.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// Words, at the left.
    Text,
    /// Whole numbers, or words about a quantity, at the right.
    Count,
    /// Numbers, shown to people as the function writes them; files have them exact.
    Real(fn(f64) -> String),
    /// Numbers with this many digits after the point, in files too.
    Fixed(usize),
}

/// A column.
#[derive(Debug, Clone)]
pub struct Column {
    /// What its head says to people, with the unit.
    pub head: String,
    /// What it and its neighbours of the same group are about, above their heads; empty for none.
    pub group: String,
    /// Its name in files.
    pub key: String,
    /// What it holds.
    pub kind: Kind,
    /// Which writers show it.
    pub shown: Shown,
    /// Characters that it has on a terminal at most; longer words end with `…`.
    pub at_most: usize,
    /// Whether longer words have `…` in the middle instead: names that differ at their end.
    pub keeps_ends: bool,
    /// Whether words that are longer take several lines on a terminal instead.
    pub wraps: bool,
}

impl Column {
    /// A column of `kind`, under one name for people and for files.
    pub fn new(head: impl Into<String>, kind: Kind) -> Column {
        let head = head.into();
        Column {
            key: head.clone(),
            head,
            group: String::new(),
            kind,
            shown: Shown::Everywhere,
            at_most: usize::MAX,
            keeps_ends: false,
            wraps: false,
        }
    }

    /// Words.
    pub fn text(head: impl Into<String>) -> Column {
        Column::new(head, Kind::Text)
    }

    /// Whole numbers, or words about a quantity.
    pub fn count(head: impl Into<String>) -> Column {
        Column::new(head, Kind::Count)
    }

    /// Numbers to three significant digits.
    pub fn real(head: impl Into<String>) -> Column {
        Column::new(head, Kind::Real(crate::format::significant))
    }

    /// Numbers with `digits` after the point.
    pub fn fixed(head: impl Into<String>, digits: usize) -> Column {
        Column::new(head, Kind::Fixed(digits))
    }

    /// What it and its neighbours of the same group are about.
    pub fn group(mut self, group: impl Into<String>) -> Column {
        self.group = group.into();
        self
    }

    /// Its name in files.
    pub fn key(mut self, key: impl Into<String>) -> Column {
        self.key = key.into();
        self
    }

    /// Which writers show it.
    pub fn on(mut self, shown: Shown) -> Column {
        self.shown = shown;
        self
    }

    /// Characters that it has on a terminal at most.
    pub fn at_most(mut self, characters: usize) -> Column {
        self.at_most = characters;
        self
    }

    /// Longer words lose their middle.
    pub fn cut_in_the_middle(mut self) -> Column {
        self.keeps_ends = true;
        self
    }

    /// Sentences: on a terminal, as many lines as they need.
    pub fn wraps(mut self) -> Column {
        self.wraps = true;
        self
    }

    /// The head of a page, which has one line for it.
    pub(super) fn page_head(&self) -> String {
        match self.group.is_empty() {
            true => self.head.clone(),
            false => format!("{}: {}", self.group, self.head),
        }
    }

    /// Whether its cells are at the right.
    pub(super) fn is_number(&self) -> bool {
        !matches!(self.kind, Kind::Text)
    }

    /// What people read in a cell.
    pub(super) fn words(&self, cell: &Cell) -> Text {
        match (cell, self.kind) {
            (Cell::Missing, _) => "-".into(),
            (Cell::Empty, _) => Text::default(),
            (Cell::Words(text), _) => text.clone(),
            (Cell::Count(n), _) => n.to_string().into(),
            (Cell::Real(x), Kind::Real(shown)) => shown(*x).into(),
            (Cell::Real(x), Kind::Fixed(digits)) => fixed(*x, digits).into(),
            (Cell::Real(x), Kind::Text | Kind::Count) => x.to_string().into(),
            (Cell::Flag(yes), _) => if *yes { "yes" } else { "no" }.into(),
        }
    }

    /// What a CSV file has in a cell.
    pub(super) fn record(&self, cell: &Cell) -> String {
        match (cell, self.kind) {
            (Cell::Missing | Cell::Empty, _) => String::new(),
            (Cell::Words(text), _) => text.plain(),
            (Cell::Count(n), _) => n.to_string(),
            (Cell::Real(x), Kind::Fixed(digits)) => fixed(*x, digits),
            (Cell::Real(x), _) => x.to_string(),
            (Cell::Flag(yes), _) => yes.to_string(),
        }
    }
}

/// A cell.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Not known or not measured: `-`, an empty cell in CSV, null in JSON.
    Missing,
    /// Nothing belongs here.
    Empty,
    /// Words.
    Words(Text),
    /// A whole number.
    Count(u64),
    /// A number, exact.
    Real(f64),
    /// Yes or no.
    Flag(bool),
}

impl From<&str> for Cell {
    fn from(words: &str) -> Cell {
        Cell::Words(words.into())
    }
}

impl From<String> for Cell {
    fn from(words: String) -> Cell {
        Cell::Words(words.into())
    }
}

impl From<Text> for Cell {
    fn from(text: Text) -> Cell {
        Cell::Words(text)
    }
}

impl From<u64> for Cell {
    fn from(n: u64) -> Cell {
        Cell::Count(n)
    }
}

impl From<usize> for Cell {
    fn from(n: usize) -> Cell {
        Cell::Count(n as u64)
    }
}

impl From<u32> for Cell {
    fn from(n: u32) -> Cell {
        Cell::Count(n.into())
    }
}

impl From<f64> for Cell {
    fn from(x: f64) -> Cell {
        Cell::Real(x)
    }
}

impl From<bool> for Cell {
    fn from(yes: bool) -> Cell {
        Cell::Flag(yes)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Cell {
        value.map_or(Cell::Missing, Into::into)
    }
}

/// A table: every row has a cell for every column.
#[derive(Debug, Clone, Default)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows.
    pub rows: Vec<Vec<Cell>>,
    /// Rows that a terminal shows, if not all.
    pub most: Option<usize>,
    /// The line below the rows on a terminal, such as where the others are; empty for none.
    pub more: String,
}

impl Table {
    /// A table without rows.
    pub fn new(columns: impl IntoIterator<Item = Column>) -> Table {
        Table { columns: columns.into_iter().collect(), ..Table::default() }
    }

    /// A table for files, without rows: columns of these names, which have blanks between them.
    /// Numbers are exact.
    pub fn record(keys: &str) -> Table {
        Table::new(keys.split_whitespace().map(Column::text))
    }

    /// Adds a row.
    ///
    /// # Panics
    /// Unless it has a cell for every column.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        let cells: Vec<Cell> = cells.into_iter().collect();
        assert_eq!(cells.len(), self.columns.len(), "cells of a row of {:?}", self.columns);
        self.rows.push(cells);
    }

    /// With these rows.
    ///
    /// # Panics
    /// As [`Table::row`].
    pub fn rows<R: IntoIterator<Item = Cell>>(
        mut self,
        rows: impl IntoIterator<Item = R>,
    ) -> Table {
        for row in rows {
            self.row(row);
        }
        self
    }

    /// Rows that a terminal shows; `all` is the file that has the others.
    pub fn most(mut self, rows: usize, all: &str) -> Table {
        if self.rows.len() > rows {
            self.more = format!("... and {} more: {all}", self.rows.len() - rows);
            self.most = Some(rows);
        }
        self
    }

    /// The file: keys of the columns, then numbers as they are.
    pub fn csv(&self) -> Vec<u8> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut write = |cells: &mut dyn Iterator<Item = String>| {
            writer.write_record(cells).expect("rows of one length, in memory");
        };
        write(&mut self.columns.iter().map(|c| c.key.clone()));
        for row in &self.rows {
            let cells = self.columns.iter().zip(row).map(|(column, cell)| column.record(cell));
            write(&mut cells.map(spreadsheet_safe));
        }
        writer.into_inner().expect("writing to memory cannot fail")
    }
}

/// A number with `digits` after the point; what rounds to zero has no sign.
fn fixed(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    match text.strip_prefix('-') {
        Some(size) if size.chars().all(|c| matches!(c, '0' | '.')) => size.to_owned(),
        Some(_) | None => text,
    }
}
