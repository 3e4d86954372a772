//! Two eyes are one frame of the display: what a pair costs, by hand.

use std::sync::Arc;

use approx::assert_relative_eq;
use powergs_core::flow::tile_wise::measures;
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::frames::spread;
use powergs_core::run::{
    FrameView, Frames, MemoryFrames, Session, Subject, System, SystemSpec, TraceFile,
};
use powergs_core::sim::FrameReport;
use powergs_core::sim::statistics::{self, Value};
use powergs_core::sim::statistics::{Kind, catalogue};
use powergs_frame::scene::{Eye, StorageOrder};
use powergs_frame::trace::{Frame, TraceHeader, Writer};
use powergs_scene::Camera;
use powergs_scene::camera::edit::stereo;
use powergs_testkit::scenes::{front_camera, random_scene};

use crate::workload::support::rendered;

fn demo() -> TraceFile {
    TraceFile::open("../../traces/demo.bin".as_ref()).expect("the demonstration")
}

/// The first frames of the demonstration, as views or as pairs.
fn views(count: usize, are_pairs: bool) -> MemoryFrames {
    let mut demo = demo();
    let frame = |k: usize| {
        let frame = demo.take(k % 3).and_then(|pending| pending.get()).expect("a frame");
        let mut frame = Frame::clone(&frame);
        let camera = &mut frame.facts.camera;
        let eye = Eye::ALL[k % 2];
        camera.name = format!("view_{}_{}", k / 2, eye.name());
        camera.eye = are_pairs.then_some(eye);
        frame
    };
    MemoryFrames::new("pairs", (0..count).map(frame).collect::<Vec<_>>())
}

