//! Timelines as text, with the names that stages declare.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::stage;
use crate::kernel::timeline::{State, Timeline};
use powergs_energy::action::StageId;

impl State {
    /// One character: the last digit of the item, the first letter of its cause for a stall, `.`
    /// for idle.
    fn symbol(self) -> char {
        match self {
            State::Busy(item) => char::from(b'0' + (item % 10) as u8),
            State::Stalled(cause) => cause.words().symbol,
            State::Idle => '.',
        }
    }
}

impl Timeline {
    /// One line of text per unit, one character per cycle: `vru0 |...0011`.
    pub fn draw(&self) -> String {
        let mut rows: BTreeMap<(StageId, u32), Vec<char>> = BTreeMap::new();
        for span in &self.spans {
            let row = rows.entry((span.unit, span.instance)).or_default();
            let end = row.len().max(span.to as usize);
            row.resize(end, '.');
            row[span.from as usize..span.to as usize].fill(span.state.symbol());
        }
        let end = rows.values().map(Vec::len).max().unwrap_or(0);
        let mut text = String::new();
        for ((unit, instance), row) in rows {
            let unit = stage(unit).key;
            let row: String = row.into_iter().chain(std::iter::repeat('.')).take(end).collect();
            writeln!(text, "{unit}{instance} |{row}").expect("a string takes any text");
        }
        text
    }
}
