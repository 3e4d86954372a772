//! Whether a model and its cameras belong together: a word where no view sees anything.

use super::{Context, out};
use powergs_raster::most_in_sight;
use powergs_scene::{Camera, Gaussians};

/// One in so many Gaussians must be in sight of some view.
const LEAST: u64 = 1000;

/// Warns of cameras that have next to nothing of `scene` in sight, before any work is done.
pub fn check(scene: &Gaussians, cameras: &[Camera], context: &Context) {
    let points = scene.len() as u64;
    let enough = points.div_ceil(LEAST);
    warn(most_in_sight(scene, cameras, enough), points, context);
}

/// Warns where the view that sees most has only so many of `points` Gaussians in sight.
pub fn warn(most: u64, points: u64, context: &Context) {
    if most >= points.div_ceil(LEAST) || context.global.quiet {
        return;
    }
    let seen = match most {
        0 => "no Gaussian is".to_owned(),
        most => format!("at most {most} of {points} Gaussians are"),
    };
    out::complain(format_args!(
        "warning: {seen} in view in any frame: do the model and the cameras belong together? \
         Usually a trainer moved and scaled the model (nerfstudio: put its \
         dataparser_transforms.json beside the model), or the axes of the cameras are others"
    ));
}
