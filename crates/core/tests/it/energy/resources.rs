//! No free lunch: twice of every capacity and rate of a machine costs area, PHY, standing power or
//! energy of an action. Keys that cost nothing on purpose are listed with their reason.

use powergs_base::config::embedded::{ENERGY, MACHINES, find};
use powergs_base::config::{KeyDoc, key_docs, knob};
use powergs_core::machine::Machine;
use powergs_core::sim::cost;
use powergs_core::stage::EnergyTable;
use powergs_core::stage::{hardware, stage_id, work_id};
use powergs_energy::{Prices, same_costs};
use toml::{Table, Value};

/// Keys of which less is better: they are halved.
const LESS_IS_BETTER: [&str; 3] = ["vru.recurrence", "vru.blend-stall", "gradients.sum-cycles"];

/// Keys, or tables of keys, without a price.
const FREE: [(&str, &str); 32] = [
    ("ccu.operations", "the work of a conversion, in somebody's count"),
    ("binning.pointer-size", "bytes in DRAM, and in buffers that have a price"),
    ("binning.line", "bytes that are written together, out of a buffer that has a price"),
    ("binning.block", "a division of DRAM"),
    ("geometry", "decides the work, not what is built; buffers that it needs have a price"),
    ("record", "bytes that are moved: paid for as work"),
    ("fovea.record", "as `record`"),
    ("fovea.feature", "as `record`"),
    ("training", "work of a step: paid for as work"),
    ("gradients.kept", "as `record`"),
    ("levels.gaussians", "a property of the model"),
    ("levels.children", "as `levels.gaussians`"),
    ("levels.record", "as `record`"),
    ("levels.entry", "as `record`"),
    ("levels.period", "a policy"),
    ("levels.operations", "as `ccu.operations`"),
    ("gradients.pixels", "an order of work; what is kept of it has a price"),
    ("ccu.latency", "depth of the published pipeline: what the clock makes of the logic"),
    ("gsu.qsu-latency", "as `ccu.latency`"),
    ("gsu.bsu-latency", "as `ccu.latency`"),
    ("vru.latency", "as `ccu.latency`"),
    ("vru.stop-latency", "as `ccu.latency`: a reduction behind it"),
    ("vru.colour-latency", "as `ccu.latency`"),
    ("gsu.reuse-period", "a policy"),
    ("schedule.merge-below", "a policy"),
    ("gating.residual", "a property of the technology"),
    ("dram.efficiency", "a property of the memory under this access pattern"),
    ("dram.latency", "a property of the memory"),
    ("dram.controller-latency", "a property of the memory's controller"),
    ("dram.second-master", "the traffic of another: it costs the accelerator time"),
    ("dram.third-master", "as `dram.second-master`"),
    ("dram.fourth-master", "as `dram.second-master`"),
];

/// A machine of which everything can be had twice.
const BASE: [&str; 26] = [
    "levels.gaussians=64",
    "clock=500 MHz",
    "cache.capacity=32 KiB",
    "cache.eviction=reuse-distance",
    "vru.blend-stall=2",
    "vru.impl=parallel",
    "vru.pixels-per-unit=16",
    "vru.stop-latency=16",
    "record.colour-extra=2 B",
    "ccu.operations-per-cycle=50",
    "ccu.cull-operations-per-cycle=50",
    "gating.units=true",
    "schedule.merge-below=64",
    "dram.second-master.rate=1 GB/s",
    "dram.third-master.rate=1 GB/s",
    "dram.fourth-master.rate=1 GB/s",
    "dram.second-master.guaranteed=100 MB/s",
    "dram.third-master.guaranteed=100 MB/s",
    "dram.fourth-master.guaranteed=100 MB/s",
    "ccu.fetch=lazy-colour",
    "record.feature-source=nobody",
    "vru.colour-operations-per-cycle=133",
    "codebook.entries=1024",
    "training.interval=2",
    "gradients.sum-cycles=2",
    "training.densify=100",
];

