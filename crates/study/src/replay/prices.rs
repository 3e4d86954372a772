//! A run priced again: the knobs of the price assumptions that its machine rests on.

use std::collections::BTreeSet;

use powergs_base::config::assumptions::{Knob, KnobFile, Turn, assumptions};
use powergs_base::config::knob;
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{FileKind, System};
use powergs_core::sim::FrameReport;
use powergs_core::sim::statistics::{Aggregate, Value, Weight};
use powergs_energy::Prices;
use toml::Table;

use crate::findings::prices::{PriceBar, PriceBars};

/// What the price assumptions at work in `system` do to the power of its frames on a display at
/// `fps`; `None` without frames that count actions.
pub(super) fn bars(system: &System, frames: &[FrameReport], fps: f64) -> Option<PriceBars> {
    let power = |prices: &Prices| {
        let watts = |f: &FrameReport| f.power_with_w(prices, fps).map(Value::Real);
        let weighted = frames.iter().map(|f| (watts(f), Weight::Displayed.of(f, fps)));
        Aggregate::weighted(weighted).map(|a| a.mean).filter(|watts| watts.is_finite())
    };
    let power_w = power(system.prices())?;
    let cited = cited(system);
    let prices = system.table(FileKind::Energy).unwrap_or_default();
    let mut bars = Vec::new();
    for (number, assumption) in assumptions() {
        let assumption_name = format!("A{number}");
        for knob in &assumption.knobs {
            let is_cited = cited.contains(&assumption_name);
            let sources = sources(&prices, knob);
            let is_assumption =
                |source: &&str| source.strip_prefix('A').is_some_and(|n| n.parse::<u16>().is_ok());
            // Other assumptions are behind all of these prices.
            let is_named = sources.contains(assumption_name.as_str());
            let is_of_others =
                !sources.is_empty() && sources.iter().all(is_assumption) && !is_named;
            if !is_at_work(system, knob, is_cited, [is_named, is_of_others]) {
                continue;
            }
            let Some(sides) = knob.turns() else { continue };
            let at = |turn: &Turn| power(turned(system, knob, turn)?.prices());
            let watts = sides.iter().filter_map(at).chain([power_w]);
            let ends = watts.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], watts| {
                [low.min(watts), high.max(watts)]
            });
            let [low_w, high_w] = ends;
            let (assumption, keys) = (assumption_name.clone(), knob.keys.clone());
            bars.push(PriceBar { assumption, keys, low_w, high_w });
        }
    }
    Some(PriceBars::new(power_w, bars))
}

/// Whether a knob is of prices that the machine has. What it moves there, turning it tells; but a
/// price of the memory is only that of the assumption which its device cites, and a number of a
/// technology is none of another.
fn is_at_work(
    system: &System,
    knob: &Knob,
    is_cited: bool,
    [is_named, is_of_others]: [bool; 2],
) -> bool {
    let is_of_a_device = knob.with.iter().any(|set| set.starts_with("dram.device="))
        || knob.keys.iter().any(|key| key == "energy.scale");
    let node = system.energy_table().node.map(|node| node.0);
    let is_of_its_node = knob.node.is_none_or(|nm| node == Some(f64::from(nm)));
    match knob.file {
        KnobFile::Machine => false,
        // What is about another machine is about all whose prices name it.
        KnobFile::Energy => (knob.on.is_none() || is_named) && is_of_its_node && !is_of_others,
        KnobFile::Dram => knob.on.is_none() && (is_cited || !is_of_a_device),
    }
}

/// The sources beside the prices that a knob turns: `actions.alpha.source` beside
/// `actions.*.energy`.
fn sources<'a>(prices: &'a Table, knob: &Knob) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    for key in &knob.keys {
        let mut at: Vec<&toml::Value> = Vec::new();
        let mut parts: Vec<&str> = key.split('.').collect();
        parts.pop();
        for (i, part) in parts.iter().enumerate() {
            let inside = |table: &'a Table| -> Vec<&'a toml::Value> {
                match *part {
                    "*" => table.values().collect(),
                    name => table.get(name).into_iter().collect(),
                }
            };
            at = match i {
                0 => inside(prices),
                _ => at.into_iter().filter_map(toml::Value::as_table).flat_map(inside).collect(),
            };
        }
        let source = |value: &&'a toml::Value| value.get("source")?.as_str();
        found.extend(at.iter().filter_map(source));
    }
    found
}

/// The assumptions that the prices of the DRAM device cite.
fn cited(system: &System) -> BTreeSet<String> {
    fn add(value: &toml::Value, found: &mut BTreeSet<String>) {
        match value {
            toml::Value::String(text) => {
                found.insert(text.clone());
            }
            toml::Value::Table(table) => table.values().for_each(|value| add(value, found)),
            _ => {}
        }
    }
    let mut found = BTreeSet::new();
    let table = system.table(FileKind::Dram).unwrap_or_default();
    table.get("energy").iter().for_each(|prices| add(prices, &mut found));
    found
}

/// The system with a knob turned; `None` where it does not have the keys, or is none then.
fn turned(system: &System, knob: &Knob, turn: &Turn) -> Option<System> {
    let mut table: Table = system.table(knob.file.into())?;
    let mut to = |value: &toml::Value| match turn {
        Turn::Set(text) => Some(knob::written(text)),
        Turn::Times(factor) => knob::scaled(value, *factor),
    };
    let changed: usize = knob.keys.iter().map(|key| knob::change(&mut table, key, &mut to)).sum();
    let system = || system.with_table(knob.file.into(), &table, &EmbeddedFiles).ok();
    (changed > 0).then(system).flatten()
}
