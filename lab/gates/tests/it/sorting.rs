//! The committed netlists of the sorting units against functional models, in 64 lanes with
//! random stalls on both sides.

use std::collections::VecDeque;

use rand::{Rng, RngExt};

use super::unit::{LANES, LIBRARIES, Unit};

#[derive(Debug, Clone, Copy, PartialEq)]
struct Entry {
    part: u64,
    key: u64,
    payload: u64,
}

/// The part of a key: the number of pivots that are not above it.
fn part(pivots: &[u64; 7], key: u64) -> u64 {
    pivots.iter().filter(|pivot| **pivot <= key).count() as u64
}

fn quick_sort(library: &str) {
    let mut unit = Unit::new("qsu", library);
    let mut pivots = [[0u64; 7]; LANES];
    for lane in &mut pivots {
        lane.fill_with(|| unit.random.next_u64() & 0xffff);
        lane.sort_unstable();
    }
    for index in 0..7 {
        unit.set("pivot_valid", &[1; LANES]);
        unit.set("pivot_index", &[index as u64; LANES]);
        unit.set("pivot_key", &pivots.map(|lane| lane[index]));
        unit.cycle();
    }
    unit.set("pivot_valid", &[0; LANES]);
    let mut expected: Vec<VecDeque<Entry>> = vec![VecDeque::new(); LANES];
    let (mut offered, mut left): ([Option<Entry>; LANES], _) = ([None; LANES], 0);
    for _ in 0..100 {
        let (comes, goes) = (unit.coins(), unit.coins());
        for lane in 0..LANES {
            if offered[lane].is_none() && comes[lane] == 1 {
                // Every other key is a pivot or next to one.
                let near = pivots[lane][unit.random.random_range(0..7)];
                let near = near.wrapping_add(unit.random.random_range(0..3)).wrapping_sub(1);
                let key = if unit.random.random() { near } else { unit.random.next_u64() } & 0xffff;
                let payload = unit.random.next_u64() & 0xffff;
                offered[lane] = Some(Entry { part: part(&pivots[lane], key), key, payload });
            }
        }
        unit.set("in_valid", &offered.map(|entry| u64::from(entry.is_some())));
        unit.set("in_key", &offered.map(|entry| entry.map_or(0, |entry| entry.key)));
        unit.set("in_payload", &offered.map(|entry| entry.map_or(0, |entry| entry.payload)));
        unit.set("out_ready", &goes);
        unit.simulator.settle();
        let (valid, ready) = (unit.get("out_valid"), unit.get("in_ready"));
        let (parts, keys) = (unit.get("out_part"), unit.get("out_key"));
        let payloads = unit.get("out_payload");
        for lane in 0..LANES {
            if valid[lane] & goes[lane] == 1 {
                let entry = Entry { part: parts[lane], key: keys[lane], payload: payloads[lane] };
                assert_eq!(Some(entry), expected[lane].pop_front(), "lane {lane}");
                left += 1;
            }
            if ready[lane] == 1 {
                expected[lane].extend(offered[lane].take());
            }
        }
        unit.simulator.clock();
    }
    assert!(left > 3000, "{left} entries");
}

#[test]
fn quick_sorting_units_deal_keys_to_the_parts_of_the_model() {
    LIBRARIES.iter().for_each(|library| quick_sort(library));
}

type Row = [u32; 16];

/// Rows in front of a port, with whether each is the last of its list.
#[derive(Clone, Default)]
struct Source {
    rows: VecDeque<(Row, bool)>,
    offered: bool,
}

