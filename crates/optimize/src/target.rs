//! How good a model is, and how good it must be.

use serde::{Deserialize, Serialize};

/// Mean quality over some views.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Mean of the PSNRs of the views, decibels; infinite where all images are equal.
    pub psnr_db: f64,
    /// Mean SSIM.
    pub ssim: f64,
    /// Mean HVSQ at the pooling of the level that the model is for; `None` where it was not
    /// measured. Less is better.
    pub hvsq: Option<f64>,
}

impl Quality {
    /// A quality without HVSQ.
    pub const fn likeness(psnr_db: f64, ssim: f64) -> Quality {
        Quality { psnr_db, ssim, hvsq: None }
    }
}

/// A named step of quality: high, medium, low.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// 99 % of the dense model.
    High,
    /// 98 %.
    Medium,
    /// 97 %.
    Low,
}

impl Level {
    /// All levels, best first.
    pub const ALL: [Level; 3] = [Level::High, Level::Medium, Level::Low];

    /// `H`, `M` or `L`.
    pub const fn name(self) -> &'static str {
        match self {
            Level::High => "H",
            Level::Medium => "M",
            Level::Low => "L",
        }
    }

    /// The share of the dense model's PSNR and SSIM, with photos as the reference.
    pub const fn share(self) -> f64 {
        match self {
            Level::High => 0.99,
            Level::Medium => 0.98,
            Level::Low => 0.97,
        }
    }

    /// The target of this step. `is_own`: the references are the dense model's own renders.
    pub(crate) fn rule(self, is_own: bool) -> TargetRule {
        if is_own { TargetRule::Absolute(self.absolute()) } else { TargetRule::Share(self.share()) }
    }

    /// The absolute target where the dense model's own renders are the reference: a share of an
    /// infinite PSNR says nothing. Ours: 40 dB is hard to see beside the original, 34 dB is easy.
    pub const fn absolute(self) -> Quality {
        match self {
            Level::High => Quality::likeness(40.0, 0.98),
            Level::Medium => Quality::likeness(37.0, 0.965),
            Level::Low => Quality::likeness(34.0, 0.945),
        }
    }
}

/// What a model must reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Both PSNR and SSIM.
    Likeness(Quality),
    /// At most this HVSQ: the target of a level of the periphery.
    Hvsq(f64),
}

/// A sample that misses the target by less than this share still counts in the fit (`powergs`,
/// 5.1).
const NEAR: f64 = 0.01;

impl Target {
    /// A share of the quality of the dense model.
    pub(crate) fn share_of(dense: Quality, share: f64) -> Target {
        Target::Likeness(Quality::likeness(share * dense.psnr_db, share * dense.ssim))
    }

    /// Whether the quality reaches the target. NaN does not, nor does a number that is missing.
    pub fn passes(&self, quality: Quality) -> bool {
        match self {
            Target::Likeness(t) => quality.psnr_db >= t.psnr_db && quality.ssim >= t.ssim,
            Target::Hvsq(most) => quality.hvsq.is_some_and(|hvsq| hvsq <= *most),
        }
    }

    /// Whether the quality reaches the target or misses it by less than 1 %.
    pub(crate) fn is_near(&self, quality: Quality) -> bool {
        let eased = match self {
            Target::Likeness(t) => {
                Target::Likeness(Quality::likeness((1.0 - NEAR) * t.psnr_db, (1.0 - NEAR) * t.ssim))
            }
            Target::Hvsq(most) => Target::Hvsq((1.0 + NEAR) * most),
        };
        eased.passes(quality)
    }

    /// Distance from the target, decibels: that of the PSNR or that of 1 - SSIM as a ratio,
    /// whichever is less, or that of the HVSQ as a ratio. Negative where one of them misses.
    pub fn margin_db(&self, quality: Quality) -> f64 {
        // Equal pictures have an error of 0, and the ratio is to stay finite.
        let ratio = |allowed: f64, got: f64| 10.0 * (allowed.max(1e-12) / got.max(1e-12)).log10();
        match self {
            Target::Likeness(t) => {
                let psnr = quality.psnr_db - t.psnr_db;
                psnr.min(ratio(1.0 - t.ssim, 1.0 - quality.ssim))
            }
            Target::Hvsq(most) => ratio(*most, quality.hvsq.unwrap_or(f64::INFINITY)),
        }
    }

    /// The mean square error that it allows, by its PSNR, or the HVSQ, which is one of pools.
    pub(crate) fn square_error(&self) -> f64 {
        match self {
            Target::Likeness(t) => 10f64.powf(-t.psnr_db / 10.0),
            Target::Hvsq(most) => *most,
        }
    }

    /// Whether the quality passes, but by no more than `epsilon_db`.
    pub(crate) fn is_settled(&self, quality: Quality, epsilon_db: f64) -> bool {
        self.passes(quality) && self.margin_db(quality) <= epsilon_db
    }

    /// By how much a quality misses the target: decibels and SSIM, or HVSQ; 0 where that one is
    /// reached.
    pub fn shortfall(&self, quality: Quality) -> Quality {
        let missing = |wanted: f64, got: f64| if got >= wanted { 0.0 } else { wanted - got };
        match self {
            Target::Likeness(t) => Quality::likeness(
                missing(t.psnr_db, quality.psnr_db),
                missing(t.ssim, quality.ssim),
            ),
            Target::Hvsq(most) => {
                let excess = quality.hvsq.map(|hvsq| missing(-most, -hvsq));
                Quality { hvsq: excess, ..Quality::likeness(0.0, 0.0) }
            }
        }
    }

    /// PSNR and SSIM, where they are the target.
    pub fn likeness_target(&self) -> Option<Quality> {
        match self {
            Target::Likeness(quality) => Some(*quality),
            Target::Hvsq(_) => None,
        }
    }
}

/// How the target follows from the dense model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum TargetRule {
    /// This share of its quality.
    Share(f64),
    /// These numbers.
    Absolute(Quality),
}

impl TargetRule {
    /// The target, given the dense model's quality over the gate views.
    pub fn target(self, dense: Quality) -> Target {
        match self {
            TargetRule::Share(share) => Target::share_of(dense, share),
            TargetRule::Absolute(quality) => Target::Likeness(quality),
        }
    }

    /// What was asked for, as it was typed: `0.99`, `35 dB`.
    pub fn asked(self) -> String {
        match self {
            TargetRule::Share(share) => share.to_string(),
            TargetRule::Absolute(Quality { psnr_db, ssim, .. }) if ssim > 0.0 => {
                format!("{psnr_db} dB, SSIM {ssim}")
            }
            TargetRule::Absolute(Quality { psnr_db, .. }) => format!("{psnr_db} dB"),
        }
    }
}
