//! A timeline as a picture: units by time, coloured by what each did most of the time in a column
//! of the picture.

use std::collections::BTreeMap;
use std::ops::Range;

use powergs_core::kernel::timeline::{Observer, Span, State};
use powergs_core::stage::{Stall, stage};
use powergs_energy::action::{Phase, StageId};

/// Columns of the picture.
pub const COLUMNS: usize = 1080;

/// Instances of one kind of unit that are drawn; further ones have no room.
pub const MOST_INSTANCES: u32 = 12;

/// States of a column: busy with an item, busy with the next one, causes by [`Stall::index`], idle.
pub const STATES: usize = Stall::MOST + 3;

/// The state without work.
pub const IDLE: usize = STATES - 1;

/// Finds the cycles in which some of the tiles are worked on, and the units that there are.
#[derive(Debug, Clone)]
pub struct Window {
    tiles: Range<u32>,
    /// First and last cycle of work on them; empty if there is none.
    pub cycles: Range<u64>,
}

impl Window {
    /// For these tiles.
    pub fn new(tiles: Range<u32>) -> Window {
        Window { tiles, cycles: Range { start: u64::MAX, end: 0 } }
    }
}

impl Observer for Window {
    fn span(&mut self, span: Span) {
        if let State::Busy(item) = span.state
            && stage(span.unit).phase != Phase::Preprocessing
            && self.tiles.contains(&item)
        {
            self.cycles.start = self.cycles.start.min(span.from);
            self.cycles.end = self.cycles.end.max(span.to);
        }
    }
}

/// An item on a unit, from its first cycle to its last.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// Number of the batch or tile.
    pub number: u32,
    /// Cycles, waits between them included.
    pub cycles: Range<u64>,
    /// Those of them with work.
    pub busy: u64,
}

/// One unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name and number: `vru0`.
    pub name: String,
    /// Cycles in each state, by column.
    columns: Vec<[f32; STATES]>,
    /// Items that are long enough to be labelled and worked on most of that time.
    pub items: Vec<Item>,
    open: Option<Item>,
    /// Which of the two colours of work the open item has.
    shade: usize,
}

impl Row {
    /// The state that a column spent most cycles in.
    pub fn state(&self, column: usize) -> usize {
        let cell = &self.columns[column];
        let mut best = IDLE;
        for (state, cycles) in cell.iter().enumerate() {
            if *cycles > cell[best] {
                best = state;
            }
        }
        best
    }
}

/// The picture while it is made.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Cycles that are shown.
    pub cycles: Range<u64>,
    rows: BTreeMap<(StageId, u32), Row>,
    /// Whether instances had no room.
    pub cut: bool,
}

impl Picture {
    /// An empty picture of these cycles, of which there is at least one.
    pub fn new(cycles: Range<u64>) -> Picture {
        assert!(!cycles.is_empty(), "a picture of no time");
        Picture { cycles, rows: BTreeMap::new(), cut: false }
    }

    /// The rows in pipeline order.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.rows.values()
    }

    /// Whether one of its units may wait for a cause.
    pub fn has(&self, cause: Stall) -> bool {
        self.rows.keys().any(|(unit, _)| stage(*unit).stalls().any(|own| own == cause))
    }

    /// Closes the last items.
    pub fn finish(&mut self) {
        let shortest = self.shortest();
        self.rows.values_mut().for_each(|row| close(row, shortest));
    }

    /// Cycles of the shortest item with a label: as wide as three characters.
    fn shortest(&self) -> u64 {
        (self.cycles.end - self.cycles.start) * 34 / COLUMNS as u64
    }
}

fn close(row: &mut Row, shortest: u64) {
    if let Some(item) = row.open.take()
        && item.cycles.end - item.cycles.start >= shortest.max(1)
        && 2 * item.busy > item.cycles.end - item.cycles.start
    {
        row.items.push(item);
    }
}

impl Observer for Picture {
    fn span(&mut self, span: Span) {
        let (from, to) = (span.from.max(self.cycles.start), span.to.min(self.cycles.end));
        if from >= to {
            return;
        }
        if span.instance >= MOST_INSTANCES {
            self.cut = true;
            return;
        }
        let shortest = self.shortest();
        let row = self.rows.entry((span.unit, span.instance)).or_insert_with(|| Row {
            name: format!("{} {}", stage(span.unit).key.to_uppercase(), span.instance),
            columns: vec![[0.0; STATES]; COLUMNS],
            items: Vec::new(),
            open: None,
            shade: 0,
        });
        let state = match (span.state, &mut row.open) {
            (State::Busy(item), Some(open)) if open.number == item => {
                open.cycles.end = to;
                open.busy += to - from;
                row.shade
            }
            (State::Busy(item), _) => {
                close(row, shortest);
                row.open = Some(Item { number: item, cycles: from..to, busy: to - from });
                row.shade = 1 - row.shade;
                row.shade
            }
            (State::Stalled(cause), _) => 2 + cause.index(),
            (State::Idle, _) => IDLE,
        };
        let scale = COLUMNS as f64 / (self.cycles.end - self.cycles.start) as f64;
        let at = |cycle: u64| (cycle - self.cycles.start) as f64 * scale;
        let (start, end) = (at(from), at(to));
        let last = (end.ceil() as usize).min(COLUMNS);
        for (i, column) in row.columns[..last].iter_mut().enumerate().skip(start as usize) {
            let part = end.min(i as f64 + 1.0) - start.max(i as f64);
            column[state] += part as f32;
        }
    }
}
