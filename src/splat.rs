//! Projected Gaussians (splats) and the tiles that they touch.
//!
//! Everything that depends on the exact bits of a projected splat (conic, radius, tile rectangle,
//! intersection tests) is here once, and used by the rasteriser and by the workload alike: that is
//! why their counters agree exactly.

pub mod counters;

pub use counters::Counters;

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

/// How a splat is tested against a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Intersection {
    /// Bounding square of the 3-sigma radius, as INRIA's rasteriser.
    Aabb,
    /// Oriented box of 3-sigma half-lengths, separating axes (GSCore).
    Obb,
    /// The exact ellipse where α reaches 1/255.
    Ellipse,
}
