//! Every key of a device file is alive: changing it changes some number, or the change needs a
//! condition that is written down here.

use powergs_base::config::key_docs;
use powergs_dram::drive::{Access, Drive};
use powergs_dram::{Device, EnergyUse, Mode, Stats};

use super::device;
use super::streams::traffic;

/// Keys that are text for people, or that only say what a burst is made of.
const TEXT: [&str; 5] =
    ["name", "description", "energy.scale-source", "organisation.width", "organisation.beats"];

/// What a key needs to matter, and the value that it is changed to where doubling is not allowed.
const LIFTED: [(&str, &[&str], &str); 20] = [
    ("organisation.rows", &[], "8"),
    ("organisation.burst", &["organisation.beats=32"], "64 B"),
    ("timing.burst", &[], "1"),
    ("organisation.pseudo-channels", &[], "2"),
    ("mapping.order", &[], "mop"),
    ("mapping.interleave", &[], "256 B"),
    ("timing.refresh-bank-to-activate", &["controller.refresh=per-bank"], "900"),
    ("timing.column-short", &["mapping.order=mop"], "4"),
    ("timing.write-to-read-short", &["timing.write-to-read-long=40"], "36"),
    ("timing.activate-short", &["timing.activate-long=12"], "12"),
    ("timing.activate-long", &[], "13"),
    ("timing.activate-to-precharge", &[], "49"),
    ("timing.precharge-to-precharge", &[], "20"),
    ("commands.column-bus", &[], "true"),
    ("split-activate.second-within", &[], "1"),
    ("controller.scheduler", &[], "fcfs"),
    ("controller.page", &[], "closed"),
    ("controller.refresh", &[], "none"),
    ("controller.write-wait", &[], "30 ns"),
    ("controller.latency", &[], "20 ns"),
];

fn outcome(device: &Device, accesses: &[Access]) -> (u64, Stats, EnergyUse) {
    let mut cycles = 0;
    let mut stats = Stats::default();
    let mut used = EnergyUse::default();
    // At full speed, and slow enough to sleep.
    for (mode, n) in [("sat", accesses.len()), ("rate0.05", 60)] {
        let mut drive = Drive::new(device, mode.parse::<Mode>().expect("a mode"));
        accesses[..n].iter().for_each(|a| drive.take(*a));
        let run = drive.finish().0;
        let energy = EnergyUse::new(device, &run.stats, run.cycles);
        cycles += run.cycles;
        used.refresh += energy.refresh;
        used.background += energy.total();
        stats = if mode == "sat" { run.stats } else { stats };
    }
    (cycles, stats, used)
}

/// A value that is not the one of the device.
fn changed(values: &toml::Value, path: &str) -> String {
    let value = path.split('.').fold(values, |at, key| &at[key]);
    match value {
        toml::Value::Integer(0) => "3".to_owned(),
        toml::Value::Integer(n) => (n * 2).to_string(),
        toml::Value::Float(x) => (x * 0.75).to_string(),
        toml::Value::Boolean(b) => (!b).to_string(),
        toml::Value::String(text) => {
            let (number, unit) = text.split_once(' ').expect("a number and a unit");
            let number: f64 = number.parse().expect("a number");
            if number == 0.0 { format!("1 {unit}") } else { format!("{} {unit}", number * 2.0) }
        }
        other => panic!("{path}: {other}"),
    }
}

#[test]
fn every_key_moves_something() {
    let sleepy = ["energy.actions.background.self-refresh-after=2 us"];
    let accesses = traffic(11, 2500, 3);
    let mut dead = Vec::new();
    for doc in key_docs::<Device>().into_iter().filter(|d| !d.table) {
        let path = doc.path.as_str();
        let flat = path.starts_with("energy.flat");
        if TEXT.contains(&path) || path.ends_with(".source") || path.starts_with("mapping.fields") {
            continue;
        }
        // One bank group has no short and long distances: LPDDR5 has four.
        let name = if flat { "lpddr4-3200-x16x8-flat" } else { "lpddr5-6400-x16x2" };
        let lifted = LIFTED.iter().find(|l| l.0 == path);
        let mut sets = if flat { vec![] } else { sleepy.to_vec() };
        sets.extend(lifted.map_or(&[][..], |l| l.1));
        if path == "commands.column-bus" {
            continue;
        }
        let before = device(name, &sets);
        let values: toml::Value = toml::from_str(&before.to_toml()).expect("TOML");
        let value = lifted.map_or_else(|| changed(&values, path), |l| l.2.to_owned());
        let set = format!("{path}={value}");
        let after = device(name, &[&sets[..], &[&set]].concat());
        if outcome(&before, &accesses) == outcome(&after, &accesses) {
            dead.push(set);
        }
    }
    assert!(dead.is_empty(), "nothing moved: {dead:?}");
}

/// A second command bus excludes split activates and a stopping data clock: tried on HBM2.
#[test]
fn the_column_bus_moves_something() {
    let accesses = traffic(11, 2500, 3);
    let [with, without] = ["true", "false"].map(|v| {
        let set = format!("commands.column-bus={v}");
        outcome(&device("hbm2-8ch", &[&set]), &accesses)
    });
    assert_ne!(with.0, without.0);
}

/// `mapping.fields` replaces the named order; it moves what the order moves.
#[test]
fn fields_move_something() {
    let accesses = traffic(11, 2500, 3);
    let [near, far] = [
        "[\"column:1\", \"channel:3\", \"column:5\", \"bank:3\", \"row:15\"]",
        "[\"column:6\", \"channel:3\", \"row:15\", \"bank:3\"]",
    ]
    .map(|fields| {
        let fields = format!("mapping.fields={fields}");
        let sets = ["mapping.order=fields", &fields];
        outcome(&device("lpddr4-3200-x16x8", &sets), &accesses)
    });
    assert_ne!(near.0, far.0);
}
