//! Machine files: the embedded ones, overlays, contradictions, the wording of errors.

use std::collections::BTreeMap;

use expect_test::expect_file;
use powergs_base::config::embedded::{MACHINES, find};
use powergs_base::config::layer::base_of;
use powergs_base::config::schema::leaves;
use powergs_base::config::{KeyDoc, key_docs, key_docs_of, knob, schema_of};
use powergs_base::quantity::{Bytes, BytesPerSecond, Hertz};
use powergs_core::flow::tile_wise::Fetch;
use powergs_core::flow::{self, Dataflow};
use powergs_core::machine::{KeyValues, Machine, Optional};
use serde_json::Value;

use super::{gscore, sets};

#[test]
fn gscore_is_as_published() {
    let machine = Machine::parse(gscore()).expect("gscore");
    assert_eq!(machine.clock, Hertz(1e9));
    let units = machine.inventory().units;
    assert_eq!(units[..4], [4, 8, 4, 64], "CCU, QSU, BSU, VRC as in NeRArch-Sim");
    assert_eq!((machine.dram.bandwidth, machine.dram_peak()), (None, BytesPerSecond(51.2e9)));
    let sum: u64 = machine.tiles().buffers.all().iter().map(|b| b.capacity.0).sum();
    assert_eq!(sum, 248 * 1024, "the buffers that NeRArch-Sim names");
    let r = &machine.tiles().record;
    assert_eq!(
        (r.position.0, r.geometry.0, r.projected.0, machine.tiles().list_entry()),
        (6, 16, 18, 6)
    );
    assert_eq!((r.feature.0, r.colour.0, r.pixel.0), (18, 96, 3), "59 numbers in FP16");
}

#[test]
fn embedded_machines_are_named_as_their_files_and_survive_a_round_trip() {
    for file in MACHINES {
        let machine = Machine::parse(file.text).unwrap_or_else(|e| panic!("{}: {e}", file.name));
        assert_eq!(machine.name, file.name);
        // Keys that have no effect are left out, and may be others.
        let again = Machine::parse(&machine.to_toml()).expect("what was printed");
        assert_eq!(again.to_toml(), machine.to_toml(), "{}", file.name);
    }
}

#[test]
fn banks_are_the_shares_of_units_and_cores() {
    let inventory = Machine::parse(gscore()).expect("gscore").inventory();
    let kib: Vec<(u64, u32)> =
        inventory.memories.iter().map(|m| (m.bank.0 / 1024, m.banks)).collect();
    let (kib, others) = kib.split_at(13);
    assert!(others.iter().all(|other| *other == (0, 0)), "of other dataflows: {others:?}");
    let none = (0, 0);
    let all = [
        (1, 8),
        (4, 8),
        (2, 32),
        (16, 8),
        (1, 16),
        none,
        none,
        none,
        none,
        none,
        (2, 8),
        (1, 8),
        none,
    ];
    assert_eq!(kib, all);
}

#[test]
fn overlays_change_one_key_and_the_last_one_wins() {
    let overlays = sets(&[
        "vru.cores=2",
        "vru.cores = 8",
        "clock=800MHz",
        "ccu.fetch=everything",
        "vru.subtile-skipping=false",
        "buffers.feature.capacity=\"256 KiB\"",
        "buffers.sorting.capacity=128 KiB",
        "dram.efficiency=0.5",
        "energy=paper",
    ]);
    let machine = Machine::parse_with(gscore(), &overlays).expect("a good overlay");
    let mut expected = Machine::parse(gscore()).expect("gscore");
    expected.tiles_mut().vru.cores = 8;
    expected.clock = Hertz(8e8);
    expected.tiles_mut().ccu.fetch = Fetch::Everything;
    expected.tiles_mut().vru.subtile_skipping = false;
    expected.tiles_mut().buffers.feature.capacity = Bytes(256 << 10);
    expected.tiles_mut().buffers.sorting.capacity = Bytes(128 << 10);
    expected.dram.efficiency = 0.5;
    expected.energy = "paper".into();
    assert_eq!(machine, expected);
    assert_eq!(Machine::parse(&machine.to_toml()), Ok(machine));
}

#[test]
fn an_overlay_can_mend_what_is_wrong_in_the_file() {
    let broken = gscore().replace("clock = \"1 GHz\"", "clock = 1");
    assert!(Machine::parse(&broken).is_err());
    assert!(Machine::parse_with(&broken, &sets(&["clock=1GHz"])).is_ok());
    let missing = gscore().replace("clock = \"1 GHz\"", "");
    assert!(Machine::parse_with(&missing, &sets(&["clock=1GHz"])).is_ok());
}

