//! Eccentricity, pooling size and level at every point of a flat screen.
//!
//! Source: `powergs` (after `metasapiens`); `docs/metrics.md` has the formulas. The arguments of
//! arc cosines are clamped, so that the eccentricity at the gaze is 0.

use super::{GazeError, Screen};

/// Largest level: no blending beyond the last.
const LEVEL_MAX: f64 = 3.9;
/// The pooling sizes that the regions R1 to R4 stand for, pixels.
pub const POOLINGS: [f64; 4] = [1.0, 3.0, 7.0, 12.0];

/// The eccentricity map of a screen of a given size in pixels, for one gaze.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EccentricityMap {
    size: [f64; 2],
    /// Half the width of the screen at distance 1.
    half: f64,
    pooling_rate: f64,
    gaze: [f64; 3],
}

impl EccentricityMap {
    /// A gaze at (`x`, `y`), shares of width and height from the upper left corner, on a screen of
    /// `width` x `height` pixels that is `fov_deg` wide. Published: 90 degrees.
    ///
    /// # Errors
    /// A gaze outside the picture, an angle that is not between 0 and 180 degrees, or NaN.
    pub fn new(gaze: [f64; 2], fov_deg: f64, size: [u32; 2]) -> Result<EccentricityMap, GazeError> {
        EccentricityMap::on(Screen { fov_deg, ..Screen::PUBLISHED }, gaze, size)
    }

    /// As [`EccentricityMap::new`], for a screen with its own pooling rate.
    ///
    /// # Errors
    /// As [`EccentricityMap::new`]; an impossible pooling rate.
    pub fn on(
        screen: Screen,
        [x, y]: [f64; 2],
        size: [u32; 2],
    ) -> Result<EccentricityMap, GazeError> {
        if !(0.0..=1.0).contains(&x) || !(0.0..=1.0).contains(&y) {
            return Err(GazeError::Gaze { x, y });
        }
        screen.check()?;
        let half = (screen.fov_deg.to_radians() / 2.0).tan();
        let (size, pooling_rate) = (size.map(f64::from), screen.pooling_rate);
        let mut map = EccentricityMap { size, half, pooling_rate, gaze: [0.0, 0.0, 1.0] };
        map.gaze = map.place(x * size[0], y * size[1]);
        Ok(map)
    }

    /// The place of a point in pixels on the screen, seen from the eye.
    fn place(&self, x: f64, y: f64) -> [f64; 3] {
        let pixel = 2.0 * self.half / self.size[0];
        [(x - 0.5 * self.size[0]) * pixel, (y - 0.5 * self.size[1]) * pixel, 1.0]
    }

    /// The angle between the gaze and a point in pixels, degrees.
    pub fn eccentricity_deg(&self, x: f64, y: f64) -> f64 {
        angle(self.gaze, self.place(x, y)).to_degrees()
    }

    /// The diameter of the patch that the eye pools there, pixels; infinite if the patch reaches
    /// beyond a right angle.
    pub fn pooling_px(&self, x: f64, y: f64) -> f64 {
        let place = self.place(x, y);
        let eccentricity = angle(self.gaze, place);
        let tilt = angle(place, [0.0, 0.0, 1.0]);
        let half = self.pooling_rate * eccentricity * eccentricity / 2.0;
        if tilt + half >= std::f64::consts::FRAC_PI_2 {
            return f64::INFINITY;
        }
        let major = (tilt + half).tan() - (tilt - half).tan();
        let minor = 2.0 * length(place) * half.tan();
        let pixel = 2.0 * self.half / self.size[0];
        (std::f64::consts::PI * major * minor / 4.0).max(0.0).sqrt() / pixel
    }

    /// The level: 0 to 3.9, whole at the poolings of the regions.
    pub fn level(&self, x: f64, y: f64) -> f64 {
        let pooling = self.pooling_px(x, y);
        if pooling <= 1.0 {
            return 0.0;
        }
        let step = (12.0f64.sqrt() - 1.0) / 3.0;
        ((pooling.sqrt() - 1.0) / step).min(LEVEL_MAX)
    }

    /// The regions that no pixel of the picture belongs to, 0 for R1 to 3 for R4: the picture is
    /// too small, or the screen too narrow, for them.
    pub fn missing_regions(&self) -> Vec<u8> {
        let mut seen = [false; 4];
        self.regions().into_iter().for_each(|region| seen[usize::from(region)] = true);
        (0..4).filter(|&region| !seen[usize::from(region)]).collect()
    }

    /// The region of every pixel, row-major: 0 for R1 to 3 for R4.
    pub fn regions(&self) -> Vec<u8> {
        let (width, height) = (self.size[0] as u32, self.size[1] as u32);
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)))
            .map(|(x, y)| self.level(x, y) as u8)
            .collect()
    }
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let dot: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    (dot / (length(a) * length(b))).clamp(-1.0, 1.0).acos()
}
