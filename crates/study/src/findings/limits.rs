//! What is not modelled, and which assumptions mattered most: said with every report.

use super::bottleneck::{Bottleneck, Limit};
use crate::run_record::{Experiments, MachineFacts};
use powergs_core::machine::DramModel;
use powergs_core::machine::Machine;
use powergs_core::sim::statistics::{Key, Record};
use powergs_core::stage::{OmitDecl, left_out, omissions, stage};
use powergs_energy::Component;

pub use powergs_core::stage::Bias;

/// An effect that is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effect {
    /// What is left out.
    pub what: &'static str,
    /// Which way the frame time is wrong for it.
    pub bias: Bias,
    /// The assumption that says more; empty where none does.
    pub assumption: &'static str,
    /// The key and value with which a machine leaves it out; empty where all do.
    pub with: &'static str,
}

impl From<&OmitDecl> for Effect {
    fn from(omit: &OmitDecl) -> Effect {
        let OmitDecl { what, bias, assumption, with, by: _ } = *omit;
        Effect { what, bias, assumption, with }
    }
}

/// The effects that runs of a machine leave out.
pub fn left_out_by(machine: &Machine) -> Vec<Effect> {
    left_out(machine).map(Effect::from).collect()
}

/// Everything that is known to be left out.
pub fn not_modelled() -> Vec<Effect> {
    omissions().map(Effect::from).collect()
}

/// How many effects are wrong which way, in the order of [`Bias`].
pub fn ways(effects: &[Effect]) -> [usize; 3] {
    let of = |bias| effects.iter().filter(|e| e.bias == bias).count();
    [Bias::Optimistic, Bias::Pessimistic, Bias::Either].map(of)
}

/// An assumption, and why it mattered in this run.
#[derive(Debug, Clone, PartialEq)]
pub struct Mattered {
    /// Number in `docs/model.md` or `docs/model-accel.md`, or a key of `references.toml`.
    pub assumption: String,
    /// Why.
    pub why: Why,
}

/// Why an assumption mattered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Why {
    /// It decides how fast a resource is that moves the time.
    Doubled {
        /// What was doubled, in the words of the machine file.
        resource: &'static str,
        /// Relative change of the frame time.
        change: f64,
    },
    /// It is behind the bottleneck of the run.
    Bottleneck,
    /// Turned to its low and high, it moves the power at the display rate.
    Price {
        /// Power with the prices as they are, watts.
        power_w: f64,
        /// Least power, watts.
        low_w: f64,
        /// Greatest power, watts.
        high_w: f64,
    },
    /// It prices a large part of the energy.
    Energy {
        /// The part.
        part: Component,
        /// Its share of the energy of a frame, 0 to 1.
        share: f64,
    },
}

/// A doubled resource that moves the time, or a price that moves the power, by at least this share
/// matters.
const MATTERS: f64 = 0.03;

/// A part of the energy of at least this share matters.
const LARGE: f64 = 0.15;

/// The assumptions that mattered most: those behind the resources that move the time most when they
/// are doubled (without that experiment: behind the bottleneck), those whose prices move the power
/// most when they are turned, then those behind the largest parts of the energy that have no knob.
/// Each is named once, for its first reason.
pub fn mattered(
    record: &Record,
    machine: &MachineFacts,
    bottleneck: Option<&Bottleneck>,
    experiments: &Experiments,
) -> Vec<Mattered> {
    let mut all: Vec<Mattered> = Vec::new();
    let mut add = |assumption: &str, why: Why| {
        if !all.iter().any(|m| m.assumption == assumption) {
            all.push(Mattered { assumption: assumption.to_owned(), why });
        }
    };
    match &experiments.what_if {
        Some(what_if) => {
            for step in &what_if.steps {
                let change = what_if.time_change(step);
                if change.abs() >= MATTERS {
                    let why = Why::Doubled { resource: step.resource, change };
                    step.assumptions.iter().for_each(|number| add(number, why));
                }
            }
        }
        None => {
            if let Some(found) = bottleneck {
                let numbers: &[&str] = match found.limit {
                    // Only that model has an efficiency and a latency of its own.
                    Limit::Dram => match machine.dram_model {
                        None | Some(DramModel::Bandwidth) => &["A4", "A5"],
                        Some(_) => &["A41"],
                    },
                    Limit::Unit(unit) => stage(unit).behind,
                };
                numbers.iter().for_each(|number| add(number, Why::Bottleneck));
            }
        }
    }
    if let Some(prices) = &experiments.prices {
        let power_w = prices.power_w;
        for bar in prices.bars.iter().filter(|bar| bar.spread_w() >= MATTERS * power_w) {
            let (low_w, high_w) = (bar.low_w, bar.high_w);
            add(&bar.assumption, Why::Price { power_w, low_w, high_w });
        }
    }
    let total = record.value(Key::Energy);
    if total > 0.0 {
        let share = |part| record.value(Key::EnergyOf(part)) / total;
        let mut large: Vec<_> = Component::ALL.map(|part| (share(part), part)).to_vec();
        large.retain(|(share, _)| *share >= LARGE);
        large.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (share, part) in large {
            if let Some(source) = behind(part, machine) {
                add(source, Why::Energy { part, share });
            }
        }
    }
    all
}

/// What is behind the price of a part of the energy and has no knob of a price.
fn behind(part: Component, machine: &MachineFacts) -> Option<&str> {
    match part {
        Component::Dram => machine.dram_byte_price.as_deref(),
        Component::Sram => Some("A13"),
        Component::Flop | Component::Leakage | Component::Background | Component::Refresh => None,
    }
}
