//! Systems and sessions: what a change of a key does, and that a session is the plain loop.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use powergs_base::budget::Budget;
use powergs_base::quantity::Bytes;
use powergs_core::flow::tile_wise::measures;
use powergs_core::flow::{FrameTask, History};
use powergs_core::kernel::Memo;
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::frames::spread;
use powergs_core::run::{
    Change, FileKind, Frames, MemoryFrames, PaperModel, RunError, Session, Subject, System,
    SystemSpec, TraceFile, Watch,
};
use powergs_core::sim::{FrameReport, Label, priced, time};
use powergs_core::workload::demand::demand;
use powergs_core::workload::paper::Padding;
use powergs_core::workload::{FrameDetail, bin};
use powergs_dram::address_trace::Requests;

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../traces/demo.bin")
}

fn trace() -> TraceFile {
    TraceFile::open(&demo()).expect("the demo trace")
}

fn system(name: &str, changes: &[&str]) -> System {
    let changes: Result<Vec<Change>, String> = changes.iter().map(|c| c.parse()).collect();
    let named = System::named(name).expect("a machine");
    named.with(&changes.expect("changes")).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn refused(name: &str, change: &str) -> String {
    let change: Change = change.parse().expect("a change");
    let system = System::named(name).expect("a machine");
    let error = system.with_from(&[change], &EmbeddedFiles).expect_err("an invalid change");
    assert!(matches!(error, RunError::Config { .. }), "{error:?}");
    error.to_string()
}

#[test]
fn a_budget_changes_no_result_and_what_is_above_it_is_refused() {
    let systems = [system("gscore", &[]), system("gscore", &["geometry.test=aabb"])];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().expect("threads");
    let run = |mib: u64| {
        let mut frames = trace();
        frames.allow(Budget(Bytes(mib << 20)));
        pool.install(|| Session::new(&mut frames, &()).reports(&systems))
    };
    let free = run(1 << 20).expect("reports");
    let mut refusals = 0;
    for mib in [1, 2, 4, 8, 16, 32, 64] {
        match run(mib) {
            Ok(reports) => assert!(reports == free, "{mib} MiB"),
            Err(RunError::Input { message, .. }) => {
                assert!(message.contains("--memory \"1 GiB\""), "{message}");
                refusals += 1;
            }
            Err(other) => panic!("{other}"),
        }
    }
    assert!((1..7).contains(&refusals), "{refusals} of 7 refused");
}

/// The moves of lists take more than the lists themselves.
#[test]
fn lists_that_take_more_than_the_budget_are_refused() {
    let run = |method: &str| {
        let mut frames = trace();
        let first = frames.take(0).and_then(|pending| pending.get()).expect("a frame");
        let geometry = system("gscore", &[]).machine().tiles().geometry;
        let enough = demand(&first, geometry, FrameDetail::default(), Budget::DEFAULT)
            .expect("a small frame");
        frames.allow(Budget(Bytes(enough)));
        let method = format!("binning.impl={method}");
        let nothing = ["binning.pointers.capacity=0 B", "binning.combining.capacity=0 B"];
        let changes: Vec<&str> = match method.ends_with("free") {
            true => vec![&method],
            false => nothing.into_iter().chain([method.as_str()]).collect(),
        };
        let system = system("gscore", &changes);
        let on = Session::new(&mut frames, &()).frame_on(&system, 0).map(drop);
        frames.select(0, Some(1)).expect("the first frame");
        [on, Session::new(&mut frames, &()).reports(&[system]).map(drop)]
    };
    assert!(run("free").iter().all(Result::is_ok));
    for refused in run("append").into_iter().chain(run("two-pass")) {
        let refused = refused.expect_err("lists above the budget");
        assert!(matches!(refused, RunError::Incompatible { .. }), "{refused:?}");
        let text = refused.to_string();
        assert!(text.contains("tile lists of machine `gscore`"), "{text}");
        assert!(text.contains("allow more with --memory \"1 GiB\", or set"), "{text}");
    }
}

/// The plain loop: one machine, frame after frame.
fn by_hand(system: &System) -> Vec<FrameReport> {
    let mut frames = trace();
    let (machine, mut history) = (system.machine(), History::default());
    let one = |k: usize| {
        let frame = frames.take(k).and_then(|pending| pending.get()).expect("a frame");
        let workload = bin(&frame, machine.tiles().geometry);
        let (flow, memo) = (machine.flow(), Memo::default());
        let before = flow.hand_over(machine, &workload, None, &mut history);
        let name = frame.facts.camera.name.clone();
        let sh_degree = frame.facts.sh_degree;
        let label = Label { frame: k, name, sh_degree, ..Label::default() };
        let first = FrameTask::first(machine, &workload, &memo);
        let timed = time(&FrameTask { frame: k, before: before.as_ref(), ..first });
        priced(label, &timed.expect("accounts"), system.prices()).expect("accounts")
    };
    trace().range().map(one).collect()
}

#[test]
fn a_session_is_the_plain_loop_for_any_number_of_threads() {
    let systems = [
        system("gscore", &[]),
        system("neo", &[]),
        system("gscore", &["cache.capacity=32 KiB", "cache.ways=4"]),
        system("gscore", &["geometry.test=aabb"]),
        // Differs from the first in prices only: timed once.
        system("gscore", &["energy=gscore-7nm"]),
    ];
    let expected: Vec<Vec<FrameReport>> = systems.iter().map(by_hand).collect();
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let reports =
            pool.install(|| Session::new(&mut trace(), &()).reports(&systems).expect("reports"));
        assert_eq!(reports, expected, "{threads} threads");
    }
    let mut source = trace();
    let all: Vec<_> = source
        .range()
        .map(|k| source.take(k).and_then(|pending| pending.get()).expect("a frame"))
        .map(|frame| powergs_frame::trace::Frame::clone(&frame))
        .collect();
    let mut memory = MemoryFrames::new("demo", all);
    assert_eq!(memory.size().expect("a size"), source.size().expect("a size"));
    let reports = Session::new(&mut memory, &()).reports(&systems).expect("reports");
    assert_eq!(reports, expected, "from memory");
}