#[track_caller]
fn contradicts(overlays: &[&str], key: &str, because: &str) {
    let error = Machine::parse_with(gscore(), &sets(overlays)).expect_err("a contradiction");
    let found = error.problems.iter().find(|p| p.key == key && p.message.contains(because));
    assert!(found.is_some(), "{overlays:?}: {error}");
}

#[test]
fn contradictions_are_refused_with_the_reason() {
    contradicts(&["geometry.tile=24"], "geometry.tile", "a power of two: 16 or 32");
    contradicts(&["geometry.subtile=12"], "geometry.subtile", "a power of two: 8 or 16");
    contradicts(&["geometry.subtile=32"], "geometry.subtile", "does not divide");
    contradicts(&["geometry.tile=32"], "geometry.sort-group", "`geometry.tile` = 32");
    contradicts(&["geometry.sort-group=48"], "geometry.sort-group", "a power of two");
    contradicts(&["geometry.sort-group=8"], "geometry.sort-group", "above it");
    contradicts(&["gsu.bsu-width=12"], "gsu.bsu-width", "a power of two: 8 or 16");
    contradicts(&["clock=1 Hz"], "clock", "from 10 kHz to 100 GHz");
    contradicts(&["dram.bandwidth=1 kB/s"], "dram.bandwidth", "from 1 MB/s");
    contradicts(&["dram.latency=1e9 ns"], "dram.latency", "at most 1000000 ns");
    contradicts(&["dram.efficiency=1e-9"], "dram.efficiency", "at least 0.001");
    contradicts(&["record.feature-pitch=1 B"], "record.feature-pitch", "at least `record.feature`");
    contradicts(&["record.colour-pitch=1 GiB"], "record.colour-pitch", "a typing error?");
    contradicts(&["buffers.sorting.word=0 B"], "buffers.sorting.word", "from 1 B to the capacity");
    let word = "buffers.feature.word=1000000 GiB";
    contradicts(&[word], "buffers.feature.word", "from 1 B to the capacity");
    contradicts(&["cache.capacity=1000000 GiB"], "cache.capacity", "a typing error?");
    let cache = ["cache.ways=4", "cache.capacity=32 KiB", "cache.word=0 B"];
    contradicts(&cache, "cache.word", "from 1 B to the capacity");
    contradicts(&["ccu.fetch=lazy-colour"], "record.feature-source", "`ccu.fetch`");
    let nobody = ["ccu.fetch=lazy-colour", "record.feature-source=nobody"];
    contradicts(&nobody, "vru.colour-operations-per-cycle", "contradicts `ccu.fetch`");
    contradicts(&["record.feature=19 B"], "record.feature-source", "`record.projected` = 18 B");
    contradicts(&["record.feature=0 B"], "record.feature", "at least 1 B");
    contradicts(&["record.pixel=1 MiB"], "record.pixel", "a typing error?");
    contradicts(&["buffers.sorting.capacity=0 B"], "buffers.sorting.capacity", "above zero");
    contradicts(&["buffers.sorting.capacity=2 GiB"], "buffers.sorting.capacity", "typing error");
    contradicts(&["name=../x"], "name", "file names");
    contradicts(&["energy="], "energy", "must name an energy table");
    let feature = "buffers.feature.capacity";
    // 2 x 4 x 256 x 18 B = 36,864 B: one byte less is too small.
    let just = "buffers.feature.capacity=36864 B";
    assert!(Machine::parse_with(gscore(), &sets(&[just])).is_ok());
    contradicts(&["buffers.feature.capacity=36863 B"], feature, "need 36 KiB");
    contradicts(&["geometry.chunk=1024"], feature, "`geometry.chunk` 1024");
    contradicts(&["geometry.chunk=65536", "vru.cores=1024"], feature, "is too small");
    assert!(Machine::parse_with(gscore(), &sets(&["buffers.sorting.capacity=6 KiB"])).is_ok());
    let less = ["buffers.sorting.capacity=6143 B"];
    contradicts(&less, "buffers.sorting.capacity", "one chunk per core");
    contradicts(&["buffers.gaussian-in.capacity=143 B"], "buffers.gaussian-in.capacity", "two rec");
    contradicts(&["buffers.pixel-out.capacity=1 KiB"], "buffers.pixel-out.capacity", "sub-tiles");
    contradicts(&["buffers.tile-list.capacity=31 B"], "buffers.tile-list.capacity", "two entries");
    let bare = "fovea.accumulators=0";
    let whole = "geometry.subtile=16";
    contradicts(&["vru.impl=leaders"], "vru.impl", "`fovea.accumulators` = 1");
    let quad = ["vru.impl=leaders", bare, "vru.termination=quad"];
    contradicts(&quad, "vru.termination", "mini-tiles stop whole");
    contradicts(&["vru.impl=leaders", bare, whole], "geometry.subtile", "a test unit looks at 2x2");
    let rows = ["vru.impl=rows", bare, "vru.termination=tile"];
    contradicts(&rows, "geometry.subtile", "such units have no sub-tiles");
    let many = [&rows[..], &[whole, "vru.units-per-core=17"]].concat();
    contradicts(&many, "vru.units-per-core", "`geometry.tile` = 16 rows");
    contradicts(&["vru.impl=pixels", bare, whole], "vru.termination", "stop with the pixel");
    contradicts(&["vru.termination=none"], "vru.termination", "`fovea.accumulators` = 1");
    contradicts(&["gsu.impl=none", bare], "gsu.impl", "`vru.termination` = \"subtile\"");
    let group = ["gsu.impl=none", "vru.termination=none", bare, "geometry.sort-group=64"];
    contradicts(&group, "gsu.impl", "`geometry.sort-group` = 64");
    contradicts(&["stereo.impl=derived"], "stereo.impl", "`fovea.accumulators` = 1");
    let kept = ["stereo.impl=shared", bare, "gsu.impl=update", "binning.impl=free"];
    contradicts(&kept, "stereo.impl", "`gsu.impl` = \"update\"");
    let late = ["stereo.impl=shared", bare, "ccu.fetch=everything"];
    contradicts(&late, "stereo.impl", "`ccu.fetch` = \"everything\"");
    let buffer = |capacity: &str, word: &str| {
        format!(
            "stereo.buffer={{ capacity = \"{capacity}\", word = \"{word}\", banks = 4, ports = \
             \"1rw\" }}"
        )
    };
    let word = ["stereo.impl=derived", bare, &buffer("64 KiB", "0 B")];
    contradicts(&word, "stereo.buffer.word", "from 1 B to the capacity");
    let large = ["stereo.impl=derived", bare, &buffer("2 GiB", "32 B")];
    contradicts(&large, "stereo.buffer.capacity", "is above");
    let parallel = "vru.impl=parallel";
    let units = "vru.units-per-core";
    contradicts(&[parallel, "vru.units-per-core=6"], units, "a multiple of 4");
    contradicts(&[parallel, "geometry.subtile=4", "vru.units-per-core=8"], units, "of 16");
    let one = ["vru.termination=pixel", "vru.pixels-per-unit=1"];
    contradicts(&one, "vru.termination", "`vru.pixels-per-unit`");
    let scan = ["vru.impl=scan", "vru.termination=tile"];
    contradicts(&scan, "vru.impl", "`vru.termination`");
    contradicts(&["vru.pixel-state=0 B"], "vru.pixel-state", "from 1 B");
    contradicts(&[parallel, "vru.subtile-queue=0"], "vru.subtile-queue", "at least 1");
    // 2 x 4 x 64 x 3 B of pixels and 4 x 256 x 8 B of state.
    let just = ["vru.impl=swap", "buffers.pixel-out.capacity=9728 B"];
    assert!(Machine::parse_with(gscore(), &sets(&just)).is_ok());
    let less = ["vru.impl=swap", "buffers.pixel-out.capacity=9727 B"];
    contradicts(&less, "buffers.pixel-out.capacity", "`vru.pixel-state` 8 B");
}

