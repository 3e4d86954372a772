//! `sweep --confirm`: the front on `banked`, the same bytes however the sweep was run.

use std::collections::BTreeMap;
use std::fs;

use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

use super::{Bench, assert_same};

/// A sweep of 24 designs of a machine whose DRAM model is `banked`: too many to have that at once.
const SWEEP: &str = r#"
question = "How many cores?"
base = "mine.toml"

[[axes]]
key = "vru.cores"
values = [1, 2, 4, 8]

[[axes]]
key = "ccu.units"
values = [1, 2, 4]

[[axes]]
key = "vru.units-per-core"
values = [8, 16]
"#;

/// A folder with this sweep and a machine.
fn bench() -> Bench {
    let bench = Bench::new();
    let machine = concat!(env!("CARGO_MANIFEST_DIR"), "/arch-configs/machines/gscore.toml");
    let machine = fs::read_to_string(machine).unwrap();
    let machine = machine.replace("model = \"bandwidth\"", "model = \"banked\"");
    assert!(machine.contains("model = \"banked\""));
    fs::write(bench.path("mine.toml"), machine).unwrap();
    fs::write(bench.path("cores.toml"), SWEEP).unwrap();
    bench
}

impl Bench {
    /// One frame of the sweep with these arguments, which succeeds.
    #[track_caller]
    fn confirmed(&self, arguments: &[&str]) {
        self.sweep(&["--frames", "0..1", "-q"]).args(arguments).assert().success();
    }

    /// The rows of a table by the names of their columns.
    fn rows(&self, file: &str) -> Vec<BTreeMap<String, String>> {
        let mut table = csv::Reader::from_path(self.path(file)).unwrap();
        table.deserialize().map(Result::unwrap).collect()
    }
}

#[test]
fn threads_parts_and_interruptions_confirm_the_same() {
    let bench = bench();
    bench.confirmed(&["--out", "one", "-j", "1"]);
    bench.confirmed(&["--out", "two", "-j", "2"]);
    assert_same(&bench.path("one"), &bench.path("two"));
    for shard in ["2/2", "1/2"] {
        bench.confirmed(&["--out", "parts", "--shard", shard]);
    }
    bench.program(&["sweep", "merge", "parts", "-q"]).assert().success();
    assert_same(&bench.path("one"), &bench.path("parts"));
    // Killed while it confirmed, and before.
    let journal = "records/shard-00001-of-00001.jsonl";
    let whole = fs::read(bench.path("one").join(journal)).unwrap();
    for cut in [whole.len() / 3, whole.len() - 1] {
        for gone in ["finished.toml", "confirmed.csv", "confirmed.json"] {
            fs::remove_file(bench.path("two").join(gone)).unwrap();
        }
        fs::write(bench.path("two").join(journal), &whole[..cut]).unwrap();
        bench.confirmed(&["--out", "two", "--resume"]);
        assert_same(&bench.path("one"), &bench.path("two"));
    }
    // A finished sweep says it again; `pareto` has it in its report too.
    let again = bench.sweep(&["--frames", "0..1", "--out", "two", "--resume"]).assert().success();
    again.stdout(contains("Confirmed with banked").and(contains("confirmed.csv")));
    bench.program(&["pareto", "two", "-q"]).assert().success();
    assert!(
        fs::read_to_string(bench.path("two/analysis/summary.md")).unwrap().contains("confirmed")
    );
    // Another number of designs is another answer on the same results.
    bench.confirmed(&["--out", "two", "--resume", "--confirm", "1"]);
    let points = |name: &str| {
        let rows = bench.rows(&format!("{name}/confirmed.csv"));
        let mut points: Vec<String> =
            rows.into_iter().map(|mut r| r.remove("point").unwrap()).collect();
        points.dedup();
        points
    };
    assert_eq!(points("two")[0], points("one")[0], "the knee comes first");
    assert!(points("two").len() < points("one").len());
    bench.confirmed(&["--out", "two", "--resume", "--confirm", "0"]);
    assert!(!bench.path("two/confirmed.csv").exists());
    assert!(!bench.path("two/confirmed.json").exists());
    let models = |name: &str| {
        let rows = bench.rows(&format!("{name}/results.csv")).into_iter();
        let mut models: Vec<String> = rows.map(|mut r| r.remove("dram_model").unwrap()).collect();
        models.sort();
        models.dedup();
        models
    };
    assert_eq!(models("two"), ["calibrated"]);
    assert_eq!(models("one"), ["banked", "calibrated"]);
}

