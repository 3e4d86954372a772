//! Hostile texts: an error, never a panic or a hang.

use powergs_core::machine::Machine;
use powergs_core::stage::EnergyTable;
use powergs_frame::display::Display;
use proptest::prelude::*;

use super::{gscore, sets};

#[test]
fn an_empty_file_lists_what_is_missing() {
    let error = Machine::parse("").expect_err("an empty file");
    let tables = ["geometry", "record", "ccu", "gsu", "vru", "buffers", "dram"];
    for key in ["name", "description", "clock", "energy"].iter().chain(&tables) {
        let wanted = format!("missing key `{key}`");
        assert!(error.to_string().contains(&wanted), "{key}: {error}");
    }
    assert!(EnergyTable::parse("").is_err());
    assert!(Display::parse("").is_err());
}

#[test]
fn a_file_cut_anywhere_is_refused_or_complete() {
    let text = gscore();
    let last = "controller-latency = \"40 ns\"";
    let last_value = text.rfind(last).expect("the last key") + last.len();
    for end in (0..text.len()).step_by(11).filter(|&i| text.is_char_boundary(i)) {
        assert_eq!(Machine::parse(&text[..end]).is_ok(), end >= last_value, "cut at {end}");
    }
}

#[test]
fn monsters_are_refused() {
    let deep = format!("name = {}{}", "[".repeat(20_000), "]".repeat(20_000));
    let tables = format!("[{}]", vec!["a"; 5_000].join("."));
    let long = format!("name = \"{}\"", "x".repeat(2 << 20));
    let many: String = (0..20_000).map(|i| format!("k{i} = {i}\n")).collect();
    let binary = "\u{0}\u{1}PK\u{3}\u{4}";
    let key = format!("{} = 1", "k".repeat(500_000));
    for text in [&deep, &tables, &long, &many, &key, binary, "\u{feff}", "= = =", "[[vru]]"] {
        let error = Machine::parse(text).expect_err("a monster");
        assert!(!error.problems.is_empty());
        assert!(error.to_string().len() < 10_000_000);
    }
}

#[test]
fn odd_overlays_are_refused_and_named() {
    for set in ["", "=", "x", "=1", ".=1", "vru.=1", ".cores=1", "clock.x=1", "vru=1", "a.b.c=1"] {
        let error = Machine::parse_with(gscore(), &sets(&[set])).expect_err(set);
        assert!(error.to_string().contains(&format!("in --set {set}: ")), "{error}");
    }
    let deep = format!("vru.cores={}", "[".repeat(50_000));
    assert!(Machine::parse_with(gscore(), &sets(&[&deep])).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_mutation_panics(at in 0usize..4000, junk in "[\\PC\n]{0,6}", cut in 0usize..8) {
        let text: Vec<char> = gscore().chars().collect();
        let at = at % text.len();
        let end = (at + cut).min(text.len());
        let bad: String = text[..at].iter().copied().chain(junk.chars())
            .chain(text[end..].iter().copied()).collect();
        if let Err(error) = Machine::parse(&bad) {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
