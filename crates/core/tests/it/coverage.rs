//! What the oracles cover, as `docs/model-accel.md` shows it: for each dataflow and each of its
//! choices, in how many of their random machines it was on, and what checks it where none was.

use std::collections::{BTreeMap, BTreeSet};

use expect_test::expect_file;
use powergs_core::flow::FLOWS;
use powergs_core::flow::gpu::GradientSum;
use powergs_core::machine::Machine;
use rayon::prelude::*;
use serde_json::Value;

use crate::pipeline::{Case, modes};
use crate::{gpu, pipeline, resident};

/// A choice of a dataflow: its key or what it is, and its values.
struct Row {
    flow: &'static str,
    choice: &'static str,
    values: &'static [&'static str],
    /// What checks a value that no machine of an oracle has.
    otherwise: &'static [(&'static str, &'static str)],
}

const fn row(
    flow: &'static str,
    choice: &'static str,
    values: &'static [&'static str],
    otherwise: &'static [(&'static str, &'static str)],
) -> Row {
    Row { flow, choice, values, otherwise }
}

const TILE: &str = "tile-wise";
const RESIDENT: &str = "resident";
const GPU: &str = "gpu";
const MODELS: &[&str] = &["bandwidth", "banked", "calibrated"];
const ON: &[&str] = &["on"];

const ROWS: &[Row] = &[
    row(
        TILE,
        "vru.impl",
        &["serial", "swap", "scan", "parallel", "leaders", "rows", "quads", "pixels", "box"],
        &[],
    ),
    row(TILE, "vru.termination", &["pixel", "quad", "subtile", "tile", "none"], &[]),
    row(TILE, "gsu.impl", &["split", "merge", "update", "last", "shared", "none"], &[]),
    row(TILE, "binning.impl", &["free", "append", "two-pass"], &[]),
    row(TILE, "ccu.fetch", &["everything", "geometry-first", "visible-colour", "lazy-colour"], &[]),
    row(TILE, "record.feature-source", &["nobody", "ccu"], &[("ccu", "laws of bytes")]),
    row(TILE, "geometry.sort-group above geometry.tile", ON, &[]),
    row(TILE, "schedule.assignment", &["static", "greedy", "longest-first"], &[]),
    row(TILE, "schedule.overlap", &["none", "tiles", "frames"], &[]),
    row(TILE, "stereo.impl", &["separate", "shared", "derived"], &[]),
    row(TILE, "pixels.impl", &["all", "warped", "cached", "sampled"], &[]),
    row(TILE, "training.interval above 0, gradients.behind", &["false", "true"], &[]),
    row(TILE, "cache", ON, &[]),
    row(TILE, "codebook", ON, &[]),
    row(TILE, "ccu.clusters", ON, &[]),
    row(TILE, "levels", ON, &[]),
    row(TILE, "foveated frames", ON, &[]),
    row(TILE, "rules of one's own", ON, &[("on", "the built-in rules by that way, and laws")]),
    row(TILE, "dram.model", MODELS, &[]),
    row(TILE, "dram.second-master", ON, &[]),
    row(TILE, "dram.second-master.priority", &["first", "equal", "last"], &[]),
    row(TILE, "dram.fourth-master", ON, &[]),
    row(RESIDENT, "region.cut", &["box", "rows", "exact"], &[]),
    row(RESIDENT, "region.slices above 1", ON, &[]),
    row(RESIDENT, "compose.through, with slices", &["dram", "stores"], &[]),
    row(RESIDENT, "tail", ON, &[]),
    row(RESIDENT, "front.lazy", &["false", "true"], &[]),
    row(RESIDENT, "front.overlap", &["none", "frames"], &[]),
    row(RESIDENT, "raster.saturation", &["false", "true"], &[]),
    row(RESIDENT, "pixels.impl", &["all", "warped"], &[]),
    row(RESIDENT, "levels", ON, &[]),
    row(RESIDENT, "training.interval above 0", ON, &[("on", "a twin of bytes and bounds")]),
    row(RESIDENT, "dram.model", MODELS, &[]),
    row(RESIDENT, "dram.second-master", ON, &[]),
    row(GPU, "pairs.test", &["aabb", "obb", "ellipse"], &[]),
    row(GPU, "attached.impl", &["none", "rows", "pixels", "box", "tile"], &[]),
    row(GPU, "attached.overlap, with a unit", &["none", "frames"], &[]),
    row(GPU, "rops.impl", &["none", "boxes"], &[]),
    row(GPU, "pixels.impl", &["all", "warped", "sampled"], &[]),
    row(GPU, "training.sum", &["none", "pixel", "warp", "block"], &[]),
    row(GPU, "training.update, with training", &["all", "visible", "none", "pose"], &[]),
    row(GPU, "dram.model", MODELS, &[("calibrated", "laws")]),
    row(GPU, "dram.second-master", ON, &[]),
    row("recorded", "runs of other simulators", ON, &[("on", "laws: nothing is simulated")]),
];

