//! How good a model is, and how good it must be.

/// Mean quality over some views.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Mean of the PSNRs of the views, decibels; infinite where all images are equal.
    pub psnr_db: f64,
    /// Mean SSIM.
    pub ssim: f64,
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

    /// The absolute target where the dense model's own renders are the reference: a share of an
    /// infinite PSNR says nothing. Ours: 40 dB is hard to see beside the original, 34 dB is easy.
    pub const fn absolute(self) -> Quality {
        match self {
            Level::High => Quality { psnr_db: 40.0, ssim: 0.98 },
            Level::Medium => Quality { psnr_db: 37.0, ssim: 0.965 },
            Level::Low => Quality { psnr_db: 34.0, ssim: 0.945 },
        }
    }
}

/// What a model must reach: both numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target(pub Quality);

impl Target {
    /// A share of the quality of the dense model.
    pub fn share_of(dense: Quality, share: f64) -> Target {
        Target(Quality { psnr_db: share * dense.psnr_db, ssim: share * dense.ssim })
    }

    /// Whether both PSNR and SSIM reach the target. Never with a NaN.
    pub fn passes(&self, quality: Quality) -> bool {
        quality.psnr_db >= self.0.psnr_db && quality.ssim >= self.0.ssim
    }

    /// Distance from the target, decibels: that of the PSNR or that of 1 - SSIM as a ratio,
    /// whichever is less. Negative where one of them misses.
    pub fn margin_db(&self, quality: Quality) -> f64 {
        let psnr = quality.psnr_db - self.0.psnr_db;
        let error = |ssim: f64| (1.0 - ssim).max(1e-12);
        let ssim = 10.0 * (error(self.0.ssim) / error(quality.ssim)).log10();
        psnr.min(ssim)
    }

    /// Whether the quality passes, but by no more than `epsilon_db`.
    pub fn is_settled(&self, quality: Quality, epsilon_db: f64) -> bool {
        self.passes(quality) && self.margin_db(quality) <= epsilon_db
    }

    /// By how much a quality misses the target: decibels and SSIM, 0 where that one is reached.
    pub fn shortfall(&self, quality: Quality) -> Quality {
        let missing = |wanted: f64, got: f64| if got >= wanted { 0.0 } else { wanted - got };
        Quality {
            psnr_db: missing(self.0.psnr_db, quality.psnr_db),
            ssim: missing(self.0.ssim, quality.ssim),
        }
    }
}

/// How the target follows from the dense model.
#[derive(Debug, Clone, Copy, PartialEq)]
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
            TargetRule::Absolute(quality) => Target(quality),
        }
    }
}
