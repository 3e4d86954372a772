//! Views of a scene, rendered and binned.

use super::Workload;
use powergs_core::workload::{FrameWorkload, Geometry, bin};
use powergs_raster::{Detail, Options, render};
use powergs_scene::Gaussians;
use powergs_scene::synth::Preset;

/// One view, binned for one geometry.
pub(super) struct Step {
    /// The frame.
    pub frame: FrameWorkload,
    /// Whether it counts, or only warms up.
    pub counts: bool,
}

/// Hands the views of a workload to `each`, every one once per geometry.
pub(super) fn scene_steps<E>(
    scene: &Gaussians,
    preset: &Preset,
    workload: &Workload,
    geometries: &[Geometry],
    mut each: impl FnMut(&Step) -> Result<(), E>,
) -> Result<(), E> {
    let options = Options::reference(Detail::Counters);
    for (i, camera) in workload.cameras(preset).iter().enumerate() {
        let frame = render(scene, camera, &options).into_frame(camera, options.background);
        for &geometry in geometries {
            let step = Step { frame: bin(&frame, geometry), counts: i >= workload.warm_up() };
            each(&step)?;
        }
    }
    Ok(())
}
