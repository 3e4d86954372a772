//! Picture files: any bytes are a picture of the promised size within the limits, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_pixels::{Limits, decode, size};

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { side: 4096, bytes: 16 << 20 };
    let Ok(picture) = decode(bytes, limits) else { return };
    assert_eq!(size(bytes).ok(), Some((picture.width, picture.height)));
    let pixels = picture.width as usize * picture.height as usize;
    assert_eq!(picture.rgba().count(), pixels);
    assert_eq!(picture.rgba8().len(), pixels);
});
