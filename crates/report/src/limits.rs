//! What is not modelled, and which assumptions mattered most, in words.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::OnceLock;

use serde::Deserialize;

use super::document::{Cell, Column, Table, Text};
use super::format::{engineering_like, percent};
use powergs_base::config::assumptions::assumptions;
use powergs_base::config::references::references;
use powergs_base::format::counted;
use powergs_core::machine::{Exclusion, KeyValues};
use powergs_core::stage::stages;
use powergs_energy::Component;
use powergs_study::findings::limits::{Effect, Mattered, Why, not_modelled, ways};
use powergs_study::findings::prices::PriceBars;

/// Why an assumption mattered, in a few words.
pub fn why(why: &Why) -> String {
    match why {
        Why::Doubled { resource, change } => {
            format!("doubling {resource}: frame time {}", signed_percent(*change))
        }
        Why::Bottleneck => "behind the bottleneck of this run".into(),
        Why::Price { power_w, low_w, high_w } => {
            let watt = |watts: f64| engineering_like(watts, *power_w, "W");
            format!("power {}, {} to {} by its price", watt(*power_w), watt(*low_w), watt(*high_w))
        }
        Why::Energy { part, share } => {
            format!("{}: {} % of the energy", part_words(*part), percent(*share))
        }
    }
}

/// A relative change with its sign: `-24 %`.
pub fn signed_percent(change: f64) -> String {
    match change * 100.0 {
        p if p.abs() < 0.05 => "0 %".to_owned(),
        p if p.abs() < 9.95 => format!("{p:+.1} %"),
        p => format!("{p:+.0} %"),
    }
}

fn part_words(part: Component) -> &'static str {
    match part {
        Component::Dram => "DRAM accesses",
        Component::Sram => "buffer accesses",
        Component::Flop => "arithmetic",
        Component::Leakage => "leakage",
        Component::Background => "DRAM background",
        Component::Refresh => "DRAM refresh",
    }
}

/// Assumptions that are named on a terminal.
const NAMED: usize = 3;

/// The line on the terminal that points to the lists: effects, and assumptions other than prices.
pub fn line(left_out: &[Effect], mattered: &[Mattered]) -> String {
    let mut text = sum(left_out);
    let others = |m: &&Mattered| !matches!(m.why, Why::Price { .. });
    let mattered: Vec<&Mattered> = mattered.iter().filter(others).collect();
    if mattered.is_empty() {
        return text;
    }
    let named: Vec<String> = mattered.iter().take(NAMED).map(|m| titled(&m.assumption)).collect();
    text += &format!("; the assumptions that matter most: {}", named.join("; "));
    let others: Vec<&str> = mattered.iter().skip(NAMED).map(|m| m.assumption.as_str()).collect();
    if !others.is_empty() {
        text += &format!("; also {}", others.join(", "));
    }
    text
}

/// Which way all effects together are wrong, by their number: nobody knows their sizes.
pub fn sum(left_out: &[Effect]) -> String {
    let [optimistic, pessimistic, either] = ways(left_out);
    let all = counted(left_out.len(), "effect");
    if left_out.is_empty() {
        return format!("{all} left out");
    }
    let so = match optimistic.cmp(&pessimistic) {
        Ordering::Greater => "frame times are rather too short",
        Ordering::Less => "frame times are rather too long",
        Ordering::Equal => "neither way prevails",
    };
    format!(
        "{all} left out: {optimistic} optimistic, {pessimistic} pessimistic, {either} either way: \
         {so}"
    )
}

/// How far the widest price assumptions move the power, in a line; `None` where none does.
pub fn prices(prices: &PriceBars) -> Option<String> {
    let watt = |watts: f64| engineering_like(watts, prices.power_w, "W");
    let bar = |bar: &powergs_study::findings::prices::PriceBar| {
        format!("{} to {} by {}", watt(bar.low_w), watt(bar.high_w), titled(&bar.assumption))
    };
    let bars: Vec<String> = prices.bars.iter().take(NAMED).map(bar).collect();
    let head = format!("{}, one assumption at a time", watt(prices.power_w));
    (!bars.is_empty()).then(|| format!("{head}: {}", bars.join("; ")))
}

/// An assumption with its number, or a source with its key, in words.
pub fn titled(name: &str) -> String {
    let number = name.strip_prefix('A').and_then(|n| n.parse().ok());
    let known = number.and_then(|number| assumptions().get(&number));
    match (known, references().get(name)) {
        (Some(assumption), _) => format!("{name} ({})", assumption.text),
        (None, Some(source)) => {
            let title = source.title.split(':').next().unwrap_or_default();
            format!("numbers of {title} (`{name}`)")
        }
        (None, None) => name.to_owned(),
    }
}

/// By how much the chip of `rtl/` takes longer than the model; `powergs-lab assumptions` wrote it.
const RTL: &str = include_str!("rtl.toml");