/// With a device the rate follows from it and the channels.
#[test]
fn the_rate_of_a_device_is_said_once() {
    let machine = |overlays: &[&str]| Machine::parse_with(gscore(), &sets(overlays));
    let peak = |overlays: &[&str]| machine(overlays).expect("a machine").dram_peak().0;
    assert_eq!(peak(&[]), 51.2e9);
    assert_eq!(peak(&["dram.channels=16"]), 102.4e9);
    assert_eq!(peak(&["dram.device=lpddr5-6400-x16x4"]), 102.4e9);
    // The same once more, also rounded, says nothing new and is forgotten.
    let same = machine(&["dram.bandwidth=51.2 GB/s"]).expect("the same");
    assert_eq!(same, machine(&[]).expect("a machine"));
    let rounded = ["dram.device=lpddr5x-8533-x16x4", "dram.channels=4", "dram.bandwidth=68.3 GB/s"];
    assert!((peak(&rounded) / (4.0 * 32.0 / 1.875e-9) - 1.0).abs() < 1e-12);
    let other = "`dram.bandwidth` = 100 TB/s contradicts `dram.device` = \"lpddr4-3200-x16x8\" \
                 with `dram.channels` = 8, which have 51.2 GB/s: leave `dram.bandwidth` out and \
                 set `dram.channels`";
    contradicts(&["dram.bandwidth=100 TB/s"], "dram.bandwidth", other);
    contradicts(&["dram.channels=16", "dram.bandwidth=51.2 GB/s"], "dram.bandwidth", "102.4 GB/s");
    let flat = "dram.model=bandwidth";
    assert_eq!(peak(&[flat, "dram.device=none", "dram.bandwidth=7 GB/s"]), 7e9);
    contradicts(&[flat, "dram.device=none"], "dram.bandwidth", "needs `dram.bandwidth`");
    let banked = ["dram.model=banked", "dram.device=none", "dram.bandwidth=7 GB/s"];
    contradicts(&banked, "dram.model", "`dram.device` is \"none\"");
}

