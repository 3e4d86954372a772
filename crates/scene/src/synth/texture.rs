//! Colours: patterns that are continuous in space, so that neighbouring Gaussians agree and images
//! look like something.

use glam::{DVec3, Vec3};

/// The colours of a part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// First colour, sRGB.
    pub base: Vec3,
    /// Second colour, sRGB.
    pub accent: Vec3,
    /// How they alternate.
    pub pattern: Pattern,
    /// Size of the pattern, world units.
    pub scale: f64,
    /// Strength of the highlight, 0 to 1.
    pub gloss: f32,
}

/// How two colours alternate in space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pattern {
    /// Smooth noise.
    Noise,
    /// Squares.
    Checker,
    /// Boards with joints and grain along x.
    Planks,
    /// Bricks with joints.
    Bricks,
    /// From `base` at the horizon to `accent` at the zenith, with clouds.
    Sky,
}

/// Direction to the sun.
pub(super) const SUN: DVec3 = DVec3::new(0.4242640687, 0.2828427125, 0.8602325267);

impl Look {
    /// A look without highlight.
    pub(crate) fn matt(base: [f32; 3], accent: [f32; 3], pattern: Pattern, scale: f64) -> Look {
        let (base, accent) = (Vec3::from_array(base), Vec3::from_array(accent));
        Look { base, accent, pattern, scale, gloss: 0.0 }
    }

    /// A smooth plastic of one colour.
    pub(crate) fn plastic(base: [f32; 3]) -> Look {
        let accent = base.map(|c| c * 0.8);
        Look { gloss: 0.6, ..Look::matt(base, accent, Pattern::Noise, 0.15) }
    }

    /// The lit colour at a point of a surface, sRGB.
    pub(crate) fn colour(&self, position: DVec3, normal: DVec3) -> Vec3 {
        let p = position / self.scale;
        let mix = match self.pattern {
            Pattern::Noise => fractal(p),
            Pattern::Checker => {
                let odd = (p.x.floor() + p.y.floor() + p.z.floor()).rem_euclid(2.0);
                0.85 * odd + 0.15 * fractal(p * 4.0)
            }
            Pattern::Planks => {
                let joint = near_integer(p.y, 0.04);
                joint.max(0.7 * fractal(DVec3::new(p.x * 0.5, p.y * 8.0, p.z * 8.0)))
            }
            Pattern::Bricks => {
                let shift = 0.5 * p.z.floor().rem_euclid(2.0);
                let joint =
                    near_integer(p.z, 0.08).max(near_integer(0.5 * (p.x + p.y) + shift, 0.04));
                joint.max(0.4 * fractal(p * 3.0))
            }
            Pattern::Sky => {
                let up = position.z / position.length().max(1e-9);
                return self.base.lerp(self.accent, up.clamp(0.0, 1.0) as f32)
                    + Vec3::splat(0.35 * (fractal(p) - 0.45).max(0.0) as f32);
            }
        };
        let light = 0.55 + 0.45 * normal.dot(SUN).max(0.0) + 0.1 * normal.z;
        self.base.lerp(self.accent, mix as f32) * light as f32
    }
}

/// 1 within `width` of an integer, else 0.
fn near_integer(x: f64, width: f64) -> f64 {
    f64::from((x - x.round()).abs() < width)
}

/// Three octaves of smooth noise, about 0 to 1.
fn fractal(p: DVec3) -> f64 {
    (noise(p) + 0.5 * noise(p * 2.03) + 0.25 * noise(p * 4.01)) / 1.75
}

/// Value noise: random values at the integer points, smooth between them.
fn noise(p: DVec3) -> f64 {
    let cell = p.floor();
    let t = p - cell;
    let t = t * t * (DVec3::splat(3.0) - 2.0 * t);
    let [x, y, z] = cell.to_array().map(|c| c as i64);
    let value = |dx, dy, dz| lattice(x + dx, y + dy, z + dz);
    let along_x = |dy, dz| value(0, dy, dz) * (1.0 - t.x) + value(1, dy, dz) * t.x;
    let plane = |dz| along_x(0, dz) * (1.0 - t.y) + along_x(1, dz) * t.y;
    plane(0) * (1.0 - t.z) + plane(1) * t.z
}

/// A hash of a lattice point, 0 to 1.
fn lattice(x: i64, y: i64, z: i64) -> f64 {
    let mut h = (x as u64).wrapping_mul(0x8da6_b343)
        ^ (y as u64).wrapping_mul(0xd816_3841)
        ^ (z as u64).wrapping_mul(0xcb1a_b31f);
    h = (h ^ (h >> 13)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    h = (h ^ (h >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((h >> 40) as f64) / f64::from(1u32 << 24)
}
