//! One key at a time.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufReader;

use powergs_sim::config::embedded::{ENERGY, MACHINES, find};
use powergs_sim::config::inert::inert;
use powergs_sim::flow;
use powergs_sim::machine::Machine;
use powergs_sim::machine::Optional;
use powergs_sim::sim::{self, FrameReport, Label, simulate};
use powergs_sim::stage::EnergyTable;
use powergs_sim::trace::Reader;
use powergs_sim::workload::bin;
use serde_json::Value;

use super::{json, rows, sensitivity, text};

/// The memory whose prices are keys of the energy table.
const FLAT: &str = "dram.model=bandwidth";

/// The first frame of the demo trace on gscore with this value.
fn simulated(set: &str) -> FrameReport {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
    let file = BufReader::new(File::open(path).expect("the demo trace"));
    let mut reader = Reader::open(file).expect("a trace");
    let frame = reader.read_block(0).expect("a frame").decode().expect("a frame");
    let text = find(MACHINES, "gscore").expect("a machine");
    let sets = [FLAT, set].map(str::to_owned);
    let machine = Machine::parse_with(text, &sets).expect("a machine");
    let table = EnergyTable::parse(find(ENERGY, "gscore-28nm").expect("a table")).expect("it");
    let prices = sim::cost::prices(&table, &machine).expect("prices");
    let workload = bin(&frame, machine.tiles().geometry);
    simulate(Label::default(), &workload, &machine, &prices).expect("accounts close")
}

fn row<'a>(found: &'a Value, key: &str) -> &'a Value {
    let row = rows(found, "keys").iter().find(|r| r["key"] == key);
    row.unwrap_or_else(|| panic!("no row {key}: {found}"))
}

fn elasticity(found: &Value, key: &str, measure: &str) -> f64 {
    row(found, key)["elasticity"][measure].as_f64().unwrap_or_else(|| panic!("{key} {measure}"))
}

#[test]
fn elasticities_are_differences_of_logarithms() {
    let keys = "vru.latency,vru.cores,geometry.tile";
    let found = json("gscore", &["--set", FLAT, "--keys", keys, "--step", "0.5"]);
    for (key, low, high) in [("vru.latency", 11.0, 33.0), ("vru.cores", 2.0, 6.0)] {
        let [a, b] = [low, high].map(|x| simulated(&format!("{key}={x}")));
        let over = |f: fn(&FrameReport) -> f64| (f(&b).ln() - f(&a).ln()) / f64::ln(high / low);
        let fps = over(|r| r.achieved_fps().expect("a time"));
        let energy = over(|r| r.energy.total().0);
        let power = over(|r| r.power_display_rate_w(60.0));
        let area = over(|r| r.area.as_ref().expect("an area").total().0);
        // The same numbers in another order of operations.
        for (measure, exact) in [("fps", fps), ("energy", energy), ("power", power), ("area", area)]
        {
            let found = elasticity(&found, key, measure);
            assert!((found - exact).abs() < 1e-9, "{key} {measure}: {found}, not {exact}");
        }
        assert_eq!(row(&found, key)["elasticity_sides"], "both");
    }
    // 32 would need another sort group, so there is one side only.
    let tile = row(&found, "geometry.tile");
    assert_eq!((text(tile, "elasticity_sides"), text(tile, "status")), ("down", "alive"));
    let [a, b] = ["geometry.tile=8", "geometry.tile=16"].map(simulated);
    let fps = |r: &FrameReport| r.achieved_fps().expect("a time").ln();
    let exact = (fps(&b) - fps(&a)) / f64::ln(2.0);
    assert!((elasticity(&found, "geometry.tile", "fps") - exact).abs() < 1e-9);
}

