//! A corpus of typing errors: every key of the machine file and of an energy table misspelt in
//! several ways, and values that are wrong in every way that we could think of.

use powergs_base::config::embedded::{ENERGY, find};
use powergs_base::config::{ConfigError, Problem};
use powergs_core::machine::Machine;
use powergs_core::stage::EnergyTable;

use super::gscore;

/// (line index, key) of each `key = value` line.
fn keys(text: &str) -> Vec<(usize, &str)> {
    let plain = |k: &str| !k.is_empty() && k.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
    let key = |(i, line): (usize, &'static str)| (i, line.split(" = ").next().unwrap_or(""));
    let lines: Vec<(usize, &'static str)> =
        text.lines().map(|l| &*l.to_owned().leak()).enumerate().collect();
    lines
        .into_iter()
        .filter(|(_, l)| l.contains(" = "))
        .map(key)
        .filter(|(_, k)| plain(k))
        .collect()
}

/// The text with one line changed.
fn with_line(text: &str, index: usize, line: &str) -> String {
    let lines = text.lines().enumerate().map(|(i, l)| if i == index { line } else { l });
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

/// Misspellings of a key.
fn misspelt(key: &str) -> Vec<String> {
    let chars: Vec<char> = key.chars().collect();
    let text = |chars: &[char]| chars.iter().collect::<String>();
    let mut all = vec![key.to_uppercase(), format!("{key}s")];
    let mut dropped = chars.clone();
    dropped.remove(chars.len() / 2);
    all.push(text(&dropped));
    let mut swapped = chars.clone();
    swapped.swap(chars.len() - 2, chars.len() - 1);
    all.push(text(&swapped));
    if key.contains('-') {
        all.push(key.replace('-', "_"));
        all.push(key.replace('-', ""));
    }
    all.retain(|k| k != key);
    all
}

fn check_keys<T>(text: &str, parse: impl Fn(&str) -> Result<T, ConfigError>) -> usize {
    let mut tried = 0;
    for (index, key) in keys(text) {
        let line = text.lines().nth(index).expect("the line");
        for typo in misspelt(key) {
            let bad = with_line(text, index, &line.replacen(key, &typo, 1));
            let error = parse(&bad).err().unwrap_or_else(|| panic!("`{typo}` was accepted"));
            let hit = |p: &&Problem| p.place.line() == Some(index + 1);
            let problem = error.problems.iter().find(hit).unwrap_or_else(|| panic!("{error}"));
            let hint = format!("did you mean `{key}`?");
            assert!(problem.message.contains(&hint), "`{typo}`: {problem}");
            assert_eq!(error.problems.len(), 1, "one mistake, one problem: {error}");
            tried += 1;
        }
    }
    tried
}

#[test]
fn misspelt_keys_are_found_with_their_line_and_the_right_suggestion() {
    assert!(check_keys(gscore(), Machine::parse) >= 100);
    let table = find(ENERGY, "gscore-28nm").expect("the default table");
    assert!(check_keys(table, EnergyTable::parse) >= 30);
}

#[test]
fn misspelt_tables_are_found() {
    for table in ["geometry", "record", "ccu", "gsu", "vru", "buffers", "dram"] {
        let typo = format!("[{}]", &table[..table.len() - 1]);
        let bad = gscore().replace(&format!("[{table}]"), &typo);
        let error = Machine::parse(&bad).expect_err("a misspelt table");
        let text = error.to_string();
        assert!(text.contains(&format!("did you mean `{table}`?")), "{text}");
        assert_eq!(error.problems.len(), 1, "{text}");
    }
}

/// (key in the file, line to put in its place, what the message must say).
const WRONG_VALUES: &[(&str, &str, &str)] = &[
    ("clock", "clock = 1000000000", "needs its unit: write e.g. \"1 GHz\""),
    ("clock", "clock = 1.0", "needs its unit"),
    ("clock", "clock = \"1\"", "needs its unit"),
    ("clock", "clock = \"1 Ghz\"", "unknown unit `Ghz`"),
    ("clock", "clock = \"0 GHz\"", "greater than zero"),
    ("clock", "clock = \"-1 GHz\"", "greater than zero"),
    ("clock", "clock = \"inf GHz\"", "plain decimal number"),
    ("clock", "clock = \"fast\"", "plain decimal number"),
    ("clock", "clock = true", "a frequency with its unit"),
    ("clock", "clock = [\"1 GHz\"]", "a frequency with its unit"),
    ("clock", "clock = { GHz = 1 }", "a frequency with its unit"),
    ("clock", "clock = 2026-01-01", "a frequency with its unit"),
    ("clock", "clock = inf", "needs its unit"),
    ("name", "name = 1", "a text in quotes"),
    ("name", "name = \"a/b\"", "file names"),
    ("name", "name = \"\"", "file names"),
    ("tile", "tile = 7", "must be at least 8"),
    ("tile", "tile = 128", "must be at most 64"),
    ("tile", "tile = -16", "must be at least 8"),
    ("tile", "tile = 16.0", "must be a whole number, not 16.0"),
    ("tile", "tile = \"16\"", "must be a whole number, not the text \"16\""),
    ("tile", "tile = 99999999999999999999999999", "must be at most 64"),
    ("tile", "tile = \"16 px\"", "must be a whole number"),
    ("tile", "tile = [16]", "must be a whole number, not a list"),
    ("tile", "tile = {}", "must be a whole number, not a table"),
    ("subtile", "subtile = 2", "must be at least 4"),
    ("chunk", "chunk = 0", "must be at least 1"),
    ("test", "test = \"OBB\"", "did you mean \"obb\"?"),
    ("test", "test = \"elipse\"", "did you mean \"ellipse\"?"),
    ("test", "test = \"sphere\"", "must be one of \"aabb\", \"obb\", \"ellipse\""),
    ("test", "test = 1", "must be one of"),
    ("position", "position = 6", "a size needs its unit"),
    ("position", "position = \"6 bytes\"", "unknown unit `bytes`"),
    ("position", "position = \"6.5 B\"", "a whole number of bytes"),
    ("units", "units = 0", "must be at least 1"),
    ("operations-per-cycle", "operations-per-cycle = 0", "must be at least 1"),
    ("batch", "batch = 1_000_000", "must be at most 65536"),
    ("fetch", "fetch = \"lazy_colour\"", "did you mean \"lazy-colour\"?"),
    ("pivots", "pivots = 0", "must be at least 1"),
    ("bsu-width", "bsu-width = 1", "must be at least 2"),
    ("bsu-latency", "bsu-latency = -4", "must be at least 0"),
    ("cores", "cores = 0", "must be at least 1"),
    ("cores", "cores = 100000", "must be at most 1024"),
    ("subtile-skipping", "subtile-skipping = 1", "must be true or false, not 1"),
    ("subtile-skipping", "subtile-skipping = \"true\"", "must be true or false"),
    ("sorting", "sorting = \"64 KiB\"", "is a table"),
    ("sorting", "sorting = { capacity = 64 }", "a size needs its unit"),
    ("sorting", "sorting = { size = \"64 KiB\" }", "unknown key `size` in [buffers.sorting]"),
    ("sorting", "sorting = { capacity = \"64 KiB\", ways = 4 }", "unknown key `ways`"),
    ("sorting", "sorting = {}", "missing key `capacity`"),
    ("model", "model = \"bank\"", "must be one of \"bandwidth\""),
    ("efficiency", "efficiency = 1\nbandwidth = \"51.2 GB\"", "unknown unit `GB` for a bandwidth"),
    ("efficiency", "efficiency = 1\nbandwidth = \"51.2\"", "needs its unit"),
    ("efficiency", "efficiency = 0", "must be above 0"),
    ("efficiency", "efficiency = 0.0", "must be above 0"),
    ("efficiency", "efficiency = 1.01", "must be at most 1"),
    ("efficiency", "efficiency = nan", "must be a finite number"),
    ("efficiency", "efficiency = \"78 %\"", "must be a number"),
    ("pixel", "pixel = \"3 B\"\npixel = \"4 B\"", "duplicate key"),
    ("pixel", "pixel = 3 B", "not valid TOML"),
    ("pixel", "pixel", "not valid TOML"),
    ("pixel", "pixel = \"3 B", "not valid TOML"),
];

#[test]
fn wrong_values_are_refused_with_their_line_and_what_to_write() {
    for (key, replacement, because) in WRONG_VALUES {
        let (index, _) =
            keys(gscore()).into_iter().find(|(_, k)| k == key).unwrap_or_else(|| panic!("{key}"));
        let bad = with_line(gscore(), index, replacement);
        let Err(error) = Machine::parse(&bad) else { panic!("`{replacement}` was accepted") };
        let last = index + replacement.lines().count();
        let hit = error.problems.iter().find(|p| p.message.contains(because));
        let hit = hit.unwrap_or_else(|| panic!("`{replacement}`: {error}"));
        let line = hit.place.line().expect("a place in the file");
        assert!((index + 1..=last).contains(&line), "`{replacement}`: {error}");
    }
}

#[test]
fn a_key_of_another_table_is_pointed_to() {
    let bad = gscore().replace("[dram]", "[dram]\npivots = 7");
    let error = Machine::parse(&bad).expect_err("a misplaced key").to_string();
    assert!(
        error.contains("unknown key `pivots` in [dram]; did you mean `gsu.pivots`?"),
        "{error}"
    );
}
