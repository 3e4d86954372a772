//! One published number, and what is measured for it.

use std::fmt;

use super::Metric;

/// A machine: a name or path, and what is changed of it.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct MachineName {
    /// Name of a machine that comes with the program, or path of a TOML file.
    pub arch: String,
    /// `key=value` overlays.
    pub sets: Vec<String>,
}

impl MachineName {
    /// Reads `gscore vru.cores=8 clock=800MHz`.
    pub fn parse(text: &str) -> Option<MachineName> {
        let mut words = text.split_whitespace().map(str::to_owned);
        Some(MachineName { arch: words.next()?, sets: words.collect() })
    }
}

impl fmt::Display for MachineName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.arch)?;
        self.sets.iter().try_for_each(|set| write!(f, " {set}"))
    }
}

/// Rounding of a share.
const BORDER: f64 = 1e-9;

/// What of a value is near enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tolerance {
    /// At most this share of the published value away from it.
    Share(f64),
    /// From the first to the second value.
    Range(f64, f64),
}

impl Tolerance {
    /// Reads `10%` or `0.43..0.68`.
    pub fn parse(text: &str) -> Option<Tolerance> {
        let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
        if let Some((low, high)) = text.split_once("..") {
            let (low, high) = (number(low)?, number(high)?);
            return (low <= high).then_some(Tolerance::Range(low, high));
        }
        let share = number(text.trim().strip_suffix('%')?)? * 0.01;
        (share >= 0.0).then_some(Tolerance::Share(share))
    }

    /// Whether `ours` is near enough to `published`.
    pub fn holds(self, published: f64, ours: f64) -> bool {
        match self {
            // What lies on the border is inside, whatever its last bit says.
            Tolerance::Share(share) => {
                (ours - published).abs() <= (share + BORDER) * published.abs()
            }
            Tolerance::Range(low, high) => (low..=high).contains(&ours),
        }
    }
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Tolerance::Share(share) => write!(f, "±{} %", (share * 1e4).round() * 1e-2),
            Tolerance::Range(low, high) => write!(f, "{low} to {high}"),
        }
    }
}

/// What is expected of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// It must stay inside its tolerance.
    Enforced,
    /// It is outside of its tolerance, for the reason in its note.
    KnownGap,
}

impl Status {
    /// The name in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Status::Enforced => "enforced",
            Status::KnownGap => "known_gap",
        }
    }
}

/// Whether the row had a say in a default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// A default was chosen with its help; the note says which.
    Calibrated,
    /// No default was.
    HeldOut,
}

impl Origin {
    /// The name in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Origin::Calibrated => "calibrated",
            Origin::HeldOut => "held_out",
        }
    }
}

/// A published number.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its name: letters, digits and `-`.
    pub id: String,
    /// The publication or group that it belongs to.
    pub section: String,
    /// What it is, in a few words.
    pub what: String,
    /// Name of its workload; `None` where it needs no frame.
    pub workload: Option<String>,
    /// The machine.
    pub machine: MachineName,
    /// What it is compared with, for metrics that compare.
    pub against: Option<MachineName>,
    /// What is measured.
    pub metric: Metric,
    /// The published value, in the unit of the metric.
    pub published: f64,
    /// What is near enough.
    pub tolerance: Tolerance,
    /// What is expected.
    pub status: Status,
    /// Whether it had a say in a default.
    pub origin: Origin,
    /// Who published it.
    pub source: String,
    /// Settings, arithmetic, and the reason of a gap.
    pub note: String,
}
