//! `validate`: tables, verdicts, measuring, and a subset of the published rows.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use expect_test::expect_file;
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{System, SystemSpec, Watch};
use powergs_scene::synth::{Preset, generate};
use powergs_study::validate::numbers::baseline_csv;
use powergs_study::validate::run::{MEMORY, measure_on, of_any_scene, steps, value};
use powergs_study::validate::{
    Baseline, Built, Gap, MachineName, Metric, Parts, Row, Status, Tables, Tolerance, Verdict,
    headline, judge, measure, rows_of,
};
use powergs_views::{RenderedViews, rendered};

fn build(name: &MachineName) -> Built {
    let spec = SystemSpec { sets: name.sets.clone(), ..SystemSpec::named(&name.arch) };
    let system = System::load(&spec, &EmbeddedFiles);
    Built::new(system.unwrap_or_else(|e| panic!("{name}: {e}")))
}

fn machines(rows: &[&Row]) -> BTreeMap<MachineName, Built> {
    let names = rows.iter().flat_map(|r| [Some(&r.machine), r.against.as_ref()]).flatten();
    names.map(|name| (name.clone(), build(name))).collect()
}

/// Counts steps, and cancels once there are too many.
struct Counting {
    done: AtomicU64,
    most: u64,
}

impl Watch for Counting {
    fn is_cancelled(&self) -> bool {
        self.done.load(Ordering::Relaxed) >= self.most
    }

    fn simulated(&self, n: u64) {
        self.done.fetch_add(n, Ordering::Relaxed);
    }
}

/// The header of `published.csv` and one row.
fn published(cells: [&str; 5]) -> String {
    let [id, workload, against, metric, value] = cells;
    format!(
        "id,section,what,workload,machine,against,metric,published,tolerance,status,class,missing,\
         source,note\n{id},Section,what,{workload},gscore,{against},{metric},{value},10%,enforced,\
         ,,s,\n"
    )
}

const HEAD: &str = "name,preset,seed,width,height,views,path,eyes,quick,why\n";
const NONE: &str = "id,workload,ours\n";

fn parts(value: f64) -> Parts {
    Parts::from([(String::new(), value)])
}

#[test]
fn embedded_tables_are_complete() {
    let tables = Tables::embedded();
    assert!(tables.rows.len() > 40);
    for row in &tables.rows {
        assert!(!row.what.is_empty() && !row.source.is_empty(), "{}", row.id);
        if matches!(row.status, Status::KnownGap(_) | Status::Calibrated | Status::Dropped) {
            assert!(row.note.len() > 30, "{}: {} without a reason", row.id, row.status.name());
        }
        build(&row.machine);
        row.against.iter().for_each(|name| drop(build(name)));
        assert!(tables.before(row).is_some(), "{}: validate --bless", row.id);
    }
    for workload in &tables.workloads {
        let is_used = |row: &Row| row.workloads.contains(&workload.name);
        assert!(tables.rows.iter().any(is_used), "{} is not used", workload.name);
        assert!(workload.why.len() > 10, "{}", workload.name);
    }
}

/// Rows that must hold do, and known gaps exist, in what the command measured the last time. Where
/// a gain is less than half of what was published, the row says what is missing.
/// Rows that held once, and keep their status: the page says that they fail.
const FAILS: [&str; 1] = ["rtgs-buffer"];

#[test]
fn the_baseline_is_what_the_statuses_say() {
    let tables = Tables::embedded();
    for row in &tables.rows {
        let ours = tables.before(row);
        let judged = judge(row, ours, ours);
        let expected = match row.status {
            _ if FAILS.contains(&&*row.id) => Verdict::Fails,
            Status::Enforced | Status::Calibrated | Status::Plausibility => Verdict::Holds,
            Status::KnownGap(_) => Verdict::Gap,
            Status::Dropped => Verdict::Dropped,
        };
        let is_small = judged.share_of_gain().is_some_and(|share| share < 0.5);
        assert!(!is_small || row.gain.as_ref().is_some_and(|g| g.len() > 10), "{}", row.id);
        assert_eq!(judged.verdict, expected, "{}: {ours:?}", row.id);
    }
}

