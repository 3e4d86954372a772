//! glTF, as JSON or binary: any bytes are a model or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_sim::scene::{OneFile, read};

fuzz_target!(|bytes: &[u8]| {
    let _ = read(&OneFile(bytes), "bytes", None);
});
