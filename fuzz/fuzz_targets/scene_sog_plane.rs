//! The images of SOG: the bytes are every image of a folder. A zip archive would hide them from
//! mutation behind its checksums.
#![no_main]

use std::io;

use libfuzzer_sys::fuzz_target;
use powergs_sim::scene::{Folder, Input, read};

struct Planes<'a>(&'a [u8]);

const META: &str = r#"{
    "means": { "shape": [3, 3], "mins": [-1, -1, -1], "maxs": [1, 1, 1], "files": ["a", "a"] },
    "scales": { "mins": [-6, -6, -6], "maxs": [-2, -2, -2], "files": ["a"] },
    "quats": { "files": ["a"] },
    "sh0": { "mins": [-1, -1, -1, -3], "maxs": [1, 1, 1, 3], "files": ["a"] }
}"#;

impl Folder for Planes<'_> {
    fn open(&self, name: &str) -> io::Result<Input<'_>> {
        Ok(if name == "meta.json" { META.as_bytes().into() } else { self.0.into() })
    }
}

fuzz_target!(|bytes: &[u8]| {
    let _ = read(&Planes(bytes), "meta.json", None);
});
