//! The scenes of the benches: a trained one where it is there, and synthetic ones of fixed sizes.

use std::path::Path;

use powergs_sim::cli::camera_file;
use powergs_sim::scene::camera::edit;
use powergs_sim::scene::synth::{Preset, cameras, generate};
use powergs_sim::scene::{Camera, Gaussians, OneFile, read};

/// A scene and one view of it.
pub struct Case {
    /// Name in tables.
    pub name: &'static str,
    /// The model.
    pub scene: Gaussians,
    /// The view.
    pub camera: Camera,
}

/// All cases.
pub fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = trained().into_iter().collect();
    cases.push(synthetic("synthetic 100k 979x546", "outdoor-bounded", 100_000, (979, 546)));
    cases.push(synthetic("synthetic 1M 1600x1064", "outdoor-unbounded", 1_000_000, (1600, 1064)));
    cases
}

/// A preset at another number of Gaussians and image size.
pub fn synthetic(name: &'static str, preset: &str, points: usize, size: (u32, u32)) -> Case {
    let preset = Preset::named(preset).expect("a preset");
    let scene = generate(preset, points, 1);
    let camera = edit::resized(&cameras(preset)[0], size.0, size.1);
    Case { name, scene, camera }
}

/// The 250,000-Gaussian robot of `../shared/data` at 1920x1080.
fn trained() -> Option<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/playcanvas-playbot");
    let bytes = std::fs::read(folder.join("playbot_lod1_sh2.ply")).ok()?;
    let scene = read(&OneFile(&bytes), "playbot_lod1_sh2.ply", None).ok()?.gaussians;
    let file = camera_file::read(&folder.join("cameras.json"), None).ok()?;
    let camera = edit::resized(&file.cameras[3], 1920, 1080);
    Some(Case { name: "trained robot 250k 1920x1080", scene, camera })
}