/// Energy is a sum of prices times counts, and area one of areas: the elasticities of all prices
/// add up to 1. Over steps of 10 % the difference of logarithms bends by less than 1 %.
#[test]
fn elasticities_of_prices_add_up() {
    let keys = "actions.*,sram.cacti.energy-factor,sram.cacti.leakage-factor,leakage.*,\
                dram.flat.*,area.*,phy.*";
    let prices = ["--set", FLAT, "--energy", "gscore-28nm-flat"];
    let found = json("gscore", &[&prices[..], &["--keys", keys]].concat());
    let sum = |measure: &str, start: &dyn Fn(&str) -> bool| -> f64 {
        let all = rows(&found, "keys").iter().filter(|r| start(text(r, "key")));
        all.filter_map(|r| r["elasticity"][measure].as_f64()).sum()
    };
    // `dram.flat.channels` is no price: standby is divided by it.
    let is_area = |key: &str| {
        key.starts_with("area.") || key.contains("phy.area") || key.contains("phy.controller")
    };
    let is_price = |key: &str| !is_area(key) && key != "dram.flat.channels";
    let (energy, power) = (sum("energy", &is_price), sum("power", &is_price));
    let area = sum("area", &|key| is_area(key) && key != "area.rest.share");
    for (measure, sum) in [("energy", energy), ("power", power), ("area", area)] {
        assert!((sum - 1.0).abs() < 0.01, "{measure}: {sum}");
    }
    let moves_time = rows(&found, "keys").iter().filter(|r| r["elasticity"]["fps"] != 0.0).count();
    assert_eq!(moves_time, 0, "prices take no time");
}

/// Dead keys that are alive elsewhere, and nobody lists: they limit nothing on this small frame.
const NOT_THE_LIMIT: [&str; 10] = [
    "ccu.operations.cull",
    "ccu.operations.obb-prepare",
    "ccu.operations.project",
    "ccu.operations.sh-colour",
    "gsu.bsu-latency",
    "gsu.depth",
    "gsu.qsu-latency",
    "record.colour-extra",
    "record.feature-source",
    "record.id-check",
];

#[test]
fn dead_keys_are_the_inert_ones() {
    let found = json("gscore", &["--set", FLAT]);
    let of = |status: &str| -> BTreeSet<String> {
        let all = rows(&found, "keys").iter().filter(|r| r["status"] == status);
        all.map(|r| text(r, "key").to_owned()).collect()
    };
    let dead = of("dead");
    let machine = |when: &'static str| {
        let all = inert()["machine"].iter().filter(move |(_, i)| i.when.contains(when));
        all.map(|(key, _)| key.clone())
    };
    // What its conditions say of gscore, whatever the frame.
    let mut must: BTreeSet<String> = machine("`dram.model` is `bandwidth`").collect();
    must.retain(|key| Optional::of(key).is_none());
    // Keys of other dataflows are not tried.
    must.retain(|key| {
        let flow = flow::of_table(key.split('.').next().unwrap_or_default());
        flow.is_none_or(|flow| flow.key() == flow::DEFAULT)
    });
    let alive: Vec<&String> = must.difference(&dead).collect();
    assert!(must.len() >= 4 && alive.is_empty(), "alive: {alive:?}");
    let listed = |key: &String| {
        inert().values().any(|keys| keys.contains_key(key)) || NOT_THE_LIMIT.contains(&key.as_str())
    };
    let strange: Vec<&String> = dead.iter().filter(|key| !listed(key)).collect();
    assert!(strange.is_empty(), "dead, and nobody knows why: {strange:?}");
    assert!(of("alive").len() > 60, "{:?}", of("alive"));
    assert_eq!(found["not_tried"][0]["file"], "dram");
    for row in rows(&found, "keys").iter().filter(|r| r["status"] == "fixed") {
        let refused = rows(row, "varied").iter().all(|t| t["refused"].is_string());
        assert!(refused, "{row}");
    }
}

