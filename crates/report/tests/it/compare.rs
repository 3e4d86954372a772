//! Runs beside each other.

use powergs_base::quantity::SquareMillimetres;
use powergs_chart::{Chart, Format, Style};
use powergs_core::flow::Task;
use powergs_core::flow::steps::Updated;
use powergs_report::compare::{
    Decided, charts, compare_csv, decision_csv, decision_json, document, document_of, json, note,
    run_toml,
};
use powergs_report::document::Document;
use powergs_report::{csv, record};
use powergs_study::findings::compare::{
    Across, AskedLimits, Basis, Comparison, Decision, Measure, Note, Shortfall, Side, SideError,
};
use powergs_study::run_record::Run;
use powergs_study::speedup::{Gain, SpeedUp};
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
    Comparison::new(vec![side(&builder::run(&[4.0, 6.0])), side(&slower(2.0))], Across::default())
}

/// The page, with nothing asked for but the display rate.
fn page(comparison: &Comparison, charts: &[Chart], folder: Option<&str>) -> Document {
    let limits = AskedLimits::default();
    let decision = Decision::of(std::slice::from_ref(comparison), &limits).expect("no condition");
    document(comparison, Decided { decision: &decision, limits: &limits }, charts, folder)
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
    let c = Comparison::new(vec![of(5.0, 4.0), of(10.0, 1.0)], Across::default());
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
    let c = Comparison::new(sides(), Across::default());
    for measure in Measure::ALL {
        let ratio = c.row(measure).ratio(1);
        let is_none = measure.is_of_a_node() || measure == Measure::Node;
        assert_eq!(ratio.is_none(), is_none, "{}", measure.name());
        assert!(c.row(measure).values[1].is_some(), "{}: the value stays", measure.name());
    }
    let text = page(&c, &[], None).terminal(100);
    assert!(text.contains("technology nodes differ (28 nm, 7 nm)"), "{text}");
    assert!(text.contains("--across-nodes"), "{text}");
    assert_eq!(c.labels_with_nodes(), ["gscore, 28 nm", "small, 7 nm"]);
    let asked = Comparison::new(sides(), Across { nodes: true, tasks: false });
    let measures = Measure::ALL.into_iter().filter(|m| *m != Measure::Node);
    assert!(measures.into_iter().all(|m| asked.row(m).ratio(1).is_some()));
    // Where a table does not say its node, nobody can tell.
    run.facts.machine.node_nm = None;
    let unknown =
        Comparison::new(vec![side(&builder::run(&[4.0, 6.0])), side(&run)], Across::default());
    assert!(unknown.row(Measure::Area).ratio(1).is_some());
    let same =
        Comparison::new(vec![side(&builder::run(&[4.0])), side(&slower(2.0))], Across::default());
    let text = page(&same, &[], None).terminal(100);
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
    assert_eq!(pair().notes, [Note::Memories(vec![51.2, 25.6])]);
    let mut other = slower(1.0);
    other.facts.machine.energy_table = "lpddr4".into();
    other.facts.display_fps = 72.0;
    other.facts.inputs[0].xxh3 = 7;
    other.facts.trace.frames = 9;
    let notes =
        Comparison::new(vec![side(&builder::run(&[4.0, 6.0])), side(&other)], Across::default())
            .notes;
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
        let text =
            page(&Comparison::new(sides, Across::default()), &[], Some("reports/x/summary.md"))
                .terminal(80);
        for line in text.lines() {
            assert!(line.chars().count() <= 80, "{n}: {line}");
            assert_eq!(line, line.trim_end());
        }
    }
}

