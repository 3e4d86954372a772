//! Writes the seed corpus of the fuzz targets: `cargo run --example fuzz_seeds [FOLDER]`
//! (default `fuzz/corpus`). The same bytes are mutated by ordinary tests.

use std::path::PathBuf;

#[path = "../tests/it/camera/encode.rs"]
mod camera;
#[path = "../tests/it/scene/encode.rs"]
mod scene;
// The tests use more of it than the seeds do.
#[allow(dead_code)]
#[path = "../tests/it/trace/support.rs"]
mod trace;

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os().nth(1).map_or("fuzz/corpus".into(), PathBuf::from);
    // A target of another reader adds its own `seeds()` to this chain.
    let seeds = camera::seeds().into_iter().chain(scene::seeds()).chain(trace::seeds());
    for (target, name, bytes) in seeds {
        let corpus = folder.join(target);
        std::fs::create_dir_all(&corpus)?;
        std::fs::write(corpus.join(name), bytes)?;
    }
    Ok(())
}
