//! Floating-point operations of a colour, by SH degree.

use powergs_frame::scene::ShDegree;

/// A colour from spherical harmonics, by degree 0 to 3. Degree 3 is published (`powergs`); of its
/// 133 operations 96 are 2 a coefficient and channel, the rest is direction and basis functions,
/// shared among degrees 1 to 3 like the 15, 15 and 26 operations of the usual polynomials (A17).
pub const SH_COLOUR: [u32; ShDegree::ALL.len()] = [6, 34, 74, 133];

/// Operations of a colour of this SH degree over those of degree 3.
pub fn colour_share(degree: ShDegree) -> f64 {
    let of = |degree: ShDegree| f64::from(SH_COLOUR[usize::from(degree.get())]);
    of(degree) / of(ShDegree::MAX)
}
