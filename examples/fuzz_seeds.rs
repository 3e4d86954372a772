//! Writes the seed corpus of the fuzz targets: `cargo run --example fuzz_seeds [FOLDER]`
//! (default `fuzz/corpus`). The same bytes are mutated by ordinary tests.

use std::path::PathBuf;

use powergs_sim::config::embedded::{ENERGY, MACHINES, SWEEPS};
use powergs_sim::optimize::checkpoint::Checkpoints;
use powergs_sim::optimize::tune::Model;
use powergs_sim::run::store::journal;
use powergs_sim::run::{MemoryStore, RunError, Store};
use powergs_testkit::{camera_files, scene_files, traces};

/// The fuzz target, the name of a file, its bytes.
type Seed = (&'static str, &'static str, Vec<u8>);

/// Checkpoints of a run that has just begun, and of a model.
fn checkpoints() -> Result<Vec<Seed>, RunError> {
    let store = MemoryStore::new();
    let checkpoints = Checkpoints::new(&store, 7);
    checkpoints.save(&[], &[], None)?;
    checkpoints.save_model("job", &Model::fresh(&scene_files::sample(3, 1)))?;
    let seed = |name| Ok(store.read(&format!("checkpoints/{name}.ckpt"))?.unwrap_or_default());
    Ok(vec![("checkpoint", "progress", seed("progress")?), ("checkpoint", "model", seed("job")?)])
}

/// A journal, and what comes with the program as configuration.
fn texts() -> std::io::Result<Vec<Seed>> {
    let mut lines = Vec::new();
    let outcome = r#"{"ok":{"samples":[[0.5,2.0,0.25]],"means":[1.0,null]}}"#;
    for (key, record) in [(1, r#"{"failed":"too small"}"#), (2, outcome)] {
        journal::append(&mut lines, key, record)?;
    }
    let files = MACHINES.iter().chain(ENERGY).chain(SWEEPS);
    let files = files.map(|file| ("config", file.name, file.text.as_bytes().to_vec()));
    Ok(std::iter::once(("journal", "two", lines)).chain(files).collect())
}

/// Invented cells, a circuit of them, and the smallest netlist of a unit.
fn netlists() -> [Seed; 3] {
    let cells = include_bytes!("../lab/gates/tests/data/invented.lib");
    let circuit = include_bytes!("../lab/gates/tests/data/gated.json");
    let priced = include_bytes!("../rtl/netlists/qsu-nangate45.gates");
    [
        ("liberty", "invented.lib", cells.to_vec()),
        ("mapped_json", "gated.json", circuit.to_vec()),
        ("gates", "qsu.gates", priced.to_vec()),
    ]
}

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os().nth(1).map_or("fuzz/corpus".into(), PathBuf::from);
    // A target of another reader adds its own `seeds()` to this chain.
    let files = camera_files::seeds().into_iter().chain(scene_files::seeds());
    let pictures = scene_files::sog(&scene_files::sample(9, 2), 2).into_iter();
    let pictures = pictures.filter(|(name, _)| name.ends_with(".webp")).take(1);
    let pictures = pictures.map(|(_, bytes)| ("picture", "plane.webp", bytes));
    let mut png = Vec::new();
    powergs_pixels::write_png(&mut png, 3, 2, &[90; 18])?;
    let seeds = files.chain(traces::seeds()).chain(pictures).chain([("picture", "small.png", png)]);
    let seeds = seeds.chain(checkpoints().map_err(std::io::Error::other)?).chain(texts()?);
    let seeds = seeds.chain(netlists());
    for (target, name, bytes) in seeds {
        let corpus = folder.join(target);
        std::fs::create_dir_all(&corpus)?;
        std::fs::write(corpus.join(name), bytes)?;
    }
    Ok(())
}
