//! COLMAP cameras.bin and images.bin: any bytes are views or an error. points3D: any bytes are
//! points or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_sim::scene::camera::colmap::{read_binary, read_points_binary, read_points_text};

fuzz_target!(|bytes: &[u8]| {
    let Some((length, rest)) = bytes.split_first_chunk::<2>() else { return };
    let (cameras, images) = rest.split_at(rest.len().min(usize::from(u16::from_le_bytes(*length))));
    let _ = read_binary(cameras, images);
    let _ = read_points_binary(rest);
    let _ = read_points_text(rest);
});