/// A model of the model is not worth its error where designs are few.
#[test]
fn few_designs_have_banked_at_once() {
    let bench = bench();
    bench.confirmed(&["--out", "few", "--points", "4"]);
    bench.confirmed(&["--out", "all", "--points", "4", "--dram-model", "banked"]);
    let all = |name: &str| bench.rows(&format!("{name}/results.csv"));
    assert!(all("few").iter().all(|row| row["dram_model"] == "banked"));
    let times = |name: &str| -> Vec<String> {
        all(name).into_iter().map(|mut row| row.remove("frame_time_ms.mean").unwrap()).collect()
    };
    assert_eq!(times("few"), times("all"));
    assert!(!bench.path("few/confirmed.csv").exists());
    bench.confirmed(&["--out", "plain", "--points", "4", "--confirm", "0"]);
    assert!(all("plain").iter().all(|row| row["dram_model"] == "calibrated"));
}

#[test]
fn both_models_have_the_numbers_of_their_own_sweeps() {
    let bench = bench();
    let store = ["--store", "store"];
    bench.confirmed(&["--out", "one", store[0], store[1]]);
    bench.confirmed(&["--out", "banked", "--dram-model", "banked"]);
    // What is in the store of the one is found by the other, and by it alone.
    bench.confirmed(&["--out", "shared", "--dram-model", "banked", store[0], store[1]]);
    let all = bench.rows("banked/results.csv");
    assert_eq!(all, bench.rows("shared/results.csv"));
    assert!(!bench.path("banked/confirmed.csv").exists());
    let find = |rows: &[BTreeMap<String, String>], point: &str, column: &str| {
        let row = rows.iter().find(|row| row["point"] == point && row["scope"] == "mean");
        row.unwrap()[column].clone()
    };
    bench.confirmed(&["--out", "plain", "--confirm", "0"]);
    let calibrated = bench.rows("plain/results.csv");
    let confirmed = bench.rows("one/confirmed.csv");
    let results = bench.rows("one/results.csv");
    let mut differ = 0;
    for row in confirmed.iter().filter(|row| row["trace"].is_empty()) {
        let (point, column) = (&row["point"], &row["column"]);
        assert_eq!(row["calibrated"], find(&calibrated, point, column), "#{point} {column}");
        assert_eq!(row["banked"], find(&all, point, column), "#{point} {column}");
        // And so it stands in the results.
        assert_eq!(row["banked"], find(&results, point, column), "#{point} {column}");
        assert_eq!(find(&results, point, "dram_model"), "banked");
        differ += u32::from(row["calibrated"] != row["banked"]);
        if column == "area_mm2" {
            assert_eq!(row["difference_frac"], "0");
        }
    }
    assert!(differ > 0 && confirmed.len() > 5);
}

#[test]
fn what_cannot_be_confirmed_is_said() {
    let bench = bench();
    for wrong in ["21", "-1", "all"] {
        let confirm = format!("--confirm={wrong}");
        bench.sweep(&["--out", "one", &confirm]).assert().code(2).stderr(contains("--confirm"));
    }
    let part = bench.sweep(&["--out", "one", "--shard", "1/2", "--confirm", "3"]).assert();
    part.code(2).stderr(contains("sweep merge"));
    assert!(!bench.path("one").exists());
    for (model, why) in [("banked", "`banked` already"), ("bandwidth", "model `calibrated`")] {
        let arguments = ["--frames", "0..1", "--dram-model", model, "--confirm", "3"];
        let run = bench.sweep(&["--points", "2", "--out", model]).args(arguments).assert();
        run.success().stderr(contains("nothing to confirm").and(contains(why)));
        assert!(!bench.path(model).join("confirmed.csv").exists());
    }
    let varied = format!("{SWEEP}\n[[axes]]\nkey = \"dram.model\"\nvalues = [\"calibrated\"]\n");
    fs::write(bench.path("cores.toml"), varied).unwrap();
    let varied = bench.sweep(&["--dry-run", "--confirm", "3"]).assert().success();
    varied.stderr(contains("varies `dram.model`"));
    fs::write(bench.path("cores.toml"), SWEEP).unwrap();
    let dry = bench.sweep(&["--frames", "0..1", "--dry-run"]).assert().success();
    dry.stdout(contains("up to 20 designs").and(contains("20 machine-frames")));
}
