//! Trace files whose checksums are made right: what is behind them holds up too.
#![no_main]

#[path = "../../crates/frame/tests/it/trace/seal.rs"]
mod seal;

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use powergs_sim::trace::{Reader, verify};

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = bytes.to_vec();
    seal::seal(&mut bytes);
    let _ = verify(bytes.as_slice());
    if let Ok(mut reader) = Reader::open(Cursor::new(&bytes)) {
        for k in 0..reader.len().min(4) {
            let _ = reader.info(k);
            let _ = reader.frame(k);
        }
    }
});
