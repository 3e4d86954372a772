//! What the tests of several crates need: scenes, traces, files in every format, frozen numbers.

pub mod bombs;
pub mod camera_files;
pub mod charts;
pub mod difference;
pub mod display;
pub mod docs;
pub mod foveated;
pub mod lpips;
pub mod scene_files;
pub mod scenes;
pub mod traces;
pub mod verilator;

/// The folder of real data, where it is there.
pub fn data() -> Option<std::path::PathBuf> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let found = std::path::PathBuf::from(path);
    if !found.is_dir() {
        println!("skipped: ../shared/data is absent");
        return None;
    }
    Some(found)
}
