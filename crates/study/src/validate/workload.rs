//! The frames on which rows are measured.

use powergs_scene::Camera;
use powergs_scene::camera::edit::{resized, stereo};
use powergs_scene::camera::path::Path;
use powergs_scene::synth::{Preset, cameras};

/// A synthetic scene and its views.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Workload {
    /// Its name in rows.
    pub name: String,
    /// Name of the `synth` preset.
    pub preset: String,
    /// Seed of the scene.
    pub seed: u64,
    /// Image size, pixels.
    pub size: (u32, u32),
    /// Number of views.
    pub views: usize,
    /// Where above zero: frames of a smooth path through the views of the preset, of which the
    /// first `views + 1` are taken. The first of these warms up and is not counted.
    pub path: usize,
    /// Where above zero: thousandths of a world unit between the eyes that see each view, with
    /// square pixels and the field of view across of the preset.
    pub eyes: u32,
    /// Whether rows on it belong to a quick run.
    pub quick: bool,
    /// Which published statistics it matches.
    pub why: String,
}

impl Workload {
    /// What decides the scene: workloads with the same key share it.
    pub(crate) fn scene_key(&self) -> (&str, u64) {
        (&self.preset, self.seed)
    }

    /// The preset.
    pub fn preset(&self) -> Option<&'static Preset> {
        Preset::named(&self.preset)
    }

    /// Frames that are counted: the views, each by both eyes where it has them.
    pub fn frames(&self) -> usize {
        self.views * if self.eyes > 0 { 2 } else { 1 }
    }

    /// Frames that are simulated but not counted.
    pub fn warm_up(&self) -> usize {
        usize::from(self.path > 0)
    }

    /// The views, warm-up included.
    pub fn cameras(&self, preset: &Preset) -> Vec<Camera> {
        let (width, height) = self.size;
        let all = cameras(preset);
        let chosen: Vec<Camera> = if self.path > 0 {
            let path = Path::through(&all).map(|path| path.frames(self.path)).unwrap_or(all);
            path.into_iter().take(self.views + 1).collect()
        } else {
            let count = self.views.min(all.len());
            (0..count).map(|i| all[i * all.len() / count].clone()).collect()
        };
        if self.eyes == 0 {
            return chosen.iter().map(|camera| resized(camera, width, height)).collect();
        }
        let pair = |camera: &Camera| {
            let mut own = resized(camera, width, height);
            (own.fy, own.cy) = (own.fx, 0.5 * f64::from(height));
            stereo(&own, 1e-3 * f64::from(self.eyes))
        };
        chosen.iter().flat_map(pair).collect()
    }
}
