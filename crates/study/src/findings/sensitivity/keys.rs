//! What every key of a machine's files moves, one key at a time: elasticities, what a factor of two
//! does, and the keys that move nothing.

use super::measure::{Measure, Traced, incomplete_note};
use crate::findings::cost::Cost;

/// Below this relative change a key is weak.
pub const LEAST: f64 = 0.0005;

/// How far a key is perturbed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// The step of the elasticity.
    Near,
    /// To half or to double, or as near to it as a machine allows.
    Far,
    /// To another name, or on from off.
    Name,
}

impl Reach {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Reach::Near => "near",
            Reach::Far => "far",
            Reach::Name => "name",
        }
    }
}

/// A key with another value.
#[derive(Debug, Clone, PartialEq)]
pub struct Perturbation {
    /// How far.
    pub reach: Reach,
    /// What it is set to, as in a file.
    pub value: String,
    /// The value over the one of the machine; `None` for names.
    pub ratio: Option<f64>,
    /// What it costs, by trace; or why that is no machine.
    pub outcomes: Result<Vec<Cost>, String>,
}

/// `d ln y / d ln x`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Elasticity {
    /// The value: 1 if twice as much of the key is twice as much of the measure.
    pub value: f64,
    /// Sides that it is taken over: `both`, `down`, `up`.
    pub sides: &'static str,
}

/// Elasticities below this have no kink worth a mark.
const KINK: f64 = 0.02;

/// How a measure runs around the value of a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Alike on both sides.
    Smooth,
    /// At least twice as steep on one side as on the other, or up on both: whole turns of a unit, a
    /// buffer that just fits. The elasticity says nothing about other steps.
    Kinked,
    /// Known on one side only.
    OneSided,
}

impl Shape {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Shape::Smooth => "smooth",
            Shape::Kinked => "kinked",
            Shape::OneSided => "one-sided",
        }
    }
}

/// A key.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct KeyRow {
    /// Kind of file that has it.
    pub file: &'static str,
    /// The key.
    pub key: String,
    /// What the machine has, as in a file.
    pub value: String,
    /// The machine as it is, by trace.
    pub base: Vec<Cost>,
    /// Other values: near ones, far ones, names; each ascending.
    pub perturbations: Vec<Perturbation>,
    /// Why it may move nothing, where that is known.
    pub reason: Option<String>,
}

impl KeyRow {
    /// The perturbations of one reach that are machines, with their means over the traces.
    pub fn reached(&self, reach: Reach) -> impl Iterator<Item = (&Perturbation, Cost)> {
        let of = move |t: &Perturbation| t.reach == reach;
        let mean = |t: &Perturbation| Some(Cost::mean(t.outcomes.as_ref().ok()?));
        self.perturbations.iter().filter(move |t| of(t)).filter_map(move |t| Some((t, mean(t)?)))
    }

    /// The elasticity of a measure, of its mean over the traces: over both near sides where both
    /// are machines, else over one. `None` for names, and for a measure that is zero or unknown.
    pub fn elasticity(&self, measure: Measure) -> Option<Elasticity> {
        let log = |o: &Cost| measure.of(o).filter(|&y| y > 0.0).map(f64::ln);
        let centre = log(&Cost::mean(&self.base))?;
        let (mut low, mut high) = ((0.0, centre), (0.0, centre));
        for (turned, outcome) in self.reached(Reach::Near) {
            let point = (turned.ratio?.ln(), log(&outcome)?);
            if point.0 < 0.0 {
                low = point;
            } else {
                high = point;
            }
        }
        let sides = match (low.0 < 0.0, high.0 > 0.0) {
            (true, true) => "both",
            (true, false) => "down",
            (false, true) => "up",
            (false, false) => return None,
        };
        Some(Elasticity { value: (high.1 - low.1) / (high.0 - low.0), sides })
    }

    /// How far the elasticity of a measure can be trusted.
    pub fn shape(&self, measure: Measure) -> Shape {
        let log = |o: &Cost| measure.of(o).filter(|&y| y > 0.0).map(f64::ln);
        let slope = |up: bool| {
            let centre = log(&Cost::mean(&self.base))?;
            let is_side = |t: &Perturbation| t.ratio.is_some_and(|r| (r > 1.0) == up);
            let (near, outcome) = self.reached(Reach::Near).find(|(t, _)| is_side(t))?;
            Some((log(&outcome)? - centre) / near.ratio?.ln())
        };
        match (slope(false), slope(true)) {
            (Some(down), Some(up)) => {
                let (steep, flat) = (down.abs().max(up.abs()), down.abs().min(up.abs()));
                let kinked = steep > KINK && (flat < steep / 2.0 || down * up < 0.0);
                if kinked { Shape::Kinked } else { Shape::Smooth }
            }
            _ => Shape::OneSided,
        }
    }

