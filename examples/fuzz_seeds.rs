//! Writes the seed corpus of the fuzz targets: `cargo run --example fuzz_seeds [FOLDER]`
//! (default `fuzz/corpus`). The same bytes are mutated by ordinary tests.

use std::path::PathBuf;

use powergs_testkit::{camera_files, scene_files, traces};

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os().nth(1).map_or("fuzz/corpus".into(), PathBuf::from);
    // A target of another reader adds its own `seeds()` to this chain.
    let seeds =
        camera_files::seeds().into_iter().chain(scene_files::seeds()).chain(traces::seeds());
    for (target, name, bytes) in seeds {
        let corpus = folder.join(target);
        std::fs::create_dir_all(&corpus)?;
        std::fs::write(corpus.join(name), bytes)?;
    }
    Ok(())
}