/// Two pairs of a scene of balls, a hundredth of a unit apart.
fn stereo_pairs() -> MemoryFrames {
    let mut scene = random_scene(3, 2000, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
    let view = |x: f64| {
        let mut camera = front_camera(75, 51);
        camera.name = format!("at_{x}");
        camera.centre.x += x;
        stereo(&camera, 0.01)
    };
    let frame = |camera: Camera| {
        let mut frame = rendered(&scene, &camera).1;
        frame.facts.camera.eye = camera.eye;
        frame
    };
    let cameras = [0.0, 0.1].into_iter().flat_map(view);
    MemoryFrames::new("pairs", cameras.map(frame).collect::<Vec<_>>())
}

fn reports(frames: &mut dyn Frames, system: &System) -> Vec<FrameReport> {
    Session::new(frames, &()).reports(std::slice::from_ref(system)).expect("reports").remove(0)
}

fn system(name: &str) -> System {
    let display = Some("oled-powergs".to_owned());
    let spec = SystemSpec { display, ..SystemSpec::named(name) };
    System::load(&spec, &EmbeddedFiles).expect("a machine")
}

#[test]
fn a_pair_takes_the_time_and_the_joules_of_both_eyes() {
    let gscore = system("gscore");
    let [single, pairs] = [false, true].map(|are_pairs| reports(&mut views(4, are_pairs), &gscore));
    assert_eq!((single.len(), pairs.len()), (4, 2));
    for (eyes, pair) in single.chunks(2).zip(&pairs) {
        assert_eq!((pair.eyes, pair.eye, pair.frame), (2, None, eyes[0].frame));
        assert_eq!(pair.name, format!("view_{}", pair.frame / 2));
        let sum = |of: &dyn Fn(&FrameReport) -> f64| eyes.iter().map(of).sum::<f64>();
        let time = sum(&|r| r.frame_time_s().expect("a time"));
        assert_relative_eq!(pair.frame_time_s().expect("a time"), time, max_relative = 1e-12);
        let joules = sum(&|r| r.energy.total().0);
        assert_relative_eq!(pair.energy.total().0, joules, max_relative = 1e-12);
        assert_relative_eq!(
            pair.display_w.expect("a display"),
            sum(&|r| r.display_w.expect("a display")),
            max_relative = 1e-12
        );
        // Counts add up, but for what a buffer holds at most and how many units there are.
        for statistic in catalogue().iter().filter(|s| s.kind == Kind::Count) {
            let of = |r: &FrameReport| statistic.of(r, 1.0).map(|value| value.as_f64());
            let Some(both) = of(pair) else { continue };
            let [a, b] = [of(&eyes[0]), of(&eyes[1])].map(|value| value.expect("as the pair"));
            let name = statistic.name.as_str();
            let wanted = match name {
                "counters.sh_degree" | "deadline_missed" => a,
                // Both eyes are shown for the periods that their pair takes.
                "display_periods" => pair.display_periods(1.0).expect("shown") as f64,
                _ if name.ends_with(".instances") || name.ends_with("capacity_bytes") => a,
                _ if name.ends_with("peak_bytes") => a.max(b),
                _ => a + b,
            };
            assert_eq!(both, wanted, "{name}");
        }
    }
}

/// What a second eye loses is said of the pair, though the first one knows nothing of it.
#[test]
fn a_pair_says_what_its_second_eye_loses() {
    let separate = "stereo.impl=separate";
    let with = |sets: &[&str]| {
        let sets = sets.iter().map(|set| (*set).to_owned()).collect();
        let spec = SystemSpec { sets, ..SystemSpec::named("nebula") };
        System::load(&spec, &EmbeddedFiles).expect("a machine")
    };
    let mut pairs = stereo_pairs();
    let named = |report: &FrameReport, name: &str| {
        statistics::find(name).expect("a statistic").of(report, 60.0).map(Value::as_f64)
    };
    let [derived, plain] = [&[][..], &[separate]].map(|sets| reports(&mut pairs, &with(sets)));
    assert_eq!((derived.len(), plain.len()), (2, 2));
    for (pair, other) in derived.iter().zip(&plain) {
        let of = |name: &str| named(pair, &format!("stereo.{name}")).expect("a second eye");
        assert!(of("kept") > 0.0 && of("kept_frac") < 1.0);
        assert!(of("changed_pixels_frac") >= of("cut_off_pixels_frac"));
        assert!(of("lost_blends_frac") < 1.0 && of("largest_disparity") > 0.0);
        assert!(named(other, "stereo.kept").is_none());
        assert!(pair.frame_time_s() < other.frame_time_s());
    }
}

/// A display of 72 Hz needs 144 views a second: what each eye alone keeps, a pair misses.
#[test]
fn deadline_and_power_are_those_of_a_period_with_both_eyes() {
    let gscore = system("gscore");
    let eyes = reports(&mut views(2, false), &gscore);
    let pair = reports(&mut views(2, true), &gscore).remove(0);
    let slowest = eyes.iter().filter_map(FrameReport::frame_time_s).fold(0.0, f64::max);
    // Slow enough for each eye, too fast for both.
    let fps = 1.0 / (1.2 * slowest);
    assert!(eyes.iter().all(|eye| !eye.misses_deadline(fps)));
    assert!(pair.misses_deadline(fps));
    assert_relative_eq!(pair.displayed_fps(fps), pair.achieved_fps().unwrap());
    // At half that rate: the work of both eyes in each period, standby once.
    let fps = 0.5 * fps;
    assert!(!pair.misses_deadline(fps));
    let work: f64 = eyes.iter().map(|eye| eye.energy.dynamic().0 * 1e-12 * fps).sum();
    let standby: f64 = pair.standby_w(fps).iter().sum();
    assert_relative_eq!(pair.power_display_rate_w(fps), work + standby, max_relative = 1e-12);
    let alone: f64 = eyes[0].standby_w(fps).iter().sum();
    assert!(standby < 1.5 * alone, "standby of one chip: {standby} against {alone}");
}

/// The order of a view is kept for the next one of the same eye.
#[test]
fn an_eye_keeps_its_own_order() {
    let neo = system("neo");
    let reused = |frames: &mut dyn Frames| -> Vec<bool> {
        let subjects = [Subject::of(&neo)];
        let keep = |all: &mut Vec<bool>, view: FrameView<'_>| {
            let cycle = view.report.cycle().expect("cycles");
            all.push(cycle.measured.count(&measures::KEPT).is_some());
        };
        let folded = Session::new(frames, &()).fold(&subjects, |_| Vec::new(), keep);
        folded.expect("reports").states.remove(0)
    };
    // The same picture for both eyes, then another one twice.
    let mut frames = views(4, true);
    let same = |k: usize| {
        let mut frame = Frame::clone(&frames.frames[k - k % 2]);
        frame.facts.camera.eye = Some(Eye::ALL[k % 2]);
        Arc::new(frame)
    };
    frames.frames = (0..4).map(same).collect();
    assert_eq!(reused(&mut frames), [false, true], "the first pair begins from nothing");
    let [first, second] = [0, 1].map(|k| reports(&mut frames, &neo).remove(k));
    let share = |report: &FrameReport| {
        let find = powergs_core::sim::statistics::find("reuse.kept_frac").expect("a statistic");
        find.of(report, 60.0).map(|value| value.as_f64())
    };
    assert_eq!(share(&first), None);
    let kept = share(&second).expect("the second pair reuses");
    // Each eye against the frame before of its own: not all of the other eye's picture.
    assert!((0.0..1.0).contains(&kept), "{kept}");
}

