//! The SH degree of a scene decides the bytes and the operations of its colours.

use powergs_core::flow::tile_wise::ResolvedUnits;
use powergs_core::run::{Change, MemoryFrames, Session, System};
use powergs_core::sim::paper::{self, UnitPrices};
use powergs_core::sim::{FrameReport, Label};
use powergs_core::stage::{DRAM_READ, work_id};
use powergs_core::workload::paper::Padding;
use powergs_core::workload::{FrameWorkload, Geometry, bin};
use powergs_energy::Component::Flop;
use powergs_energy::action::Phase;
use powergs_frame::scene::ShDegree;
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{front_camera, random_scene};

/// Bytes and distance of the colour records of a machine, by degree.
fn colours(sets: &[&str]) -> [(u64, u64); 4] {
    let changes: Vec<Change> = sets.iter().map(|s| s.parse().unwrap()).collect();
    let system = System::named("gscore-powergs").unwrap().with(&changes).unwrap();
    ShDegree::ALL.map(|sh_degree| {
        let geometry = system.machine().tiles().geometry;
        let workload = FrameWorkload { sh_degree, ..FrameWorkload::empty(geometry) };
        let record = ResolvedUnits::for_frame(system.machine(), &workload).ccu.record;
        (record.colour.0, record.colour_pitch.0)
    })
}

#[test]
fn records_shrink_with_the_degree() {
    assert_eq!(colours(&[]), [(13, 32), (31, 32), (61, 64), (103, 128)]);
    let packed = ["record.colour=96 B", "record.colour-extra=0 B", "record.colour-pitch=96 B"];
    assert_eq!(colours(&packed), [(6, 32), (24, 32), (54, 64), (96, 96)]);
    let without_gaps = ["record.colour-pitch=103 B"];
    assert_eq!(colours(&without_gaps), [(13, 13), (31, 31), (61, 61), (103, 103)]);
    // Of 12 bits a coefficient: whole bytes.
    let twelve = ["record.colour=79 B", "record.colour-pitch=80 B"];
    assert_eq!(colours(&twelve).map(|c| c.0), [12, 25, 48, 79]);
    let palette = ["record.colour-extra=103 B"];
    assert_eq!(colours(&palette), [(103, 128); 4]);
}

#[test]
fn the_part_that_stays_is_a_part_of_the_record() {
    let change: Change = "record.colour-extra=104 B".parse().unwrap();
    let error = System::named("gscore-powergs").unwrap().with(&[change]).unwrap_err().to_string();
    assert!(error.contains("`record.colour-extra` = 104 B is more than `record.colour` = 103 B"));
}

fn frame(degree: Option<u8>) -> Frame {
    let camera = front_camera(64, 48);
    let options = Options::reference(Detail::Counters);
    let mut frame =
        render(&random_scene(3, 900, 0), &camera, &options).into_frame(&camera, [0.0; 3]);
    assert_eq!(frame.facts.sh_degree, Some(ShDegree::ZERO), "the scene's own");
    frame.facts.sh_degree = degree.and_then(ShDegree::new);
    frame
}

fn replayed(degree: Option<u8>, sets: &[&str]) -> FrameReport {
    let changes: Vec<Change> = sets.iter().map(|s| s.parse().unwrap()).collect();
    let system = System::named("gscore-powergs").unwrap().with(&changes).unwrap();
    let mut frames = MemoryFrames::new("scene", [frame(degree)]);
    let mut reports = Session::new(&mut frames, &()).reports(&[system]).unwrap();
    reports.remove(0).remove(0)
}

#[test]
fn bytes_and_energy_of_a_frame_follow_the_degree() {
    for sets in [&[][..], &["ccu.fetch=geometry-first"], &["dram.model=banked"]] {
        let reports = [0, 1, 2, 3].map(|degree| replayed(Some(degree), sets));
        let colours = reports.each_ref().map(|r| r.actions.total(work_id("sh-colour")));
        assert!(colours[0] > 0 && colours == [colours[0]; 4], "{colours:?}");
        let bytes = reports.each_ref().map(|r| r.actions.total(DRAM_READ));
        assert_eq!(bytes[3] - bytes[0], colours[0] * (103 - 13), "{sets:?}");
        assert_eq!(bytes[2] - bytes[1], colours[0] * (61 - 31), "{sets:?}");
        let energy = reports.each_ref().map(|r| r.energy.total().0);
        assert!(energy.is_sorted() && energy[0] < energy[3], "{energy:?}");
    }
    // Colours alone: 35.35 pJ for 133 operations.
    let arithmetic = |degree| replayed(Some(degree), &[]).energy.part(Phase::Rendering, Flop).0;
    let n = replayed(Some(0), &[]).actions.total(work_id("sh-colour")) as f64;
    let saved = arithmetic(3) - arithmetic(0);
    let due = n * 35.35 * (133.0 - 6.0) / 133.0;
    assert!((saved - due).abs() < 1e-6 * due, "{saved} pJ, {due} pJ expected");
}

#[test]
fn a_trace_that_does_not_say_counts_as_degree_three() {
    let (unknown, three) = (replayed(None, &[]), replayed(Some(3), &[]));
    assert_eq!(unknown.sh_degree, None);
    assert_eq!(FrameReport { sh_degree: three.sh_degree, ..unknown }, three);
}

#[test]
fn the_published_model_knows_no_degree() {
    let report = |degree| {
        let workload = bin(&frame(Some(degree)), Geometry::REFERENCE);
        paper::simulate(Label::default(), &workload, Padding::TrueTiles, &UnitPrices::PUBLISHED)
    };
    assert_eq!(report(0), report(3));
}
