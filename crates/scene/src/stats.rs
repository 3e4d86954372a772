//! Facts about a model: bounds, percentiles, shares, oddities.

use serde::Serialize;

use super::convert::sigmoid;
use super::{Gaussians, Warning};
use powergs_frame::splat::{ALPHA_MIN, NEAR};

/// Opacities below this are faint: the median of trained scenes lies there (FlashGS).
const FAINT: f64 = 0.35;
/// Axis ratios from this on count as elongated (FLICKER calls them spiky).
const ELONGATED: f32 = 3.0;

/// Fewer Gaussians than this are no scene.
const FEW: u64 = 16;

/// Quaternions within this of length 1 count as normalised.
const LENGTH_MARGIN: f32 = 0.01;

/// Values below which a share of the data lies, in percent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Percentiles {
    /// 1 % of the values lie below.
    pub p1: f64,
    /// 5 %.
    pub p5: f64,
    /// 25 %.
    pub p25: f64,
    /// The median.
    pub p50: f64,
    /// 75 %.
    pub p75: f64,
    /// 95 %.
    pub p95: f64,
    /// 99 %.
    pub p99: f64,
}

impl Percentiles {
    /// Name and value of each, in order.
    pub fn named(&self) -> [(&'static str, f64); 7] {
        let Self { p1, p5, p25, p50, p75, p95, p99 } = *self;
        let values = [p1, p5, p25, p50, p75, p95, p99];
        std::array::from_fn(|i| (["p1", "p5", "p25", "p50", "p75", "p95", "p99"][i], values[i]))
    }

    fn of(p: [f64; 7]) -> Self {
        Self { p1: p[0], p5: p[1], p25: p[2], p50: p[3], p75: p[4], p95: p[5], p99: p[6] }
    }
}

/// An axis-aligned box, world units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bounds {
    /// Lowest x, y, z.
    pub min: [f32; 3],
    /// Highest x, y, z.
    pub max: [f32; 3],
}

impl Bounds {
    /// Length of the diagonal, world units.
    pub(crate) fn diagonal(&self) -> f64 {
        let side = |axis: usize| f64::from(self.max[axis]) - f64::from(self.min[axis]);
        (0..3).map(|axis| side(axis).powi(2)).sum::<f64>().sqrt()
    }
}

/// Facts about a model, with stable names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneStats {
    /// Gaussians.
    pub points: u64,
    /// Degree of the spherical harmonics.
    pub sh_degree: u8,
    /// Bytes in memory.
    pub memory_bytes: u64,
    /// Bounds of the centres, world units.
    pub bounds: Bounds,
    /// Percentiles of each coordinate of the centres, world units.
    pub position: [Percentiles; 3],
    /// Percentiles of the opacity, 0 to 1.
    pub opacity: Percentiles,
    /// Percentiles of the standard deviations along all three axes, world units.
    pub scale: Percentiles,
    /// Percentiles of the longest over the shortest axis.
    pub axis_ratio: Percentiles,
    /// Share of Gaussians with an opacity below 0.35.
    pub share_opacity_below_0_35: f64,
    /// Share of Gaussians whose longest axis is at least 3 times their shortest.
    pub share_axis_ratio_at_least_3: f64,
    /// Share of Gaussians whose longest axis is at least 3 times their middle one: needles, which
    /// stay elongated in most views, while flat discs do not.
    pub share_needles_at_least_3: f64,
}

impl SceneStats {
    /// Measures `scene`, and warns of oddities. The model must not be empty.
    pub fn of(scene: &Gaussians) -> (Self, Vec<Warning>) {
        assert!(!scene.is_empty(), "readers refuse models without Gaussians");
        let n = scene.len() as f64;
        let bounds = bounds(scene);
        let axes: Vec<[f32; 3]> = scene.log_scales.iter().map(sorted).collect();
        let opacities: Vec<f64> = scene.logit_opacities.iter().map(|&o| sigmoid(o)).collect();
        let share = |count: usize| count as f64 / n;
        let ratio = ELONGATED.ln();
        let stats = Self {
            points: scene.len() as u64,
            sh_degree: scene.sh_degree,
            memory_bytes: scene.bytes(),
            bounds,
            position: std::array::from_fn(|axis| {
                percentiles(scene.means.iter().map(|m| f64::from(m[axis])).collect())
            }),
            scale: exp(percentiles(
                scene.log_scales.iter().flatten().map(|&s| f64::from(s)).collect(),
            )),
            axis_ratio: exp(percentiles(axes.iter().map(|a| f64::from(a[2] - a[0])).collect())),
            share_opacity_below_0_35: share(opacities.iter().filter(|o| **o < FAINT).count()),
            share_axis_ratio_at_least_3: share(
                axes.iter().filter(|a| a[2] - a[0] >= ratio).count(),
            ),
            share_needles_at_least_3: share(axes.iter().filter(|a| a[2] - a[1] >= ratio).count()),
            opacity: percentiles(opacities),
        };
        let mut oddities = oddities(scene, bounds.diagonal());
        oddities.extend(stats.small());
        (stats, oddities)
    }

    /// Whether a view that the scene fills would cut some of it off at the near plane. A few
    /// Gaussians have no size that counts.
    fn small(&self) -> Option<Warning> {
        let side = |p: &Percentiles| (p.p95 - p.p5).powi(2);
        let diagonal = self.position.iter().map(side).sum::<f64>().sqrt();
        let is_small = self.points >= FEW && diagonal < f64::from(NEAR);
        is_small.then_some(Warning::SmallScene { diagonal })
    }
}

fn bounds(scene: &Gaussians) -> Bounds {
    let mut bounds = Bounds { min: scene.means[0], max: scene.means[0] };
    for mean in &scene.means {
        for (axis, &value) in mean.iter().enumerate() {
            bounds.min[axis] = bounds.min[axis].min(value);
            bounds.max[axis] = bounds.max[axis].max(value);
        }
    }
    bounds
}

fn sorted(scales: &[f32; 3]) -> [f32; 3] {
    let mut axes = *scales;
    axes.sort_by(f32::total_cmp);
    axes
}

fn oddities(scene: &Gaussians, diagonal: f64) -> Vec<Warning> {
    let unnormalised = scene.rotations.iter().filter(|q| {
        let length = q.iter().map(|c| c * c).sum::<f32>().sqrt();
        (length - 1.0).abs() > LENGTH_MARGIN
    });
    let longest = |s: &[f32; 3]| f64::from(s[0].max(s[1]).max(s[2])).exp();
    let absurd = scene.log_scales.iter().filter(|s| longest(s) > diagonal);
    let invisible = scene.logit_opacities.iter().filter(|o| sigmoid(**o) < ALPHA_MIN);
    let all = [
        Warning::Unnormalised { count: unnormalised.count() as u64 },
        Warning::AbsurdScales { count: absurd.count() as u64 },
        Warning::Invisible { count: invisible.count() as u64 },
    ];
    all.into_iter().filter(|w| w.count() != Some(0)).collect()
}

/// Percentiles with linear interpolation between neighbours, as `numpy.percentile`.
fn percentiles(mut values: Vec<f64>) -> Percentiles {
    values.sort_unstable_by(f64::total_cmp);
    let at = |percent: f64| {
        let place = percent / 100.0 * (values.len() - 1) as f64;
        let (low, high) = (values[place.floor() as usize], values[place.ceil() as usize]);
        low + (high - low) * place.fract()
    };
    Percentiles::of([1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0].map(at))
}

fn exp(percentiles: Percentiles) -> Percentiles {
    Percentiles::of(percentiles.named().map(|(_, value)| value.exp()))
}
