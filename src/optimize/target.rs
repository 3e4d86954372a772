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

    /// Whether the quality passes, and its nearer limit is no further away than `epsilon_db` of
    /// PSNR, or the same share of SSIM as that is of the PSNR target.
    pub fn is_settled(&self, quality: Quality, epsilon_db: f64) -> bool {
        let ssim = epsilon_db / self.0.psnr_db.max(1e-9) * self.0.ssim;
        let near =
            quality.psnr_db - self.0.psnr_db <= epsilon_db || quality.ssim - self.0.ssim <= ssim;
        self.passes(quality) && near
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