/// What an assumption is off by, measured on the chip of `rtl/`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RtlError {
    /// The phase of a frame that is compared.
    pub of: String,
    /// By how much the RTL takes longer than the model, percent: the least of all runs.
    pub low: f64,
    /// The most.
    pub high: f64,
}

/// What `rtl/` says of the assumption behind an effect.
pub fn measured(effect: &Effect) -> Option<&'static RtlError> {
    static ALL: OnceLock<BTreeMap<String, RtlError>> = OnceLock::new();
    let all = ALL.get_or_init(|| toml::from_str(RTL).unwrap_or_else(|e| panic!("rtl.toml: {e}")));
    all.get(effect.assumption)
}

/// Which way the time is wrong, and by how much where that is measured.
fn way(effect: &Effect) -> String {
    let bias = effect.bias.name();
    match measured(effect) {
        None => bias.to_owned(),
        Some(RtlError { of, low, high }) => {
            format!("{bias}; {of} of the RTL: {low:+.1} to {high:+.1} %")
        }
    }
}

/// Effects that a run leaves out.
pub fn table(effects: &[Effect]) -> Table {
    let columns = ["effect", "simulated time is", "see"].map(Column::text);
    let row = |e: &Effect| [e.what.into(), way(e).into(), Cell::from(e.assumption)];
    Table::new(columns).rows(effects.iter().map(row))
}

/// All of [`not_modelled`] for `docs/limits.md`.
pub fn page() -> String {
    let columns = ["effect", "simulated time is", "see", "machines"].map(Column::text);
    let row = |e: &Effect| {
        let machines = if e.with.is_empty() { Text::from("all") } else { Text::code(e.with) };
        let see = if e.assumption.is_empty() { "-" } else { e.assumption };
        [e.what.into(), way(e).into(), see.into(), Cell::from(machines)]
    };
    let effects = Table::new(columns).rows(not_modelled().iter().map(row)).markdown();
    let columns = ["choice", "excludes", "because"].map(Column::text);
    let all = stages().iter().flat_map(|stage| stage.excludes);
    let row = |exclusion: &Exclusion| {
        let both = [exclusion.choice, exclusion.other].map(setting);
        both.map(|words| Cell::from(Text::marked(&words)))
            .into_iter()
            .chain([exclusion.because.into()])
    };
    format!("{PAGE}{effects}{EXCLUSIONS}{}", Table::new(columns).rows(all.map(row)).markdown())
}

/// Values of a key, in words.
fn setting(setting: KeyValues) -> String {
    let any = |values: &[&str]| {
        let values: Vec<String> = values.iter().map(|value| format!("`{value}`")).collect();
        values.join(" or ")
    };
    match setting {
        KeyValues::Is(key, values) => format!("`{key}` = {}", any(values)),
        KeyValues::Not(key, values) => format!("`{key}` other than {}", any(values)),
        KeyValues::Unlike(key, second) => format!("`{key}` other than `{second}`"),
    }
}

const EXCLUSIONS: &str = "
## What excludes what

A machine that has both is refused, with the values that would end it.

";

const PAGE: &str = "\
# What is not modelled

<!-- Written from crates/study/src/findings/limits.rs: change that, then
     UPDATE_EXPECT=1 cargo test report:: -->

Every report of the `cycle` model ends with this list (`summary.md`, `not_modelled` in `--json`). \
*Optimistic*: real frames take longer than simulated ones; *pessimistic*: real frames take less \
time. Where a percentage stands, the chip of [rtl/](../rtl/README.md) took so much longer (+) or \
less (-) than the model of the same machine, on the scenes and machines of \
[chip.md](../evidence/chip.md): an effect of the assembly, of which the one that is named has the \
largest part. The A-numbers are explained in [model-accel.md](model-accel.md), \
[model-resident.md](model-resident.md), [model-gpu.md](model-gpu.md), \
[elsewhere.md](elsewhere.md) and [model.md](model.md). \
Beside it a report names the assumptions that mattered most in that run: those behind the \
resources that move the frame time by 3 % or more when they are doubled (`--what-if`), those whose \
prices move the power by 3 % or more, and those without such a knob behind every part of 15 % or \
more of the energy. For the prices, `replay` prices the counts of the run again with the knob of \
each price assumption that is in use at its low and its high (`arch-configs/assumptions.toml`; the \
prices of a DRAM device are those of assumptions that its file cites), one at a time, and names \
the three that move the power most (`prices` in `--json` has all that move it by 0.5 %). They say \
nothing of one another: two that are wrong the same way add up.

Another question is which accelerators a machine file can describe at all: there are \
three dataflows, tile-wise sort-then-blend, resident pixels and kernels of a GPU, and runs of \
other simulators ([elsewhere.md](elsewhere.md)). [what-fits.md](what-fits.md) says which \
published designs fit them, which do not, and what keys like `record.feature` do not change.

";
