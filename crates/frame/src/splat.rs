//! Projected Gaussians (splats) and the tiles that they touch.
//!
//! Everything that depends on the exact bits of a projected splat (conic, radius, tile rectangle,
//! intersection tests) is here once, and used by the rasteriser and by the workload alike: that is
//! why their counters agree exactly.

mod counters;
pub mod cover;
mod ellipse;
pub mod gradient;
pub mod levels;
mod obb;
pub mod pixel;
pub mod project;
pub mod runs;
pub mod simd;
mod touch;

pub use counters::{Counters, FoveaCounters};
pub use cover::{Cover, TileGrid};
pub use ellipse::Ellipse;
pub use touch::touch;

/// Steps of an 8-bit colour, exact: α below 1/`ALPHA_STEPS` is not blended.
pub const ALPHA_STEPS: f64 = 255.0;
/// α below this is not blended.
pub const ALPHA_MIN: f64 = 1.0 / ALPHA_STEPS;
/// α is clamped to this.
pub const ALPHA_MAX: f32 = 0.99;
/// A pixel stops when its transmittance would fall below this.
pub const TRANSMITTANCE_MIN: f32 = 1e-4;
/// Gaussians nearer than this (view-space depth, world units) are culled.
pub const NEAR: f32 = 0.2;
/// The largest tile side: traces keep every splat that a tile of this size could touch.
pub(crate) const TILE_MAX: u32 = 64;

/// A Gaussian projected to the image, as stored in traces (32 bytes).
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Splat {
    /// Index in the scene.
    pub index: u32,
    /// View-space depth, world units, positive: the sort key.
    pub depth: f32,
    /// Centre, pixels; pixel centres are at integer coordinates.
    pub mean: [f32; 2],
    /// 2D covariance `[a, b, d]` of `[[a, b], [b, d]]`, pixels², low-pass included.
    pub cov: [f32; 3],
    /// Opacity, 0 to 1.
    pub opacity: f32,
}

impl Splat {
    /// The inverse covariance `[c0, c1, c2]` of `[[c0, c1], [c1, c2]]`, 1/pixels²; `None` where the
    /// covariance is singular or not finite.
    #[inline]
    pub fn conic(&self) -> Option<[f32; 3]> {
        let [a, b, d] = self.cov;
        let det = a * d - b * b;
        let conic = [d / det, -b / det, a / det];
        (det != 0.0 && conic.iter().all(|c| c.is_finite())).then_some(conic)
    }

    /// The 3-sigma radius that bounds the tile rectangle: a whole number of pixels. The smaller
    /// root's floor of 0.1 is the published rule.
    #[inline]
    pub fn radius(&self) -> f32 {
        let [a, b, d] = self.cov;
        let mid = 0.5 * (a + d);
        let lambda = mid + (mid * mid - (a * d - b * b)).max(0.1).sqrt();
        let reach = 3.0 * lambda.sqrt();
        let whole = reach as i64 as f32;
        if whole < reach { whole + 1.0 } else { whole }
    }

    /// The key of the depth order: positive floats order like their bits; ties go by index.
    pub fn order_key(&self) -> u64 {
        u64::from(self.depth.to_bits()) << 32 | u64::from(self.index)
    }
}

/// How a splat is tested against a tile.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    PartialOrd,
    Ord,
    serde::Deserialize,
    serde::Serialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Intersection {
    /// Bounding square of the 3-sigma radius, as INRIA's rasteriser.
    Aabb,
    /// Oriented box of 3-sigma half-lengths, separating axes (GSCore).
    Obb,
    /// The exact ellipse where α reaches 1/255, within the bounding square.
    Ellipse,
}
