//! Runs beside each other.

use powergs_base::quantity::SquareMillimetres;
use powergs_chart::{Format, Style};
use powergs_report::compare::{charts, compare_csv, document, json, note, run_toml};
use powergs_report::{csv, record};
use powergs_study::findings::compare::{Comparison, Measure, Side, SideError};
use powergs_study::run_record::Run;
use powergs_testkit::charts::covered;

use crate::builder;

fn side(run: &Run) -> Side {
    Side::of_run(run).expect("frames")
}

/// A machine that takes `factor` times as long, with half the bandwidth.
fn slower(factor: f64) -> Run {
    let mut run = builder::run(&[4.0 * factor, 6.0 * factor]);
    run.facts.machine.name = "slow".into();
    run.facts.machine.dram_peak_gb_s = Some(25.6);
    run
}

fn pair() -> Comparison {
    Comparison::new(vec![side(&builder::run(&[4.0, 6.0])), side(&slower(2.0))], false)
}

fn value(comparison: &Comparison, measure: Measure, i: usize) -> f64 {
    comparison.row(measure).values[i].unwrap_or_else(|| panic!("{}", measure.name()))
}

/// Means are sums of a few terms in another order.
const ROUNDING: f64 = 1e-9;

#[track_caller]
fn same(a: f64, b: f64) {
    assert!((a - b).abs() <= ROUNDING * a.abs().max(b.abs()), "{a} is not {b}");
}

#[test]
fn measures_of_two_machines() {
    let c = pair();
    same(value(&c, Measure::FrameTime, 0), 5.0);
    same(value(&c, Measure::FrameTime, 1), 10.0);
    same(value(&c, Measure::Throughput, 1), 100.0);
    same(c.row(Measure::Throughput).ratio(1).expect("times"), 0.5);
    same(c.least_speedup().expect("times"), 0.5);
    // Frames per joule: power at full rate times the energy of a frame is frames per second.
    let (fps, watts) = (value(&c, Measure::Throughput, 0), value(&c, Measure::PowerFullRate, 0));
    same(value(&c, Measure::FpsPerWatt, 0), fps / watts);
    same(value(&c, Measure::AreaCore, 0), 3.812);
    same(value(&c, Measure::Area, 0), 3.812 + 8.8);
}

#[test]
fn rates_are_held_against_the_die() {
    let of = |millions, mm2| {
        let mut run = builder::run(&[millions]);
        let area = run.frames[0].area.as_mut().expect("an area");
        *area = builder::area_of(SquareMillimetres(mm2));
        side(&run)
    };
    let c = Comparison::new(vec![of(5.0, 4.0), of(10.0, 1.0)], false);
    same(value(&c, Measure::FpsPerArea, 0), 50.0);
    same(value(&c, Measure::FpsPerArea, 1), 100.0);
    assert_eq!(c.labels(), ["gscore-1", "gscore-2"], "one name is numbered");
}

/// 28 against 7 nm: a ratio of areas or joules would be that of the technologies.
#[test]
fn technologies_are_not_put_into_ratios() {
    let mut run = builder::run(&[8.0, 12.0]);
    run.facts.machine.name = "small".into();
    run.facts.machine.energy_table = "gscore-7nm".into();
    run.facts.machine.node_nm = Some(7.0);
    let sides = || vec![side(&builder::run(&[4.0, 6.0])), side(&run)];
    let c = Comparison::new(sides(), false);
    for measure in Measure::ALL {
        let ratio = c.row(measure).ratio(1);
        let is_none = measure.is_of_a_node() || measure == Measure::Node;
        assert_eq!(ratio.is_none(), is_none, "{}", measure.name());
        assert!(c.row(measure).values[1].is_some(), "{}: the value stays", measure.name());
    }
    let text = document(&c, &[], None).terminal(100);
    assert!(text.contains("technology nodes differ (28 nm, 7 nm)"), "{text}");
    assert!(text.contains("--across-nodes"), "{text}");
    assert_eq!(c.labels_with_nodes(), ["gscore, 28 nm", "small, 7 nm"]);
    let asked = Comparison::new(sides(), true);
    let measures = Measure::ALL.into_iter().filter(|m| *m != Measure::Node);
    assert!(measures.into_iter().all(|m| asked.row(m).ratio(1).is_some()));
    // Where a table does not say its node, nobody can tell.
    run.facts.machine.node_nm = None;
    let unknown = Comparison::new(vec![side(&builder::run(&[4.0, 6.0])), side(&run)], false);
    assert!(unknown.row(Measure::Area).ratio(1).is_some());
    let same = Comparison::new(vec![side(&builder::run(&[4.0])), side(&slower(2.0))], false);
    let text = document(&same, &[], None).terminal(100);
    assert!(!text.contains("nodes"), "{text}");
    assert_eq!(same.labels_with_nodes(), ["gscore", "slow"]);
}

