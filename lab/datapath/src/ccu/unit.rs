//! The unit as a whole: what becomes of a Gaussian.

use super::graph::Graph;
use super::programs::{self, projected as at};
use super::tiles::Walk;
use crate::{NumberFormat, WideFormat};
use powergs_base::number::{Number, Parts};

/// A Gaussian as the unit takes it, in numbers of the wide format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gaussian {
    /// Mean, world units.
    pub mean: [u32; 3],
    /// Standard deviations, world units; quaternion (w, x, y, z) of length sqrt(2); opacity.
    pub shape: [u32; 8],
}

/// A camera as the unit takes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Numbers of the wide format: see [`programs::SETTINGS`].
    pub numbers: [u32; programs::SETTINGS],
    /// Columns and rows of tiles.
    pub tiles: [u32; 2],
}

/// What culling says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Verdict {
    /// Place from the eye, and depth.
    pub place: [u32; 4],
    /// Whether it is in front of the near plane.
    pub kept: bool,
}

/// What projection says, in numbers of the wide format: see [`programs::projected`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Projected {
    /// The outputs of the graph.
    pub numbers: [u32; at::COUNT],
}

/// What leaves for a splat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Converted {
    /// Depth: the sort key.
    pub depth: u16,
    /// a, b, c of the record.
    pub root: [u16; 3],
    /// Opacity of the record.
    pub opacity: u16,
    /// Direction from the eye.
    pub direction: [u16; 3],
}

/// Which whole number a number becomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rounding {
    Floor,
    Ceiling,
    /// Half of one away from zero.
    Nearest,
}

/// The unit for two number formats.
#[derive(Debug, Clone)]
pub struct Ccu {
    wide: WideFormat,
    narrow: NumberFormat,
    cull: Graph,
    project: Graph,
    colours: [Graph; 4],
}

/// A camera: eye, rotation from the world, focal lengths, principal point (pixel centres at whole
/// numbers and a half), size of the image in pixels.
pub fn camera(
    wide: WideFormat,
    eye: [f64; 3],
    rotation: [[f64; 3]; 3],
    focal: [f64; 2],
    principal: [f64; 2],
    size: [u32; 2],
) -> Settings {
    let mut numbers = eye.to_vec();
    for (row, &scale) in rotation.iter().zip(focal.iter().chain(&[1.0])) {
        numbers.extend(row.map(|value| value * scale));
    }
    numbers.extend(principal.map(|place| place - 0.5));
    for axis in 0..2 {
        // Slopes are held within 0.15 images around the image.
        let length = f64::from(size[axis]);
        numbers.push(-principal[axis] - 0.15 * length);
        numbers.push(length - principal[axis] + 0.15 * length);
    }
    let mut settings = [0; programs::SETTINGS];
    for (setting, number) in settings.iter_mut().zip(numbers) {
        *setting = wide.from_f64(number);
    }
    Settings { numbers: settings, tiles: size.map(|length| length.div_ceil(16)) }
}

impl Ccu {
    /// A unit that computes in `wide` and hands over `narrow`; `None` where a table of its special
    /// functions is too coarse for `wide` (18 bits of mantissa and more) or the narrow format has
    /// less than four bits of exponent.
    pub fn new(wide: WideFormat, narrow: NumberFormat) -> Option<Ccu> {
        let fine = wide.mantissa_bits() <= super::special::MANTISSA_MOST;
        (fine && narrow.exponent_bits() >= 4).then(|| Ccu {
            wide,
            narrow,
            cull: programs::cull(),
            project: programs::project(),
            colours: [0, 1, 2, 3].map(programs::colour),
        })
    }

    /// The format of geometry.
    pub fn wide(&self) -> WideFormat {
        self.wide
    }

    /// The format of what leaves.
    pub fn narrow(&self) -> NumberFormat {
        self.narrow
    }

    /// Culls a Gaussian by its mean.
    pub fn cull(&self, settings: &Settings, mean: &[u32; 3]) -> Verdict {
        let out = self.cull.run(self.wide, [mean, &[], &settings.numbers]);
        let difference = out[4];
        let kept = difference & self.wide.sign() != 0 && !self.wide.is_nan(difference);
        Verdict { place: [out[0], out[1], out[2], out[3]], kept }
    }