#[test]
fn a_frame_in_the_middle_is_what_the_session_saw() {
    let neo = system("neo", &[]);
    let frame = Session::new(&mut trace(), &()).frame_on(&neo, 2).expect("a frame");
    assert!(frame.task().before.is_some(), "it keeps the order of frame 1");
    let FrameReport { name, sh_degree, .. } = by_hand(&neo).remove(2);
    let label = Label { frame: 2, name, sh_degree, ..Label::default() };
    let timed = time(&frame.task()).expect("accounts");
    let report = priced(label, &timed, neo.prices()).expect("accounts");
    assert_eq!(report, by_hand(&neo)[2]);
    assert_eq!(Some(&frame.observe(&mut ()).expect("accounts").timing), report.timing());
}

#[test]
fn dram_requests_are_an_address_trace() {
    let system = system("gscore", &[]);
    let frame = Session::new(&mut trace(), &()).frame_on(&system, 0).expect("a frame");
    let mut text = Vec::new();
    let written = frame.write_dram_requests(&mut text).expect("memory takes everything");
    let read: Result<Vec<_>, _> = Requests::new(&text[..]).collect();
    let read = read.expect("what we write can be read");
    assert_eq!(read.len() as u64, written);
    let bytes = |writes: bool| -> u64 {
        read.iter().filter(|r| r.write == writes).map(|r| u64::from(r.bytes)).sum()
    };
    let stages = by_hand(&system)[0].stages;
    assert_eq!(bytes(false), stages.iter().map(|s| s.read).sum::<u64>());
    assert_eq!(bytes(true), stages.iter().map(|s| s.write).sum::<u64>());
    let mut full: &mut [u8] = &mut [0; 100];
    assert!(frame.write_dram_requests(&mut full).is_err());
}

/// Cancels after some simulations.
struct Stop {
    simulated: AtomicU64,
    most: u64,
}

impl Watch for Stop {
    fn is_cancelled(&self) -> bool {
        self.simulated.load(Ordering::Relaxed) >= self.most
    }

    fn simulated(&self, n: u64) {
        self.simulated.fetch_add(n, Ordering::Relaxed);
    }
}