/// A key of a part that the machine does not have says what brings it; a file that says that it has
/// none keeps what it says of it.
#[test]
fn keys_of_parts_that_are_not_there_are_refused() {
    let refused = |text: &str, set: &[&str]| {
        Machine::parse_with(text, &sets(set)).expect_err("no such part").to_string()
    };
    for part in Optional::all() {
        let of_part = |key: &&KeyDoc| {
            !key.table && Optional::of(&key.path).is_some_and(|own| own.what == part.what)
        };
        let docs = key_docs::<Machine>();
        let own = docs.iter().filter(of_part).find(|doc| doc.path != part.switch);
        // What several dataflows have is said by the first of them.
        let Some(own) = own else {
            let is_said = |key: &&str| Optional::of(key).is_some_and(|own| own.what != part.what);
            assert!(part.keys.iter().all(is_said), "{}: no key", part.what);
            continue;
        };
        let is_own = |flow: &&dyn Dataflow| {
            let mut all = flow.stages().iter().flat_map(|stage| stage.optional);
            all.any(|own| (own.what, own.switch) == (part.what, part.switch))
        };
        let flow = flow::all().find(is_own);
        let file = flow.and_then(flow::example).map_or(gscore(), |file| file.text);
        let machine = Machine::parse_with(file, &sets(part.with));
        let table = machine.unwrap_or_else(|e| panic!("{}: {e}", part.what)).stated();
        let value = knob::values(&table, &own.path).pop();
        let value = value.unwrap_or_else(|| panic!("{}: not there with {:?}", own.path, part.with));
        let set = format!("{}={value}", own.path);
        let without = [
            ("gscore", ""),
            ("gscore", "vru.impl=serial"),
            ("vorion", ""),
            ("gscore-powergs", ""),
            ("gbu", "cache.eviction=lru"),
            ("vorion", "region.slices=1"),
            ("gcc", ""),
            ("gbu", ""),
            ("axis-shared", ""),
            ("xavier-nx", ""),
        ];
        let lacks = |(name, other): &(&str, &str)| {
            let others: Vec<&str> =
                Some(*other).filter(|set| !set.is_empty()).into_iter().collect();
            let text = find(MACHINES, name).expect("a machine");
            let machine = Machine::parse_with(text, &sets(&others)).expect("a good machine");
            machine.lacks(&own.path).is_some_and(|lacked| lacked.switch == part.switch)
        };
        let (name, other) = without.into_iter().find(lacks).expect("a machine without");
        let file = find(MACHINES, name).expect("a machine");
        let asked: Vec<&str> = [other, &set].into_iter().filter(|set| !set.is_empty()).collect();
        let said = refused(file, &asked);
        let switch = format!("which this machine does not have: give `{}`", part.switch);
        assert!(said.contains(&own.path) && said.contains(&switch), "{said}");
    }
    let stray = gscore().replace("[schedule]", "[cache]\nways = 8\n\n[schedule]");
    let said = refused(&stray, &[]);
    assert!(said.contains("line ") && said.contains("give `cache.capacity`"), "{said}");
    let old = "[cache]\ncapacity = \"0 B\"\nways = 8\n\n[schedule]";
    let old = Machine::parse(&gscore().replace("[schedule]", old)).expect("a file of before");
    assert_eq!(old.to_toml(), Machine::parse(gscore()).expect("gscore").to_toml());
    let none = gscore().replace("[geometry]", "cache = \"none\"\nbinning = \"none\"\n[geometry]");
    let twice = refused(&none, &[]);
    assert!(twice.contains("binning"), "{twice}");
    let none = gscore().replace("[geometry]", "cache = \"none\"\n[geometry]");
    assert_eq!(Machine::parse(&none), Machine::parse(gscore()));
}

