//! Is the exact ellipse at mini-tile size a contribution test?

use powergs_frame::splat::{ALPHA_MIN, Cover, Intersection, Splat, TileGrid};

use super::support::dense_frame;

/// α of `splat` at a pixel, in double precision.
fn alpha(splat: &Splat, conic: [f32; 3], x: u32, y: u32) -> f64 {
    let [dx, dy] =
        [f64::from(x) - f64::from(splat.mean[0]), f64::from(y) - f64::from(splat.mean[1])];
    let [c0, c1, c2] = conic.map(f64::from);
    let power = -0.5 * (c0 * dx * dx + c2 * dy * dy) - c1 * dx * dy;
    f64::from(splat.opacity) * power.exp()
}

#[test]
fn mini_tiles_of_the_ellipse_are_those_that_contribute() {
    let frame = dense_frame(61);
    let camera = &frame.facts.camera;
    let grid = TileGrid::new(camera.width, camera.height, 4);
    let (mut accepted, mut idle, mut boxed) = (0u32, 0u32, 0u32);
    for splat in &frame.splats {
        let Some(conic) = splat.conic() else { continue };
        let ellipse = Cover::new(splat, grid, Intersection::Ellipse);
        let oriented = Cover::new(splat, grid, Intersection::Obb);
        let rect = splat.tile_rect(&grid);
        for (y, x) in (rect.y0..rect.y1).flat_map(|y| (rect.x0..rect.x1).map(move |x| (y, x))) {
            let (x0, y0, x1, y1) = grid.pixels(x, y);
            let mut pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
            let contributes = pixels.any(|(x, y)| alpha(splat, conic, x, y) >= ALPHA_MIN);
            let hit = ellipse.row(y).is_some_and(|row| (row.x0..row.x1).contains(&x));
            assert!(hit || !contributes, "a contributing mini-tile is left out");
            accepted += u32::from(hit);
            idle += u32::from(hit && !contributes && rect.area() > 1);
            boxed += u32::from(oriented.row(y).is_some_and(|r| (r.x0..r.x1).contains(&x)));
        }
    }
    println!(
        "{} splats: {accepted} accepted, {idle} of them idle; oriented boxes accept {boxed}",
        frame.splats.len()
    );
    // Idle ones: the ellipse passes between pixel centres, or the margin of single precision.
    assert!(f64::from(idle) < 0.04 * f64::from(accepted), "{idle} of {accepted}");
    assert!(accepted < boxed);
}
