//! Clusters whose bounds are tested before records are read (A136).

use powergs_base::quantity::Bytes;
use powergs_core::flow::FrameTask;
use powergs_core::flow::tile_wise::BinningImpl;
use powergs_core::kernel::Memo;
use powergs_core::machine::Machine;
use powergs_core::sim::{Timed, time};
use powergs_core::workload::{Cull, FrameWorkload};
use powergs_energy::action::Phase;
use powergs_frame::trace::Frame;
use powergs_testkit::scenes::{front_camera, random_scene};

use crate::pipeline::support::gscore;
use crate::workload::support::rendered;

/// A frame of a model that is sorted along an axis, of which the camera sees one end.
fn frame() -> Frame {
    let mut scene = random_scene(7, 3000, 0);
    scene.means.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut camera = front_camera(75, 51);
    camera.centre.x += 3.5;
    rendered(&scene, &camera).1
}

fn machine(clusters: u32, cull: Cull) -> Machine {
    let mut machine = gscore();
    let m = machine.tiles_mut();
    m.geometry.cull = cull;
    m.ccu.clusters = clusters;
    machine
}

fn run(machine: &Machine, frame: &Frame) -> (Timed, FrameWorkload) {
    let flow = machine.flow();
    let work = flow.work_key(machine).prepare(frame);
    let memo = Memo::default();
    let timed = time(&FrameTask::first(machine, &*work, &memo)).expect("it runs");
    let workload: &FrameWorkload = (*work).of().expect("of this dataflow");
    (timed, workload.clone())
}

#[test]
fn only_bounds_are_read_of_clusters_that_nobody_sees() {
    let frame = frame();
    for cull in [Cull::Depth, Cull::Frustum] {
        let (whole, workload) = run(&machine(0, cull), &frame);
        let mut before = whole.outcome.served.stages[0].read;
        for size in [32, 64] {
            let (timed, _) = run(&machine(size, cull), &frame);
            let blocks = size as usize / 32;
            let mut last = 0;
            let mut live = 0;
            for (i, own) in workload.storage.chunks(blocks).enumerate() {
                let now = own.last().expect("a chunk").survivors;
                let records = (3000 - i as u64 * u64::from(size)).min(size.into());
                live += if now > last { records } else { 0 };
                last = now;
            }
            let position = machine(size, cull).tiles().record.position.0;
            let bounds = 3000u64.div_ceil(size.into()) * 16;
            let read = timed.outcome.served.stages[0].read;
            let skipped = (3000 - live) * position;
            assert_eq!(read + skipped, whole.outcome.served.stages[0].read + bounds);
            let rest = |t: &Timed| [1, 2].map(|stage| t.outcome.served.stages[stage].read);
            assert_eq!(rest(&timed), rest(&whole), "what follows is the same");
            let culls = |t: &Timed| t.outcome.actions.count(Phase::Preprocessing, cull_work());
            assert_eq!(culls(&timed), live + bounds / 16);
            if cull == Cull::Frustum {
                assert!(live < 2500, "{live} of 3000");
                before = before.min(read);
            }
        }
        if cull == Cull::Frustum {
            assert!(before < whole.outcome.served.stages[0].read);
        }
    }
}

fn cull_work() -> powergs_energy::action::ActionId {
    powergs_core::stage::work_id("cull")
}

/// Lists that are made with pointers are written whole, though the last records are not read.
#[test]
fn lists_are_finished_behind_the_last_record_that_is_read() {
    let frame = frame();
    for way in [BinningImpl::Append, BinningImpl::TwoPass] {
        let served = [0, 32, 96].map(|clusters| {
            let mut machine = machine(clusters, Cull::Frustum);
            let binning = &mut machine.tiles_mut().binning;
            binning.implementation = way;
            binning.combining.capacity = Bytes(4 << 10);
            run(&machine, &frame).0.outcome.served.stages
        });
        for stages in &served[1..] {
            assert_eq!(stages[0].write, served[0][0].write);
            assert_eq!(stages[1..], served[0][1..]);
        }
    }
}

#[test]
fn what_contradicts_clusters_names_both_keys() {
    let said = |change: fn(&mut Machine)| {
        let mut machine = machine(64, Cull::Depth);
        change(&mut machine);
        let found = machine.contradictions();
        found.iter().map(|problem| format!("{problem:?}")).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(said(|_| ()), "");
    assert!(said(|m| m.tiles_mut().ccu.clusters = 50).contains("multiple of 32"));
    assert!(said(|m| m.tiles_mut().ccu.cluster.0 = 0).contains("ccu.cluster"));
    let stereo = said(|m| {
        let stereo = &mut m.tiles_mut().stereo;
        stereo.implementation = powergs_core::flow::tile_wise::StereoImpl::Shared;
        m.tiles_mut().fovea.accumulators = 0;
    });
    assert!(stereo.contains("ccu.clusters") && stereo.contains("stereo.impl"), "{stereo}");
}
