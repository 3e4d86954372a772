//! What is not modelled, and which assumptions mattered most: said with every report.

use super::Means;
use super::bottleneck::{Bottleneck, Limit};
use super::what_if::WhatIf;

/// What an effect that is left out does to the frame time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bias {
    /// Real frames take longer than simulated ones.
    Optimistic,
    /// Real frames take less time than simulated ones.
    Pessimistic,
    /// Depends on the scene or the design.
    Either,
}

impl Bias {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Bias::Optimistic => "optimistic",
            Bias::Pessimistic => "pessimistic",
            Bias::Either => "either",
        }
    }
}

/// An effect that is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effect {
    /// What is left out.
    pub what: &'static str,
    /// Which way the frame time is wrong for it.
    pub bias: Bias,
    /// The assumption that says more; empty where none does.
    pub assumption: &'static str,
    /// Left out only by machines with this value of this key of `[dram]`; `None`: by all.
    pub dram: Option<(&'static str, &'static str)>,
}

impl Effect {
    /// Whether it is left out by the machine of `configuration` (as in `run.toml`).
    pub fn applies(&self, configuration: &toml::Table) -> bool {
        let Some((key, value)) = self.dram else { return true };
        let dram = configuration.get("machine").and_then(|m| m.get("dram"));
        dram.and_then(|d| d.get(key)).is_none_or(|v| v.as_str() == Some(value))
    }
}

const fn effect(what: &'static str, bias: Bias, assumption: &'static str) -> Effect {
    Effect { what, bias, assumption, dram: None }
}

/// The effects that a run left out.
pub fn left_out(configuration: &toml::Table) -> Vec<Effect> {
    NOT_MODELLED.into_iter().filter(|e| e.applies(configuration)).collect()
}

/// Everything that is known to be left out.
pub const NOT_MODELLED: [Effect; 9] = [
    Effect {
        dram: Some(("model", "bandwidth")),
        ..effect("rows, banks, refresh and turnaround of the DRAM", Bias::Either, "A4")
    },
    effect("box tests uneven within a batch of Gaussians", Bias::Optimistic, "A21"),
    effect("pivots that split a list unevenly and need another pass", Bias::Optimistic, "A23"),
    effect("deeper prefetch while nobody knows that a tile is done", Bias::Either, "A30"),
    effect("address translation, interconnect and other users of the DRAM", Bias::Optimistic, ""),
    effect("frame set-up: camera, command lists, the processor", Bias::Optimistic, ""),
    effect("clock and voltage changes, temperature, wake-up times", Bias::Optimistic, ""),
    effect("reads of one unit served before older ones of another", Bias::Either, "A33"),
    effect("lists of early tiles used before preprocessing ends", Bias::Pessimistic, "A28"),
];

/// An assumption, and why it mattered in this run.
#[derive(Debug, Clone, PartialEq)]
pub struct Mattered {
    /// Number in `docs/model.md` or `docs/model-accel.md`, or a key of `references.toml`.
    pub assumption: &'static str,
    /// Why.
    pub why: String,
}

/// A doubled resource that moves the time by at least this share matters.
const MATTERS: f64 = 0.03;

/// A part of the energy of at least this share matters.
const LARGE: f64 = 0.15;

/// The assumptions that mattered most: those behind the resources that move the time most when they
/// are doubled (without that experiment: behind the bottleneck), then those behind the largest
/// parts of the energy. Each is named once, for its first reason.
pub fn mattered(
    means: &Means,
    bottleneck: Option<&Bottleneck>,
    what_if: Option<&WhatIf>,
) -> Vec<Mattered> {
    let mut all: Vec<Mattered> = Vec::new();
    let mut add = |numbers: &[&'static str], why: String| {
        for &assumption in numbers {
            if !all.iter().any(|m| m.assumption == assumption) {
                all.push(Mattered { assumption, why: why.clone() });
            }
        }
    };
    match what_if {
        Some(what_if) => {
            for step in &what_if.steps {
                let change = what_if.time_change(step);
                if change.abs() >= MATTERS {
                    let change = super::what_if::signed_percent(change);
                    let why = format!("doubling {}: frame time {}", step.resource, change.trim());
                    add(step.assumptions, why);
                }
            }
        }
        None => {
            if let Some(found) = bottleneck {
                let numbers: &[&str] = match found.limit {
                    Limit::Dram => &["A4", "A5"],
                    Limit::Unit("ccu") => &["A1", "A2"],
                    Limit::Unit("qsu") => &["A23", "A24"],
                    Limit::Unit("bsu") => &["A25"],
                    Limit::Unit(_) => &["A26", "A27"],
                };
                add(numbers, "behind the bottleneck of this run".into());
            }
        }
    }
    let total = means.get("energy_pj.total").filter(|t| *t > 0.0);
    let parts: [(&str, &str, &[&'static str]); 6] = [
        ("dram", "DRAM accesses", &["powergs"]),
        ("sram", "buffer accesses", &["A13"]),
        ("flop", "arithmetic", &["A8", "A10"]),
        ("leakage", "leakage", &["A9"]),
        ("background", "DRAM background", &["A11"]),
        ("refresh", "DRAM refresh", &["A11"]),
    ];
    let mut large: Vec<_> = parts
        .into_iter()
        .filter_map(|(name, words, numbers)| {
            let share = means.get(&format!("energy_pj.{name}"))? / total?;
            (share >= LARGE).then_some((share, words, numbers))
        })
        .collect();
    large.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (share, words, numbers) in large {
        add(numbers, format!("{words}: {} % of the energy", super::format::percent(share)));
    }
    all
}

/// The line on the terminal that points to the list.
pub fn line(left_out: usize, mattered: &[Mattered]) -> String {
    let numbers: Vec<&str> = mattered.iter().map(|m| m.assumption).take(6).collect();
    let mattered = if numbers.is_empty() {
        String::new()
    } else {
        format!("; mattered most: {}", numbers.join(" "))
    };
    format!("limits  {left_out} effects left out{mattered}\n")
}

/// The table of [`NOT_MODELLED`] for `docs/limits.md`.
pub fn page() -> String {
    let mut text = String::from(PAGE);
    for effect in NOT_MODELLED {
        let which = effect.dram.map_or("all".to_owned(), |(k, v)| format!("`dram.{k} = \"{v}\"`"));
        let see = if effect.assumption.is_empty() { "-" } else { effect.assumption };
        let (what, bias) = (effect.what, effect.bias.name());
        text += &format!("| {what} | {bias} | {see} | {which} |\n");
    }
    text
}

const PAGE: &str = "\
# What is not modelled

<!-- Written from src/report/limits.rs: change that, then UPDATE_EXPECT=1 cargo test report:: -->

Every report of the `cycle` model ends with this list (`summary.md`, `not_modelled` in `--json`). \
*Optimistic*: real frames take longer than simulated ones; *pessimistic*: real frames take less \
time. The A-numbers are explained in [model-accel.md](model-accel.md) and [model.md](model.md). \
Beside it a report names the assumptions that mattered most in that run: those behind the \
resources that move the frame time by 3 % or more when they are doubled (`--what-if`), and those \
behind every part of 15 % or more of the energy.

| effect | simulated time is | see | machines |
|---|---|---|---|
";
