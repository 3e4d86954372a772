//! Trace files: any bytes are a report or an error, and frames or an error.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use powergs_sim::trace::{Reader, verify};

fuzz_target!(|bytes: &[u8]| {
    let _ = verify(bytes);
    if let Ok(mut reader) = Reader::open(Cursor::new(bytes)) {
        for k in 0..reader.len().min(4) {
            let _ = reader.info(k);
            let _ = reader.frame(k);
        }
    }
});