/// With each kind of price of the memory.
const MEMORIES: [[&str; 2]; 2] = [
    ["dram.model=bandwidth", "energy=gscore-28nm"],
    ["dram.model=calibrated", "energy=gscore-28nm"],
];

fn base(memory: [&str; 2]) -> Table {
    let sets: Vec<String> = BASE.iter().chain(&memory).map(|s| (*s).to_owned()).collect();
    let text = find(MACHINES, "gscore").expect("a machine");
    Machine::parse_with(text, &sets).expect("a good machine").to_toml().parse().expect("TOML")
}

fn prices(table: &Table) -> Result<Prices, String> {
    let machine = Machine::parse(&table.to_string()).map_err(|e| e.to_string())?;
    let text = find(ENERGY, &machine.energy).expect("a table");
    let energy = EnergyTable::parse(text).expect("a good table");
    cost::prices(&energy, &machine).map_err(|e| e.to_string())
}

/// What a machine costs, named.
fn costs(p: &Prices) -> Vec<(String, f64)> {
    let [background, refresh] = p.dram.standby_w();
    let mut all = vec![
        ("area".into(), p.area.as_ref().expect("an area").total().0),
        ("PHY standby".into(), p.phy_standby_w),
        ("leakage".into(), p.leakage_w()),
        ("background".into(), background),
        ("refresh".into(), refresh),
    ];
    all.extend(p.per_action.iter().enumerate().map(|(i, &pj)| (format!("action {i}"), pj)));
    all
}

/// The costs that are higher in the second machine.
fn grown(before: &Prices, after: &Prices) -> Vec<String> {
    let pairs = costs(before).into_iter().zip(costs(after));
    let higher = pairs.filter(|((_, a), (_, b))| *b > a * (1.0 + 1e-9));
    higher.map(|((name, _), _)| name).collect()
}

fn is_number(value: &Value) -> bool {
    let text = |t: &str| t.starts_with(|c: char| c.is_ascii_digit()) && t.contains(' ');
    value.is_integer() || value.is_float() || value.as_str().is_some_and(text)
}

fn is_free(path: &str) -> bool {
    FREE.iter().any(|(free, _)| {
        path.strip_prefix(free).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    })
}

/// What twice (or half) of a key costs more of, with any of the memories; `None` for a key without
/// a number.
fn cost_of(doc: &KeyDoc) -> Option<Vec<String>> {
    let mut found = Vec::new();
    for memory in MEMORIES {
        let table = base(memory);
        // Of two ways to say the rate of the memory the machine has one.
        let value = knob::values(&table, &doc.path).pop()?;
        if !is_number(&value) {
            return None;
        }
        let factor = if LESS_IS_BETTER.contains(&doc.path.as_str()) { 0.5 } else { 2.0 };
        let more = knob::scaled(&value, factor)
            .unwrap_or_else(|| panic!("{}: {value} cannot be scaled", doc.path));
        let mut changed = table.clone();
        assert!(knob::set(&mut changed, &doc.path, &more), "{}", doc.path);
        let before = prices(&table).expect("a good machine");
        match prices(&changed) {
            Ok(after) => {
                assert_eq!(same_costs(&before, &after), before == after);
                found.extend(grown(&before, &after));
            }
            // Only what is free may be impossible: a tile of 32 needs other sort groups.
            Err(e) => assert!(is_free(&doc.path), "{}: {e}", doc.path),
        }
    }
    Some(found)
}

#[test]
fn twice_of_every_resource_costs_something() {
    let docs = key_docs::<Machine>();
    let (mut unpriced, mut priced, mut counted) = (Vec::new(), Vec::new(), 0);
    for doc in docs.iter().filter(|d| !d.table) {
        let Some(grown) = cost_of(doc) else { continue };
        counted += 1;
        println!("{}: {}", doc.path, grown.join(", "));
        if is_free(&doc.path) {
            // A key that has a price is no longer on the list of those that have none.
            if !grown.is_empty() {
                priced.push((doc.path.clone(), grown));
            }
        } else if grown.is_empty() {
            unpriced.push(doc.path.clone());
        }
    }
    assert!(unpriced.is_empty(), "these cost nothing: {unpriced:#?}");
    assert!(priced.is_empty(), "these are listed as free: {priced:#?}");
    assert!(counted > 60, "{counted} numbers");
}

