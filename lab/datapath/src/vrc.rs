//! The volume-rendering core: what `rtl/vrc.sv` makes of splats and pixels, bit for bit.
//!
//! The quadratic form is a sum of two squares: with the conic as the product of a triangular matrix
//! and its transpose, q = u² + v², u = a δx + b δy, v = c δy. That takes as many operations as the
//! form of the conic, cannot become negative, and does not cancel where the conic of a thin splat
//! does. (The other values of [`Form`] are for comparison; `rtl/` has no such cores.) α is o 2^-q;
//! what is below 1/255 is dropped, and α is clamped to 0.99.
//!
//! Every operation rounds. For records of [`Record::new`] no NaN arises: differences of places and
//! sums in u stay finite because means and the triangular matrix are bounded; a square that
//! overflows is +∞, and so is the sum of two squares of which one is; 2^-∞ is 0. Of other records,
//! an α that is NaN or negative is dropped, and an infinite one is clamped.

use crate::{Arithmetic, Exponential};
use powergs_base::number::NumberFormat;

/// Side of a tile, pixels.
pub const TILE: u32 = 16;
/// Means are held within the largest number over this, from the middle of the tile.
const MEAN_ROOM: f64 = 8.0;
/// The entries of the triangular matrix are at most this; with the low-pass filter of 0.3 pixels²
/// they are below 1.56.
const ROOT_MOST: f64 = 2.0;
/// The same of a conic, below 4.9.
const CONIC_MOST: f64 = 5.0;

/// A splat as a core receives it: nine numbers, 18 bytes in FP16.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Record {
    /// u₀ and v₀ of [`Form::Local`]; in the other forms the centre, pixels from the middle of the
    /// tile (7.5, 7.5).
    pub mean: [u16; 2],
    /// a, b, c of u = a x + b y, v = c y, 1/pixels, with the root of log₂e/2 in them (or those of
    /// a conic, 1/pixels², with log₂e/2).
    pub root: [u16; 3],
    /// Opacity, 0 to 1.
    pub opacity: u16,
    /// Red, green, blue.
    pub colour: [u16; 3],
}

/// The state of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pixel {
    /// What of the background is seen.
    pub transmittance: u16,
    /// Red, green, blue so far.
    pub colour: [u16; 3],
    /// Whether it takes part: it is in the image and has not stopped.
    pub live: bool,
}

/// What a splat does to a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing: the pixel has stopped before, or takes no part.
    Idle,
    /// Nothing: its α is below 1/255.
    Dropped,
    /// It blends.
    Blended,
    /// It would leave less than 1e-4: the pixel stops, and stays what it was.
    Stopped,
}

/// How the quadratic form is written, and what the mean and a, b, c of a record are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// q = (a δx + b δy)² + (c δy)².
    Root,
    /// q = u² + v² with u = a x + b y + u₀, v = c y + v₀ for the pixel at (x, y) from the middle of
    /// the tile: the record has (u₀, v₀) in place of the mean. That of `rtl/`.
    Local,
    /// q = (a δx + b δy) δx + c δy δy; where it is negative the splat is dropped.
    Conic,
}

/// A volume-rendering core of a number format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Vrc {
    format: NumberFormat,
    form: Form,
    alpha_min: u16,
    alpha_max: u16,
    stop: u16,
}

/// How far means reach, and the most of a colour.
fn room(format: NumberFormat) -> f64 {
    format.to_f64(format.largest()) / MEAN_ROOM
}

impl Record {
    /// Its nine numbers in the order of the hardware: mean, root, opacity, colour.
    pub fn numbers(&self) -> [u16; 9] {
        let Record { mean: [u, v], root: [a, b, c], opacity, colour: [red, green, blue] } = *self;
        [u, v, a, b, c, opacity, red, green, blue]
    }

    /// The record of a splat: mean in pixels from the middle of the tile, covariance `[a, b, d]` of
    /// `[[a, b], [b, d]]` in pixels², opacity and colour. Everything is computed exactly and
    /// rounded once, as by a culling and conversion unit that is wide enough. `None` where the
    /// covariance is no ellipse.
    pub fn new(
        format: NumberFormat,
        mean: [f64; 2],
        covariance: [f32; 3],
        opacity: f32,
        colour: [f32; 3],
    ) -> Option<Record> {
        Record::of_form(format, Form::Local, mean, covariance, opacity, colour)
    }

