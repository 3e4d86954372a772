//! Between what files store and raw parameters.

/// The constant SH basis function, `1 / (2 √π)`: colour = 0.5 + `SH_C0` · DC coefficient.
pub const SH_C0: f64 = 0.282_094_791_773_878_14;

/// Opacities are kept this far from 0 and 1, where the logit is infinite.
const OPACITY_MARGIN: f64 = 1e-6;

/// The raw opacity of an opacity between 0 and 1; those at the ends are moved inside by `1e-6`.
pub fn logit(opacity: f64) -> f32 {
    let p = opacity.clamp(OPACITY_MARGIN, 1.0 - OPACITY_MARGIN);
    (p / (1.0 - p)).ln() as f32
}

/// The raw scale of a scale; one of zero or less has the end of the range, which the check of the
/// whole model replaces and counts.
pub(super) fn log_scale(scale: f32) -> f32 {
    if scale <= 0.0 { f32::NEG_INFINITY } else { scale.ln() }
}

/// The opacity of a raw opacity.
pub fn sigmoid(logit: f32) -> f64 {
    1.0 / (1.0 + (-f64::from(logit)).exp())
}

/// The opacity of a raw opacity in steps of 1/255.
pub(super) fn opacity_byte(raw: f32) -> u8 {
    (255.0 * sigmoid(raw)).round() as u8
}

/// How many raw opacities are beyond what a byte is read back as.
pub(super) fn opacities_beyond_bytes(raw: &[f32]) -> u64 {
    let (least, most) = (logit(0.0), logit(1.0));
    raw.iter().filter(|raw| !(least..=most).contains(*raw)).count() as u64
}

/// The DC coefficient of a colour, 0 to 1 and a little beyond.
pub fn dc(colour: f64) -> f32 {
    ((colour - 0.5) / SH_C0) as f32
}

/// The colour of a DC coefficient.
pub(super) fn colour(dc: f32) -> f64 {
    f64::from(dc) * SH_C0 + 0.5
}

/// SH coefficients beyond DC, per channel, for a degree.
pub(super) fn rest_of(degree: u8) -> usize {
    (degree as usize + 1).pow(2) - 1
}

/// The degree that has `rest` coefficients per channel beyond DC.
pub(super) fn degree_of(rest: usize) -> Option<u8> {
    (0..=4).find(|&degree| rest_of(degree) == rest)
}

/// A unit quaternion from its three smaller components in order, and the place (of w, x, y, z) of
/// the largest, which is positive.
pub(super) fn quaternion(small: [f64; 3], largest: usize) -> [f32; 4] {
    let sum: f64 = small.iter().map(|c| c * c).sum();
    let mut q = [(1.0 - sum).max(0.0).sqrt() as f32; 4];
    let places = (0..4).filter(|&place| place != largest);
    places.zip(small).for_each(|(place, c)| q[place] = c as f32);
    q
}