/// What needs no frame, and Lego with one view in place of four: a view is within a tenth of the
/// mean of four, so the tolerance is twice that of the row.
#[test]
fn a_subset_of_the_rows_holds() {
    let mut tables = Tables::embedded();
    tables.workloads.retain(|w| w.name == "lego");
    tables.workloads[0].views = 1;
    let wanted = |row: &&Row| {
        !row.metric.needs_frames() || ["nas-lego-fps", "nas-records"].contains(&&*row.id)
    };
    let rows: Vec<&Row> = tables.rows.iter().filter(wanted).collect();
    assert!(rows.len() > 5);
    let measured =
        measure(&tables, &rows, &machines(&rows), &rendered, MEMORY, &()).expect("no defect");
    let measured = measured.expect("not cancelled");
    for row in rows {
        let ours = value(row, &measured).unwrap_or_else(|| panic!("{}: not measured", row.id));
        let holds = if row.metric.needs_frames() {
            Tolerance::Share(0.2).holds(row.published, ours["lego"])
        } else {
            let verdict = judge(row, Some(&ours), None).verdict;
            !matches!(verdict, Verdict::Fails | Verdict::Closed)
        };
        assert!(holds, "{}: {ours:?} against {}", row.id, row.published);
    }
}

#[test]
fn measuring_is_deterministic_reports_steps_and_can_be_broken_off() {
    let rows = published(["a", "w", "gscore vru.cores=2", "speedup", "2"])
        + "b,Section,what,path,neo,,lists_keeping,0.9,10%,enforced,,,s,\n"
        + "c,Section,what,w path,gscore vru.cores=2,,tile_pairs,1,10%,enforced,,,s,\n";
    let workloads =
        format!("{HEAD}w,demo,1,96,80,2,0,0,true,why\npath,demo,1,96,80,2,200,0,false,why\n");
    let tables = Tables::parse(&rows, &workloads, NONE).expect("good tables");
    let rows: Vec<&Row> = tables.rows.iter().collect();
    let built = machines(&rows);
    let counting = Counting { done: AtomicU64::new(0), most: u64::MAX };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            measure(&tables, &rows, &built, &rendered, MEMORY, &counting)
                .expect("no defect")
                .unwrap()
        })
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one, three);
    // Two machines on two views of each workload; the warm-up goes through no machine.
    assert_eq!((steps(&tables, &rows), counting.done.into_inner()), (8, 16));
    let speedup = value(rows[0], &one).expect("both machines")["w"];
    assert!(speedup > 1.2, "four cores against two: {speedup}");
    let keeping = value(rows[1], &one).expect("a path")["path"];
    assert!((0.5..=1.0).contains(&keeping), "{keeping}");

    let pairs = value(rows[2], &one).expect("both workloads");
    assert_eq!(pairs.keys().collect::<Vec<_>>(), ["path", "w"]);
    let mean = judge(rows[2], Some(&pairs), None).ours.expect("a mean");
    assert!((mean - (pairs["w"] + pairs["path"]) / 2.0).abs() < 1e-12, "{mean}");

    for most in [0, 1, 3] {
        let stop = Counting { done: AtomicU64::new(0), most };
        assert!(
            measure(&tables, &rows, &built, &rendered, MEMORY, &stop).expect("no defect").is_none(),
            "{most}"
        );
    }
}