    /// The largest relative change of any measure at half or at double, or by another name.
    pub fn far_effect(&self) -> f64 {
        if !self.is_number() {
            return self.largest();
        }
        let changes = Measure::ALL.into_iter().flat_map(|m| self.far(m));
        changes.flatten().map(f64::abs).fold(0.0, f64::max)
    }

    /// The largest relative change of one measure at half or at double, or by another name.
    pub fn far_effect_on(&self, measure: Measure) -> f64 {
        if !self.is_number() {
            return self.effect(measure);
        }
        self.far(measure).into_iter().flatten().map(f64::abs).fold(0.0, f64::max)
    }

    /// Relative changes of a measure at half and at double (or as near to it as there are
    /// machines).
    pub fn far(&self, measure: Measure) -> [Option<f64>; 2] {
        let base = Cost::mean(&self.base);
        let side = |up: bool| {
            let is_side = |t: &Perturbation| t.ratio.is_some_and(|r| (r > 1.0) == up);
            let (_, outcome) = self.reached(Reach::Far).find(|(t, _)| is_side(t))?;
            measure.change(&outcome, &base)
        };
        [side(false), side(true)]
    }

    /// The largest relative change of a measure by any perturbation on any trace; 0 if none is a
    /// machine.
    pub fn effect(&self, measure: Measure) -> f64 {
        let change = |outcomes: &Vec<Cost>| {
            let pairs = outcomes.iter().zip(&self.base);
            pairs
                .filter_map(|(new, base)| measure.change(new, base))
                .map(f64::abs)
                .fold(0.0, f64::max)
        };
        self.perturbations
            .iter()
            .filter_map(|t| t.outcomes.as_ref().ok())
            .map(change)
            .fold(0.0, f64::max)
    }

    /// The largest effect on any measure.
    pub fn largest(&self) -> f64 {
        Measure::ALL.into_iter().map(|m| self.effect(m)).fold(0.0, f64::max)
    }

    /// What the key is on these traces.
    pub fn status(&self) -> Status {
        match self.largest() {
            _ if self.perturbations.iter().all(|t| t.outcomes.is_err()) => Status::Fixed,
            0.0 => Status::Dead,
            effect if effect < LEAST => Status::Weak,
            _ => Status::Alive,
        }
    }

    /// Whether it has numbers, not names.
    pub fn is_number(&self) -> bool {
        self.perturbations.iter().any(|t| t.reach != Reach::Name)
    }
}

/// What a key is on some traces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// It moves something.
    Alive,
    /// It moves no measure by 0.05 %.
    Weak,
    /// It moves nothing at all.
    Dead,
    /// No other value that was tried is a machine.
    Fixed,
}

impl Status {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Status::Alive => "alive",
            Status::Weak => "weak",
            Status::Dead => "dead",
            Status::Fixed => "fixed",
        }
    }
}

/// Keys that are not perturbed.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct NotTried {
    /// Kind of file.
    pub file: &'static str,
    /// Which keys.
    pub keys: String,
    /// Why not.
    pub why: String,
}

/// The whole experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Keys {
    /// Name of the machine.
    pub machine: String,
    /// Display rate of the powers, frames per second.
    pub display_fps: f64,
    /// Relative step of elasticities that was asked for; whole numbers and sizes take larger ones.
    pub step: f64,
    /// The traces.
    pub traces: Vec<Traced>,
    /// The keys; after [`Keys::sorted`] by what a far step does to the power, the largest first.
    pub rows: Vec<KeyRow>,
    /// Keys that are not perturbed.
    pub not_tried: Vec<NotTried>,
}

impl Keys {
    /// Rows by what a far step does to the power, in steps of [`LEAST`]; of those that are alike in
    /// it by what it does to anything; equal ones stay in the order of the files.
    #[must_use]
    pub fn sorted(mut self) -> Keys {
        let step = |row: &KeyRow| (row.far_effect_on(Measure::Power) / LEAST).floor();
        let order = |a: &KeyRow, b: &KeyRow| {
            step(b).total_cmp(&step(a)).then(b.far_effect().total_cmp(&a.far_effect()))
        };
        self.rows.sort_by(order);
        self
    }

    /// Rows of one status.
    pub fn of(&self, status: Status) -> impl Iterator<Item = &KeyRow> {
        self.rows.iter().filter(move |r| r.status() == status)
    }

    /// Keys without an effect by the reason for it, in the order of their first key.
    pub fn dead_by_reason(&self) -> Vec<(String, Vec<&KeyRow>)> {
        let mut found: Vec<(String, Vec<&KeyRow>)> = Vec::new();
        for row in self.of(Status::Dead) {
            let why = row.reason.clone().unwrap_or_else(|| "limits nothing on these frames".into());
            match found.iter_mut().find(|(known, _)| *known == why) {
                Some((_, rows)) => rows.push(row),
                None => found.push((why, vec![row])),
            }
        }
        found
    }

    /// What is missing because it was interrupted, if so.
    pub fn incomplete_note(&self) -> Option<String> {
        incomplete_note(&self.traces)
    }
}
