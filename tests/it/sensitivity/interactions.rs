//! Keys that are turned together.

use serde_json::Value;

use super::{json, rows, sensitivity, text};

fn factor<'a>(found: &'a Value, key: &str) -> &'a Value {
    let all = rows(&found["interactions"], "factors");
    all.iter().find(|f| f["key"] == key).unwrap_or_else(|| panic!("no {key}: {found}"))
}

fn number(value: &Value, path: &[&str]) -> f64 {
    let found = path.iter().fold(value, |value, name| &value[*name]);
    found.as_f64().unwrap_or_else(|| panic!("{path:?}: {value}"))
}

/// Prices add up, so that their effects do not depend on each other, and they take no time. Between
/// prices of 5 and 15 pJ/B the effect is the bytes times 10 pJ.
#[test]
fn morris_finds_that_prices_add_up_and_cores_do_not() {
    let keys = "dram.flat.read.energy=5 pJ/B..15 pJ/B,actions.alpha.energy,vru.cores=2..8,\
                vru.units-per-core=8|16|32";
    let found = json(
        "gscore",
        &[
            "--set",
            "dram.model=bandwidth",
            "--energy",
            "gscore-28nm-flat",
            "--interactions",
            "morris",
            "--samples",
            "6",
            "--keys",
            keys,
        ],
    );
    let all = &found["interactions"];
    assert_eq!((text(all, "method"), all["samples"].as_u64()), ("morris", Some(6)));
    for key in ["dram.flat.read.energy", "actions.alpha.energy"] {
        let measures = &factor(&found, key)["measures"];
        assert_eq!(number(measures, &["fps", "mu_star_percent"]), 0.0);
        let size = number(measures, &["energy", "mu_star_percent"]);
        assert!(size > 1.0, "{key}: {size}");
    }
    let cores = &factor(&found, "vru.cores")["measures"];
    assert!(number(cores, &["fps", "mu_percent"]) > 10.0, "{cores}");
    // Area: cores times units, so that neither has the same effect everywhere.
    let [size, spread] = ["mu_star_percent", "sigma_percent"].map(|n| number(cores, &["area", n]));
    assert!(size > 20.0 && spread > 0.05 * size, "{cores}");
    // Levels of a range: even steps of the logarithm.
    assert_eq!(factor(&found, "vru.cores")["levels"], serde_json::json!(["2", "3", "5", "8"]));
    let levels = rows(factor(&found, "dram.flat.read.energy"), "levels");
    assert_eq!((levels.len(), levels[0].as_str()), (4, Some("5 pJ/B")));
}

#[test]
fn sobol_shares_the_variance_of_a_sum() {
    let keys = "dram.flat.read.energy,actions.alpha.energy,leakage.ccu.power";
    let found = json(
        "gscore",
        &[
            "--set",
            "dram.model=bandwidth",
            "--energy",
            "gscore-28nm-flat",
            "--interactions",
            "sobol",
            "--samples",
            "2048",
            "--keys",
            keys,
        ],
    );
    let energy = |key: &str, order: &str, of: &str| {
        number(&factor(&found, key)["measures"]["energy"], &[order, of])
    };
    let (mut firsts, mut totals) = (0.0, 0.0);
    for key in keys.split(',') {
        let [first, total] = ["first", "total"].map(|o| energy(key, o, "value"));
        // The error falls with the root of the rows, of 2048 rows to about 0.025.
        assert!((first - total).abs() < 0.1, "{key}: {first} {total}");
        assert!(energy(key, "total", "low") <= total && total <= energy(key, "total", "high"));
        assert_eq!(number(&factor(&found, key)["measures"]["fps"], &["total", "value"]), 0.0);
        (firsts, totals) = (firsts + first, totals + total);
    }
    assert!((firsts - 1.0).abs() < 0.15 && (totals - 1.0).abs() < 0.15, "{firsts} {totals}");
    let alone = number(&found["interactions"]["explained_alone"]["energy"], &["value"]);
    assert!((alone - firsts).abs() < 1e-9, "{alone} {firsts}");
    // Four levels of three prices, and every row has five of them.
    assert!(number(&found["interactions"], &["machines"]) <= 64.0);
}

/// Eight cores with long chunks need more sorting buffer than there is.
#[test]
fn invalid_designs_are_drawn_again_and_said() {
    let keys = "vru.cores=4|8,geometry.chunk=256|512,buffers.sorting.capacity=16 KiB|64 KiB";
    let root = tempfile::tempdir().expect("a folder");
    let args = ["--interactions", "morris", "--samples", "3", "--keys", keys];
    let run = sensitivity("gscore", &args, &root.path().join("s")).assert().success();
    let said = String::from_utf8_lossy(&run.get_output().stdout).into_owned();
    assert!(said.replace('\n', " ").contains("drawn again (invalid)"), "{said}");
    let page = std::fs::read_to_string(root.path().join("s/summary.md")).expect("a page");
    assert!(
        page.contains("Keys are independent only as far as configurations are valid"),
        "{page}"
    );
}

#[test]
fn the_report_does_not_depend_on_threads_and_has_all_files() {
    let root = tempfile::tempdir().expect("a folder");
    let keys = "vru.cores,dram.channels,ccu.fetch,dram.flat.read.energy";
    let names = ["interactions.csv", "designs.csv", "summary.md", "run.toml", "sensitivity.csv"];
    for (method, charts) in
        [("morris", ["morris_fps.svg", "morris_area.svg"]), ("sobol", ["sobol.svg"; 2])]
    {
        let run = |jobs: &str| {
            let out = root.path().join(format!("{method}{jobs}"));
            let args = ["--interactions", method, "--samples", "4", "--keys", keys, "--jobs", jobs];
            let run = sensitivity("gscore", &args, &out).assert().success();
            let said = String::from_utf8_lossy(&run.get_output().stdout).into_owned();
            let lines = said.lines().filter(|l| !l.starts_with("report"));
            let wide: Vec<&str> = lines.filter(|l| l.chars().count() > 80).collect();
            assert!(wide.is_empty(), "{wide:#?}");
            let read = |name: &str| {
                std::fs::read(out.join(name)).unwrap_or_else(|e| panic!("{method} {name}: {e}"))
            };
            names.iter().chain(&charts).map(|name| read(name)).collect::<Vec<_>>()
        };
        assert_eq!(run("1"), run("3"), "{method}");
    }
}
