//! Foveated models: any bytes are a model or an error, also behind a right header.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_sim::scene::{Foveated, OneFile, read};

fuzz_target!(|bytes: &[u8]| {
    let _ = read(&OneFile(bytes), "bytes", None);
    let mut sealed = bytes.to_vec();
    if let Some(head) = sealed.get(..28) {
        let crc = crc32fast::hash(head).to_le_bytes();
        if let Some(place) = sealed.get_mut(28..32) {
            place.copy_from_slice(&crc);
        }
    }
    if let Ok(model) = Foveated::read(sealed.as_slice().into()) {
        let mut again = Vec::new();
        model.write(&mut again).expect("memory");
        assert_eq!(again[32..], sealed[32..]);
    }
});
