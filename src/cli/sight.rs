//! Whether a model and its cameras belong together: a word where no view sees anything.

use super::{Context, out};
use powergs_frame::splat::NEAR;
use powergs_raster::{NearCut, most_in_sight, near_cut};
use powergs_scene::{Camera, Gaussians};

/// One in so many Gaussians must be in sight of some view.
const LEAST: u64 = 1000;
/// One in this number of Gaussians in the pictures may be nearer than the near plane.
const NEARER: u64 = 10;

/// Warns of cameras that have next to nothing of `scene` in sight, or much of it before the near
/// plane, before any work is done.
pub fn check(scene: &Gaussians, cameras: &[Camera], context: &Context) {
    let NearCut { cut, drawn } = near_cut(scene, cameras);
    if cut > 0 && NEARER * cut >= cut + drawn {
        warn_of_near_plane(cut, cut + drawn, context);
        return;
    }
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
         dataparser_transforms.json beside the model), or the axes of the cameras or of the model \
         are others (SPZ and glTF files that have those of a PLY: --axes ply)"
    ));
}

/// Warns of Gaussians that are not drawn because they are close to the camera.
fn warn_of_near_plane(cut: u64, all: u64, context: &Context) {
    if context.global.quiet {
        return;
    }
    out::complain(format_args!(
        "warning: {cut} of {all} Gaussians in the pictures are not drawn, because they are within \
         {NEAR} world units of the camera, the near plane of 3DGS: is the scene small? Scale model \
         and cameras up together, until cameras are some units away from what they show"
    ));
}
