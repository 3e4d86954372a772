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
    bench.program(&pareto).args(objectives).assert().success().stdout(contains("on the front"));
    let priced = "power_w.mean,area_mm2 * if(vru.cores > 2, 2, 1)";
    let pareto = ["pareto", "gscore-units", "--minimize", priced, "--maximize", "fps.mean"];
    let said = contains("minimize area_mm2 * if(vru.cores > 2, 2, 1), maximize\n");
    bench.program(&pareto).assert().success().stdout(said);
}

#[test]
fn keys_of_set_may_need_those_of_an_axis() {
    let bench = Bench::new();
    let text = "question = \"?\"\nbase = \"gscore\"\n\
                set = { \"geometry.tile\" = 64, \"geometry.sort-group\" = 64 }\n\
                [[axes]]\nkey = \"vru.units-per-core\"\nvalues = [64, 128]\n";
    std::fs::write(bench.path("s.toml"), text).unwrap();
    let run = ["sweep", "s.toml", "--traces", "demo.bin", "--out", "s"];
    bench.program(&run).assert().success().stdout(contains("2 designs simulated"));
    let summary = std::fs::read_to_string(bench.path("s/summary.txt")).unwrap();
    assert!(summary.contains("Baseline: the first design"), "{summary}");
    let mut rows = csv::Reader::from_path(bench.path("s/results.csv")).unwrap();
    let heads = rows.headers().unwrap().clone();
    let units = heads.iter().position(|h| h == "vru.units-per-core").unwrap();
    let first = rows.records().next().unwrap().unwrap();
    assert_eq!((&first[1], &first[units]), ("true", "64"));
}

#[test]
fn a_table_that_cannot_price_a_design_leaves_it_to_the_others() {
    let bench = Bench::new();
    // `paper` has prices for one format of numbers alone; no table has them for e5m8.
    let text = "question = \"?\"\nbase = \"gscore\"\n\
                [[axes]]\nkey = \"record.numbers\"\nvalues = [\"e5m10\", \"e4m3\", \"e5m8\"]\n\
                [[energy]]\nlabel = \"a\"\ntable = \"gscore-28nm\"\n\
                [[energy]]\nlabel = \"b\"\ntable = \"paper\"\n";
    std::fs::write(bench.path("s.toml"), text).unwrap();
    let run = ["sweep", "s.toml", "--traces", "demo.bin", "--out", "s"];
    bench.program(&run).assert().success();
    let mut rows = csv::Reader::from_path(bench.path("s/results.csv")).unwrap();
    let heads = rows.headers().unwrap().clone();
    let columns = ["point", "energy_table", "scope", "status", "fps.mean", "reason"]
        .map(|head| heads.iter().position(|h| h == head).unwrap());
    let mut seen = Vec::new();
    for row in rows.records().map(Result::unwrap) {
        let [point, table, scope, status, fps, reason] = columns.map(|i| row[i].to_owned());
        if scope == "mean" && !point.is_empty() {
            assert_eq!(status == "ok", !fps.is_empty(), "{point} {table}");
            assert_eq!(status == "ok", !reason.contains("has no prices"), "{point} {table}");
            seen.push((point, table, status));
        }
    }
    let seen: Vec<_> = seen.iter().map(|(p, t, s)| [p.as_str(), t, s].join(" ")).collect();
    let wanted = ["0 a ok", "0 b ok", "1 a ok", "1 b invalid", "2 a invalid", "2 b invalid"];
    assert_eq!(seen, wanted);
}

/// A display rate of the command is that of every later report; another one needs another sweep.
#[test]
fn the_display_rate_of_the_command_stays_with_the_sweep() {
    let bench = Bench::new();
    let sweep = ["sweep", "tiles", "--traces", "demo.bin", "--points", "4", "--fps", "100"];
    bench.program(&sweep).args(["--out", "s"]).assert().success();
    let summary = || std::fs::read_to_string(bench.path("s/analysis/summary.md")).expect("text");
    let facts = || {
        let page = std::fs::read_to_string(bench.path("s/analysis/report.html")).expect("a page");
        (page.contains("100 FPS"), page.contains("--fps 100"))
    };
    assert_eq!(facts(), (true, true), "{}", summary());
    bench.program(&["pareto", "s"]).assert().success();
    assert_eq!(facts(), (true, true), "{}", summary());
    let other = bench.program(&["pareto", "s", "--fps", "90", "--display", "lcd"]).assert().code(2);
    other.stderr(contains("powergs-sim sweep tiles --fps 90 --display lcd --out DIR"));
}

/// The sweep of one axis over the demonstration, and what the analysis says.
fn swept(bench: &Bench, name: &str, axis: &str) -> (String, String) {
    let text = format!(
        "question = \"what is best?\"\nbase = \"gscore\"\n[[traces]]\npath = \"demo.bin\"\n\
         [[axes]]\n{axis}\n"
    );
    let file = format!("{name}.toml");
    std::fs::write(bench.path(&file), text).expect("a file");
    let output = bench.program(&["sweep", &file, "--out", name]).assert().success();
    let words = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let output = output.get_output();
    (words(&output.stdout), words(&output.stderr))
}

/// Frames that overlap come faster and each is there later: "nothing to trade" is not all of it.
#[test]
fn later_frames_are_said_beside_what_is_best() {
    let bench = Bench::new();
    const LATER: &str = "Its frames are there after";
    let overlap = "key = \"schedule.overlap\"\nvalues = [\"none\", \"frames\"]";
    let (said, _) = swept(&bench, "overlap", overlap);
    assert!(said.contains("nothing to trade among these") && said.contains(LATER), "{said}");
    let units = "key = \"vru.units-per-core\"\nvalues = [8, 16]";
    let (said, _) = swept(&bench, "units", units);
    assert!(!said.contains(LATER), "{said}");
}

/// Designs of several tasks, nodes or scopes do not rank by their machines alone.
#[test]
fn what_designs_mix_is_said() {
    let bench = Bench::new();
    let machines = "key = \"machine\"\nvalues = [\"gscore\", \"splatonic\", \"neo\"]";
    let (_, warned) = swept(&bench, "mixed", machines);
    assert!(warned.contains("what a frame is (render, track, 1 pixel in 256)"), "{warned}");
    assert!(warned.contains("technology nodes (") && !warned.contains("power is of"), "{warned}");
    let alike = "key = \"machine\"\nvalues = [\"gscore\", \"edge\"]";
    let (_, warned) = swept(&bench, "alike", alike);
    assert!(!warned.contains("designs differ"), "{warned}");
}
