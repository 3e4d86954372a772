//! Work of the units as words of 16 bits: what the test benches of `rtl/tb/` read, and the events
//! that they write when the unit is right.
//!
//! A stimulus begins with a seed and the shares of cycles, in eighths, in which inputs and outputs
//! are stalled. An event is a kind, a cycle (low, high) and the words of that kind. The cycles of
//! the expected events are those of a bench without stalls. `rtl/README.md` has the formats.

pub mod ccu;
mod sorting;
mod vrc;
mod vru;

pub use ccu::{CcuWork, ccu};
pub use sorting::{bsu, qsu};
pub use vrc::{Core, CoreTile, vrc};
pub use vru::{Tile, vru};

/// A stimulus and what the unit answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Vectors {
    /// What the bench reads, without stalls.
    pub stimulus: Vec<u16>,
    /// The events that it writes.
    pub expected: Vec<Event>,
    /// Words of an event in the file, with its kind and its cycle.
    pub event_words: usize,
    /// Whether the cycles of the events are known; otherwise they are 0, and events are in the
    /// order of their kinds.
    pub timed: bool,
}

/// Something that a bench sees.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// What it is.
    pub kind: u16,
    /// The cycle in which it happens.
    pub cycle: u32,
    /// Its words; those that are missing in the file are 0.
    pub words: Vec<u16>,
}

/// Words in front of what is fed: a seed, stalls of inputs and outputs in eighths of cycles.
pub const HEAD: usize = 3;

impl Vectors {
    /// The stimulus with other stalls: seed, eighths of cycles of inputs and of outputs.
    #[must_use]
    pub fn stalled(&self, head: [u16; HEAD]) -> Vec<u16> {
        let mut words = self.stimulus.clone();
        words[..HEAD].copy_from_slice(&head);
        words
    }

    /// The events as they stand in a file.
    pub fn expected_words(&self) -> Vec<u16> {
        let words = |event: &Event| {
            let mut words = vec![event.kind, event.cycle as u16, (event.cycle >> 16) as u16];
            words.extend(&event.words);
            words.resize(self.event_words, 0);
            words
        };
        self.expected.iter().flat_map(words).collect()
    }

    /// Events of what a bench wrote.
    pub fn events(&self, words: &[u16]) -> Vec<Event> {
        let event = |words: &[u16]| Event {
            kind: words[0],
            cycle: u32::from(words[1]) | u32::from(words[2]) << 16,
            words: words[3..].to_vec(),
        };
        words.chunks_exact(self.event_words).map(event).collect()
    }

    /// Where events of a bench differ from the expected ones, in their order for each kind: kind,
    /// number, found and expected words. With `cycles` in the cycle too, where it is known.
    pub fn difference(&self, found: &[Event], cycles: bool) -> Option<String> {
        let cycles = cycles && self.timed;
        let mut kinds: Vec<u16> = found.iter().chain(&self.expected).map(|e| e.kind).collect();
        kinds.sort_unstable();
        kinds.dedup();
        for kind in kinds {
            let of = |events: &[Event]| -> Vec<Event> {
                events.iter().filter(|event| event.kind == kind).cloned().collect()
            };
            let (found, expected) = (of(found), of(&self.expected));
            for (number, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let same = found.words.starts_with(&expected.words)
                    && (!cycles || found.cycle == expected.cycle);
                if !same {
                    return Some(format!("kind {kind}, {number}: {found:?}, not {expected:?}"));
                }
            }
            if found.len() != expected.len() {
                return Some(format!(
                    "kind {kind}: {} events, not {}",
                    found.len(),
                    expected.len()
                ));
            }
        }
        None
    }

    /// Cycles until the last event, where they are known.
    pub fn cycles(&self) -> Option<u32> {
        self.timed.then(|| self.expected.last().map_or(0, |event| event.cycle + 1))
    }
}

/// Low and high half of a number.
fn halves(number: u32) -> [u16; 2] {
    [number as u16, (number >> 16) as u16]
}
