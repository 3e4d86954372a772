//! Writers of models: what they hold, what they refuse, and that both are said.

mod compressed_ply;
mod gltf;
mod hostile;
mod laws;
mod real;
mod sog;
mod spz;

use powergs_scene::export::{Export, Fidelity, Files, Target, write};
use powergs_scene::{Gaussians, Model, OneFile, read};

/// What is written is read back.
fn read_back(export: &Export) -> Model {
    match &export.files {
        Files::One(bytes) => read(&OneFile(bytes), "file", None).expect("our own file"),
        Files::Folder(files) => read(files, "meta.json", None).expect("our own folder"),
    }
}

/// Writes, reads back, writes what was read and reads that.
fn twice(scene: &Gaussians, target: Target) -> (Gaussians, Fidelity, Gaussians, Fidelity) {
    let first = write(scene, target).expect("a sound model");
    let once = read_back(&first).gaussians;
    let second = write(&once, target).expect("a model that was read");
    let again = read_back(&second).gaussians;
    (once, first.fidelity, again, second.fidelity)
}