/// Runs rows through the ports of a unit until everything expected has left; returns cycles.
fn stream(
    unit: &mut Unit,
    ports: &[&str],
    mut sources: Vec<Vec<Source>>,
    mut expected: Vec<VecDeque<Row>>,
) -> u32 {
    let mut cycles = 0;
    while expected.iter().any(|rows| !rows.is_empty()) {
        for (port, lanes) in ports.iter().zip(&mut sources) {
            let comes = unit.coins();
            for (source, comes) in lanes.iter_mut().zip(comes) {
                source.offered |= comes == 1 && !source.rows.is_empty();
            }
            let first = |lane: usize| lanes[lane].rows.front().filter(|_| lanes[lane].offered);
            let rows: [Option<Row>; LANES] =
                std::array::from_fn(|lane| first(lane).map(|row| row.0));
            let last: [u64; LANES] =
                std::array::from_fn(|lane| first(lane).map_or(0, |row| u64::from(row.1)));
            unit.set(&format!("{port}_valid"), &rows.map(|row| u64::from(row.is_some())));
            unit.set_rows(&format!("{port}_row"), &rows);
            if *port != "sort" {
                unit.set(&format!("{port}_last"), &last);
            }
        }
        let goes = unit.coins();
        unit.set("out_ready", &goes);
        unit.simulator.settle();
        let (valid, rows) = (unit.get("out_valid"), unit.rows("out_row"));
        for lane in 0..LANES {
            if valid[lane] & goes[lane] == 1 {
                assert_eq!(Some(rows[lane]), expected[lane].pop_front(), "lane {lane}");
            }
        }
        for (port, lanes) in ports.iter().zip(&mut sources) {
            let ready = unit.get(&format!("{port}_ready"));
            for (source, _) in
                lanes.iter_mut().zip(ready).filter(|(source, ready)| source.offered && *ready == 1)
            {
                source.rows.pop_front();
                source.offered = false;
            }
        }
        unit.simulator.clock();
        cycles += 1;
        assert!(cycles < 10_000, "rows are missing");
    }
    ports.iter().for_each(|port| unit.set(&format!("{port}_valid"), &[0; LANES]));
    cycles
}

/// A list in ascending order; a small `spread` makes ties.
fn list(unit: &mut Unit, rows: usize, spread: u32) -> Vec<u32> {
    let from = unit.random.random_range(0..3) * (spread / 2);
    let entry = |_| from.wrapping_add(unit.random.random_range(0..spread));
    let mut list: Vec<u32> = (0..16 * rows).map(entry).collect();
    list.sort_unstable();
    list
}

fn rows(list: &[u32]) -> impl Iterator<Item = (Row, bool)> {
    let count = list.len() / 16;
    let rows = list.as_chunks::<16>().0.iter().copied();
    rows.enumerate().map(move |(row, entries)| (entries, row + 1 == count))
}

fn bitonic_sort(library: &str) {
    let mut unit = Unit::new("bsu", library);
    let mut sources = vec![Source::default(); LANES];
    let mut expected = vec![VecDeque::new(); LANES];
    for (source, expected) in sources.iter_mut().zip(&mut expected) {
        for turn in 0..16 {
            let spread = if turn % 2 == 0 { u32::MAX } else { 9 };
            let mut row: Row = std::array::from_fn(|_| unit.random.random_range(0..spread));
            source.rows.push_back((row, false));
            row.sort_unstable();
            expected.push_back(row);
        }
    }
    stream(&mut unit, &["sort"], vec![sources], expected);
    let mut sources = vec![vec![Source::default(); LANES]; 2];
    let mut expected = vec![VecDeque::new(); LANES];
    for (lane, expected) in expected.iter_mut().enumerate() {
        for turn in 0..6 {
            let spread = if turn % 2 == 0 { u32::MAX } else { 40 };
            let mut merged = Vec::new();
            for side in &mut sources {
                let length = unit.random.random_range(1..=4);
                let list = list(&mut unit, length, spread);
                side[lane].rows.extend(rows(&list));
                merged.extend(list);
            }
            merged.sort_unstable();
            expected.extend(rows(&merged).map(|(row, _)| row));
        }
    }
    stream(&mut unit, &["a", "b"], sources, expected);
}

#[test]
fn bitonic_sorting_units_sort_rows_and_merge_lists_at_45_nm() {
    bitonic_sort("nangate45");
}

#[test]
fn bitonic_sorting_units_sort_rows_and_merge_lists_at_7_nm() {
    bitonic_sort("asap7");
}
