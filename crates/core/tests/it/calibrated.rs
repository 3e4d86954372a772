//! The `calibrated` model of the memory is near `banked` on machines that it was not measured on.

use std::sync::Arc;

use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::session::Subject;
use powergs_core::run::{Change, Frames, MemoryFrames, Session, System, SystemSpec, TraceFile};
use powergs_core::sim::FrameReport;
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{front_camera, random_scene};

/// Numbers of CCUs, cores, rendering units and sorters of a core, and the sizes of buffers over
/// those of GSCore's share.
const MACHINES: [(u32, u32, u32, u32, f64); 12] = [
    (1, 1, 4, 1, 1.0),
    (1, 4, 32, 2, 2.0),
    (2, 2, 16, 1, 0.5),
    (2, 8, 32, 4, 1.0),
    (4, 4, 16, 2, 1.0),
    (4, 4, 32, 2, 4.0),
    (4, 8, 16, 1, 0.5),
    (8, 1, 32, 2, 2.0),
    (8, 2, 8, 2, 1.0),
    (8, 8, 16, 2, 0.5),
    (8, 8, 32, 4, 1.0),
    (8, 8, 32, 4, 4.0),
];

fn system(model: &str, sets: &[String]) -> System {
    let spec =
        SystemSpec { sets: vec![format!("dram.model={model}")], ..SystemSpec::named("gscore") };
    let system = System::load(&spec, &EmbeddedFiles).expect("a system");
    let changes: Vec<Change> = sets.iter().map(|s| s.parse().expect("a change")).collect();
    system.with(&changes).expect("a system")
}

fn machine(model: &str, place: usize) -> System {
    let (ccus, cores, units, sorters, scale) = MACHINES[place];
    let kib = |share: u32, n: u32| format!("{} B", (f64::from(share * n) * 1024.0 * scale) as u64);
    let sets = [
        format!("ccu.units={ccus}"),
        format!("vru.cores={cores}"),
        format!("vru.units-per-core={units}"),
        format!("gsu.qsu-per-core={sorters}"),
        format!("gsu.bsu-per-core={}", sorters.div_ceil(2)),
        format!("buffers.gaussian-in.capacity={}", kib(2, ccus)),
        format!("buffers.tile-list.capacity={}", kib(8, ccus)),
        format!("buffers.sorting.capacity={}", kib(16, cores)),
        format!("buffers.feature.capacity={}", kib(32, cores)),
        format!("buffers.pixel-out.capacity={}", kib(4, cores)),
    ];
    system(model, &sets)
}

/// The first frame of the trace that comes with the program, and one of scattered splats.
fn frames() -> MemoryFrames {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../traces/demo.bin");
    let mut demo = TraceFile::open(path.as_ref()).expect("the demo trace");
    let first = demo.take(0).and_then(|pending| pending.get()).expect("a frame");
    let camera = front_camera(256, 192);
    let scene = random_scene(5, 15_000, 3);
    let scattered = render(&scene, &camera, &Options::reference(Detail::Counters));
    let mut frames = MemoryFrames::new("two", [scattered.into_frame(&camera, [0.0; 3])]);
    frames.frames.insert(0, Arc::clone(&first));
    frames
}

/// By machine, by frame.
fn reports(model: &str) -> Vec<Vec<FrameReport>> {
    let systems: Vec<System> = (0..MACHINES.len()).map(|place| machine(model, place)).collect();
    Session::new(&mut frames(), &()).reports(&systems).expect("accounts close")
}

fn time(report: &FrameReport) -> f64 {
    report.frame_time_s().expect("timed")
}

#[test]
fn near_banked_on_machines_with_other_units_and_buffers() {
    let (banked, calibrated) = (reports("banked"), reports("calibrated"));
    for frame in 0..2 {
        let ratio = |of: &dyn Fn(&FrameReport) -> f64, place: usize| {
            of(&calibrated[place][frame]) / of(&banked[place][frame]) - 1.0
        };
        let all = |of: &dyn Fn(&FrameReport) -> f64| -> (f64, f64) {
            let errors = (0..MACHINES.len()).map(|place| ratio(of, place).abs());
            let (sum, worst) = errors.fold((0.0, 0.0_f64), |a, e| (a.0 + e, a.1.max(e)));
            (sum / MACHINES.len() as f64, worst)
        };
        let (mean, worst) = all(&time);
        // Small requests in many places, as of scattered splats, depend most on who makes them.
        let most = [0.03, 0.06][frame];
        assert!(mean < most && worst < 0.12, "frame {frame}: time {mean:.3}, {worst:.3} at worst");
        let (mean, worst) = all(&|report| report.energy.total().0);
        assert!(
            mean < 0.03 && worst < 0.08,
            "frame {frame}: energy {mean:.3}, {worst:.3} at worst"
        );
        for a in 0..MACHINES.len() {
            for b in 0..a {
                let order = |all: &[Vec<FrameReport>]| time(&all[a][frame]) / time(&all[b][frame]);
                let (real, seen) = (order(&banked), order(&calibrated));
                let is_clear = (real - 1.0).abs() > 0.12;
                assert!(!is_clear || (real > 1.0) == (seen > 1.0), "{a} and {b} change places");
            }
        }
    }
}

#[test]
fn the_requests_are_those_of_banked() {
    let one = |model: &str| {
        let system = [machine(model, 4)];
        Session::new(&mut frames(), &()).reports(&system).expect("accounts close").remove(0)
    };
    for (banked, calibrated) in one("banked").iter().zip(one("calibrated")) {
        let of = |report: &FrameReport| report.timing().expect("timed").dram;
        let (real, seen) = (of(banked), of(&calibrated));
        assert_eq!(real.requested_bytes(), seen.requested_bytes());
        assert_eq!(real.requests_served, seen.requests_served);
        let moved = |dram: &powergs_core::kernel::DramUse| {
            dram.commands.expect("a device has commands").moved_bytes() as f64
        };
        assert!((moved(&seen) / moved(&real) - 1.0).abs() < 0.02);
    }
}

#[test]
fn who_else_is_simulated_changes_nothing() {
    let together = reports("calibrated");
    for place in [0, 7, 11] {
        let alone = machine("calibrated", place);
        let mut frames = frames();
        let mut session = Session::new(&mut frames, &());
        let subjects = [Subject::of(&alone)];
        let alone = session.fold(&subjects, |_| Vec::new(), |all, view| all.push(view.report));
        assert_eq!(alone.expect("accounts close").states[0], together[place]);
    }
}
