//! The verdict on a measured row.

use super::numbers::{Parts, mean};
use super::row::{Row, Status};

/// Deviations that grow by less than this share of the published value have not worsened: scenes
/// are deterministic, but not every last digit of a change is worth a discussion.
const SLACK: f64 = 0.01;

/// What came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Enforced, calibrated or plausible, and inside its tolerance.
    Holds,
    /// The same, and outside.
    Fails,
    /// A known gap, and still outside.
    Gap,
    /// A known gap that is inside by now: the record should say so.
    Closed,
    /// Nothing can be decided.
    Dropped,
    /// Nothing could be measured, or it was left out of this run.
    Open,
}

impl Verdict {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Fails => "FAILS",
            Verdict::Gap => "gap",
            Verdict::Closed => "gap closed",
            Verdict::Dropped => "dropped",
            Verdict::Open => "not measured",
        }
    }
}

/// A row with its measurement.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Judged<'a> {
    /// The row.
    pub row: &'a Row,
    /// What came out: the mean over the workloads.
    pub ours: Option<f64>,
    /// What came out on each workload.
    pub parts: Parts,
    /// What came out the last time.
    pub before: Option<f64>,
    /// What to think of it.
    pub verdict: Verdict,
}

impl Judged<'_> {
    /// Ours over published, less one.
    pub fn deviation(&self) -> Option<f64> {
        deviation(self.row.published, self.ours)
    }

    /// Whether it must be inside of its tolerance, and is.
    pub fn holds(&self) -> bool {
        self.verdict == Verdict::Holds
    }

    /// Which part of the published gain ours is: 1 is all of it, 0 none. `None` for rows that are
    /// not the gain of a later accelerator.
    pub fn share_of_gain(&self) -> Option<f64> {
        self.row.gain.as_ref()?;
        Some((self.ours? - 1.0) / (self.row.published - 1.0))
    }

    /// Whether ours is farther from the published value than the last time.
    pub fn has_worsened(&self) -> bool {
        let far = |ours| deviation(self.row.published, ours).map(f64::abs);
        if self.row.status == Status::Dropped {
            return false;
        }
        far(self.before).zip(far(self.ours)).is_some_and(|(before, now)| now > before + SLACK)
    }

    /// Whether the run fails because of this row: it fails, or has worsened. A plausible row whose
    /// miss is on record stays on the page, under the status that it was given, and fails no run.
    pub fn is_bad(&self) -> bool {
        let is_known = self.row.status == Status::Plausibility
            && self.before.is_some_and(|before| !self.row.is_near(before));
        (self.verdict == Verdict::Fails && !is_known) || self.has_worsened()
    }
}

fn deviation(published: f64, ours: Option<f64>) -> Option<f64> {
    ours.filter(|_| published != 0.0).map(|ours| ours / published - 1.0)
}

/// Compares a row with what was measured now and the last time.
pub fn judge<'a>(row: &'a Row, ours: Option<&Parts>, before: Option<&Parts>) -> Judged<'a> {
    let parts = ours.cloned().unwrap_or_default();
    let (ours, before) = (ours.and_then(mean), before.and_then(mean));
    let verdict = match (row.status, ours.map(|ours| row.is_near(ours))) {
        (_, None) => Verdict::Open,
        (Status::Dropped, Some(_)) => Verdict::Dropped,
        (Status::KnownGap(_), Some(false)) => Verdict::Gap,
        (Status::KnownGap(_), Some(true)) => Verdict::Closed,
        (Status::Enforced | Status::Calibrated | Status::Plausibility, Some(true)) => {
            Verdict::Holds
        }
        (Status::Enforced | Status::Calibrated | Status::Plausibility, Some(false)) => {
            Verdict::Fails
        }
    };
    Judged { row, ours, parts, before, verdict }
}
