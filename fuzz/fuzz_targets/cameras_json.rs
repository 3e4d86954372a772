//! cameras.json and transforms.json: any text is views or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_sim::scene::camera::json::read;

fuzz_target!(|text: &str| {
    let _ = read(text, Some((64, 48)));
});
