//! A second master takes its part of the memory, and nothing else changes.

use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{Change, MemoryFrames, Session, System, SystemSpec};
use powergs_core::sim::FrameReport;
use powergs_core::stage::{DRAM_READ, hardware};
use powergs_energy::hardware::Does;
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{front_camera, random_scene};

/// So many requests under way never hold the other one back.
const DEEP: &str = "dram.second-master.in-flight=4096";

const MODELS: [&str; 3] = ["bandwidth", "calibrated", "banked"];

fn system(sets: &[String]) -> Result<System, String> {
    let changes: Vec<Change> = sets.iter().map(|s| s.parse().expect("a change")).collect();
    System::named("gscore").expect("a machine").with(&changes).map_err(|e| e.to_string())
}

fn frame() -> Frame {
    let camera = front_camera(160, 120);
    let options = Options::reference(Detail::Counters);
    render(&random_scene(3, 12_000, 3), &camera, &options).into_frame(&camera, [0.0; 3])
}

/// The frame on two channels of LPDDR4-3200, 12.8 GB/s, which it keeps busy.
fn replayed(model: &str, sets: &[&str]) -> FrameReport {
    let mut all = vec![format!("dram.model={model}"), "dram.channels=2".to_owned()];
    all.extend(sets.iter().map(|s| (*s).to_owned()));
    let system = system(&all).expect("a system");
    let mut frames = MemoryFrames::new("scene", [frame()]);
    let mut reports = Session::new(&mut frames, &()).reports(&[system]).expect("accounts close");
    reports.remove(0).remove(0)
}

fn cycles(report: &FrameReport) -> f64 {
    report.timing().expect("timed").frame as f64
}

#[test]
fn without_a_rate_there_is_none() {
    for model in MODELS {
        let off = ["dram.second-master.pattern=random", "dram.second-master.request=12 B"];
        assert_eq!(replayed(model, &off), replayed(model, &[]), "{model}");
        assert_eq!(replayed(model, &[]).timing().expect("timed").dram.master_bytes[0], 0);
    }
}

#[test]
fn more_for_the_other_never_makes_a_frame_faster() {
    for model in MODELS {
        for pattern in ["stream", "random"] {
            let at = |rate: &str| {
                let rate = format!("dram.second-master.rate={rate}");
                replayed(model, &[&rate, &format!("dram.second-master.pattern={pattern}"), DEEP])
            };
            let reports = ["0 B/s", "500 MB/s", "1 GB/s", "2 GB/s", "4 GB/s", "8 GB/s"].map(at);
            let mut times = reports.each_ref().map(cycles);
            if model == "calibrated" && pattern == "random" {
                // Requests under way hold it back here, and the share of the accelerator follows
                // from how many it has: the reference has more.
                times[5] = times[5].max(times[4]);
            }
            // Which request meets an open row is a matter of luck.
            let slower = |w: &[f64]| w[1] >= w[0] * 0.995;
            assert!(times.windows(2).all(slower), "{model}, {pattern}: {times:?}");
            assert!(times[5] > 1.3 * times[0], "{model}, {pattern}: {times:?}");
        }
    }
}

#[test]
fn its_bytes_are_apart_and_cost_the_accelerator_time_only() {
    for model in MODELS {
        let alone = replayed(model, &[]);
        let shared = replayed(model, &["dram.second-master.rate=4 GB/s", DEEP]);
        // Units that wait are clocked.
        let done = |r: &FrameReport| {
            let clock = |does| matches!(does, Does::Clock(_) | Does::IdleClock(_));
            let all = hardware().actions().filter(|(_, does)| !clock(*does));
            all.map(|(action, _)| r.actions.total(action)).collect::<Vec<_>>()
        };
        let work = |r: &FrameReport| (done(r), r.stages, r.energy.dynamic().0);
        if model == "bandwidth" {
            assert_eq!(work(&alone), work(&shared), "{model}");
        } else {
            // Rows that the other closes are opened again; bytes stay.
            assert_eq!((done(&alone), alone.stages), (done(&shared), shared.stages));
        }
        let dram = &shared.timing().expect("timed").dram;
        assert_eq!(dram.read_bytes, shared.actions.total(DRAM_READ));
        let seconds = shared.frame_time_s().expect("timed");
        let rate = dram.master_bytes[0] as f64 / seconds;
        assert!((rate / 4e9 - 1.0).abs() < 0.02, "{model}: {rate}");
        let busy = |r: &FrameReport| r.timing().expect("timed").dram_busy_frac();
        assert!(busy(&shared) > busy(&alone), "{model}: {} {}", busy(&alone), busy(&shared));
    }
}