/// With banks the device matters, and the peak rate of the machine does not.
#[test]
fn the_memory_model_decides_which_keys_are_dead() {
    let keys = "dram.latency,dram.efficiency,timing.read-data,energy.scale,dram.channels";
    let sets = ["--set", "dram.model=banked", "--keys", keys];
    let found = json("gscore", &sets);
    for (key, status) in [
        ("dram.latency", "dead"),
        ("dram.efficiency", "dead"),
        ("timing.read-data", "alive"),
        ("energy.scale", "alive"),
        ("dram.channels", "alive"),
    ] {
        assert_eq!(row(&found, key)["status"], status, "{key}");
    }
    assert!(text(row(&found, "dram.latency"), "reason").contains("is not `bandwidth`"));
    assert!(rows(&found, "not_tried").is_empty());
}

#[test]
fn the_report_is_complete_and_fits_a_terminal() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("s");
    let csv = root.path().join("table.csv");
    let keys = "dram.channels,geometry.test,vru.*,dram.latency,area.*,vru.cores";
    let run = sensitivity("gscore", &["--keys", keys], &out)
        .args(["--csv".as_ref(), csv.as_os_str()])
        .assert()
        .success();
    let said = String::from_utf8_lossy(&run.get_output().stdout).into_owned();
    let lines = said.lines().filter(|l| !l.starts_with("report"));
    let wide: Vec<&str> = lines.filter(|l| l.chars().count() > 80).collect();
    assert!(wide.is_empty(), "{wide:#?}");
    for word in
        ["vru.cores", "aabb", "Dead on these frames", "dram.latency", "move only energy or area"]
    {
        assert!(said.contains(word), "{word}: {said}");
    }
    let names = ["sensitivity.csv", "elasticity.csv", "summary.md", "run.toml", "tornado_fps.png"];
    for name in names.into_iter().chain(["tornado_energy.svg", "tornado_area.png"]) {
        assert!(out.join(name).exists(), "{name}");
    }
    let read = |path: std::path::PathBuf| std::fs::read_to_string(path).expect("a file");
    assert_eq!(read(csv), read(out.join("elasticity.csv")));
    let page = read(out.join("summary.md"));
    assert!(page.contains("| machine | `vru.cores` | 4 | 2, 8 |"), "{page}");
    assert!(page.contains("![What every key moves: area](tornado_area.png)"), "{page}");
}

#[test]
fn wrong_keys_and_steps_are_refused() {
    let root = tempfile::tempdir().expect("a folder");
    let check = |args: &[&str], expected: &str| {
        let run = sensitivity("gscore", args, &root.path().join("s")).assert().failure().code(2);
        let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
        assert!(said.contains(expected), "{args:?}: {said}");
        assert!(!root.path().join("s").exists(), "{args:?}");
    };
    check(&["--keys", "vru.coress"], "did you mean `vru.cores`?");
    check(&["--keys", "cache.ways"], "does not have: give `cache.capacity`");
    check(&["--keys", "=1..2"], "a key is missing");
    check(&["--step", "0"], "a share from 0.001 to 0.5");
    check(&["--step", "NaN"], "a share from 0.001 to 0.5");
    check(&["--only", "A4"], "--assumptions");
    check(&["--assumptions", "--keys", "clock"], "cannot be used");
    check(&["--samples", "3"], "--interactions");
    let morris = |keys: &'static str| ["--interactions", "morris", "--keys", keys];
    check(&morris("vru.cores=8..2"), "must ascend");
    check(&morris("vru.cores=a..b"), "names are written A|B|C");
    check(&morris("clock=1 GHz..2000 MHz"), "in one unit");
    check(&morris("geometry.test=obb|round"), "round: invalid configuration");
    check(&morris("vru.cores=4"), "nothing acts together");
    check(&["--interactions", "sobol", "--samples", "1000000", "--keys", "clock"], "more than");
}

#[test]
fn geometries_that_do_not_fit_together_are_taken_one_after_the_other() {
    let keys = ["--keys", "geometry.tile,geometry.subtile,clock"];
    let all = json("gscore", &keys);
    // Room for one geometry of the frame, not for five.
    let small = json("gscore", &[&keys[..], &["--memory", "6 MiB"]].concat());
    assert_eq!(rows(&all, "keys"), rows(&small, "keys"));
}
