//! The sweeps that come with the program, at small size.

use std::collections::BTreeMap;
use std::path::Path;

use predicates::str::contains;

use super::Bench;

/// Every two energy tables of a sweep give some design another power.
fn tables_differ(name: &str, results: &Path) {
    let mut rows = csv::Reader::from_path(results).expect("results");
    let heads = rows.headers().expect("heads").clone();
    let place = |head: &str| heads.iter().position(|h| h == head).expect("a column");
    let columns = ["point", "trace", "scope", "energy_table", "power_w.mean"].map(place);
    let mut powers: BTreeMap<String, BTreeMap<[String; 3], String>> = BTreeMap::new();
    for row in rows.records() {
        let row = row.expect("a row");
        let [point, trace, scope, table, power] = columns.map(|i| row[i].to_owned());
        powers.entry(table).or_default().insert([point, trace, scope], power);
    }
    let tables: Vec<_> = powers.iter().collect();
    for (i, (a, of_a)) in tables.iter().enumerate() {
        assert!(of_a.values().any(|power| !power.is_empty()), "{name}: {a} has no results");
        for (b, of_b) in &tables[i + 1..] {
            assert_ne!(of_a, of_b, "{name}: {a} and {b} price every design alike");
        }
    }
}

#[test]
fn every_example_answers_its_question() {
    let bench = Bench::new();
    for name in ["gscore-units", "sram-bandwidth", "tiles", "node-energy", "node-choice"] {
        let run = ["sweep", name, "--traces", "demo.bin", "--points", "10", "--out", name];
        bench.program(&run).assert().success().stdout(contains("?"));
        assert!(bench.path(name).join("analysis/report.html").exists(), "{name}");
        assert!(bench.path(name).join("analysis/front.png").exists(), "{name}");
        tables_differ(name, &bench.path(name).join("results.csv"));
    }
    let where_ = "frame_time_ms.p99 <= 16.67 && area_mm2.core <= 4";
    let objectives = ["--minimize", "power_w.mean,area_mm2", "--maximize", "fps.mean"];
    let pareto = ["pareto", "gscore-units", "--where", where_];
    bench.program(&pareto).args(objectives).assert().success().stdout(contains("knee"));
}
