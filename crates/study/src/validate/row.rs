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

    /// The largest distance from `published` that is near enough, as a share of it.
    pub fn width(self, published: f64) -> f64 {
        match self {
            Tolerance::Share(share) => share,
            Tolerance::Range(low, high) => {
                let away = |end: f64| ((end - published) / published).abs();
                away(low).max(away(high))
            }
        }
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

/// What a row says, and so what is expected of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Held out, and near: it must stay inside a tolerance of at most [`Status::NEAR`]. Only these
    /// rows are evidence that the simulator is right.
    Enforced,
    /// The published value set a price, a key, an organisation or a workload that the row depends
    /// on. It must stay inside its tolerance, and proves nothing.
    Calibrated,
    /// The range is so wide, or what is compared so loosely defined, that a wrong simulator may
    /// pass, too. It must stay inside.
    Plausibility,
    /// Outside of its tolerance, for a reason of this class that is told in its note.
    KnownGap(Gap),
    /// Nothing can be decided by it, for the reason in its note.
    Dropped,
}

impl Status {
    /// The widest tolerance of an enforced row, as a share of the published value.
    pub const NEAR: f64 = 0.25;

    /// The name in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Status::Enforced => "enforced",
            Status::Calibrated => "calibrated",
            Status::Plausibility => "plausibility",
            Status::KnownGap(_) => "known_gap",
            Status::Dropped => "dropped",
        }
    }

    /// The class of a known gap.
    pub const fn gap(self) -> Option<Gap> {
        match self {
            Status::KnownGap(gap) => Some(gap),
            Status::Enforced | Status::Calibrated | Status::Plausibility | Status::Dropped => None,
        }
    }

    /// The status of this name and class.
    pub(super) fn named(name: &str, class: &str) -> Option<Status> {
        let gap = || Gap::ALL.into_iter().find(|gap| gap.name() == class);
        let plain = [Status::Enforced, Status::Calibrated, Status::Plausibility, Status::Dropped];
        match name {
            "known_gap" => gap().map(Status::KnownGap),
            _ => plain.into_iter().find(|s| class.is_empty() && s.name() == name),
        }
    }
}

/// Why a row is outside of its tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Gap {
    /// Publications contradict each other, or themselves.
    Contradiction,
    /// The simulator lacks a mechanism.
    Mechanism,
    /// The workload is not like the one that was used.
    Workload,
    /// The machine file is not like the machine that was published.
    Preset,
}

impl Gap {
    /// All classes.
    pub const ALL: [Gap; 4] = [Gap::Contradiction, Gap::Mechanism, Gap::Workload, Gap::Preset];

    /// The name in the file and in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Gap::Contradiction => "contradiction",
            Gap::Mechanism => "mechanism",
            Gap::Workload => "workload",
            Gap::Preset => "preset",
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
    /// Names of its workloads, over which its value is the mean; none where it needs no frame.
    pub workloads: Vec<String>,
    /// The machine.
    pub machine: MachineName,
    /// What it is compared with, for metrics that compare.
    pub against: Option<MachineName>,
    /// What is measured.
    pub metric: Metric,
    /// The published value, in the unit of the metric.
    pub published: f64,
    /// What is near enough; `None` where nothing is decided.
    pub tolerance: Option<Tolerance>,
    /// What is expected.
    pub status: Status,
    /// Where the row is the gain of a later accelerator over the one before it: what the machine
    /// or the simulator lacks to show it; empty where nothing is known to be missing.
    pub gain: Option<String>,
    /// Who published it.
    pub source: String,
    /// Settings, arithmetic, and the reason of a gap.
    pub note: String,
}

impl Row {
    /// Whether a value of ours is within its tolerance.
    pub(super) fn is_near(&self, ours: f64) -> bool {
        self.tolerance.is_none_or(|t| t.holds(self.published, ours))
    }

    /// The names of its workloads; one empty name where it needs none.
    pub fn part_names(&self) -> impl Iterator<Item = &str> {
        let none = self.workloads.is_empty().then_some("");
        none.into_iter().chain(self.workloads.iter().map(String::as_str))
    }
}
