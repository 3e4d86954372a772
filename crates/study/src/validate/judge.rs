//! The verdict on a measured row.

use super::row::{Row, Status};

/// Deviations that grow by less than this share of the published value have not worsened: scenes
/// are deterministic, but not every last digit of a change is worth a discussion.
const SLACK: f64 = 0.01;

/// What came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Enforced, and inside its tolerance.
    Holds,
    /// Enforced, and outside.
    Fails,
    /// A known gap, and still outside.
    Gap,
    /// A known gap that is inside by now: the record should say so.
    Closed,
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
            Verdict::Open => "not measured",
        }
    }
}

/// A row with its measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged<'a> {
    /// The row.
    pub row: &'a Row,
    /// What came out.
    pub ours: Option<f64>,
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

    /// Whether ours is farther from the published value than the last time.
    pub fn has_worsened(&self) -> bool {
        let far = |ours| deviation(self.row.published, ours).map(f64::abs);
        far(self.before).zip(far(self.ours)).is_some_and(|(before, now)| now > before + SLACK)
    }

    /// Whether the run fails because of this row.
    pub fn is_bad(&self) -> bool {
        self.verdict == Verdict::Fails || self.has_worsened()
    }
}

fn deviation(published: f64, ours: Option<f64>) -> Option<f64> {
    ours.filter(|_| published != 0.0).map(|ours| ours / published - 1.0)
}

/// Compares a row with what was measured now and the last time.
pub fn judge(row: &Row, ours: Option<f64>, before: Option<f64>) -> Judged<'_> {
    let holds = ours.map(|ours| row.tolerance.holds(row.published, ours));
    let verdict = match (row.status, holds) {
        (_, None) => Verdict::Open,
        (Status::Enforced, Some(true)) => Verdict::Holds,
        (Status::Enforced, Some(false)) => Verdict::Fails,
        (Status::KnownGap, Some(false)) => Verdict::Gap,
        (Status::KnownGap, Some(true)) => Verdict::Closed,
    };
    Judged { row, ours, before, verdict }
}
