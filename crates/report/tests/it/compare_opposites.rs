//! What a comparison concludes, beside sides of which the opposite is true.

use powergs_core::flow::steps::Updated;
use powergs_core::flow::{Task, TaskKind};
use powergs_report::compare::{Decided, caveats, compare_csv, document};
use powergs_study::findings::compare::{
    Across, AskedLimits, Comparison, Decision, Measure, Note, Shortfall, Side,
};
use powergs_study::findings::limits::not_modelled;
use powergs_study::run_record::Run;

use crate::builder;

/// Two sides that are equal but for what is changed of the second.
fn beside(change: impl Fn(&mut Run)) -> Comparison {
    across(change, Across::default())
}

fn across(change: impl Fn(&mut Run), across: Across) -> Comparison {
    let [a, mut b] = [builder::run(&[4.0, 6.0]), builder::run(&[4.0, 6.0])];
    b.facts.machine.name = "other".into();
    change(&mut b);
    let sides = [a, b].map(|run| Side::of_run(&run).expect("frames"));
    Comparison::new(sides.to_vec(), across)
}

fn text(comparison: &Comparison, limits: &AskedLimits) -> String {
    let decision = Decision::of(std::slice::from_ref(comparison), limits).expect("a decision");
    document(comparison, Decided { decision: &decision, limits }, &[], None).terminal(200)
}

fn nothing_asked() -> AskedLimits {
    AskedLimits::default()
}

fn trains(run: &mut Run) {
    run.facts.machine.task = Task { kind: TaskKind::Train(Updated::All), one_in: 1 };
}

/// The ratios of a row of `compare.csv`, by its name.
fn csv_ratio(comparison: &Comparison, name: &str) -> String {
    let csv = String::from_utf8(compare_csv(comparison)).expect("text");
    let row = csv.lines().find(|line| line.split(',').nth(1) == Some(name));
    let row = row.unwrap_or_else(|| panic!("no row {name}"));
    row.rsplit(',').next().expect("a cell").to_owned()
}

#[test]
fn files_have_no_ratio_that_pages_withhold() {
    let names = ["energy_per_frame_mj", "energy_pj.total", "power_w.total", "throughput_fps"];
    let has = |c: &Comparison| names.map(|name| !csv_ratio(c, name).is_empty());
    assert_eq!(has(&beside(|_| ())), [true; 4]);
    let node = |run: &mut Run| run.facts.machine.node_nm = Some(7.0);
    assert_eq!(has(&beside(node)), [false, false, false, true], "of another node");
    assert!(csv_ratio(&beside(node), "area_mm2.total").is_empty());
    let asked = Across { nodes: true, tasks: false };
    assert_eq!(has(&across(node, asked)), [true; 4]);
    assert_eq!(has(&beside(trains)), [false; 4], "of another task");
    assert!(csv_ratio(&beside(trains), "dram_read_bytes").is_empty());
}

#[test]
fn powers_are_compared_at_one_rate() {
    let ratio = |c: &Comparison| c.row(Measure::Power).ratio(1);
    assert!(ratio(&beside(|_| ())).is_some());
    let slow = |run: &mut Run| {
        let slow = builder::run(&[4.0, 20.0]);
        run.frames = slow.frames;
    };
    let c = beside(slow);
    assert_eq!(ratio(&c), None, "one of its frames is missed");
    assert_eq!(c.row(Measure::Displayed).ratio(1), None);
    assert!(c.row(Measure::Energy).ratio(1).is_some(), "a frame is a frame");
    let words = text(&c, &nothing_asked());
    assert!(words.contains("W at ≤ 60 FPS") && words.contains("or what is reached"), "{words}");
    let c = beside(|run| run.facts.display_fps = 30.0);
    assert_eq!(ratio(&c), None, "another display");
    let words = text(&c, &nothing_asked());
    assert!(words.contains("W at own rate") && words.contains("of its own display"), "{words}");
    assert!(!words.contains("times less power") && !words.contains("the power of"), "{words}");
    let words = text(&beside(|_| ()), &nothing_asked());
    assert!(words.contains("W at 60 FPS") && words.contains("the power of gscore"), "{words}");
}

#[test]
fn who_meets_nothing_has_no_gain_beside_it() {
    let c = beside(|_| ());
    let met = text(&c, &nothing_asked());
    assert!(met.contains("meets all") && !met.contains("on no trace"), "{met}");
    let all = AskedLimits { budget_w: Some(1e-6), ..nothing_asked() };
    let none = text(&c, &all);
    assert!(none.contains("on no trace, so no power is compared with it"), "{none}");
    assert!(none.contains("OVER") && !none.contains("the power of"), "{none}");
}

