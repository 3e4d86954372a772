//! Tables, summary and charts of a made-up foveated run.

use powergs_chart::{Format, Style};
use powergs_testkit::charts::covered;
use std::path::Path;

use powergs_optimize::fit::{Sample, fit};
use powergs_optimize::foveated::Method;
use powergs_optimize::pictures::{Album, Shot};
use powergs_optimize::results::{Results, saving_at};
use powergs_report::optimize::foveated::{
    Show, charts, document, foveated_csv, levels_csv, regions_csv,
};

use crate::foveated_run::run;

/// The rows of a table, by the names of its columns.
fn rows(text: &[u8]) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_reader(text);
    let names = reader.headers().unwrap().clone();
    let row = |record: csv::StringRecord| {
        assert_eq!(record.len(), names.len());
        names.iter().map(str::to_owned).zip(record.iter().map(str::to_owned)).collect()
    };
    reader.records().map(|r| row(r.unwrap())).collect()
}

#[test]
fn every_model_has_a_row_with_its_level_and_target() {
    let results = run();
    let table = rows(&levels_csv(&results));
    assert_eq!(table.len(), results.models.len());
    let row = table.iter().find(|r| r["model"] == "level3-optimum").unwrap();
    assert_eq!((row["variant"].as_str(), row["level"].as_str()), ("H", "3"));
    assert_eq!(row["target_hvsq"].parse::<f64>().unwrap(), 2.1e-5);
    assert_eq!(row["gate_hvsq"].parse::<f64>().unwrap(), 2.0e-5);
    assert!((row["total_w"].parse::<f64>().unwrap() - 0.25).abs() < 1e-12);
    let dense = table.iter().find(|r| r["role"] == "dense").unwrap();
    assert_eq!(dense["target_hvsq"], "");
}

#[test]
fn regions_that_no_view_shows_are_empty_cells() {
    let results = run();
    let table = rows(&foveated_csv(&results));
    assert_eq!(table.len(), 8);
    for row in &table {
        assert_eq!(row["hvsq_r4"], "");
        assert_eq!(row["state_l4"], "not_shown");
        assert_eq!(row["hvsq_l3"].is_empty(), row["method"] == "RTGS+D22");
        assert!(row["hvsq_r3"].parse::<f64>().is_ok());
    }
    assert_eq!(table[0]["method"], "PowerGS");
    assert_eq!(table[0]["test_psnr_db"], "27.35");
    assert_eq!((table[3]["filter_w"].as_str(), table[0]["lpips_test"].as_str()), ("0.01", ""));
    let regions = rows(&regions_csv(&results));
    assert_eq!(regions.len(), 8 * 4);
    assert_eq!(regions[1]["region"], "R2");
    assert!((regions[1]["watts"].parse::<f64>().unwrap() - 0.03).abs() < 1e-12);
    assert_eq!(regions[3]["hvsq"], "");
}

#[test]
fn savings_follow_the_panel_in_closed_form() {
    let results = run();
    let dense = results.dense().unwrap();
    // A panel that takes twice the rendering power: display power times 2 · 0.71 / 0.27.
    let scale = 2.0 * 0.71 / 0.27;
    let expected = 1.0 - (0.2 * scale + 0.1) / (0.25 * scale + 0.14);
    let saved = saving_at(dense, (0.2, 0.1), (0.25, 0.14), 2.0).unwrap();
    assert!((saved - expected).abs() < 1e-12);
    assert!(saving_at(dense, (0.2, 0.1), (0.0, 0.0), 2.0).is_err());
}

/// A picture with a ramp, so that crops differ.
fn album() -> Album {
    let (width, height) = (64u32, 48u32);
    let shade = |k: u32| (0..3 * width * height).map(move |i| ((i * k / 7) % 251) as u8);
    let shot = |name: &str, k| Shot { name: name.into(), rgb: shade(k).collect() };
    Album {
        view: "a view".into(),
        width,
        height,
        gaze: [0.5, 0.5],
        shots: vec![
            shot("photo", 1),
            shot("FR-Render", 2),
            shot("RTGS+D22", 3),
            shot("PowerGS", 4),
        ],
        levels: shade(5).collect(),
        tints: [[128; 3], [0, 115, 178], [230, 158, 0], [204, 64, 140]],
        shares: [0.3, 0.4, 0.3, 0.0],
        change: [None; 4],
    }
}

fn show(results: &Results) -> Show<'_> {
    let samples: Vec<Sample> = (0..5)
        .map(|i| {
            let u = f64::from(i) / 4.0;
            Sample { rho: 0.8 * u, display_w: 0.2 + 0.05 * u * u, render_w: 0.6 - 0.4 * u }
        })
        .collect();
    let fit = fit(&samples).unwrap();
    let fits = (1..=3).map(|l| (format!("level {l}"), fit.clone())).collect();
    Show { results, fits, album: Some(album()) }
}

#[test]
fn charts_are_drawn_and_the_summary_shows_them_with_the_tables() {
    let results = run();
    let show = show(&results);
    let drawn = charts(&show);
    let names: Vec<&str> = drawn.iter().map(|c| c.name).collect();
    let all = ["quality", "regions", "pictures", "levels", "ratio", "fits"];
    assert_eq!(names, all.map(|n| format!("foveated_{n}")));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("charts/foveated");
    std::fs::create_dir_all(&folder).unwrap();
    for chart in &drawn {
        assert_eq!(covered(chart), Vec::<String>::new());
        let svg = chart.svg(Style::default()).unwrap();
        assert!(svg.contains("bicycle on gscore"), "{}", chart.name);
        assert!(!svg.contains("NaN") && !svg.contains(">inf"), "{}", chart.name);
        std::fs::write(folder.join(format!("{}.svg", chart.name)), &svg).unwrap();
        if std::env::var_os("RUN_SLOW_TESTS").is_some() {
            let png = chart.png(Style::default()).unwrap();
            std::fs::write(folder.join(format!("{}.png", chart.name)), png).unwrap();
        }
    }
    let text = document(&show, &drawn).markdown(Format::Png);
    for part in [
        "Regions that count: R1, R2, R3; no view shows R4",
        "not a GPU's. The dense model, not foveated, runs at 20 FPS",
        "| PowerGS-H | 84 | 320.00 |",
        "| PowerGS-H (optimum) | 27.35 |",
        "| H | 3 | level3-optimum | 30.0 |",
        "(foveated_levels.png)",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_run_with_little_to_show_has_few_charts_and_no_panic() {
    let mut results = run();
    results.foveated.retain(|f| f.method == Method::PowerGs && f.variant == "H");
    results.models.retain(|m| m.baseline.is_none());
    results.foveated[0].hvsq = [None; 4];
    results.foveated[0].region_j = [0.0; 4];
    let alone = Show { results: &results, fits: Vec::new(), album: None };
    let drawn = charts(&alone);
    let names: Vec<&str> = drawn.iter().map(|c| c.name).collect();
    assert_eq!(names, ["foveated_quality", "foveated_regions"]);
    assert!(document(&alone, &drawn).markdown(Format::Png).contains("No region was measured"));
    results.foveated.clear();
    let none = Show { results: &results, fits: Vec::new(), album: None };
    assert!(charts(&none).is_empty());
    assert_eq!(document(&none, &[]).markdown(Format::Png), "");
}
