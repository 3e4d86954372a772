//! The engine in memory: the same table whatever the threads, parts and interruptions.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use powergs_core::run::{
    Change, Frames, MemoryFrames, MemoryStore, RunError, Session, Store, System, TraceFile, Watch,
};
use powergs_study::analysis::{Analysis, Objective, Question, Table};
use powergs_study::sweep::file::Objectives;
use powergs_study::sweep::gathered::{GatheredDesign, differences, gathered};
use powergs_study::sweep::outcome::Outcome;
use powergs_study::sweep::run::results::Results;
use powergs_study::sweep::run::{Shard, Sweep, SweepWatch};

/// Two frames of the demonstration.
fn frames() -> MemoryFrames {
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/../../traces/demo.bin");
    let mut trace = TraceFile::open(Path::new(demo)).unwrap();
    let frames = [0, 1].map(|k| trace.take(k).unwrap().get().unwrap());
    MemoryFrames { name: "demo".into(), frames: frames.into() }
}

/// Six designs of two geometries; of each machine there are two, which differ in prices only.
fn sweep() -> Sweep {
    Sweep::over(System::named("gscore").unwrap())
        .axis("vru.cores", [2, 4])
        .axis("geometry.chunk", [128, 256])
        .axis("gating.units", [false, true])
        .constraint("vru.cores * geometry.chunk <= 768")
}

fn on_threads(threads: usize, store: &MemoryStore, watch: &dyn SweepWatch) -> Results {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| sweep().run(&mut frames(), store, watch).unwrap())
}

/// Stops after some machine frames.
struct Until(AtomicU64);

impl Watch for Until {
    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }

    fn simulated(&self, _: u64) {
        let less = |left: u64| Some(left.saturating_sub(1));
        let _ = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
    }
}

impl SweepWatch for Until {}

#[test]
fn the_table_is_the_same_for_any_number_of_threads() {
    let one = on_threads(1, &MemoryStore::new(), &());
    assert!(one.is_complete && one.tally.ok == 6 && one.tally.failed == 0, "{:?}", one.tally);
    assert_eq!(one.means().count(), 7);
    assert_eq!(one, on_threads(4, &MemoryStore::new(), &()));
}

#[test]
fn one_frame_in_memory_at_a_time_gives_the_same_table() {
    let all = on_threads(2, &MemoryStore::new(), &());
    let one = sweep().memory(1).run(&mut frames(), &MemoryStore::new(), &()).unwrap();
    assert_eq!(all, one);
}

#[test]
fn a_cancelled_run_continues_where_it_was() {
    let store = MemoryStore::new();
    let part = on_threads(1, &store, &Until(AtomicU64::new(2)));
    assert!(!part.is_complete && part.tally.missing > 0, "{:?}", part.tally);
    let done = store.journals("records", None).unwrap().len();
    assert!(done > 0);
    let whole = on_threads(1, &store, &());
    assert_eq!(whole, on_threads(1, &MemoryStore::new(), &()));
}

#[test]
fn parts_make_the_table_together() {
    let store = MemoryStore::new();
    for number in 1..=3 {
        let part = Shard { number, of: 3 };
        assert!(sweep().run_part(part, &mut frames(), &store, &()).unwrap());
    }
    let before = store.journals("records", None).unwrap().len();
    let whole = on_threads(1, &store, &());
    assert_eq!(store.journals("records", None).unwrap().len(), before, "nothing was left to do");
    assert_eq!(whole, on_threads(1, &MemoryStore::new(), &()));
}

#[test]
fn a_store_of_another_sweep_is_refused() {
    let store = MemoryStore::new();
    on_threads(1, &store, &());
    let other = sweep().axis("ccu.units", [1, 2]).run(&mut frames(), &store, &());
    assert!(matches!(other, Err(RunError::Output { .. })), "{other:?}");
}

