//! Machines with the knob of a modelling assumption perturbed: half and one and a half times a
//! number, or every other name.

use powergs_base::config::assumptions::{Assumption, Knob, Turn, assumptions};
use powergs_base::config::knob;
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{Change, Frames, RunError, System, SystemSpec, Watch};

use super::measure::{MeasuredMachines, SensitivityMeasurements};
use crate::findings::sensitivity::{Fixed, KnobEffect, KnobSetting, Sensitivity};

/// Every assumption of `docs/model.md` that has a knob, perturbed one at a time.
#[derive(Debug, Clone, Copy)]
pub struct AssumptionStudy<'a> {
    /// The machine.
    pub system: &'a System,
    /// Numbers of the assumptions; empty: all.
    pub only: &'a [u32],
    /// Display rate of the powers, frames per second.
    pub display_fps: f64,
}

impl AssumptionStudy<'_> {
    /// Takes the frames through all machines of the experiment; the largest effect comes first.
    /// `None` if it was cancelled before the first frame was done.
    ///
    /// # Errors
    /// As [`Session::fold`](powergs_core::run::Session::fold).
    pub fn run<F: Frames>(
        &self,
        lists: &mut [F],
        watch: &dyn Watch,
    ) -> Result<Option<Sensitivity>, RunError> {
        let mut machines = MeasuredMachines::new(self.system);
        let wanted = |n: &u32| self.only.is_empty() || self.only.contains(n);
        let all = assumptions().iter().map(|(n, a)| (*n, a)).filter(|(n, _)| wanted(n));
        let (perturbed, fixed) = self.perturbed(&mut machines, all);
        let measured = machines.measure(lists, self.display_fps, watch)?;
        let Some(measured) = measured else { return Ok(None) };
        let found = Sensitivity {
            machine: self.system.machine().name.clone(),
            traces: measured.traced(),
            rows: perturbed.iter().map(|p| p.row(&measured)).collect(),
            fixed,
        };
        Ok(Some(found.sorted()))
    }

    /// The knobs of these assumptions on the machine, and the assumptions that have none on it.
    fn perturbed(
        &self,
        machines: &mut MeasuredMachines,
        all: impl Iterator<Item = (u32, &'static Assumption)>,
    ) -> (Vec<PerturbedKnob>, Vec<Fixed>) {
        let (mut perturbed, mut fixed) = (Vec::new(), Vec::new());
        for (number, assumption) in all {
            let mut why = assumption.none.clone();
            let before = perturbed.len();
            for knob in &assumption.knobs {
                match of_knob(self.system, machines, number, assumption, knob) {
                    Ok(found) => perturbed.extend(found),
                    Err(reason) => why = Some(reason),
                }
            }
            if perturbed.len() == before {
                let why =
                    why.unwrap_or_else(|| "the machine has every value of the knob".to_owned());
                let text = assumption.text.clone();
                fixed.push(Fixed { number: format!("A{number}"), text, why });
            }
        }
        (perturbed, fixed)
    }
}

/// A knob at another value.
struct AssumptionPerturbation {
    /// What the keys are set to, as in a file.
    value: String,
    /// Place of the machine with it; or why that is invalid.
    machine: Result<usize, String>,
}

/// A knob of an assumption with its perturbations.
struct PerturbedKnob {
    number: u32,
    assumption: &'static Assumption,
    knob: &'static Knob,
    /// What the keys have.
    value: String,
    /// Place of the machine that the perturbations are compared with.
    base: usize,
    /// Down.
    low: Option<AssumptionPerturbation>,
    /// Up, or to another name.
    high: Option<AssumptionPerturbation>,
}

impl PerturbedKnob {
    /// What it does to the frames that were measured.
    fn row(&self, measured: &SensitivityMeasurements) -> KnobEffect {
        let side = |perturbation: &AssumptionPerturbation| KnobSetting {
            value: perturbation.value.clone(),
            outcomes: perturbation.machine.clone().map(|place| measured.outcomes(place)),
        };
        KnobEffect {
            number: format!("A{}", self.number),
            text: self.assumption.text.clone(),
            file: self.knob.file.name(),
            keys: self.knob.keys.clone(),
            value: self.value.clone(),
            with: self.knob.with.clone(),
            on: self.knob.on.clone(),
            base: measured.outcomes(self.base),
            low: self.low.as_ref().map(side),
            high: self.high.as_ref().map(side),
        }
    }
}