#[test]
fn a_cancelled_session_leaves_whole_frames() {
    let systems = [system("gscore", &[]), system("gscore", &["vru.cores=8"])];
    let subjects: Vec<Subject> = systems.iter().map(Subject::of).collect();
    for most in 0..=6 {
        let stop = Stop { simulated: AtomicU64::new(0), most };
        let mut frames = trace();
        let mut session = Session::new(&mut frames, &stop);
        assert_eq!(session.steps(&subjects), 6);
        let folded = session.fold(
            &subjects,
            |_| Vec::new(),
            |all: &mut Vec<usize>, view| {
                all.push(view.position);
            },
        );
        let folded = folded.expect("no error");
        let whole: Vec<usize> = (0..folded.frames).collect();
        assert!(folded.states.iter().all(|seen| *seen == whole), "{most}: {:?}", folded.states);
        assert_eq!(folded.is_complete, folded.frames == 3, "{most}");
        assert!(most > 0 || folded.frames == 0);
    }
}

#[test]
fn subjects_may_want_some_frames_only() {
    let (all, some) = (system("gscore", &[]), system("gscore", &["vru.cores=8"]));
    let paper = PaperModel::new(Padding::TrueTiles).expect("the published prices");
    let wanted = spread(0..3, 1, 1);
    assert_eq!(wanted, [1]);
    let subjects = [
        Subject::of(&all).checking_order(),
        Subject::of(&some).only(&wanted),
        Subject::paper(&paper),
    ];
    let mut frames = trace();
    let step = |seen: &mut Vec<(usize, bool, bool)>, view: powergs_core::run::FrameView<'_>| {
        let is_timed = view.report.frame_time_s().is_some();
        let checked = view.report.cycle().and_then(|c| c.measured.count(&measures::NEIGHBOURS));
        seen.push((view.position, is_timed, checked.is_some()));
    };
    let folded = Session::new(&mut frames, &()).fold(&subjects, |_| Vec::new(), step);
    let states = folded.expect("a session").states;
    assert_eq!(states[0], [(0, true, true), (1, true, true), (2, true, true)]);
    assert_eq!(states[1], [(1, true, false)]);
    assert_eq!(states[2], [(0, false, false), (1, false, false), (2, false, false)]);
}

#[test]
fn keys_of_any_file_are_changed_in_one_way() {
    let base = system("gscore", &[]);
    let changed = system("gscore", &["vru.cores=8", "clock=0.5 GHz"]);
    assert_eq!(changed.machine().tiles().vru.cores, 8);
    assert_ne!(changed.id(), base.id());
    assert_ne!(changed.timing_id(), base.timing_id());

    let prices = system("gscore", &["energy=gscore-7nm"]);
    assert_eq!(prices.energy_table().name, "gscore-7nm");
    assert_eq!(prices.timing_id(), base.timing_id());
    assert_ne!(prices.id(), base.id());

    let table = base.table(FileKind::Energy).expect("a table");
    let key = "dram.flat.read.energy";
    assert!(!powergs_base::config::knob::values(&table, key).is_empty(), "{key}");
    let rate = ["dram.model=bandwidth", "dram.device=none", "dram.bandwidth=51.2 GB/s"];
    let bytes = system("gscore", &rate);
    let dearer = bytes.with(&[format!("energy:{key}=99 pJ/B").parse().expect("a change")]);
    let dearer = dearer.expect("another price");
    assert_eq!(dearer.timing_id(), bytes.timing_id());
    assert_ne!(dearer.prices(), bytes.prices());

    let banked = system("gscore", &["dram.model=banked"]);
    let slower = system("gscore", &["dram.model=banked", "dram:clock-period=1250 ps"]);
    assert!(slower.dram_peak() < 0.6 * banked.dram_peak());
    assert_ne!(slower.timing_id(), banked.timing_id());

    let files = EmbeddedFiles;
    let spec = SystemSpec { display: Some("oled-powergs".into()), ..SystemSpec::named("gscore") };
    let shown = System::load(&spec, &files).expect("a machine with a display");
    assert!(shown.display().is_some() && shown.inputs().len() == base.inputs().len() + 1);
    // A change of nothing changes nothing.
    let same = base.with(&[]).expect("no change");
    assert_eq!((same.id(), same.machine()), (base.id(), base.machine()));
}