/// The presets are the machines that prices are for: dividing them moved nothing.
#[test]
fn gscore_costs_what_was_published() {
    costs_what_was_published("gscore", "gscore-28nm");
    costs_what_was_published("gscore-powergs", "gscore-28nm-nerarch");
}

fn costs_what_was_published(machine: &str, table: &str) {
    let text = find(MACHINES, machine).expect("a machine");
    let machine = Machine::parse(text).expect("a good machine");
    assert_eq!(machine.energy, table);
    let energy = EnergyTable::parse(find(ENERGY, table).expect("it")).expect("good");
    let with = cost::prices(&energy, &machine).expect("prices");
    let mut whole = energy.clone();
    whole.parts = None;
    whole.supply = None;
    let without = cost::prices(&whole, &machine).expect("prices");
    let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} for {b}");
    for ((name, a), (_, b)) in costs(&with).into_iter().zip(costs(&without)) {
        println!("{name}");
        close(a, b);
    }
    let supply = with.supply.expect("a curve");
    assert_eq!((supply.energy, supply.leakage, supply.voltage), (1.0, 1.0, 0.9));
}

/// Sixteen box testers, a network of 256 inputs, and units that take a Gaussian in eight cycles.
#[test]
fn units_grow_with_what_is_in_them() {
    let text = find(MACHINES, "gscore").expect("a machine");
    let energy = EnergyTable::parse(find(ENERGY, "gscore-28nm").expect("it")).expect("good");
    let of = |set: &str| {
        let machine = Machine::parse_with(text, &[set.to_owned()]).expect("a good machine");
        cost::prices(&energy, &machine).expect("prices")
    };
    let unit = |set: &str, i: usize| {
        let (new, old) = (of(set), of("ccu.queue=16"));
        let area = |p: &Prices| p.area.clone().expect("an area").units[i].0;
        let ratio = area(&new) / area(&old);
        let leakage = new.unit_leakage_w[i] / old.unit_leakage_w[i];
        assert!((ratio - leakage).abs() < 1e-12, "{set}: leakage follows area");
        ratio
    };
    let is = |set: &str, i: usize, wanted: f64| {
        let ratio = unit(set, i);
        assert!((ratio - wanted).abs() < 1e-9, "{set}: {ratio}, not {wanted}");
    };
    is("ccu.intersection-units=16", 0, 1.0 + 15.0 * 0.09);
    is("ccu.operations-per-cycle=71", 0, 1.0 - 0.6 * 5.0 / 6.0);
    is("ccu.cull-operations-per-cycle=71", 0, 1.0 + 0.6 / 6.0);
    is("ccu.colour-operations-per-cycle=142", 0, 1.0 + 0.6 / 3.0);
    is("ccu.queue=32", 0, 1.0 + 0.04);
    is("ccu.batch=128", 0, 1.0 + 0.04 / 2.0);
    is("gsu.keys-per-cycle=64", 1, 1.0 + 63.0 * 0.7);
    // 4,608 compare-exchanges for 80.
    is("gsu.bsu-width=256", 2, 1.0 + 0.8 * (4608.0 / 80.0 - 1.0));
    is("gsu.queue=2", 2, 1.0 + 0.051 * 128.0 / 192.0);
    is("vru.speculation=2", 2, 1.0 + 0.051 * 64.0 / 192.0);
    is("vru.pixels-per-unit=32", 3, 1.145);
    is("vru.tile-overlap=true", 3, 1.145);
    is("vru.impl=serial", 3, 1.0 - 0.145 * 0.75 - 0.0317 * 72.0 / 224.0);
    is("vru.subtile-queue=16", 3, 1.0 + 0.0317 * 7.0 * 72.0 / 224.0);
    is("vru.recurrence=1", 3, 1.0 + 3.0 * 0.08);
    is("vru.blend-stall=1", 3, 1.0 - 0.41 / 2.0);
    is("fovea.accumulators=2", 3, 1.555);
    is("fovea.accumulators=0", 3, 1.0);
    // A key is compared with every pivot.
    let key = work_id("pivot-key");
    let ratio = of("gsu.pivots=14").of(key).0 / of("gsu.pivots=7").of(key).0;
    assert!((ratio - 1.9).abs() < 1e-12, "{ratio}");
}

