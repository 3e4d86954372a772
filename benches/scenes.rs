//! Synthetic scenes of fixed sizes for the benches.

use powergs_sim::scene::camera::edit;
use powergs_sim::scene::synth::{Preset, cameras, generate};
use powergs_sim::scene::{Camera, Gaussians};

/// A scene and one view of it.
pub struct Case {
    /// The model.
    pub scene: Gaussians,
    /// The view.
    pub camera: Camera,
}

/// A preset at another number of Gaussians and image size.
pub fn synthetic(preset: &str, points: usize, size: (u32, u32)) -> Case {
    let preset = Preset::named(preset).expect("a preset");
    let scene = generate(preset, points, 1);
    let camera = edit::resized(&cameras(preset)[0], size.0, size.1);
    Case { scene, camera }
}
