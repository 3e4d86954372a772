//! Work of the sorting units: keys in the order of storage.

use super::{Event, Vectors, halves};

const LEAVES: u16 = 0;
const DONE: u16 = 1;
/// Pivots of a quick sorting unit.
const PIVOTS: usize = 7;
/// Cycles from the acceptance of a key until it leaves.
const QSU_LATENCY: u32 = 2;
/// Cycles from a row at the input until it leaves, sorting or merging.
const BSU_LATENCY: u32 = 4;
/// Keys of a row.
const ROW: usize = 16;

/// Lists for `rtl/tb/qsu.cpp`: quantiles of each list are written as its pivots, then its keys
/// pass. Key `i` of a list has payload `i`.
pub fn qsu(lists: &[Vec<u16>]) -> Vectors {
    let mut stimulus = vec![0; super::HEAD];
    let mut expected = Vec::new();
    let mut cycle = 0;
    for list in lists {
        let mut sorted = list.clone();
        sorted.sort_unstable();
        let at = |p: usize| sorted.get((p + 1) * sorted.len() / (PIVOTS + 1)).copied();
        let pivots: [u16; PIVOTS] = std::array::from_fn(|p| at(p).unwrap_or(u16::MAX));
        stimulus.push(list.len() as u16);
        stimulus.push((list.len() >> 16) as u16);
        stimulus.extend(pivots);
        stimulus.extend(list);
        cycle += PIVOTS as u32;
        for (payload, &key) in (0..).zip(list) {
            let part = pivots.iter().filter(|&&pivot| pivot <= key).count() as u16;
            let words = vec![key, payload as u16, part];
            expected.push(Event { kind: LEAVES, cycle: cycle + payload + QSU_LATENCY, words });
        }
        cycle += list.len() as u32 + if list.is_empty() { 0 } else { QSU_LATENCY };
        expected.push(Event { kind: DONE, cycle: cycle - 1, words: Vec::new() });
    }
    Vectors { stimulus, expected, event_words: 6, timed: true }
}

/// Rows that levels of merging move, for a chunk of so many rows: a list that is left over in a
/// level stays where it is.
fn merged(rows: usize) -> Vec<usize> {
    let mut lists = vec![1; rows];
    let mut levels = Vec::new();
    while lists.len() > 1 {
        let pairs = lists.chunks(2);
        levels
            .push(pairs.clone().filter(|pair| pair.len() == 2).map(|pair| pair[0] + pair[1]).sum());
        lists = pairs.map(|pair| pair.iter().sum()).collect();
    }
    levels
}

/// Chunks for `rtl/tb/bsu.cpp`, which sorts rows of 16 and merges them level by level. An entry is
/// a key with its place in the chunk below it; unused places of the last row are ones.
///
/// # Panics
/// When a chunk is empty or has more than 65,535 keys.
pub fn bsu(chunks: &[Vec<u16>]) -> Vectors {
    let mut stimulus = vec![0; super::HEAD];
    let mut expected = Vec::new();
    let mut cycle = 0;
    for chunk in chunks {
        let places = u16::try_from(chunk.len()).expect("a chunk");
        let mut entries: Vec<u32> = chunk
            .iter()
            .zip(0..places)
            .map(|(&key, at)| u32::from(key) << 16 | u32::from(at))
            .collect();
        let rows = entries.len().div_ceil(ROW);
        entries.resize(rows * ROW, u32::MAX);
        stimulus.push(rows as u16);
        stimulus.extend(entries.iter().flat_map(|&entry| halves(entry)));
        entries.sort_unstable();
        let levels = merged(rows);
        let streams = [rows].into_iter().chain(levels.iter().copied());
        cycle += streams.map(|rows| rows as u32 + BSU_LATENCY).sum::<u32>();
        expected.push(Event { kind: DONE, cycle: cycle - 1, words: Vec::new() });
        for row in entries.chunks(ROW) {
            let words = row.iter().flat_map(|&entry| halves(entry)).collect();
            expected.push(Event { kind: LEAVES, cycle: cycle - 1, words });
        }
    }
    Vectors { stimulus, expected, event_words: 35, timed: true }
}
