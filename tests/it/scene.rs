//! Scene files: readers against writers, against real data, and against hostile bytes.

mod command;
mod data;
mod encode;
mod hostile;
mod layouts;
mod round_trip;

use powergs_sim::scene::{Gaussians, Model, OneFile, SceneError, read};

/// Reads bytes of any single-file format.
fn read_bytes(bytes: &[u8]) -> Result<Model, SceneError> {
    read(&OneFile(bytes), "bytes", None)
}

/// Largest absolute differences.
#[derive(Debug)]
struct Difference {
    mean: f32,
    log_scale: f32,
    /// Of quaternion components, with the sign that fits better.
    rotation: f32,
    /// After the logistic function.
    opacity: f64,
    dc: f32,
    /// SH coefficients beyond DC.
    rest: f32,
}

fn difference(a: &Gaussians, b: &Gaussians) -> Difference {
    use powergs_sim::scene::convert::sigmoid;
    assert_eq!((a.len(), a.sh_degree), (b.len(), b.sh_degree));
    let rows = |x: &[[f32; 3]], y: &[[f32; 3]]| worst(x.as_flattened(), y.as_flattened());
    let rotation = a.rotations.iter().zip(&b.rotations).map(|(p, q)| {
        let minus = q.map(|c| -c);
        worst(p, q).min(worst(p, &minus))
    });
    let opacity = a.logit_opacities.iter().zip(&b.logit_opacities);
    let n = a.sh_coefficients();
    let coefficients = || a.sh.iter().zip(&b.sh).map(|(x, y)| (x - y).abs()).enumerate();
    Difference {
        mean: rows(&a.means, &b.means),
        log_scale: rows(&a.log_scales, &b.log_scales),
        rotation: rotation.fold(0.0, f32::max),
        opacity: opacity.map(|(x, y)| (sigmoid(*x) - sigmoid(*y)).abs()).fold(0.0, f64::max),
        dc: coefficients().filter(|(i, _)| i % n == 0).map(|(_, d)| d).fold(0.0, f32::max),
        rest: coefficients().filter(|(i, _)| i % n != 0).map(|(_, d)| d).fold(0.0, f32::max),
    }
}

fn worst(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max)
}

/// The folder of real data, where it is there.
fn data() -> Option<std::path::PathBuf> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data");
    let found = std::path::PathBuf::from(path);
    if !found.is_dir() {
        println!("skipped: ../shared/data is absent");
        return None;
    }
    Some(found)
}
