//! A scene reader of one's own: a text format that the program does not know becomes a model in
//! memory, is seen by cameras on an orbit, and runs on a machine without any file in between.
//!
//! ```console
//! $ cargo run --release --example own_scene
//! ```
//!
//! A line of the format is a Gaussian: position, one size, opacity and a colour, as
//! `x y z size opacity r g b`. What a reader has to fill in is [`Gaussians`]: *raw* parameters
//! (logarithm of the size, opacity before the logistic function, SH coefficients).

use std::f64::consts::{FRAC_PI_3, TAU};
use std::sync::Arc;

use glam::DVec3;
use powergs_sim::model::RenderedViews;
use powergs_sim::model::scene::{Camera, Gaussians};
use powergs_sim::run::{RunError, Session, System};

/// The constant of the first spherical harmonic: a colour is `0.5 + C0 * coefficient`.
const C0: f32 = 0.282_094_79;

/// Reads the format; an error names the line.
fn read(text: &str) -> Result<Gaussians, String> {
    let mut scene = Gaussians::with_capacity(text.lines().count(), 0);
    for (i, line) in text.lines().enumerate() {
        let numbers: Result<Vec<f32>, _> = line.split_whitespace().map(str::parse).collect();
        let numbers = numbers.map_err(|e| format!("line {}: {e}", i + 1))?;
        let &[x, y, z, size, opacity, r, g, b] = numbers.as_slice() else {
            return Err(format!("line {}: {} numbers, 8 are wanted", i + 1, numbers.len()));
        };
        if !numbers.iter().all(|n| n.is_finite()) || size <= 0.0 || !(0.0..1.0).contains(&opacity) {
            return Err(format!("line {}: a size must be above 0, an opacity in 0..1", i + 1));
        }
        scene.means.push([x, y, z]);
        scene.log_scales.push([size.ln(); 3]);
        scene.rotations.push([1.0, 0.0, 0.0, 0.0]);
        scene.logit_opacities.push((opacity / (1.0 - opacity)).ln());
        scene.sh.extend([r, g, b].map(|c| (c - 0.5) / C0));
    }
    Ok(scene)
}

fn main() -> Result<(), RunError> {
    // A spiral of two thousand blobs.
    let line = |i: u32| {
        let t = f64::from(i) / 2000.0;
        let (sin, cos) = (t * 9.0 * TAU).sin_cos();
        let red = 0.2 + 0.8 * t;
        format!("{} {} {} 0.03 0.7 {red} 0.4 0.6", t * cos, 2.0 * t - 1.0, t * sin)
    };
    let text: Vec<String> = (0..2000).map(line).collect();
    let scene = read(&text.join("\n")).map_err(RunError::Request)?;
    let orbit = |i: u32| {
        let angle = f64::from(i) / 4.0 * TAU;
        let centre = DVec3::new(3.0 * angle.cos(), 0.5, 3.0 * angle.sin());
        let mut camera = Camera::looking_at(centre, DVec3::ZERO, DVec3::Y, FRAC_PI_3, (640, 360));
        camera.name = format!("view {i}");
        camera
    };
    let cameras = (0..4).map(orbit).collect();
    let mut views = RenderedViews::new("spiral", Arc::new(scene), cameras);
    let systems = [System::named("gscore")?];
    let reports = Session::new(&mut views, &()).reports(&systems)?;
    for report in &reports[0] {
        let fps = report.achieved_fps().unwrap_or(0.0);
        println!("{}: {:.0} FPS, {} tile pairs", report.name, fps, report.counters.tile_pairs);
    }
    Ok(())
}
