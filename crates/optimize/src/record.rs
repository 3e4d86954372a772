//! The numbers that a machine reads of a model: which format each field of the record of a Gaussian
//! has, and what rounding to it makes of the parameters.
//!
//! Numbers of a record are those that a culling and conversion unit takes (`rtl/ccu.sv`):
//! centres in world units, standard deviations (not their logarithms), unit quaternions, opacities
//! from 0 to 1, coefficients of colours times the factors of their functions, the constant one with
//! the half that a colour begins at. A value beyond the largest number of a format becomes that
//! number; a standard deviation or an opacity below the smallest one becomes that. With a codebook
//! coefficients are those of the entry that a Gaussian shares, rounded.

pub mod codebook;

use std::num::NonZeroU32;

use rayon::prelude::*;
use serde::Serialize;

use powergs_base::number::NumberFormat;
use powergs_frame::scene::ShDegree;
use powergs_scene::Gaussians;

/// The format of each field; `None`: the field is not rounded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize)]
pub struct RecordFormats {
    /// Centres, world units.
    pub position: Option<NumberFormat>,
    /// Standard deviations, world units.
    pub scale: Option<NumberFormat>,
    /// Unit quaternions.
    pub rotation: Option<NumberFormat>,
    /// Opacities, 0 to 1.
    pub opacity: Option<NumberFormat>,
    /// Constant coefficients of colours.
    pub colour_dc: Option<NumberFormat>,
    /// The other coefficients.
    pub colour_rest: Option<NumberFormat>,
    /// Entries that the other coefficients of all Gaussians are taken from; `None`: each has its
    /// own.
    pub codebook: Option<NonZeroU32>,
}

impl RecordFormats {
    /// Whether nothing is rounded.
    pub fn is_exact(&self) -> bool {
        *self == RecordFormats::default()
    }

    /// Every field under its name in files, in the order of the record.
    pub fn fields(&self) -> [(&'static str, Option<NumberFormat>); 6] {
        [
            ("position", self.position),
            ("scale", self.scale),
            ("rotation", self.rotation),
            ("opacity", self.opacity),
            ("colour-dc", self.colour_dc),
            ("colour-rest", self.colour_rest),
        ]
    }

    /// The model whose parameters are what a machine reads of those of `scene`; with a codebook
    /// that is made for it.
    pub fn read(&self, scene: &Gaussians) -> Gaussians {
        let mut read = Gaussians::default();
        let labels = self.codebook.map(|entries| codebook::labels(scene, entries.get()));
        self.read_into(scene, &labels.unwrap_or_default(), &mut read);
        read
    }

    /// As [`RecordFormats::read`], into a model whose room is used again, and with the labels of
    /// its codebook.
    fn read_into(&self, scene: &Gaussians, labels: &[u32], read: &mut Gaussians) {
        let Gaussians { means, log_scales, rotations, logit_opacities, sh_degree, sh, .. } = scene;
        read.means.clone_from(means);
        read.log_scales.clone_from(log_scales);
        read.rotations.clone_from(rotations);
        read.logit_opacities.clone_from(logit_opacities);
        (read.sh_degree, read.antialiased) = (*sh_degree, scene.antialiased);
        read.sh.clone_from(sh);
        if let Some(grid) = self.position.map(RecordGrid::of) {
            read.means.par_iter_mut().flatten().for_each(|x| *x = grid.nearest(*x));
        }
        if let Some(grid) = self.scale.map(RecordGrid::of) {
            // 0 has no logarithm.
            let round = |s: &mut f32| *s = grid.nearest(s.exp()).max(grid.least).ln();
            read.log_scales.par_iter_mut().flatten().for_each(round);
        }
        if let Some(grid) = self.rotation.map(RecordGrid::of) {
            read.rotations.par_iter_mut().for_each(|q| *q = grid.turn(*q));
        }
        if let Some(grid) = self.opacity.map(RecordGrid::of) {
            read.logit_opacities.par_iter_mut().for_each(|o| *o = grid.opacity(*o));
        }
        // Before colours are rounded: an entry is the mean of exact coefficients, and stored
        // rounded.
        codebook::share(read, labels);
        let [dc, rest] =
            [self.colour_dc, self.colour_rest].map(|format| format.map(RecordGrid::of));
        let each = scene.sh_coefficients();
        if each > 0 && (dc.is_some() || rest.is_some()) {
            read.sh.par_chunks_mut(each).for_each(|channel| colour(channel, dc, rest));
        }
    }
}

/// Rounds the coefficients of a channel of a Gaussian. [`ShDegree::FACTORS`] ends with degree 3, as
/// records do; a coefficient beyond is left alone.
fn colour(channel: &mut [f32], dc: Option<RecordGrid>, rest: Option<RecordGrid>) {
    let Some((first, others)) = channel.split_first_mut() else { return };
    if let Some(grid) = dc {
        *first = (grid.nearest(*first * ShDegree::FACTORS[0] + 0.5) - 0.5) / ShDegree::FACTORS[0];
    }
    if let Some(grid) = rest {
        for (k, factor) in others.iter_mut().zip(&ShDegree::FACTORS[1..]) {
            *k = grid.nearest(*k * factor) / factor;
        }
    }
}

/// The numbers of a format, as `f32` has them all.
#[derive(Debug, Clone, Copy)]
struct RecordGrid {
    /// The smallest positive number: what subnormals are multiples of.
    least: f32,
    /// The smallest number with all bits of the mantissa.
    normal: f32,
    /// The largest finite number.
    largest: f32,
    /// The largest number below 1.
    below_one: f32,
    /// Bits of the mantissa of an `f32` that the format does not have.
    dropped: u32,
}

impl RecordGrid {
    fn of(format: NumberFormat) -> RecordGrid {
        let mantissa = format.mantissa_bits();
        RecordGrid {
            least: format.to_f32(1),
            normal: format.to_f32(1 << mantissa),
            largest: format.to_f32(format.largest()),
            below_one: format.to_f32(format.one() - 1),
            dropped: f32::MANTISSA_DIGITS - 1 - mantissa,
        }
    }