/// A choice of a machine: the place of its row, and its value.
type Chosen = (&'static str, String);

/// The word for it in a machine file.
fn word(value: impl serde::Serialize) -> String {
    let value = serde_json::to_value(value).expect("a value of a machine file");
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

fn memory(machine: &Machine) -> Vec<Chosen> {
    let has_master = machine.dram.second_master.is_on();
    let master = has_master.then(|| ("dram.second-master", "on".to_owned()));
    [("dram.model", word(machine.dram.model))].into_iter().chain(master).collect()
}

fn on(choices: &[(&'static str, bool)]) -> Vec<Chosen> {
    let on = choices.iter().filter(|(_, is_on)| *is_on);
    on.map(|(choice, _)| (*choice, "on".to_owned())).collect()
}

fn tile_wise(machine: &Machine) -> Vec<Chosen> {
    let m = machine.tiles();
    let mut chosen = vec![
        ("vru.impl", word(m.vru.implementation)),
        ("vru.termination", word(m.vru.termination)),
        ("gsu.impl", word(m.gsu.implementation)),
        ("binning.impl", word(m.binning.implementation)),
        ("ccu.fetch", word(m.ccu.fetch)),
        ("record.feature-source", word(m.record.feature_source)),
        ("schedule.assignment", word(m.schedule.assignment)),
        ("schedule.overlap", word(m.schedule.overlap)),
        ("stereo.impl", word(m.stereo.implementation)),
        ("pixels.impl", word(m.pixels.source)),
    ];
    if machine.dram.second_master.is_on() {
        chosen.push(("dram.second-master.priority", word(machine.dram.second_master.priority)));
    }
    if m.training.interval > 0 {
        let key = "training.interval above 0, gradients.behind";
        chosen.push((key, m.gradients.behind.to_string()));
    }
    chosen.extend(on(&[
        ("geometry.sort-group above geometry.tile", m.geometry.sort_group > m.geometry.tile),
        ("cache", m.cache.is_there()),
        ("codebook", m.codebook.entries > 0),
        ("ccu.clusters", m.ccu.clusters > 0),
        ("levels", m.levels.is_there()),
        ("dram.fourth-master", machine.dram.fourth_master.is_on()),
    ]));
    chosen.extend(memory(machine));
    chosen
}

/// A machine of the oracle that makes up its frames: some of what it does is in the frame.
fn made_up(seed: u64) -> Vec<Chosen> {
    let case = Case::new(seed, |_| ());
    let mut chosen = tile_wise(&case.machine);
    if case.reuse.is_some() {
        chosen.retain(|(choice, _)| *choice != "gsu.impl");
        chosen.push(("gsu.impl", "update".to_owned()));
    }
    let is_foveated = case.workload.fovea.is_some();
    chosen.extend(on(&[("cache", case.hits.is_some()), ("foveated frames", is_foveated)]));
    chosen
}

fn of_resident(machine: &Machine) -> Vec<Chosen> {
    let m = machine.resident();
    let mut chosen = vec![
        ("region.cut", word(m.region.cut)),
        ("front.lazy", m.front.lazy.to_string()),
        ("front.overlap", word(m.front.overlap)),
        ("raster.saturation", m.raster.saturation.to_string()),
        ("pixels.impl", word(m.pixels.source)),
    ];
    if m.region.slices > 1 {
        chosen.push(("compose.through, with slices", word(m.compose.through)));
    }
    chosen.extend(on(&[
        ("region.slices above 1", m.region.slices > 1),
        ("tail", m.tail.share > 0.0),
        ("levels", m.levels.is_there()),
        ("training.interval above 0", m.training.interval > 0),
    ]));
    chosen.extend(memory(machine));
    chosen
}

fn of_gpu(machine: &Machine) -> Vec<Chosen> {
    let m = machine.gpu();
    let mut chosen = vec![
        ("pairs.test", word(m.pairs.test)),
        ("attached.impl", word(m.attached.implementation)),
        ("rops.impl", word(m.rops.implementation)),
        ("pixels.impl", word(m.pixels.source)),
        ("training.sum", word(m.training.sum)),
    ];
    if m.attached.is_there() {
        chosen.push(("attached.overlap, with a unit", word(m.attached.overlap)));
    }
    if m.training.sum != GradientSum::None {
        chosen.push(("training.update, with training", word(m.training.update)));
    }
    chosen.extend(memory(machine));
    chosen
}

/// How often each choice was made, by dataflow, and how many machines there were.
#[derive(Default)]
struct Counts {
    all: BTreeMap<&'static str, usize>,
    chosen: BTreeMap<(&'static str, &'static str, String), usize>,
}

impl Counts {
    fn add(&mut self, flow: &'static str, machines: Vec<Vec<Chosen>>) {
        *self.all.entry(flow).or_default() += machines.len();
        for (choice, value) in machines.into_iter().flatten() {
            *self.chosen.entry((flow, choice, value)).or_default() += 1;
        }
    }

    fn of(&self, row: &Row, value: &str) -> usize {
        let key = (row.flow, row.choice, value.to_owned());
        self.chosen.get(&key).copied().unwrap_or(0)
    }
}

fn counted() -> Counts {
    let mut counts = Counts::default();
    let all = |n: u64| (0..n).into_par_iter();
    counts.add(TILE, all(pipeline::CASES[0]).map(made_up).collect());
    let real = all(modes::CASES[0]).map(|seed| tile_wise(&modes::machine(seed)));
    counts.add(TILE, real.collect());
    let stepped = all(resident::CASES[0]).filter_map(resident::stepped_machine);
    counts.add(RESIDENT, stepped.map(|machine| of_resident(&machine)).collect());
    let drawn = all(gpu::frame::CASES[0]).filter_map(gpu::frame::machine);
    counts.add(GPU, drawn.map(|machine| of_gpu(&machine)).collect());
    counts
}

fn table(counts: &Counts) -> String {
    let mut text = String::from("| dataflow | choice | random machines | not by an oracle |\n");
    text += "|---|---|---|---|\n";
    for row in ROWS {
        let name = |value: &str| if value == "on" { String::new() } else { format!("`{value}` ") };
        let seen = row.values.iter().filter(|value| counts.of(row, value) > 0);
        let seen: Vec<String> =
            seen.map(|value| format!("{}{}", name(value), counts.of(row, value))).collect();
        let unseen = row.values.iter().filter(|value| counts.of(row, value) == 0);
        let otherwise = |value: &&str| {
            let found = row.otherwise.iter().find(|(own, _)| own == value);
            let what = found.map_or("nothing", |(_, what)| what);
            match name(value).trim() {
                "" => what.to_owned(),
                name => format!("{name}: {what}"),
            }
        };
        let unseen: Vec<String> = unseen.map(otherwise).collect();
        let key = match row.choice.contains(' ') {
            true => row.choice.to_owned(),
            false => format!("`{}`", row.choice),
        };
        let (seen, unseen) = (seen.join(", "), unseen.join(", "));
        text += &format!("| {} | {key} | {seen} | {unseen} |\n", row.flow);
    }
    let all: Vec<String> = counts.all.iter().map(|(flow, n)| format!("{n} of `{flow}`")).collect();
    format!("Random machines: {}.\n\n{text}", all.join(", "))
}

const BEGINS: &str =
    "<!-- covered: written by crates/core/tests/it/coverage.rs, UPDATE_EXPECT=1 -->\n";
const ENDS: &str = "<!-- covered -->\n";

#[test]
fn the_page_says_what_the_oracles_cover() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/model-accel.md");
    let page = std::fs::read_to_string(path).expect("the page");
    let (before, rest) = page.split_once(BEGINS).expect("where the table begins");
    let (_, after) = rest.split_once(ENDS).expect("where it ends");
    let counts = counted();
    let page = format!("{before}{BEGINS}{}{ENDS}{after}", table(&counts));
    expect_file![path].assert_eq(&page);
    // Whatever a machine has is in a row.
    let rows: BTreeSet<(&str, &str, &str)> = ROWS
        .iter()
        .flat_map(|row| row.values.iter().map(|value| (row.flow, row.choice, *value)))
        .collect();
    for (flow, choice, value) in counts.chosen.keys() {
        assert!(rows.contains(&(*flow, *choice, value.as_str())), "{flow} {choice} {value}");
    }
}

/// The values that a key may have in a machine file; none where it is no choice.
fn values_in(schema: &Value, key: &str) -> Vec<String> {
    let resolve = |mut at: Value| {
        while let Some(name) = at["$ref"].as_str() {
            at = schema.pointer(name.trim_start_matches('#')).cloned().unwrap_or_default();
        }
        at
    };
    let step = |at: Value, part: &str| resolve(at["properties"][part].clone());
    let found = key.split('.').fold(schema.clone(), step);
    let of = |one: &Value| match one["enum"].as_array() {
        Some(all) => all.clone(),
        None => vec![one["const"].clone()],
    };
    let all: Vec<Value> = match found["oneOf"].as_array() {
        Some(each) => each.iter().flat_map(of).collect(),
        None => of(&found),
    };
    all.iter().filter_map(Value::as_str).map(str::to_owned).collect()
}

#[test]
fn every_value_of_a_choice_is_in_its_row() {
    let mut compared = 0;
    for row in ROWS {
        let flow = FLOWS.iter().map(|decl| decl.flow).find(|flow| flow.key() == row.flow);
        let schema = (flow.expect("a dataflow").tables().schema)();
        let found = values_in(&schema, row.choice);
        if !found.is_empty() {
            let found: BTreeSet<&str> = found.iter().map(String::as_str).collect();
            assert_eq!(found, row.values.iter().copied().collect(), "{}", row.choice);
            compared += 1;
        }
    }
    assert!(compared > 12, "{compared} choices");
}