/// A few of the values, as one text.
fn short(values: &[String]) -> String {
    match values {
        [one] => one.clone(),
        [first, .., last] => format!("{first} ... {last}"),
        [] => String::new(),
    }
}

/// The perturbations of a knob; or why the machine has none.
fn of_knob(
    system: &System,
    machines: &mut MeasuredMachines,
    number: u32,
    assumption: &'static Assumption,
    knob: &'static Knob,
) -> Result<Vec<PerturbedKnob>, String> {
    let own = base(system, knob)?;
    let base = own.as_ref().unwrap_or(system);
    let has = values(base, knob);
    if has.is_empty() {
        return Err(format!("the {} file has no `{}`", knob.file.name(), knob.keys.join("`, `")));
    }
    let mut added = |changed: Option<(String, Result<System, String>)>| {
        let (value, system) = changed?;
        Some(AssumptionPerturbation { value, machine: system.map(|system| machines.add(system)) })
    };
    let set = |text: &str| {
        let value = knob::written(text);
        changed(base, knob, |_| Some(value.clone()))
    };
    let scaled = |factor: f64| changed(base, knob, |v| knob::scaled(v, factor));
    let mut side = |turn: Turn| match turn {
        Turn::Set(text) => added(set(&text)),
        Turn::Times(factor) => added(scaled(factor)),
    };
    let sides: Vec<[Option<AssumptionPerturbation>; 2]> = match knob.turns() {
        Some(turns) => vec![turns.map(side)],
        None => {
            let names = knob.values.iter().flatten();
            let others = names.filter(|name| has.iter().any(|h| h != *name));
            others.map(|name| [None, side(Turn::Set(name.clone()))]).collect()
        }
    };
    if let [[None, None]] = &sides[..] {
        return Err(format!(
            "`{}` is {}, which nothing scales",
            knob.keys.join("`, `"),
            short(&has)
        ));
    }
    let value = short(&has);
    let base = own.map_or(0, |own| machines.add(own));
    let perturbed = |[low, high]: [Option<AssumptionPerturbation>; 2]| {
        let value = value.clone();
        PerturbedKnob { number, assumption, knob, value, base, low, high }
    };
    Ok(sides.into_iter().map(perturbed).collect())
}

/// The machine that the perturbations of a knob are compared with, if it is not `system`.
fn base(system: &System, knob: &Knob) -> Result<Option<System>, String> {
    if knob.on.is_none() && knob.with.is_empty() {
        return Ok(None);
    }
    let other = match &knob.on {
        Some(name) => {
            Some(System::load(&SystemSpec::named(name), &EmbeddedFiles).map_err(|e| e.message())?)
        }
        None => None,
    };
    let with: Result<Vec<Change>, String> = knob.with.iter().map(|set| set.parse()).collect();
    let base = other.as_ref().unwrap_or(system).with_from(&with?, &EmbeddedFiles);
    base.map(Some).map_err(|error| error.message())
}

/// What a system has at the keys of `knob`, numbers or names, each once.
fn values(system: &System, knob: &Knob) -> Vec<String> {
    let table = system.table(knob.file.into()).unwrap_or_default();
    let all = knob.keys.iter().flat_map(|key| knob::values(&table, key));
    let mut shown: Vec<String> = all.map(|v| knob::shown(&v)).collect();
    shown.dedup();
    shown
}

/// The new value and the system with every key of `knob` changed, or why that is invalid; `None` if
/// no value can be changed. A key whose value cannot be changed (a price that is zero) stays.
fn changed(
    base: &System,
    knob: &Knob,
    mut to: impl FnMut(&toml::Value) -> Option<toml::Value>,
) -> Option<(String, Result<System, String>)> {
    let mut table = base.table(knob.file.into())?;
    let mut shown = Vec::new();
    for key in &knob.keys {
        knob::change(&mut table, key, &mut |value| {
            let new = to(value)?;
            shown.push(knob::shown(&new));
            Some(new)
        });
    }
    shown.dedup();
    if shown.is_empty() {
        return None;
    }
    let system = base.with_table(knob.file.into(), &table, &EmbeddedFiles);
    Some((short(&shown), system.map_err(|error| error.message())))
}
