//! Every key of every DRAM device: small streams through its commands, and what it costs a machine.

use std::collections::BTreeMap;

use powergs_base::config::embedded::{DRAM, Embedded};
use powergs_base::config::{key_docs, knob};
use powergs_core::sim::cost::device_costs;
use powergs_dram::drive::{Access, Drive};
use powergs_dram::{Device, EnergyUse, Mode, Stats};
use powergs_energy::DramCosts;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use toml::{Table, Value};

use super::Verdict;
use super::inert::list;

/// Text for people.
const TEXT: [&str; 4] = ["name", "description", "organisation.width", "organisation.beats"];

/// Runs of bytes here and there, a third of them written.
fn traffic(n: usize) -> Vec<Access> {
    let mut rng = Pcg64Mcg::seed_from_u64(11);
    let mut at = 0;
    let one = |_| {
        if rng.random_bool(0.7) {
            at = rng.random_range(0..1u64 << 24) * 32;
        }
        let bytes: u32 = [16, 32, 64, 200][rng.random_range(0..4)];
        let access = Access { write: rng.random_bool(0.3), address: at, bytes };
        at += u64::from(bytes);
        access
    };
    (0..n).map(one).collect()
}

type Outcome = (u64, Stats, EnergyUse, EnergyUse, DramCosts);

/// At full speed, and so slow that the channels sleep.
fn outcome(device: &Device, accesses: &[Access]) -> Outcome {
    let run = |mode: &str, n: usize| {
        let mut drive = Drive::new(device, mode.parse::<Mode>().expect("a mode"));
        accesses[..n].iter().for_each(|a| drive.take(*a));
        let run = drive.finish().0;
        let energy = EnergyUse::new(device, &run.stats, run.cycles);
        (run.cycles, run.stats, energy)
    };
    let (cycles, stats, energy) = run("sat", accesses.len());
    let slow = run("rate0.02", 40);
    (cycles + slow.0, stats, energy, slow.2, device_costs(device))
}

fn leaves(table: &Table, prefix: &str, found: &mut Vec<String>) {
    for (key, value) in table {
        let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            Value::Table(inner) => leaves(inner, &path, found),
            _ => found.push(path),
        }
    }
}

fn dead_keys(file: &Embedded, accesses: &[Access]) -> Vec<String> {
    let text: Table = file.complete().parse().expect("TOML");
    let (docs, list) = (key_docs::<Device>(), list());
    let mut keys = Vec::new();
    leaves(&text, "", &mut keys);
    let of = |lift: &[String]| {
        let device = Device::parse_with(file.text, lift)
            .unwrap_or_else(|e| panic!("{} {lift:?}: {e}", file.name));
        let values: Table = device.to_toml().parse().expect("TOML");
        (outcome(&device, accesses), values)
    };
    let is_dead = |key: &str, (base, values): &(Outcome, Table)| {
        let value = knob::values(values, key).swap_remove(0);
        let unit = docs.iter().find(|d| d.path == key).map_or("", |d| &d.unit);
        let names = knob::choices(unit);
        let is_source = key.ends_with("source");
        let tried = if is_source { vec!["nobody".into()] } else { knob::others(&value, &names) };
        assert!(!tried.is_empty(), "{}: {key}: nothing to try", file.name);
        let mut verdicts = Vec::new();
        for new in &tried {
            let mut table = values.clone();
            knob::change(&mut table, key, &mut |_| Some(new.clone()));
            verdicts.push(match Device::parse(&table.to_string()) {
                Ok(device) => Verdict::of(outcome(&device, accesses) != *base),
                Err(e) => Verdict::of_error(&e.to_string(), key, new),
            });
            if names.is_empty() && verdicts.contains(&Verdict::Moved) {
                return false;
            }
        }
        !Verdict::is_alive(&verdicts, !names.is_empty())
    };
    let base = of(&[]);
    let dead = |key: &&String| {
        let inert = list.get("dram").and_then(|l| l.get(*key));
        !TEXT.contains(&key.as_str())
            && is_dead(key, &base)
            && inert.is_none_or(|inert| is_dead(key, &of(&inert.lift)))
    };
    keys.par_iter().filter(dead).map(|key| format!("{}: {key}", file.name)).collect()
}

/// Devices that differ in the number of channels only have the same keys with the same values: one
/// of them stands for all.
#[test]
fn every_key_of_every_device_moves_something() {
    let mut families: BTreeMap<String, &Embedded> = BTreeMap::new();
    for file in DRAM {
        let mut table: Table = file.complete().parse().expect("TOML");
        for key in ["name", "description", "organisation.channels"] {
            knob::change(&mut table, key, &mut |_| Some(Value::Integer(0)));
        }
        families.entry(table.to_string()).or_insert(file);
    }
    assert!((4..DRAM.len()).contains(&families.len()), "{}", families.len());
    let accesses = traffic(900);
    let dead: Vec<String> = families.values().flat_map(|f| dead_keys(f, &accesses)).collect();
    assert!(dead.is_empty(), "nothing moved: {dead:#?}");
}
