//! What lies where in the memory does not move by chance: Gaussians that nobody sees, behind all
//! others in storage order, change nothing but the reads of their own records.

use powergs_core::run::{Change, MemoryFrames, Session, System};
use powergs_core::sim::FrameReport;
use powergs_dram::Device;
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{front_camera, random_scene};

/// A frame with so many Gaussians behind the camera.
fn frame(unseen: usize) -> Frame {
    let mut scene = random_scene(3, 12_000, 1);
    for _ in 0..unseen {
        scene.means.push([0.0, 0.0, -50.0]);
        scene.log_scales.push([-4.0; 3]);
        scene.rotations.push([1.0, 0.0, 0.0, 0.0]);
        scene.logit_opacities.push(0.0);
        scene.sh.extend([0.0; 12]);
    }
    let camera = front_camera(160, 112);
    render(&scene, &camera, &Options::reference(Detail::Counters)).into_frame(&camera, [0.0; 3])
}

fn replayed(unseen: usize, sets: &[&str]) -> FrameReport {
    let changes: Vec<Change> = sets.iter().map(|s| s.parse().expect("a change")).collect();
    let system = System::named("gscore").expect("a machine").with(&changes).expect("a system");
    let mut frames = MemoryFrames::new("scene", [frame(unseen)]);
    let mut reports = Session::new(&mut frames, &()).reports(&[system]).expect("accounts close");
    reports.remove(0).remove(0)
}

#[test]
fn gaussians_that_nobody_sees_move_no_time() {
    // Jobs that go to whichever core is free first go elsewhere after a difference of a few cycles:
    // one core does not show that.
    let times = [0, 1, 7, 100].map(|unseen| {
        let report = replayed(unseen, &["dram.model=banked", "vru.cores=1"]);
        report.timing().expect("timed").frame as f64
    });
    let most = times.iter().map(|time| (time / times[0] - 1.0).abs()).fold(0.0, f64::max);
    assert!(most < 1e-3, "{times:?}");
}

/// Arrays begin at multiples of 1 MiB: at the first column of the first bank of the first channel,
/// whatever lies in front of them.
#[test]
fn a_row_of_all_banks_divides_where_arrays_begin() {
    for preset in powergs_base::config::embedded::DRAM {
        let device = Device::parse(preset.text).expect("a device");
        let o = &device.organisation;
        let banks = o.channels * o.pseudo_channels * o.bank_groups * o.banks;
        let row = u64::from(banks) * o.row.0;
        assert_eq!((1 << 20) % row, 0, "{}: {row} B", preset.name);
    }
}
