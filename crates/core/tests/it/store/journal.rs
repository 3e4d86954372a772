//! The journal survives whatever a killed run or a bad disk leaves of it.

use powergs_core::run::store::journal::{Index, append, parse};
use proptest::prelude::*;

/// What the record of a key says.
fn record(key: u128) -> String {
    format!("{{\"value\":{},\"note\":\"frame {key}: broke\"}}", 0.1 * key as f64)
}

fn lines(count: u128) -> Vec<Vec<u8>> {
    let line = |key| {
        let mut line = Vec::new();
        append(&mut line, key, &record(key)).unwrap();
        line
    };
    (1..=count).map(line).collect()
}

#[test]
fn what_is_appended_is_found_and_the_same() {
    let lines = lines(20);
    let text = lines.concat();
    let mut index = Index::default();
    assert_eq!(index.read(7, text.as_slice(), 0).unwrap(), text.len() as u64);
    assert_eq!((index.len(), index.damaged), (20, 0));
    for key in 1..=20u128 {
        let place = index.place(key).unwrap();
        assert_eq!(place.journal, 7);
        let line = &text[place.offset as usize..][..place.length as usize];
        assert_eq!(parse(line), Some((key, record(key).as_str())));
    }
    assert_eq!(index.place(21), None);
}

#[test]
fn the_first_of_two_records_stays() {
    let mut text = Vec::new();
    append(&mut text, 5, "first").unwrap();
    let first = text.len();
    append(&mut text, 5, "second").unwrap();
    let mut index = Index::default();
    index.read(0, text.as_slice(), 0).unwrap();
    assert_eq!(index.place(5).unwrap().length as usize, first);
}

#[test]
fn a_journal_that_is_cut_anywhere_keeps_its_whole_lines() {
    let lines = lines(4);
    let text = lines.concat();
    for cut in 0..text.len() {
        let mut index = Index::default();
        let end = index.read(0, &text[..cut], 0).unwrap() as usize;
        let mut whole = 0;
        let count = lines.iter().take_while(|line| {
            whole += line.len();
            whole <= cut
        });
        let count = count.count();
        assert_eq!(index.len(), count, "cut at byte {cut}");
        assert_eq!(end, lines[..count].iter().map(Vec::len).sum::<usize>());
        assert_eq!(index.damaged, u64::from(end < cut));
    }
}

proptest! {
    #[test]
    fn a_flipped_bit_loses_its_line_and_no_other(at in 0usize..2000, bit in 0u8..8) {
        let lines = lines(6);
        let mut text = lines.concat();
        let at = at % text.len();
        text[at] ^= 1 << bit;
        let mut index = Index::default();
        index.read(0, text.as_slice(), 0).unwrap();
        // A flip can make or break a line end: then two lines are lost.
        prop_assert!(index.len() >= 4 && index.len() < 6, "{} lines", index.len());
        prop_assert!(index.damaged >= 1);
    }

    #[test]
    fn any_bytes_are_read(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let mut index = Index::default();
        index.read(0, bytes.as_slice(), 0).unwrap();
        prop_assert!(index.is_empty());
        prop_assert!(parse(&bytes).is_none());
    }
}