/// Rows of shares and ratios on frames of any source are what a session makes of them.
#[test]
fn scenes_of_ones_own_have_shares_and_ratios() {
    let more = "b,Section,what,w,gscore,,termination_saving,2,10%,enforced,,,s,\n\
                c,Section,what,w,gscore,,fps,2,10%,enforced,,,s,\n\
                d,Section,what,path,neo,,lists_keeping,0.9,10%,enforced,,,s,\n\
                e,Section,what,w,gscore,,termination_saving,2,,dropped,,,s,\n";
    let rows = published(["a", "w", "gscore vru.cores=2", "speedup", "2"]) + more;
    let workloads =
        format!("{HEAD}w,demo,1,96,80,2,0,0,true,why\npath,demo,1,96,80,2,200,0,false,why\n");
    let tables = Tables::parse(&rows, &workloads, NONE).expect("good tables");
    let all: Vec<&Row> = tables.rows.iter().collect();
    let rows = of_any_scene(&tables, &all);
    assert_eq!(rows.iter().map(|r| r.id.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    let built = machines(&rows);
    let measured = measure(&tables, &rows, &built, &rendered, MEMORY, &()).unwrap().unwrap();
    let preset = Preset::named("demo").unwrap();
    let scene = Arc::new(generate(preset, preset.points, 1));
    let mut views = RenderedViews::new("mine", scene, tables.workloads[0].cameras(preset));
    let values = measure_on(&mut views, &rows, &built, &()).unwrap().unwrap();
    assert_eq!(values.len(), 2);
    for row in rows {
        assert_eq!(values[&row.id], value(row, &measured).unwrap()["w"], "{}", row.id);
    }
}

#[test]
fn verdicts() {
    let text = published(["a", "", "", "area", "100"]);
    let tables = Tables::parse(&text, HEAD, NONE).unwrap();
    let enforced = tables.rows[0].clone();
    let with = |status| Row { status, ..enforced.clone() };
    let gap = with(Status::KnownGap(Gap::Workload));
    let check = |row: &Row, ours: Option<f64>, before: Option<f64>, verdict, bad| {
        let (ours, before) = (ours.map(parts), before.map(parts));
        let judged = judge(row, ours.as_ref(), before.as_ref());
        assert_eq!((judged.verdict, judged.is_bad()), (verdict, bad), "{ours:?} {before:?}");
    };
    check(&enforced, Some(110.0), None, Verdict::Holds, false);
    check(&enforced, Some(110.1), None, Verdict::Fails, true);
    check(&enforced, Some(89.9), Some(89.9), Verdict::Fails, true);
    check(&enforced, Some(105.0), Some(102.0), Verdict::Holds, true);
    check(&enforced, Some(105.0), Some(104.5), Verdict::Holds, false);
    check(&enforced, Some(97.0), Some(104.0), Verdict::Holds, false);
    check(&enforced, None, Some(100.0), Verdict::Open, false);
    check(&gap, Some(200.0), Some(200.5), Verdict::Gap, false);
    check(&gap, Some(200.0), Some(150.0), Verdict::Gap, true);
    check(&gap, Some(101.0), Some(200.0), Verdict::Closed, false);
    for status in [Status::Calibrated, Status::Plausibility] {
        check(&with(status), Some(110.0), None, Verdict::Holds, false);
        check(&with(status), Some(110.1), None, Verdict::Fails, true);
    }
    check(&with(Status::Plausibility), Some(89.9), Some(89.9), Verdict::Fails, false);
    check(&with(Status::Calibrated), Some(89.9), Some(89.9), Verdict::Fails, true);
    let dropped = Row { tolerance: None, ..with(Status::Dropped) };
    check(&dropped, Some(900.0), Some(100.0), Verdict::Dropped, false);

    let gain = Row { gain: Some(String::new()), published: 3.0, ..enforced.clone() };
    let share = |row, ours| judge(row, Some(&parts(ours)), None).share_of_gain();
    assert_eq!((share(&gain, 2.0), share(&gain, 0.5)), (Some(0.5), Some(-0.25)));
    assert_eq!(share(&enforced, 2.0), None);
}

#[test]
fn tolerances_and_machine_names() {
    let holds = |text, ours| Tolerance::parse(text).map(|t: Tolerance| t.holds(2.0, ours));
    assert_eq!(holds("10%", 2.2), Some(true));
    assert_eq!(holds("10 %", 1.79), Some(false));
    assert_eq!(holds("0.5..0.7", 0.7), Some(true));
    assert_eq!(holds("0.5..0.7", 2.0), Some(false));
    for bad in ["", "10", "x%", "-1%", "nan%", "2..1", "..", "1..inf"] {
        assert_eq!(Tolerance::parse(bad), None, "{bad}");
    }
    let name = MachineName::parse(" gscore  vru.cores=2 clock=1GHz").unwrap();
    assert_eq!(name.to_string(), "gscore vru.cores=2 clock=1GHz");
    assert_eq!(MachineName::parse("  "), None);
    for metric in Metric::all() {
        assert_eq!(Metric::named(&metric.name()), Some(metric));
    }
}

#[test]
fn the_baseline_keeps_what_was_not_measured() {
    let text = published(["a", "", "", "area", "1"])
        + "b,Section,what,,gscore,,area,1,10%,enforced,,,s,\n";
    let before = "# model version 3\nid,workload,ours\na,,1.5\nold,,3\n";
    let tables = Tables::parse(&text, HEAD, before).unwrap();
    let b = Baseline::from([("b".to_owned(), parts(2.0))]);
    let after = |measured, model| baseline_csv(&tables, measured, model);
    assert_eq!(after(&b, 3), "# model version 3\nid,workload,ours\na,,1.500000\nb,,2.000000\n");
    assert_eq!(Tables::parse(&text, HEAD, &after(&b, 3)).unwrap().baseline.len(), 2);
    // A part of the rows does not make the rest that of a new model; all rows do.
    assert_eq!(after(&b, 4), after(&b, 3));
    let both = Baseline::from([("a".to_owned(), parts(1.0)), ("b".to_owned(), parts(2.0))]);
    assert_eq!(after(&both, 4), "# model version 4\nid,workload,ours\na,,1.000000\nb,,2.000000\n");
}

#[test]
fn a_quick_run_has_areas_powers_and_small_scenes() {
    let tables = Tables::embedded();
    let quick: Vec<&Row> = tables.rows.iter().filter(|row| tables.is_quick(row)).collect();
    assert!(quick.len() > 10 && quick.len() < tables.rows.len());
    for row in quick {
        let is_small = |name: &String| ["lego", "train"].contains(&name.as_str());
        assert!(row.workloads.iter().all(is_small), "{}", row.id);
    }
}

fn fault(published: &str, workloads: &str, baseline: &str) -> String {
    Tables::parse(published, workloads, baseline).expect_err("a bad table").to_string()
}

#[test]
fn broken_tables_name_the_cell() {
    let good = published(["a", "", "", "area", "1"]);
    let lego = format!("{HEAD}w,lego,1,8,8,1,0,0,true,why\n");
    let with = |cells| fault(&published(cells), &lego, NONE);
    let all = [
        with(["a b", "", "", "area", "1"]),
        with(["a", "", "", "heat", "1"]),
        with(["a", "", "", "fps", "1"]),
        with(["a", "x", "", "fps", "1"]),
        with(["a", "w", "", "area", "1"]),
        with(["a", "w", "", "speedup", "1"]),
        with(["a", "w", "edge", "fps", "1"]),
        with(["a", "", "", "area", "inf"]),
        with(["a", "", "", "area", "many"]),
        fault(&good.replace("10%", "ten"), HEAD, NONE),
        fault(&good.replace("enforced", "hoped"), HEAD, NONE),
        fault(&good.replace("enforced,", "enforced,workload"), HEAD, NONE),
        fault(&good.replace("enforced,", "known_gap,laziness"), HEAD, NONE),
        fault(&good.replace("10%,enforced", "26%,enforced"), HEAD, NONE),
        fault(&good.replace("10%,enforced", "0.7..1.2,enforced"), HEAD, NONE),
        fault(&good.replace("enforced", "dropped"), HEAD, NONE),
        fault(&good.replace(",,s,", ",no queue,s,"), HEAD, NONE),
        with(["a", "w w", "", "fps", "1"]),
        fault(&good.replace(",gscore,", ",,"), HEAD, NONE),
        fault(&(good.clone() + good.lines().last().unwrap()), HEAD, NONE),
        fault(&good.replace("section,", ""), HEAD, NONE),
        fault("", HEAD, NONE),
        fault(&good, &lego.replace(",lego,", ",castle,"), NONE),
        fault(&good, &lego.replace(",8,8,", ",0,8,"), NONE),
        fault(&good, &lego.replace(",1,0,0,t", ",9,9,0,t"), NONE),
        fault(&good, &lego.replace("w,", "\u{0},\u{0},"), NONE),
        fault(&good, &lego.replace("true", "perhaps"), NONE),
        fault(&good, HEAD, "# model version four\nid,workload,ours\n"),
        fault(&good, HEAD, "id,workload,ours\na,,nan\n"),
        fault(&good, HEAD, "id,workload,ours\na,x,1\na,x,2\n"),
        fault(&good, HEAD, "id\na\n"),
    ];
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/validation-errors.txt");
    expect_file![path].assert_eq(&(all.join("\n") + "\n"));
}

#[test]
fn every_row_belongs_to_the_machine_that_it_names() {
    let tables = Tables::embedded();
    let names: std::collections::BTreeSet<&str> =
        tables.rows.iter().map(|row| row.machine.arch.as_str()).collect();
    let mut rows = 0;
    for name in names {
        let held = rows_of(name);
        assert!(held.rows.iter().all(|j| j.row.machine.sets.is_empty()), "{name}");
        assert!(held.variants.iter().all(|j| !j.row.machine.sets.is_empty()), "{name}");
        assert!(held.against.iter().all(|row| row.machine.arch != name), "{name}");
        rows += held.rows.len() + held.variants.len();
        let Some(missed) = headline(name) else { continue };
        assert_eq!(missed.row.id, held.rows[0].row.id, "the headline is the first row");
        assert!(missed.row.metric.is_of_frames(), "{name}: {}", missed.row.id);
        assert!(missed.verdict != Verdict::Holds, "{name}: {}", missed.row.id);
    }
    assert_eq!(rows, tables.rows.len());
    assert_eq!(headline("gsarch").map(|j| j.row.id.as_str()), Some("gsarch-train"));
    assert!(headline("no-such-machine").is_none() && rows_of("chang").rows.is_empty());
}
