//! The example of a dataflow: its laws, and everything that is read off the declaration of its
//! stage.

use std::path::Path;

use powergs_sim::config::embedded::{ENERGY, find};
use powergs_sim::config::{key_docs, schema_of};
use powergs_sim::flow::FrameTask;
use powergs_sim::kernel::Memo;
use powergs_sim::kernel::timeline::{Observer, Timeline};
use powergs_sim::machine::Machine;
use powergs_sim::run::{Frames, System, SystemSpec, TraceFile, files::DiskFiles};
use powergs_sim::sim::contract::{Trial, broken};
use powergs_sim::sim::statistics;
use powergs_sim::stage::{EnergyTable, doubles, hardware, omissions};
use powergs_sim::trace::Frame;

use crate::registered;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/own_flow");

fn frames() -> Vec<Frame> {
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
    let mut trace = TraceFile::open(Path::new(demo)).expect("a trace");
    let one = |n| trace.take(n).expect("a frame").get().expect("a frame");
    (0..2).map(one).map(|frame| (*frame).clone()).collect()
}

#[test]
fn it_keeps_the_laws() {
    registered();
    let text = std::fs::read_to_string(format!("{FOLDER}/unsorted.toml")).expect("the machine");
    let prices = std::fs::read_to_string(format!("{FOLDER}/prices.toml")).expect("its prices");
    let trial = Trial {
        machine: &text,
        files: &[("prices.toml", prices.as_bytes())],
        variants: &[
            &[],
            &["blender.units=3", "dram.model=bandwidth"],
            &["blender.tile=64", "dram.model=calibrated"],
        ],
        frames: &frames(),
        settled: &[],
        slack: 0.05,
        idle_keys: &[],
    };
    assert_eq!(broken(&trial), Vec::<String>::new());
}

/// One file says what the stage is; all of this follows.
#[test]
fn everything_about_a_stage_follows_from_its_declaration() {
    registered();
    let path = format!("{FOLDER}/unsorted.toml");
    let system = System::load(&SystemSpec::named(&path), &DiskFiles).expect("a machine");
    // Statistics, and with them CSV, JSON, tables of sweeps, Python and `explain`.
    for name in [
        "units.blender.busy_cycles",
        "units.blender.stall_features_cycles",
        "actions.divide",
        "area_mm2.blender",
        "buffers.blender_in.peak_bytes",
    ] {
        let statistic = statistics::find(name).unwrap_or_else(|| panic!("no {name}"));
        assert_eq!(statistic.flows, ["unsorted"], "{name}");
    }
    // Keys of energy tables, and a table that does not have them.
    let keys: Vec<String> = key_docs::<EnergyTable>().into_iter().map(|doc| doc.path).collect();
    for key in ["actions.divide", "leakage.blender", "area.blender", "clock.blender"] {
        assert!(keys.iter().any(|known| known == key), "{key}");
    }
    let gscore = EnergyTable::parse(find(ENERGY, "gscore-28nm").expect("a table")).expect("whole");
    let lacks = powergs_sim::sim::cost::prices(&gscore, system.machine()).expect_err("no price");
    assert!(lacks.to_string().contains("blending units"), "{lacks}");
    // Area, peak power, what-if, limits.
    let prices = system.prices();
    let blender = hardware().stage_called("blender").expect("a stage");
    let unit = hardware().units().position(|(id, _)| id == blender).expect("units");
    assert!(prices.area.as_ref().expect("it has areas").units[unit].0 > 0.0);
    let peak = powergs_sim::sim::cost::peak_w(system.machine(), prices);
    assert!(peak.iter().any(|(name, watts)| *name == "blender" && *watts > 0.0), "{peak:?}");
    assert!(doubles(system.machine()).any(|double| double.name == "blender.lanes"));
    assert!(omissions().any(|omit| omit.what == "conversion by the host"));
    // The schema of machine files, and the values of their keys.
    let schema = schema_of::<Machine>();
    let table = &schema["properties"]["blender"]["properties"];
    assert!(table["lanes"]["description"].is_string(), "{table}");
    let flows = &schema["properties"]["dataflow"]["enum"];
    assert!(flows.as_array().expect("names").iter().any(|name| name == "unsorted"), "{flows}");
    // Timelines.
    let (machine, memo) = (system.machine(), Memo::default());
    let work = machine.flow().work_key(machine).prepare(&frames()[0]);
    let mut timeline = Timeline::default();
    let observer: &mut dyn Observer = &mut timeline;
    let task = FrameTask::first(machine, &*work, &memo);
    machine.flow().run(&task, Some(observer)).expect("it fits");
    assert!(timeline.draw().lines().any(|line| line.starts_with("blender")));
}