/// The models agree on what a stream costs: within a sixth of the time.
#[test]
fn the_models_agree_roughly() {
    let slowdown = |model| {
        let rate = ["dram.second-master.rate=4 GB/s", DEEP];
        cycles(&replayed(model, &rate)) / cycles(&replayed(model, &[]))
    };
    let [flat, calibrated, banked] = MODELS.map(slowdown);
    let others = [("bandwidth", flat), ("calibrated", calibrated)];
    for (model, other) in others {
        assert!((other / banked - 1.0).abs() < 1.0 / 6.0, "{model}: {other}, banked: {banked}");
    }
    assert!(banked > 1.1, "{banked}");
}

/// Fewer requests under way: the other gets less than it asks for, the accelerator more.
#[test]
fn a_shallow_queue_holds_it_back() {
    let with = |n: u32| {
        let n = format!("dram.second-master.in-flight={n}");
        replayed("banked", &["dram.second-master.rate=800 MB/s", &n])
    };
    let (shallow, deep) = (with(1), with(16));
    let bytes = |r: &FrameReport| r.timing().expect("timed").dram.master_bytes[0] as f64;
    let rate = |r: &FrameReport| bytes(r) / r.frame_time_s().expect("timed");
    assert!(rate(&shallow) < 0.5 * rate(&deep), "{} {}", rate(&shallow), rate(&deep));
    assert!(cycles(&shallow) < cycles(&deep));
}

#[test]
fn what_takes_everything_is_refused() {
    let refused = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
        system(&sets).err().unwrap_or_else(|| panic!("{sets:?} was accepted"))
    };
    let all = refused(&["dram.second-master.rate=50 GB/s"]);
    for part in ["`dram.second-master.rate` = 50 GB/s", "109 % of the memory", "`dram.channels`"] {
        assert!(all.contains(part), "{all}");
    }
    assert!(system(&["dram.second-master.rate=40 GB/s".to_owned()]).is_ok());
    // Random requests of 12 B move bursts of 32 B.
    let small = ["dram.second-master.pattern=random", "dram.second-master.request=12 B"];
    let small = refused(&[&small[..], &["dram.second-master.rate=20 GB/s"]].concat());
    assert!(small.contains("takes 116 %"), "{small}");
    let bare = ["dram.device=none", "dram.bandwidth=5 GB/s", "dram.second-master.rate=5 GB/s"];
    assert!(refused(&bare).contains("takes 111 %"));
    assert!(refused(&["dram.second-master.rate=1 B/s"]).contains("from 1 kB/s"));
    assert!(refused(&["dram.second-master.request=0 B"]).contains("from 1 B"));
}

/// The last writes of preprocessing do not wait for a pause of a master that reads without one.
#[test]
fn a_master_that_only_reads_does_not_keep_writes_waiting() {
    let end = |wait: &str| {
        let sets =
            ["dram.second-master.rate=10 GB/s", &format!("dram:controller.write-wait={wait}")];
        let report = replayed("banked", &sets);
        report.timing().expect("timed").preprocessing_end
    };
    let (limited, free) = (end("4 us"), end("0 ns"));
    assert!(limited + 5000 < free, "{limited} with a limit, {free} without");
}

/// Who is served first gets what it asks for, and the others less; who waits for all takes nothing
/// from the accelerator.
#[test]
fn priorities_decide_who_waits() {
    for model in ["bandwidth", "banked"] {
        let alone = cycles(&replayed(model, &[]));
        let with = |sets: &[&str]| {
            let all = [&["dram.second-master.rate=6 GB/s", DEEP][..], sets].concat();
            let report = replayed(model, &all);
            let bytes = report.timing().expect("timed").dram.master_bytes[0] as f64;
            (bytes / report.frame_time_s().expect("timed") * 1e-9, cycles(&report) / alone)
        };
        let [first, equal, last] = ["first", "equal", "last"]
            .map(|priority| with(&[&format!("dram.second-master.priority={priority}")]));
        assert!((5.9..=6.01).contains(&first.0), "{model}: {first:?}");
        assert!(last.1 < 1.05 && last.0 < 0.2 * first.0, "{model}: {first:?} {last:?}");
        assert!(first.1 >= equal.1 && equal.1 > last.1, "{model}: {first:?} {equal:?} {last:?}");
        let held =
            with(&["dram.second-master.priority=last", "dram.second-master.guaranteed=4 GB/s"]);
        if model == "banked" {
            assert!(held.0 > 3.95 && held.0 < 5.0, "{model}: {held:?}");
        }
    }
}