#[test]
fn every_fetch_policy_and_tile_runs_on_gscore() {
    for fetch in ["everything", "geometry-first", "visible-colour", "lazy-colour"] {
        for tile in [8, 16, 32, 64] {
            let mut keys = vec![
                format!("ccu.fetch={fetch}"),
                format!("geometry.tile={tile}"),
                format!("geometry.sort-group={tile}"),
                format!("geometry.subtile={}", (tile / 4).max(4)),
                "record.feature-source=nobody".to_owned(),
            ];
            if fetch == "lazy-colour" {
                keys.push("vru.colour-operations-per-cycle=133".to_owned());
            }
            let overlays = sets(&keys.iter().map(String::as_str).collect::<Vec<_>>());
            Machine::parse_with(gscore(), &overlays).unwrap_or_else(|e| panic!("{fetch}: {e}"));
        }
    }
}

#[test]
fn independent_problems_are_reported_at_once_in_the_order_of_their_lines() {
    let bad = gscore()
        .replace("clock = \"1 GHz\"", "clock = 800")
        .replace("chunk = 256", "chunk = 0")
        .replace("fetch = \"visible-colour\"", "fetch = \"visible-color\"")
        .replace("cores = 4 ", "core = 4 ")
        .replace("subtile-skipping = true", "subtile-skipping = \"yes\"")
        .replace("efficiency = 0.78 ", "efficiency = 7.8 ")
        .replace("latency = \"100 ns\"", "");
    let error = Machine::parse_with(&bad, &sets(&["gsu.pivot=3"])).expect_err("seven mistakes");
    let keys: Vec<&str> = error.problems.iter().map(|p| p.key.as_str()).collect();
    let expected = [
        "clock",
        "geometry.chunk",
        "ccu.fetch",
        "vru.core",
        "vru.subtile-skipping",
        "dram.latency",
        "dram.efficiency",
        "gsu.pivot",
    ];
    assert_eq!(keys, expected, "{error}");
    let all_contradictions = ["geometry.tile=24", "gsu.bsu-width=5", "record.pixel=0 B"];
    let error = Machine::parse_with(gscore(), &sets(&all_contradictions)).expect_err("three");
    assert!(error.problems.len() >= 3, "{error}");
}