    fn of_form(
        format: NumberFormat,
        form: Form,
        mean: [f64; 2],
        covariance: [f32; 3],
        opacity: f32,
        colour: [f32; 3],
    ) -> Option<Record> {
        let [a, b, d] = covariance.map(f64::from);
        let det = a * d - b * b;
        let regular = det > 0.0 && d > 0.0 && det.is_finite();
        let half_log2_e = 0.5 * std::f64::consts::LOG2_E;
        let (root, most) = match form {
            Form::Root | Form::Local => {
                let along = (half_log2_e * d / det).sqrt();
                ([along, -along * b / d, (half_log2_e / d).sqrt()], ROOT_MOST)
            }
            Form::Conic => ([d, -2.0 * b, a].map(|c| half_log2_e * c / det), CONIC_MOST),
        };
        let number = |value: f64, most: f64| format.from_f64(value.clamp(-most, most));
        let features = Record {
            mean: [0; 2],
            root: root.map(|r| number(r, most)),
            opacity: number(f64::from(opacity), 1.0),
            colour: colour.map(|c| number(f64::from(c), room(format))),
        };
        let place = match form {
            Form::Root | Form::Conic => mean,
            Form::Local => [-(root[0] * mean[0] + root[1] * mean[1]), -root[2] * mean[1]],
        };
        regular.then(|| features.moved(format, place))
    }

    /// The same splat with its mean elsewhere: pixels from the middle of the tile.
    pub fn moved(&self, format: NumberFormat, mean: [f64; 2]) -> Record {
        let room = room(format);
        Record { mean: mean.map(|m| format.from_f64(m.clamp(-room, room))), ..*self }
    }
}

/// A bound in f32 on what a splat can reach, for models that must be fast.
#[derive(Debug, Clone, Copy)]
pub struct Reach {
    form: Form,
    mean: [f32; 2],
    root: [f32; 3],
    /// What rounding can take from a sum, of the sum of the magnitudes of its products.
    rounding: f32,
    /// q from which on α is below 1/255 however it is rounded.
    limit: f32,
}

impl Reach {
    /// Whether α at pixel (x, y) of the tile is certainly dropped.
    #[inline]
    pub fn misses(&self, x: u32, y: u32) -> bool {
        let half = 0.5 * (TILE - 1) as f32;
        let (dx, dy) = (x as f32 - half - self.mean[0], y as f32 - half - self.mean[1]);
        let [a, b, c] = self.root;
        let (ax, by, cy) = (a * dx, b * dy, c * dy);
        let least = match self.form {
            Form::Local => {
                let [u0, v0] = self.mean;
                let (ax, by) = (a * (x as f32 - half), b * (y as f32 - half));
                let cy = c * (y as f32 - half);
                let lost = self.rounding * (ax.abs() + by.abs() + u0.abs());
                let u = ((ax + by + u0).abs() - lost).max(0.0);
                let v = ((cy + v0).abs() - self.rounding * (cy.abs() + v0.abs())).max(0.0);
                (u * u + v * v) * (1.0 - self.rounding)
            }
            Form::Root => {
                let u = ((ax + by).abs() - self.rounding * (ax.abs() + by.abs())).max(0.0);
                let v = cy.abs() * (1.0 - self.rounding);
                (u * u + v * v) * (1.0 - self.rounding)
            }
            Form::Conic => {
                let (xx, yy, xy) = (ax * dx, cy * dy, by * dx);
                let lost = 2.0 * self.rounding * (xx.abs() + xy.abs() + yy.abs());
                xx + xy + yy - lost
            }
        };
        least > self.limit
    }
}

impl Pixel {
    /// A pixel at the beginning of a tile.
    pub fn open(format: NumberFormat, live: bool) -> Pixel {
        Pixel { transmittance: format.one(), colour: [0; 3], live }
    }
}