/// Two masters of half the rate each are as one, within what rows and places decide.
#[test]
fn several_masters_add_up() {
    for model in MODELS {
        let one = replayed(model, &["dram.second-master.rate=4 GB/s", DEEP]);
        let halves = ["second", "fourth"].map(|name| format!("dram.{name}-master.rate=2 GB/s"));
        let deep = ["second", "fourth"].map(|name| format!("dram.{name}-master.in-flight=4096"));
        let two = replayed(model, &[&halves[0], &halves[1], &deep[0], &deep[1]]);
        let bytes = two.timing().expect("timed").dram.master_bytes;
        assert_eq!(bytes[1], 0, "{model}");
        let shares = bytes.map(|bytes| bytes as f64 / two.frame_time_s().expect("timed") * 1e-9);
        assert!((shares[0] - 2.0).abs() < 0.1 && (shares[2] - 2.0).abs() < 0.1, "{shares:?}");
        // Two streams open more rows than one.
        assert!((cycles(&two) / cycles(&one) - 1.0).abs() < 0.1, "{model}");
    }
}

/// Nobody is given more than its pattern can have: with two requests under way there is a latency
/// for every two.
#[test]
fn a_rate_beyond_the_pattern_is_refused() {
    let sets = |rate: &str| {
        ["dram.model=banked", "dram.second-master.pattern=random", "dram.second-master.in-flight=2"]
            .map(str::to_owned)
            .into_iter()
            .chain([format!("dram.second-master.rate={rate}")])
            .collect::<Vec<_>>()
    };
    let refused = system(&sets("9 GB/s")).expect_err("two requests carry less");
    for part in ["`dram.second-master.rate` = 9 GB/s", "2 of them under way", "in-flight"] {
        assert!(refused.contains(part), "{refused}");
    }
    assert!(system(&sets("500 MB/s")).is_ok());
    // What a pattern has of the memory alone does not depend on who would go first.
    let spec = |set: &str| {
        let all = [&sets("500 MB/s")[..], &[set.to_owned()]].concat();
        let system = system(&all).expect("a system");
        let device = system.machine().device.as_ref().expect("linked");
        system.machine().dram.second_master.ceiling(device)
    };
    let [first, last] =
        ["first", "last"].map(|p| spec(&format!("dram.second-master.priority={p}")));
    assert_eq!(first, last);
    let more = "dram.second-master.guaranteed=2 GB/s".to_owned();
    let more: Vec<String> = sets("500 MB/s").into_iter().chain([more]).collect();
    assert!(system(&more).expect_err("more than it asks for").contains("guaranteed"));
}

/// Who shares a memory has none of its PHY, and its part of the standby; the frame is the same.
#[test]
fn a_memory_of_others_costs_what_is_said() {
    for model in MODELS {
        let own = replayed(model, &[]);
        let shared = |share: &str| {
            let share = format!("dram.standby-share={share}");
            replayed(model, &["dram.owner=shared", &share])
        };
        let [none, half, all] = ["0", "0.5", "1"].map(shared);
        assert_eq!(own.timing(), half.timing(), "{model}");
        let standby = |r: &FrameReport| r.standby.running_w[1] + r.standby.running_w[2];
        assert!(own.phy_standby_w > 0.0 && half.phy_standby_w == 0.0, "{model}");
        assert_eq!(standby(&none), 0.0, "{model}");
        let whole = standby(&own) - own.phy_standby_w;
        assert!((standby(&half) - 0.5 * whole).abs() < 1e-9, "{model}");
        assert!((standby(&all) - whole).abs() < 1e-9, "{model}");
        let area = |sets: &[String]| {
            let area = system(sets).expect("a system").prices().area.clone().expect("an area");
            (area.phy.0, area.controllers.0, area.core().0)
        };
        let sets = ["dram.owner=shared", "dram.standby-share=0"].map(str::to_owned);
        let ((phy, controllers, core), bare) = (area(&[]), area(&sets));
        assert!(phy > 0.0 && controllers > 0.0);
        assert_eq!(bare, (0.0, 0.0, core));
    }
    let refused = system(&["dram.owner=shared".to_owned()]).expect_err("nobody says how much");
    assert!(refused.contains("`dram.standby-share`"), "{refused}");
    let own = SystemSpec {
        sets: vec!["dram.standby-share=0.5".to_owned()],
        ..SystemSpec::named("gscore")
    };
    let refused = System::load(&own, &EmbeddedFiles).err().map(|e| e.to_string());
    let refused = refused.expect("its own memory");
    assert!(refused.contains("`dram.owner`"), "{refused}");
}