#[test]
fn a_folder_says_the_same_as_the_run() {
    let run = builder::garden();
    let toml = record::run_toml(&run).expect("TOML");
    let results = csv::results(&run);
    let mut read = Side::of_folder("folder", &toml, &results).expect("a report");
    read.label = "gscore".into();
    assert_eq!(read, side(&run));
}

#[test]
fn broken_folders_name_file_and_place() {
    let run = builder::run(&[4.0]);
    let toml = record::run_toml(&run).expect("TOML");
    let results = csv::results(&run);
    let text = String::from_utf8(results.clone()).expect("text");
    let read = |toml: &str, csv: &str| match Side::of_folder("x", toml, csv.as_bytes()) {
        Ok(_) => panic!("it was taken"),
        Err(e) => e.to_string(),
    };
    assert!(read("not toml", &text).starts_with("run.toml: "));
    assert!(read("", &text).contains("`inputs`"));
    assert!(read(&toml, "").contains("no row `mean`"));
    let cut: String = text.lines().take(2).map(|l| format!("{l}\n")).collect();
    assert!(read(&toml, &cut).contains("no row `mean`"));
    let means = text.lines().find(|l| l.starts_with("mean")).expect("means");
    let garbled = text.replace(means, &means.replacen("4,", "many,", 1));
    let message = read(&toml, &garbled);
    assert!(message.contains("row `mean`, column `frame_time_ms`: `many`"), "{message}");
    // A row may end anywhere.
    for end in (0..text.len()).step_by(97) {
        let _ = Side::of_folder("x", &toml, &results[..end]);
        let _ = Side::of_folder("x", &toml[..end.min(toml.len())], &results);
    }
    let huge = text.replace(means, &means.replacen("4,", "1e999,", 1));
    let huge = Side::of_folder("x", &toml, huge.as_bytes());
    assert!(matches!(huge, Err(SideError::Cell { .. })));
}

#[test]
fn what_else_differs_is_said() {
    assert_eq!(pair().notes, []);
    let mut other = slower(1.0);
    other.facts.machine.energy_table = "lpddr4".into();
    other.facts.display_fps = 72.0;
    other.facts.inputs[0].xxh3 = 7;
    other.facts.trace.frames = 9;
    let notes = Comparison::new(vec![side(&builder::run(&[4.0, 6.0])), side(&other)], false).notes;
    let notes: Vec<String> = notes.iter().map(note).collect();
    let said = |what: &str| notes.iter().any(|n| n.starts_with(what));
    for what in ["traces differ", "energy tables differ", "display rates differ (60, 72)"] {
        assert!(said(what), "{what}: {notes:?}");
    }
    assert!(said("slow is INCOMPLETE: 2 frames only"), "{notes:?}");
}

#[test]
fn text_fits_for_any_number_of_sides() {
    let mut run = slower(1.5);
    run.facts.machine.name = "a-machine-of-a-very-long-name-indeed".into();
    for n in 2..8 {
        let sides = (0..n).map(|_| side(&run)).collect();
        let text = document(&Comparison::new(sides, false), &[], Some("reports/x/summary.md"))
            .terminal(80);
        for line in text.lines() {
            assert!(line.chars().count() <= 80, "{n}: {line}");
            assert_eq!(line, line.trim_end());
        }
    }
}

#[test]
fn terminal_of_two() {
    expect_test::expect_file!["compare.txt"].assert_eq(&document(&pair(), &[], None).terminal(80));
}

#[test]
fn page_csv_json_and_record() {
    let c = pair();
    let charts = charts(&c, Some(0.5));
    assert_eq!(charts.iter().map(|c| c.name).collect::<Vec<_>>(), ["power", "cycles"]);
    for chart in &charts {
        assert_eq!(covered(chart), Vec::<String>::new());
        let svg = chart.svg(Style::default()).expect("SVG");
        assert!(svg.contains("slow") && !svg.contains("NaN"), "{}", chart.name);
    }
    let page = document(&c, &charts, None).markdown(Format::Png);
    assert!(page.contains("| frames per second | 200 | 100 | -100 | 0.500 |"), "{page}");
    let bytes = compare_csv(&c);
    let mut reader = ::csv::Reader::from_reader(bytes.as_slice());
    let head = reader.headers().expect("a head").clone();
    assert_eq!(head, vec!["kind", "name", "gscore", "slow", "slow/gscore"]);
    let row = reader.records().map(|r| r.expect("a row")).find(|r| &r[1] == "throughput_fps");
    assert_eq!(row.expect("it").iter().skip(2).collect::<Vec<_>>(), ["200", "100", "0.5"]);
    let json = json(&c);
    assert_eq!(json["sides"][1]["label"], "slow");
    assert_eq!(json["measures"][0]["ratios"][1], 2.0);
    assert!(json["means"]["energy_pj.total"][0].is_number());
    let record: toml::Table = run_toml(&c).expect("TOML").parse().expect("TOML");
    assert_eq!(record["sides"][0]["record"]["facts"]["machine"].as_str(), Some("gscore"));
}