#[test]
fn limits_hold_for_trainers_too() {
    let [a, b] = ["one", "two"].map(|name| {
        let mut run = builder::run(&[4.0, 6.0]);
        run.facts.machine.name = name.into();
        trains(&mut run);
        Side::of_run(&run).expect("frames")
    });
    let c = Comparison::new(vec![a, b], Across::default());
    let free = text(&c, &nothing_asked());
    assert!(!free.contains("Asked for") && !free.contains("verdict"), "{free}");
    let late = AskedLimits { latency_ms: Some(5.0), ..nothing_asked() };
    let late = text(&c, &late);
    assert!(late.contains("LATE 6.00 ms") && late.contains("at most 5.00 ms"), "{late}");
    assert!(!late.contains("a frame each"), "nobody shows a step: {late}");
    let met = AskedLimits { latency_ms: Some(7.0), ..nothing_asked() };
    assert!(text(&c, &met).contains("meets all"));
}

/// A renderer whose neighbour gets too little of the memory does not meet what its chip must.
#[test]
fn who_starves_another_meets_not_all() {
    let with = |gets: f64| {
        beside(|run| {
            run.facts.machine.masters.0[1] = 10.0;
            for frame in &mut run.frames {
                let powergs_core::sim::ModelReport::Cycle(cycle) = &mut frame.model else {
                    continue;
                };
                let seconds = cycle.timing.frame as f64 / cycle.clock.0;
                cycle.timing.dram.master_bytes[1] = (gets * 1e9 * seconds) as u64;
            }
            let table = "[machine.dram.third-master]\nrate = \"10 GB/s\"";
            run.facts.configuration = toml::from_str(table).expect("a table");
        })
    };
    let short = |c: &Comparison| {
        let decision = Decision::of(std::slice::from_ref(c), &nothing_asked()).expect("a decision");
        decision.row(0, 1).short.clone()
    };
    assert_eq!(short(&with(10.0)), []);
    let c = with(4.0);
    assert!(matches!(&short(&c)[..], [Shortfall::Starved(master)] if master.name == "third"));
    let words = text(&c, &nothing_asked());
    assert!(words.contains("STARVES 4.00 of 10.0 GB/s"), "{words}");
    assert!(words.contains("the third master of other is STARVED"), "{words}");
    // One that gets nothing at all is starved too.
    assert_eq!(short(&with(0.0)).len(), 1);
}

#[test]
fn what_one_side_does_or_has_for_nothing_is_said_of_it() {
    let c = beside(|run| {
        run.facts.machine.left_out.retain(|effect| effect.assumption != "A28");
    });
    let words = text(&c, &nothing_asked());
    assert!(words.contains("it alone has for nothing A28"), "{words}");
    let same = text(&beside(|_| ()), &nothing_asked());
    assert!(!same.contains("it alone"), "{same}");
    assert!(not_modelled().iter().any(|effect| effect.assumption == "A28"));
}

#[test]
fn notes_are_there_where_sides_differ_and_only_there() {
    let notes = |change: &dyn Fn(&mut Run)| beside(change).notes;
    assert_eq!(notes(&|_| ()), []);
    assert!(matches!(
        &notes(&|run| run.facts.machine.dram_peak_gb_s = Some(12.8))[..],
        [Note::Memories(_)]
    ));
    let table = |run: &mut Run| run.facts.machine.energy_table = "resident-28nm".into();
    assert!(matches!(&notes(&table)[..], [Note::EnergyTables(_)]));
    // A third side of another node does not silence the note on two tables of one node.
    let [a, mut b, mut far] = [(); 3].map(|()| builder::run(&[4.0, 6.0]));
    table(&mut b);
    far.facts.machine.node_nm = Some(7.0);
    far.facts.machine.energy_table = "gscore-7nm".into();
    let of = |runs: &[&Run]| {
        let sides = runs.iter().map(|run| Side::of_run(run).expect("frames")).collect();
        Comparison::new(sides, Across::default()).notes
    };
    let is_tables = |note: &Note| matches!(note, Note::EnergyTables(_));
    assert!(of(&[&a, &b, &far]).iter().any(is_tables));
    assert!(!of(&[&a, &far]).iter().any(is_tables), "tables of two nodes differ anyway");
    let lines = caveats(&beside(|run| run.facts.machine.dram_peak_gb_s = Some(12.8)));
    assert!(lines.iter().any(|line| line.starts_with("memories differ")), "{lines:?}");
}

#[test]
fn no_evidence_is_said_and_is_no_agreement() {
    let of = |machine: &str| {
        let c = beside(|run| run.facts.machine.name = machine.to_owned());
        text(&c, &nothing_asked())
    };
    assert!(of("splatonic").contains("splatonic:"), "a shipped machine has its line");
    assert!(!of("mine").contains("mine: no published"), "nothing is published of one's own");
    let missed = of("gsarch");
    assert!(missed.contains("gsarch-train"), "{missed}");
}