#[test]
fn terminal_of_two() {
    expect_test::expect_file!["compare.txt"].assert_eq(&page(&pair(), &[], None).terminal(80));
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
    let text = page(&c, &charts, None).markdown(Format::Png);
    assert!(text.contains("| frames per second | 200 | 100 | -100 | 0.500 |"), "{text}");
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

/// A run of steps in place of frames.
fn task(millions: &[f64], name: &str, task: &str) -> Run {
    let mut run = builder::run(millions);
    let task = Task::named(task).expect("a task");
    run.facts.machine.name = name.into();
    run.facts.machine.task = task;
    for frame in &mut run.frames {
        let powergs_core::sim::ModelReport::Cycle(cycle) = &mut frame.model else { continue };
        cycle.task = task;
        frame.display_w = frame.display_w.filter(|_| task.is_shown());
    }
    run
}

#[test]
fn frames_and_steps_are_not_put_into_ratios() {
    let sides = |other: &str| {
        vec![side(&builder::run(&[4.0, 6.0])), side(&task(&[20.0, 30.0], "trainer", other))]
    };
    let c = Comparison::new(sides("train all"), Across::default());
    assert_eq!(c.task(), None);
    for measure in Measure::ALL {
        let is_none = measure.is_of_a_task() || measure == Measure::Node;
        assert_eq!(c.row(measure).ratio(1).is_none(), is_none, "{}", measure.name());
    }
    // A step has no display: neither a rate of it nor a power at it, and no missed period, though
    // it takes 25 ms.
    assert_eq!(c.row(Measure::Displayed).values[1], None);
    assert_eq!(c.row(Measure::Power).values[1], None);
    assert_eq!(c.sides[1].statistics.deadline_misses(), None);
    assert!(!c.sides[1].statistics.misses());
    let text = page(&c, &[], None).terminal(100);
    assert!(text.contains("tasks differ (render, train all)"), "{text}");
    assert!(text.contains("frames or steps per second"), "{text}");
    assert!(!text.contains("MISSES"), "{text}");
    // Its watts are at no display rate, and do not stand in that column.
    let row = text.lines().find(|line| line.starts_with("trainer")).expect("a row");
    assert_eq!(row.split_whitespace().nth(4), Some("-"), "{row}");
    let asked = Comparison::new(sides("train all"), Across { tasks: true, nodes: false });
    assert!(asked.row(Measure::Throughput).ratio(1).is_some());
    // The opposite: the same task has ratios and no note, and steps are called so.
    let steps =
        || vec![side(&task(&[4.0], "a", "train all")), side(&task(&[8.0], "b", "train all"))];
    let same = Comparison::new(steps(), Across::default());
    assert!(same.row(Measure::Throughput).ratio(1).is_some());
    let text = page(&same, &[], None).terminal(100);
    assert!(text.contains("steps per second") && !text.contains("tasks differ"), "{text}");
    assert!(!text.contains("60 Hz") && !text.contains("FPS"), "{text}");
    // So are steps that see other pixels, or update others.
    for other in ["track, 1 pixel in 256", "train visible", "gradients", "track"] {
        let c = Comparison::new(
            vec![side(&task(&[4.0], "a", "train all")), side(&task(&[8.0], "b", other))],
            Across::default(),
        );
        assert_eq!(c.row(Measure::Energy).ratio(1), None, "{other}");
    }
}

#[test]
fn tasks_are_read_as_they_are_written() {
    let all = [
        Task::RENDER,
        Task { one_in: 256, ..Task::RENDER },
        Task::new(Some(Updated::All), &Default::default()),
        Task::new(Some(Updated::Visible), &Default::default()),
        Task::new(Some(Updated::None), &Default::default()),
        Task::new(Some(Updated::Pose), &Default::default()),
    ];
    for task in all {
        assert_eq!(Task::named(&task.name()), Some(task));
    }
    assert_eq!(Task::named("sleep"), None);
}

#[test]
fn speed_ups_of_other_tasks_are_withheld() {
    let trace = |ms: f64| {
        let sides =
            vec![side(&builder::run(&[ms])), side(&slower(2.0)), side(&task(&[ms], "t", "track"))];
        Comparison::new(sides, Across::default())
    };
    let all = [trace(4.0), trace(5.0)];
    let speedup = SpeedUp::of_comparisons(&all).expect("two traces");
    assert!(speedup.mean(Gain::Speed, 1).is_some());
    assert_eq!(speedup.mean(Gain::Speed, 2), None);
    assert_eq!(speedup.mean(Gain::Energy, 2), None);
}

/// Two frames under way at a time: one each 5 ms, and each takes 10.
#[test]
fn an_interval_is_not_a_latency() {
    let mut run = builder::run(&[4.0, 6.0]);
    run.facts.machine.name = "two".into();
    for frame in &mut run.frames {
        let powergs_core::sim::ModelReport::Cycle(cycle) = &mut frame.model else { continue };
        cycle.latency = 2 * cycle.timing.frame;
    }
    let c = Comparison::new(vec![side(&builder::run(&[4.0, 6.0])), side(&run)], Across::default());
    same(value(&c, Measure::FrameTime, 1), 5.0);
    same(value(&c, Measure::Latency, 1), 10.0);
    let text = page(&c, &[], None).terminal(100);
    assert!(text.contains("frame interval, ms") && text.contains("frame latency, ms"), "{text}");
    let text = page(&pair(), &[], None).terminal(100);
    assert!(text.contains("frame time, ms") && !text.contains("latency"), "{text}");
    // A limit is on the latency, the display on the interval.
    let limits = AskedLimits { latency_ms: Some(11.0), ..AskedLimits::default() };
    let short = |limits: &AskedLimits| {
        Decision::of(std::slice::from_ref(&c), limits)
            .expect("no condition")
            .row(0, 1)
            .short
            .clone()
    };
    assert_eq!(short(&limits), [Shortfall::Latency { ms: 12.0 }]);
    assert_eq!(short(&AskedLimits { latency_ms: Some(12.0), ..AskedLimits::default() }), []);
}

#[test]
fn who_meets_what_is_decided_by_all_that_is_asked() {
    let of = |ms: &[f64], name: &str| {
        let mut run = builder::run(ms);
        run.facts.machine.name = name.into();
        side(&run)
    };
    // The second machine misses 60 FPS with one frame of the second trace.
    let trace = |slow: f64| {
        Comparison::new(vec![of(&[4.0, 6.0], "a"), of(&[8.0, slow], "b")], Across::default())
    };
    let all = [trace(9.0), trace(17.0)];
    let decided = |limits: &AskedLimits| Decision::of(&all, limits).expect("a decision");
    let decision = decided(&AskedLimits::default());
    assert_eq!(decision.row(0, 1).short, []);
    assert_eq!(decision.row(1, 1).short, [Shortfall::Rate { missed: 1 }]);
    let (gain, on) = decision.power_gain(1).expect("one trace");
    let watts = |i: usize| all[0].row(Measure::Power).values[i].expect("a power");
    same(gain, watts(0) / watts(1));
    assert_eq!(on, 1, "powers are held against each other where both meet the rate");
    // Nothing is met: nothing is gained.
    let none = decided(&AskedLimits { budget_w: Some(1e-6), ..AskedLimits::default() });
    assert_eq!(none.power_gain(1), None);
    assert!(none.rows.iter().all(|row| !row.is_met()));
    let rich = decided(&AskedLimits { budget_w: Some(1e6), ..AskedLimits::default() });
    assert_eq!(rich.rows, decision.rows);
    let condition = |text: &str| AskedLimits {
        condition: Some(text.parse().expect("a condition")),
        ..AskedLimits::default()
    };
    let met = decided(&condition("frame_time_ms.max <= 8 && area_mm2.total > 1"));
    let is_met: Vec<bool> = met.rows.iter().map(|row| row.is_met()).collect();
    assert_eq!(is_met, [true, false, true, false]);
    assert!(Decision::of(&all, &condition("no_such_thing < 1")).is_err());
    assert!(Decision::of(&all, &condition("frame_time_ms")).is_err());
    // Where a model knows no time, nobody can tell whether it keeps up.
    let paper = builder::paper();
    let timeless = Comparison::new(vec![of(&[4.0], "a"), side(&paper)], Across::default());
    let found = Decision::of(&[timeless], &AskedLimits::default()).expect("a decision");
    assert_eq!(found.row(0, 1).short, [Shortfall::NoTime]);
    assert_eq!(found.power_gain(1), None);
    // The page begins with it, and files have it.
    let speedup = SpeedUp::of_comparisons(&all).expect("two traces");
    let limits = AskedLimits::default();
    let decided = Decided { decision: &decision, limits: &limits };
    let text = document_of(&all, decided, &speedup, &[], None).terminal(80);
    let first = text.lines().next().expect("a line");
    assert!(first.contains("FPS") && first.contains("slowest, ms"), "{text}");
    assert!(text.contains("MISSED 1/2") && text.contains("on the 1 of 2 traces"), "{text}");
    let csv = String::from_utf8(decision_csv(&all, &decision, &speedup.traces)).expect("text");
    assert_eq!(csv.lines().count(), 5);
    let json = decision_json(&all, &decision, &speedup.traces);
    assert_eq!(json[3]["missed"], 1);
    assert_eq!(json[3]["is_met"], false);
}

#[test]
fn a_module_is_no_block() {
    let of = |scope: &str, name: &str| {
        let mut run = builder::run(&[4.0]);
        run.facts.machine.name = name.into();
        run.facts.configuration = toml::from_str(scope).expect("a table");
        side(&run)
    };
    let (block, module) = ("[energy]", "[energy.scope]\narea = \"soc\"\npower = \"module\"");
    let c = Comparison::new(vec![of(block, "a"), of(module, "b")], Across::default());
    for measure in [Measure::Area, Measure::FpsPerArea, Measure::Energy, Measure::Power] {
        assert_eq!(c.row(measure).ratio(1), None, "{}", measure.name());
    }
    assert_eq!(c.row(Measure::AreaCore).values[1], None, "an SoC has no core that papers print");
    assert!(c.row(Measure::FrameTime).ratio(1).is_some());
    let parts: Vec<Basis> = c.basis().into_iter().map(|(part, _)| part).collect();
    assert_eq!(parts, [Basis::AreaScope, Basis::PowerScope]);
    let across = Across { nodes: true, tasks: false };
    let asked = Comparison::new(vec![of(block, "a"), of(module, "b")], across);
    assert!(asked.row(Measure::Energy).ratio(1).is_some());
    assert_eq!(asked.row(Measure::Area).ratio(1), None, "a die of other things stays one");
    let same = Comparison::new(vec![of(module, "a"), of(module, "b")], Across::default());
    assert!(same.row(Measure::Area).ratio(1).is_some() && same.basis().is_empty());
}

#[test]
fn a_starved_second_master_is_said() {
    let of = |gets: f64, name: &str| {
        let mut run = builder::run(&[4.0]);
        run.facts.machine.name = name.into();
        run.facts.configuration =
            toml::from_str("[machine.dram.second-master]\nrate = \"10 GB/s\"").expect("a table");
        for frame in &mut run.frames {
            let powergs_core::sim::ModelReport::Cycle(cycle) = &mut frame.model else { continue };
            let seconds = cycle.timing.frame as f64 / cycle.clock.0;
            cycle.timing.dram.master_bytes[0] = (gets * 1e9 * seconds) as u64;
        }
        side(&run)
    };
    let text = |gets| {
        let c = Comparison::new(vec![of(10.0, "a"), of(gets, "b")], Across::default());
        page(&c, &[], None).terminal(200)
    };
    assert!(text(4.0).contains("second master of b is STARVED: it gets 4.00 of 10.0 GB/s"));
    assert!(!text(10.0).contains("STARVED"));
}