/// The arithmetic of colours takes as much in the cores as it does in CCUs.
#[test]
fn colour_units_are_as_large_as_their_part_of_a_ccu() {
    let text = find(MACHINES, "gscore-powergs").expect("a machine");
    let energy = EnergyTable::parse(find(ENERGY, "gscore-28nm").expect("it")).expect("good");
    let of = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
        let machine = Machine::parse_with(text, &sets).expect("a good machine");
        let peak: f64 = {
            let prices = cost::prices(&energy, &machine).expect("prices");
            cost::peak_w(&machine, &prices).iter().map(|(_, watts)| watts).sum()
        };
        (cost::prices(&energy, &machine).expect("prices"), peak)
    };
    let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} for {b}");
    let (late, late_w) = of(&[]);
    let (early, early_w) = of(&["ccu.fetch=visible-colour", "ccu.operations-per-cycle=426"]);
    let area = |p: &Prices| p.area.clone().expect("an area");
    close(area(&late).total().0, area(&early).total().0);
    close(late.leakage_w(), early.leakage_w());
    // A colour a cycle in four cores is one in four CCUs.
    close(late_w, early_w);
    // 60 % of 205,000 um2 are 426 operations; the four cores have 133 each.
    let wanted = 4.0 * 0.205 * 0.6 * 133.0 / 426.0;
    let place = hardware().units().position(|(id, _)| id == stage_id("colour"));
    let colours = |p: &Prices| area(p).units[place.expect("a unit")].0;
    assert_eq!(colours(&early), 0.0);
    close(colours(&late), wanted);
    let (twice, _) = of(&["vru.colour-operations-per-cycle=266"]);
    close(colours(&twice), 2.0 * wanted);
}

/// Standing powers and the PHY go with the channels, whatever their rate.
#[test]
fn memory_standby_is_in_proportion_to_the_channels() {
    let text = find(MACHINES, "gscore").expect("a machine");
    let energy = EnergyTable::parse(find(ENERGY, "gscore-28nm-flat").expect("it")).expect("good");
    let of = |sets: &[&str]| {
        let sets = ["dram.model=bandwidth"].iter().chain(sets).map(|s| (*s).to_owned());
        let sets: Vec<String> = sets.collect();
        let machine = Machine::parse_with(text, &sets).expect("a good machine");
        cost::prices(&energy, &machine).expect("prices")
    };
    let base = of(&[]);
    assert_eq!(base.dram.standby_w(), [0.0252, 0.0228]);
    let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} for {b}");
    for (sets, times) in [
        (&["dram.channels=1"][..], 0.125),
        (&["dram.channels=16"], 2.0),
        (&["dram.model=calibrated", "dram.channels=16"], 2.0),
        // Channels of LPDDR5 have twice the rate: as fast with half as many.
        (&["dram.device=lpddr5-6400-x16x4", "dram.channels=4"], 0.5),
        (&["dram.device=none", "dram.bandwidth=10 GB/s", "dram.channels=4"], 0.5),
    ] {
        let prices = of(sets);
        let (new, old) = (prices.dram.standby_w(), base.dram.standby_w());
        close(new[0], times * old[0]);
        close(new[1], times * old[1]);
        let area = |p: &Prices| p.area.clone().expect("an area");
        close(area(&prices).phy.0, times * area(&base).phy.0);
        close(area(&prices).controllers.0, times * area(&base).controllers.0);
        close(prices.phy_standby_w, times * base.phy_standby_w);
        close(area(&prices).core().0, area(&base).core().0);
        close(area(&prices).total().0, area(&base).core().0 + times * 8.8);
    }
}