impl Vrc {
    /// A core of a format; `None` where its numbers do not reach over a tile (below four bits of
    /// exponent).
    pub fn new(format: NumberFormat) -> Option<Vrc> {
        (format.exponent_bits() >= 4).then(|| Vrc {
            format,
            form: Form::Local,
            alpha_min: format.at_least(1.0 / 255.0),
            alpha_max: format.at_most(0.99),
            stop: format.at_least(1e-4),
        })
    }

    /// The same core with the quadratic form written in another way.
    pub fn with_form(self, form: Form) -> Vrc {
        Vrc { form, ..self }
    }

    /// The record of a splat for this core: [`Record::new`] of its format and form.
    pub fn record(
        &self,
        mean: [f64; 2],
        covariance: [f32; 3],
        opacity: f32,
        colour: [f32; 3],
    ) -> Option<Record> {
        Record::of_form(self.format, self.form, mean, covariance, opacity, colour)
    }

    /// Its number format.
    pub fn format(&self) -> NumberFormat {
        self.format
    }

    /// What a splat can reach at most. Half an ulp is lost in a place, a product and a sum, in a
    /// square and the sum of squares; the exponential is off by one ulp, and an ulp of subnormals
    /// may come to it and to its product with the opacity.
    pub fn reach(&self, splat: &Record) -> Reach {
        let f = self.format;
        let value = |number| f.to_f32(number);
        let ulp = (-(f.mantissa_bits() as f32)).exp2();
        let least = value(1);
        let lost = (1.0 - 255.0 * 2.0 * least).max(0.0);
        let limit = (255.0 * value(splat.opacity)).log2() - lost.log2() + 8.0 * ulp;
        Reach {
            form: self.form,
            mean: splat.mean.map(value),
            root: splat.root.map(value),
            rounding: 2.0 * ulp,
            limit: limit + 1e-3,
        }
    }

    /// α of a splat at pixel (x, y) of the tile, before it is dropped or clamped.
    pub fn alpha(&self, splat: &Record, x: u32, y: u32) -> u16 {
        let f = self.format;
        let place = |p: u32| f.from_f64(f64::from(p) - 0.5 * f64::from(TILE - 1));
        let (x, y) = (place(x), place(y));
        let (dx, dy) = match self.form {
            Form::Root | Form::Conic => {
                (f.subtract(x, splat.mean[0]), f.subtract(y, splat.mean[1]))
            }
            Form::Local => (x, y),
        };
        let [a, b, c] = splat.root;
        let (u, v) = (f.add(f.multiply(a, dx), f.multiply(b, dy)), f.multiply(c, dy));
        let squares = |u, v| f.add(f.multiply(u, u), f.multiply(v, v));
        let q = match self.form {
            Form::Root => squares(u, v),
            Form::Local => squares(f.add(u, splat.mean[0]), f.add(v, splat.mean[1])),
            Form::Conic => f.add(f.multiply(u, dx), f.multiply(v, dy)),
        };
        // Of a sum of squares the sign bit is never set.
        if q & f.sign() != 0 && q != f.sign() {
            return 0;
        }
        f.multiply(splat.opacity, f.exp2_negative(q))
    }

    /// Blends a splat into pixel (x, y) of the tile.
    pub fn blend(&self, pixel: &mut Pixel, splat: &Record, x: u32, y: u32) -> Outcome {
        if !pixel.live {
            return Outcome::Idle;
        }
        let f = self.format;
        let raw = self.alpha(splat, x, y);
        // Numbers that are not negative have the order of their bits; negative ones and NaN lie
        // above infinity.
        if raw < self.alpha_min || raw > f.infinity() {
            return Outcome::Dropped;
        }
        let alpha = raw.min(self.alpha_max);
        let kept = f.multiply(pixel.transmittance, f.subtract(f.one(), alpha));
        if kept < self.stop {
            pixel.live = false;
            return Outcome::Stopped;
        }
        let weight = f.multiply(pixel.transmittance, alpha);
        for (sum, channel) in pixel.colour.iter_mut().zip(splat.colour) {
            *sum = f.add(*sum, f.multiply(weight, channel));
        }
        pixel.transmittance = kept;
        Outcome::Blended
    }
}
