//! Journals of sweeps: any lines are records or are skipped, also with right checksums.
#![no_main]

use std::io::BufReader;

use libfuzzer_sys::fuzz_target;
use powergs_sim::run::store::journal::{Index, append, parse};
use powergs_sim::sweep::Record;

fuzz_target!(|bytes: &[u8]| {
    let mut index = Index::default();
    let whole = index.read(0, BufReader::new(bytes), 0).expect("memory");
    assert!(whole <= bytes.len() as u64);
    for line in bytes.split(|&b| b == b'\n') {
        if let Some((_, record)) = parse(line) {
            let _ = Record::parse(record);
        }
        let Ok(record) = std::str::from_utf8(line) else { continue };
        let mut sealed = Vec::new();
        append(&mut sealed, 9, record).expect("memory");
        // Records are JSON: white space at the end of a line is not part of them.
        assert_eq!(parse(&sealed), Some((9, record.trim_end())));
        if let Some(record) = Record::parse(record) {
            assert!(Record::parse(&record.text()).is_some());
        }
    }
});