/// The wording of errors, one mistake after the other, as a user sees it.
#[test]
fn errors_read_well() {
    let changes: &[(&str, &str, &[&str])] = &[
        ("cores = 4 ", "coers = 4 ", &[]),
        ("clock = \"1 GHz\"", "clock = 1 GHz", &[]),
        ("clock = \"1 GHz\"", "clock = 1e9", &[]),
        ("[vru]", "[vru", &[]),
        ("latency = \"100 ns\"", "", &[]),
        ("tile = 16 ", "tile = 128 ", &[]),
        ("test = \"obb\"", "test = \"elipse\"", &[]),
        (
            "feature = { capacity = \"128 KiB\", word = \"32 B\", banks = 2, ports = \"1rw\" }",
            "cores = 3",
            &[],
        ),
        ("", "", &["vru.core=8", "clock=fast", "x"]),
        ("", "", &["vru.core=8", "clock=fast"]),
        ("", "", &["geometry.chunk=1024"]),
    ];
    let mut text = String::new();
    for (from, to, overlays) in changes {
        assert!(gscore().contains(from), "{from}");
        let error = Machine::parse_with(&gscore().replacen(from, to, 1), &sets(overlays));
        let error = error.expect_err("a mistake");
        text.push_str(&format!("== `{from}` -> `{to}` {}\n{error}\n\n", overlays.join(" ")));
    }
    expect_file![concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/config-errors.txt")]
        .assert_eq(&text);
}

#[test]
fn a_refused_change_says_what_would_make_it_fit() {
    let fit = |sets: &[&str]| {
        let sets = super::sets(sets);
        let error = Machine::parse_with(gscore(), &sets).expect_err("contradictions");
        let with = [&sets[..], &error.remedy[..]].concat();
        if !error.remedy.is_empty() {
            Machine::parse_with(gscore(), &with).expect("the remedy is one");
        }
        (error.remedy.clone(), error.to_string())
    };
    let (remedy, text) = fit(&["geometry.tile=64"]);
    assert_eq!(remedy, ["vru.units-per-core=64", "geometry.sort-group=64"]);
    let line = "it would fit with --set vru.units-per-core=64 --set geometry.sort-group=64";
    assert!(text.ends_with(line), "{text}");
    // Buffers are looked at only when all else is right: the remedy goes on until nothing is left.
    let (remedy, text) = fit(&["geometry.tile=64", "vru.cores=32"]);
    assert!(remedy.contains(&"buffers.feature.capacity=288 KiB".to_owned()), "{remedy:?}");
    assert!(text.contains("--set 'buffers.feature.capacity=288 KiB'"), "{text}");
    // What was asked for is not taken back, and a file alone gets no changes.
    assert_eq!(fit(&["geometry.tile=64", "geometry.sort-group=16"]).0, [""; 0]);
    let alone = gscore().replace("sort-group = 16", "sort-group = 24");
    assert_eq!(Machine::parse(&alone).expect_err("no power of two").remedy, [""; 0]);
}

/// Every machine that comes with the program: the keys in which it differs from its base, and
/// without one from the defaults.
#[test]
fn machines_are_what_they_were() {
    let of = |name: &str| {
        let text = find(MACHINES, name).expect(name);
        let machine = Machine::parse(text).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut all = BTreeMap::new();
        keys(&machine.to_toml().parse().expect("TOML"), "", &mut all);
        all
    };
    let mut golden = String::new();
    for file in MACHINES {
        let own = of(file.name);
        let base = base_of(file.text);
        let before = base.as_deref().map(of).unwrap_or_default();
        let defaults = defaults(&own["dataflow"]);
        golden += &format!("{} on {}\n", file.name, base.as_deref().unwrap_or("defaults"));
        let is_said = |key: &str| before.get(key).or(defaults.get(key)) == own.get(key);
        for (key, value) in own.iter().filter(|(key, _)| !is_said(key)) {
            golden += &format!("  {key} = {value}\n");
        }
        for key in before.keys().filter(|key| !own.contains_key(*key)) {
            golden += &format!("  no {key}\n");
        }
    }
    expect_file!["../../../../../tests/golden/machines.txt"].assert_eq(&golden);
}

fn keys(table: &toml::Table, path: &str, all: &mut BTreeMap<String, toml::Value>) {
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        match value {
            toml::Value::Table(inner) => keys(inner, &path, all),
            value => drop(all.insert(path, value.clone())),
        }
    }
}

/// What the keys of a dataflow's machines are where a file does not say.
fn defaults(flow: &toml::Value) -> BTreeMap<String, toml::Value> {
    let flow = flow::named(flow.as_str().expect("a name")).expect("a dataflow");
    let own = leaves(&(flow.tables().schema)());
    let all = leaves(&schema_of::<Machine>()).into_iter().chain(own);
    let default = |schema: Value| toml::Value::try_from(schema.get("default")?).ok();
    all.filter_map(|(key, schema)| Some((key, default(schema)?))).collect()
}

/// A key or a value that no machine file has would exclude nothing, and nobody would see it.
#[test]
fn what_is_excluded_is_there() {
    let mut seen = 0;
    for flow in flow::all() {
        let docs = key_docs_of(&(flow.tables().schema)());
        let check = |key: &str, values: &[&str]| {
            let doc = docs.iter().find(|doc| doc.path == key);
            let choices = doc.unwrap_or_else(|| panic!("no key {key}")).choices();
            for value in values {
                let is_one = choices.is_empty() || choices.iter().any(|choice| choice == value);
                assert!(is_one, "{key} = {value}: {choices:?}");
            }
        };
        for exclusion in flow.stages().iter().flat_map(|stage| stage.excludes) {
            for (setting, end) in
                [(exclusion.choice, exclusion.off), (exclusion.other, exclusion.instead)]
            {
                match setting {
                    KeyValues::Is(key, values) | KeyValues::Not(key, values) => {
                        check(key, values);
                        check(key, Some(end).filter(|end| !end.is_empty()).as_slice());
                    }
                    KeyValues::Unlike(key, second) => {
                        check(key, &[]);
                        check(second, &[]);
                    }
                }
            }
            seen += 1;
        }
    }
    assert!(seen > 30, "{seen}");
}
