//! Rendered frames to bin.

use powergs_core::workload::Geometry;
use powergs_frame::splat::Intersection;
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, Options, Rendered, render};
use powergs_scene::{Camera, Gaussians};
use powergs_testkit::scenes::{front_camera, random_scene};

pub fn rendered(scene: &Gaussians, camera: &Camera) -> (Rendered, Frame) {
    let rendered = render(scene, camera, &Options::reference(Detail::Counters));
    let frame = rendered.clone().into_frame(camera, [0.0; 3]);
    (rendered, frame)
}

/// Opaque enough that pixels stop, dense enough that tiles have several chunks of 64.
pub fn dense_scene(seed: u64) -> (Gaussians, Camera) {
    let mut scene = random_scene(seed, 6000, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 1.0);
    (scene, front_camera(150, 90))
}

pub fn dense_frame(seed: u64) -> Frame {
    let (scene, camera) = dense_scene(seed);
    rendered(&scene, &camera).1
}

/// A frame of a few hundred splats in an image that is no multiple of any tile, for direct counts.
pub fn small_frame(seed: u64) -> Frame {
    let mut scene = random_scene(seed, 500, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
    rendered(&scene, &front_camera(75, 51)).1
}

/// A small frame as if it had been seen from further to the right: its pixels come from elsewhere.
pub fn moved_frame(seed: u64, step: f64) -> Frame {
    let mut frame = small_frame(seed);
    frame.facts.camera.centre.x += step;
    frame
}

/// The same frame, and what an eye a little further to the right sees.
pub fn small_frames(seed: u64) -> [Frame; 2] {
    [0.0, 0.03].map(|x| {
        let mut scene = random_scene(seed, 500, 0);
        scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
        let mut camera = front_camera(75, 51);
        camera.centre.x += x;
        rendered(&scene, &camera).1
    })
}

/// Tile, sub-tile, sort group, chunk, test.
pub const GEOMETRIES: [Geometry; 5] = [
    geometry(16, 8, 16, 32, Intersection::Obb),
    geometry(32, 4, 64, 50, Intersection::Obb),
    geometry(8, 8, 32, 7, Intersection::Aabb),
    geometry(64, 16, 64, 256, Intersection::Ellipse),
    geometry(16, 4, 512, 20, Intersection::Ellipse),
];

const fn geometry(
    tile: u32,
    subtile: u32,
    sort_group: u32,
    chunk: u32,
    test: Intersection,
) -> Geometry {
    Geometry { tile, subtile, sort_group, chunk, test, ..Geometry::REFERENCE }
}