#[test]
fn ranges_and_samples_take_whole_pairs() {
    assert_eq!(spread(0..8, 2, 2), [2, 3, 6, 7]);
    assert_eq!(spread(4..6, 2, 3), [4, 5]);
    assert_eq!(spread(0..8, 1, 2), [2, 6]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pairs.bin");
    let frames = views(4, true);
    let points = frames.frames[0].facts.points;
    let header = TraceHeader {
        generator: String::new(),
        scene: "pairs".into(),
        points,
        order: StorageOrder::Storage,
    };
    let file = std::fs::File::create(&path).expect("a file");
    let mut writer = Writer::new(file, &header).expect("a trace");
    for frame in &frames.frames {
        writer.write_frame(frame).expect("a frame");
    }
    writer.finish().expect("a whole trace");
    let mut trace = TraceFile::open(&path).expect("a trace");
    assert_eq!(trace.eyes(), 2);
    trace.select(2, None).expect("the second pair");
    assert_eq!(trace.range(), 2..4);
    let error = trace.select(1, Some(4)).expect_err("half a pair").to_string();
    assert!(error.contains("write 0..4"), "{error}");
    assert!(!trace.looks_paired().expect("heads"), "it says so itself");
    assert_eq!(demo().eyes(), 1);
}

#[test]
fn a_trace_holds_whole_pairs_only() {
    let frames = views(4, true);
    let points = frames.frames[0].facts.points;
    let header = TraceHeader {
        generator: String::new(),
        scene: "pairs".into(),
        points,
        order: StorageOrder::Storage,
    };
    let written = |order: &[usize]| {
        let mut writer = Writer::new(Vec::new(), &header).expect("a trace");
        for &k in order {
            writer.write_frame(&frames.frames[k]).map_err(|e| e.to_string())?;
        }
        writer.finish().map_err(|e| e.to_string())
    };
    assert!(written(&[0, 1, 2, 3]).is_ok());
    assert!(written(&[0, 2]).unwrap_err().contains("without the right one"));
    assert!(written(&[1]).unwrap_err().contains("without the left one"));
    assert!(written(&[0]).unwrap_err().contains("without the right one"));
}

/// Counts and times priced again: the same power with the same prices, for views and for pairs, and
/// another one with others.
#[test]
fn a_report_is_priced_again_without_its_frame() {
    for name in ["gscore", "gscore-powergs"] {
        let system = system(name);
        for are_pairs in [false, true] {
            for report in reports(&mut views(4, are_pairs), &system) {
                for fps in [60.0, 2000.0] {
                    let again = report.power_with_w(system.prices(), fps).expect("counts");
                    let was = report.power_display_rate_w(fps);
                    assert_relative_eq!(again, was, max_relative = 1e-9);
                    let mut dear = system.prices().clone();
                    dear.per_action.iter_mut().for_each(|pj| *pj *= 2.0);
                    let more = report.power_with_w(&dear, fps).expect("counts");
                    assert!(more > 1.005 * was, "{name}: {more} W, and {was} W before");
                }
            }
        }
    }
}
