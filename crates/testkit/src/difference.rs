//! How far apart two models are.

use powergs_frame::scene::Gaussians;

/// Largest absolute differences.
#[derive(Debug)]
pub struct Difference {
    pub mean: f32,
    pub log_scale: f32,
    /// Of quaternion components, with the sign that fits better.
    pub rotation: f32,
    /// After the logistic function.
    pub opacity: f64,
    pub dc: f32,
    /// SH coefficients beyond DC.
    pub rest: f32,
}

pub fn difference(a: &Gaussians, b: &Gaussians) -> Difference {
    use powergs_scene::convert::sigmoid;
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