#[test]
fn the_changes_of_the_base_system_are_kept() {
    let change = Change::machine("vru.units-per-core", 8);
    let base = System::named("gscore").unwrap().with(&[change]).unwrap();
    let changed = Sweep::over(base).axis("vru.cores", [2, 4]);
    let changed = changed.run(&mut frames(), &MemoryStore::new(), &()).unwrap();
    let plain = Sweep::over(System::named("gscore").unwrap()).axis("vru.cores", [2, 4]);
    let plain = plain.run(&mut frames(), &MemoryStore::new(), &()).unwrap();
    let area = |results: &Results| results.number(&results.rows[0], "area_mm2").unwrap();
    assert!(area(&changed) < area(&plain));
}

#[test]
fn a_table_in_memory_answers_as_its_csv_does() {
    let results = on_threads(2, &MemoryStore::new(), &());
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(results.columns.iter().map(|c| &c.name)).unwrap();
    for row in &results.rows {
        csv.write_record(row.iter().map(|cell| cell.text())).unwrap();
    }
    let csv = csv.into_inner().unwrap();
    let question = Question::of(Objectives::default().all());
    let read = Table::read(csv.as_slice(), |column| question.needs(column)).unwrap();
    let made = Table::of(&results, &question).unwrap();
    assert_eq!(read, made);
    assert!(!Analysis::of(&made, &question).unwrap().front.is_empty());
}

#[test]
fn a_table_that_was_kept_is_read_back() {
    let store = MemoryStore::new();
    let mut frames = frames();
    let sweep = sweep();
    let mut opened = sweep.open(&mut frames).unwrap();
    let results = opened.run(&store, usize::MAX, &()).unwrap();
    results.keep(&opened, &store).unwrap();
    let text = store.read_text("results.csv").unwrap().expect("a table");
    let read = Results::read(text.as_bytes()).unwrap();
    assert_eq!(read.tally, results.tally);
    assert_eq!(read.columns, results.columns);
    assert_eq!(read.rows, results.rows);
    let other = Results::read("a,b\n1,2\n".as_bytes());
    assert!(other.is_err_and(|e| e.to_string().contains("`point`")));
}

/// Outcomes of machines that were replayed one by one.
fn replayed(system: &System, frames: &mut MemoryFrames) -> Outcome {
    let mut session = Session::new(frames, &());
    let reports = session.reports(std::slice::from_ref(system)).unwrap().remove(0);
    Outcome::of(&reports, 60.0).expect("frames")
}

#[test]
fn machines_that_were_replayed_make_the_table_of_a_sweep() {
    let base = System::named("gscore").unwrap();
    let cores = |n: u32| base.with(&[format!("vru.cores={n}").parse::<Change>().unwrap()]).unwrap();
    let systems = [base.clone(), cores(2), cores(8)];
    let names: Vec<&System> = systems.iter().collect();
    let mut designs = Vec::new();
    for (i, (system, settings)) in names.iter().zip(differences(&names)).enumerate() {
        assert_eq!(settings.len(), 1, "{settings:?}");
        let ran = Ok((*system, vec![replayed(system, &mut frames())]));
        let values = vec![vec![Some(i as f64)]];
        designs.push(GatheredDesign { point: (i as u64).checked_sub(1), settings, ran, values });
    }
    let wrong = Err("no such machine".to_owned());
    designs.push(GatheredDesign { point: Some(2), settings: vec![], ran: wrong, values: vec![] });
    let ours = gathered(&designs, &["demo".into()], &["mine".into()]);
    let plain = Sweep::over(base.clone()).axis("vru.cores", [2, 8]);
    let its = plain.run(&mut frames(), &MemoryStore::new(), &()).unwrap();
    // The table of the sweep, with a column and a design more.
    assert_eq!(ours.columns[..its.columns.len()], its.columns);
    for (own, row) in ours.rows.iter().zip(&its.rows) {
        for (i, column) in its.columns.iter().enumerate().filter(|(_, c)| c.name != "id") {
            assert_eq!(own[i], row[i], "{}", column.name);
        }
    }
    assert_eq!((ours.tally.ok, ours.tally.invalid), (2, 1));
    let mine: Vec<f64> = ours.means().filter_map(|row| ours.number(row, "mine")).collect();
    assert_eq!(mine, [0.0, 1.0, 2.0]);
    let question = Question::of(vec![Objective::minimize("mine")]);
    let table = Table::of(&ours, &question).unwrap();
    assert_eq!(Analysis::of(&table, &question).unwrap().front.len(), 1);
}