#[test]
fn a_machine_without_a_device_has_a_mere_rate() {
    let flat = "dram.model=bandwidth";
    let base = system("gscore", &[flat]);
    let rate = system("gscore", &[flat, "dram.device=none", "dram.bandwidth=51.2 GB/s"]);
    assert!(rate.device().is_none() && rate.table(FileKind::Dram).is_none());
    assert_eq!((rate.dram_peak(), rate.timing_id()), (base.dram_peak(), base.timing_id()));
    let back = rate.with(&["dram.device=lpddr4-3200-x16x8".parse().expect("a change")]);
    assert_eq!(back.expect("the same rate").timing_id(), base.timing_id());
    let faster = system("gscore", &[flat, "dram.channels=16"]);
    assert_ne!(faster.timing_id(), base.timing_id());
    let no_device: Change = "dram:timing.burst=9".parse().expect("a change");
    let error = rate.with(&[no_device]).expect_err("no file").to_string();
    assert!(error.contains("has no DRAM device"), "{error}");
}

#[test]
fn invalid_changes_say_what_is_wrong() {
    assert!(refused("gscore", "vru.coers=8").contains("did you mean `cores`?"));
    assert!(refused("gscore", "vru.cores=0").contains("vru.cores"));
    assert!(refused("gscore", "energy=gscore-8nm").contains("gscore-7nm"), "a suggestion");
    assert!(refused("gscore", "display:scale=2").contains("no display preset"));
    assert!(refused("gscore", "dram.channels=3").contains("power of two"));
    assert!(refused("gscore", "dram.bandwidth=1 GB/s").contains("which have 51.2 GB/s"));
    assert!(refused("gscore", "dram.device=none").contains("needs `dram.bandwidth`"));
    for wrong in ["vru.cores", "=8", "energy:=3"] {
        assert!(wrong.parse::<Change>().is_err(), "{wrong}");
    }
    let unknown = System::named("gscoer").expect_err("no such machine").to_string();
    assert!(unknown.contains("did you mean `gscore`?"), "{unknown}");
    let change: Change = "energy:dram.x=1 pJ/B".parse().expect("a change");
    assert_eq!(change.to_string(), "energy:dram.x=1 pJ/B");
}

#[test]
fn traces_that_cannot_be_read_are_inputs_at_fault() {
    let missing = TraceFile::open(Path::new("no/such.bin")).expect_err("no file");
    assert!(matches!(&missing, RunError::Input { place, .. } if place == "no/such.bin"));

    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let other = TraceFile::open(&manifest).expect_err("no trace");
    assert!(matches!(other, RunError::Input { .. }), "{other}");
    let mut trace = trace();
    let error = trace.select(3, None).expect_err("three frames only");
    assert!(matches!(error, RunError::Request(_)) && error.to_string().contains("3 frames"));
    trace.select(1, Some(99)).expect("two frames");
    assert_eq!(trace.range(), 1..3);
}

#[test]
fn dataflows_of_equal_numbers_each_have_what_they_take_over_themselves() {
    let tiles = ["geometry.subtile=8", "geometry.sort-group=16", "geometry.test=aabb"];
    let sizes = ["fovea=none", "geometry.tile=16", "record.pixel=24 B"];
    let warped = ["pixels.impl=warped", "pixels.period=4"];
    let gscore = system("gscore", &[&tiles[..], &sizes, &warped].concat());
    let gpu = system("orin-nx", &[&["blend.pixel=24 B"][..], &warped].concat());
    let of = |system: &System| {
        let flow = system.machine().flow();
        (flow.work_key(system.machine()), flow.takes_over(system.machine()))
    };
    assert_eq!(of(&gscore), of(&gpu), "they share what is prepared, and nothing else");
    let reports = |systems: &[System]| Session::new(&mut trace(), &()).reports(systems).unwrap();
    let both = reports(&[gscore.clone(), gpu.clone()]);
    let alone = [gscore, gpu].map(|system| reports(&[system]).remove(0));
    assert!(both == alone);
}