    /// The nearest number, even of two that are equally near; no infinity.
    fn nearest(&self, value: f32) -> f32 {
        let size = value.abs();
        let nearest = if size < self.normal {
            (size / self.least).round_ties_even() * self.least
        } else {
            // Just below half of the last place is added, or half where it is odd, so that ties go
            // to even; a carry out of the mantissa raises the exponent, as it should.
            let (bits, last) = (size.to_bits(), 1 << self.dropped);
            let is_odd = bits >> self.dropped & 1;
            f32::from_bits((bits + (last / 2 - 1) + is_odd) & !(last - 1))
        };
        nearest.min(self.largest).copysign(value)
    }

    /// A quaternion in the direction of the rounded unit quaternion, and as long as it was: only
    /// its direction counts, and its gradient is that of its own length.
    fn turn(&self, turn: [f32; 4]) -> [f32; 4] {
        let length = turn.iter().map(|q| q * q).sum::<f32>().sqrt();
        // What has no direction has none to round.
        if !(f32::MIN_POSITIVE..f32::INFINITY).contains(&length) {
            return turn;
        }
        turn.map(|q| self.nearest(q / length) * length)
    }

    /// The logit of a rounded opacity. 0 and 1 have none: the nearest numbers between count.
    fn opacity(&self, logit: f32) -> f32 {
        let opacity = 1.0 / (1.0 + (-logit).exp());
        let opacity = self.nearest(opacity).clamp(self.least, self.below_one);
        (opacity / (1.0 - opacity)).ln()
    }
}

/// Reads models as a machine does, again and again.
#[derive(Debug, Clone, Default)]
pub struct RecordReader {
    formats: RecordFormats,
    read: Gaussians,
}

impl RecordReader {
    /// A reader of records in these formats.
    pub fn new(formats: RecordFormats) -> RecordReader {
        RecordReader { formats, read: Gaussians::default() }
    }

    /// The model as it is read, with these labels of its codebook, none without one; `scene` itself
    /// where it is read as it is.
    pub fn of<'a>(&'a mut self, scene: &'a Gaussians, labels: &[u32]) -> &'a Gaussians {
        if self.formats.is_exact() {
            return scene;
        }
        self.formats.read_into(scene, labels, &mut self.read);
        &self.read
    }

    /// Labels for a codebook of the model: from nothing, or, where there are some for each of its
    /// Gaussians, better ones. None without a codebook.
    pub fn label(&self, scene: &Gaussians, labels: &mut Vec<u32>) {
        let Some(entries) = self.formats.codebook else { return };
        match labels.len() == scene.len() {
            true => codebook::relabel(scene, labels, entries.get()),
            false => *labels = codebook::labels(scene, entries.get()),
        }
    }

    /// The model that was read last, as it is read; `None` where nothing is rounded.
    pub fn rounded(&self) -> Option<&Gaussians> {
        Some(&self.read).filter(|_| !self.formats.is_exact())
    }
}