    /// Projects a Gaussian that was kept.
    pub fn project(&self, settings: &Settings, place: &[u32; 4], shape: &[u32; 8]) -> Projected {
        let inputs: Vec<u32> = place.iter().chain(shape).copied().collect();
        let out = self.project.run(self.wide, [&inputs, &[], &settings.numbers]);
        Projected { numbers: out.try_into().expect("so many outputs") }
    }

    /// Whether a splat is there at all: infinite numbers and NaN are dropped.
    pub fn is_regular(&self, projected: &Projected) -> bool {
        let infinity = self.wide.infinity();
        projected.numbers.iter().all(|&number| number & infinity != infinity)
    }

    /// What leaves for a splat.
    pub fn convert(&self, projected: &Projected) -> Converted {
        let narrow = |i: usize| of_wide(self.narrow, self.wide, projected.numbers[i]);
        Converted {
            depth: narrow(at::DEPTH),
            root: [0, 1, 2].map(|i| narrow(at::ROOT + i)),
            opacity: narrow(at::OPACITY),
            direction: [0, 1, 2].map(|i| narrow(at::DIRECTION + i)),
        }
    }

    /// The colour of a splat of SH degree `degree` (0 to 3), seen in a direction: numbers of the
    /// narrow format. Coefficients are three channels of each, with the factors of their functions.
    pub fn colour(&self, degree: u32, direction: &[u16; 3], coefficients: &[u16; 48]) -> [u16; 3] {
        let direction = direction.map(u32::from);
        let coefficients = coefficients.map(u32::from);
        let graph = &self.colours[degree as usize];
        let out = graph.run(self.narrow.wide(), [&direction, &coefficients, &[]]);
        [0, 1, 2].map(|channel| out[channel] as u16)
    }

    /// All of it for one Gaussian, without its colour: `None` where nothing is seen.
    pub fn splat(&self, settings: &Settings, gaussian: &Gaussian) -> Option<(Converted, Walk)> {
        let verdict = self.cull(settings, &gaussian.mean);
        if !verdict.kept {
            return None;
        }
        let projected = self.project(settings, &verdict.place, &gaussian.shape);
        let walk = Walk::new(self.wide, &projected, settings.tiles);
        let seen = self.is_regular(&projected) && walk.candidates() > 0;
        seen.then(|| (self.convert(&projected), walk))
    }
}

/// The number nearest to one of a wide format.
fn of_wide(format: NumberFormat, wide: WideFormat, number: u32) -> u16 {
    match wide.unpack(number) {
        Number::Nan => format.nan(),
        Number::Infinity(sign) => format.infinity() | if sign { format.sign() } else { 0 },
        Number::Finite(parts) => format.round(parts, powergs_base::number::Rounding::NearestEven),
    }
}
/// A number in 2^-`fraction`, a whole number of `bits` bits with its sign; what is beyond them
/// becomes the last one. Infinite numbers and NaN count as numbers of their exponent.
pub(crate) fn fixed(
    format: WideFormat,
    number: u32,
    fraction: u32,
    bits: u32,
    rounding: Rounding,
) -> i64 {
    let most = (1i64 << (bits - 1)) - 1;
    let Number::Finite(Parts { sign, exponent, significand }) = format.unpack(number) else {
        let negative = number & format.sign() != 0;
        return if negative { -most } else { most };
    };
    let shift = exponent + fraction as i32;
    let significand = significand as i64;
    let magnitude = if shift >= 0 {
        if significand == 0 { 0 } else { significand << shift.min(38) }
    } else {
        let dropped = shift.unsigned_abs().min(40);
        let whole = significand >> dropped;
        let rest = significand - (whole << dropped);
        let up = match rounding {
            Rounding::Floor => sign && rest > 0,
            Rounding::Ceiling => !sign && rest > 0,
            Rounding::Nearest => rest >= 1 << (dropped - 1),
        };
        whole + i64::from(up)
    };
    let magnitude = magnitude.min(most);
    if sign { -magnitude } else { magnitude }
}
