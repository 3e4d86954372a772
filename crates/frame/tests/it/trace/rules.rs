//! Frames that break a rule are not written.

use powergs_frame::trace::{Frame, FrameFault, TraceError, Writer};
use powergs_testkit::traces::{SMALL, Shape, frame, header};

/// `change` breaks exactly the rule that `expected` names.
#[track_caller]
fn check(change: impl Fn(&mut Frame), expected: &str) {
    // A frame with splats, stopped pixels and everything optional.
    let mut broken = frame(11, Shape { splats: 12, ..SMALL });
    broken.check().unwrap();
    change(&mut broken);
    let fault = broken.check().unwrap_err();
    assert!(fault.to_string().contains(expected), "{fault}");
    let mut out = Writer::new(Vec::new(), &header(21)).unwrap();
    let error = out.write_frame(&broken).unwrap_err();
    assert!(matches!(error, TraceError::Frame { frame: 0, fault: f } if same(&f, &fault)));
    assert!(out.is_empty(), "nothing was written");
}

/// Equal, where NaN equals itself.
fn same(a: &FrameFault, b: &FrameFault) -> bool {
    a.to_string() == b.to_string()
}

#[test]
fn facts() {
    check(|f| f.facts.camera.width = 0, "the width is not between");
    check(|f| f.facts.camera.height = 65_537, "the height is not between");
    check(|f| f.facts.camera.fx = 0.0, "focal length");
    check(|f| f.facts.camera.fy = f64::NAN, "focal length");
    check(|f| f.facts.camera.cx = f64::INFINITY, "principal point");
    check(|f| f.facts.camera.world_to_camera *= 1.01, "orthonormal");
    check(|f| f.facts.camera.world_to_camera.x_axis.x = f64::NAN, "orthonormal");
    check(|f| f.facts.camera.centre.z = f64::NAN, "centre");
    check(|f| f.facts.points = 1 << 32, "2^32 - 1");
    check(|f| f.facts.survivors = 22, "more survivors than Gaussians");
    check(|f| f.facts.survivors = 11, "more splats than survivors");
    check(|f| f.facts.survivors += 1, "do not add up");
    check(|f| f.facts.background[1] = f32::NAN, "background");
    check(|f| f.facts.mean_linear_rgb = Some([0.0, -0.1, 0.0]), "mean linear");
    check(|f| f.facts.mean_linear_rgb = Some([1e300, 0.1, 0.0]), "mean linear");
    check(|f| f.facts.camera.name = "x".repeat(65_536), "longer than 65,535");
}

#[test]
fn splats() {
    check(|f| f.splats[3].index = 21, "column `index`, entry 3: 21 is not in the scene");
    check(|f| f.splats[3].depth = -1.0, "`depth`, entry 3: -1 is not positive");
    check(|f| f.splats[3].depth = f32::NAN, "`depth`, entry 3: NaN is not positive");
    check(|f| f.splats[0].mean[0] = f32::INFINITY, "`mean_x`, entry 0: inf is not finite");
    check(|f| f.splats[0].cov[2] = f32::NAN, "`cov_d`, entry 0");
    check(|f| f.splats[11].opacity = 1.5, "`opacity`, entry 11: 1.5 is not from 0 to 1");
    check(|f| f.splats.swap(4, 5), "breaks the order");
    check(|f| f.splats[5] = f.splats[4], "breaks the order");
    let twice = |f: &mut Frame| {
        f.splats[0].index = f.splats[11].index;
        f.splats[0].depth = f32::from_bits(1);
        f.splats[11].depth = f32::MAX;
    };
    check(twice, "occurs twice");
}

#[test]
fn columns() {
    check(|f| f.pixels.stop_rank.truncate(14), "`stop_rank` has 14 entries where 15 are due");
    check(|f| f.pixels.blended.push(0), "`blended` has 16 entries");
    check(|f| f.pixels.stop_rank[7] = 12, "`stop_rank`, entry 7: 12 is not the rank of a splat");
    let too_many = |f: &mut Frame| (f.pixels.stop_rank[2], f.pixels.blended[2]) = (3, 5);
    check(too_many, "`blended`, entry 2: 5 is more than the splats up to the stop");
    check(|f| f.survivor_bits.as_mut().unwrap()[2] |= 0x80, "bits beyond the scene");
    check(|f| f.survivor_bits.as_mut().unwrap().push(0), "`survivor_bits` has 4 entries");
    check(|f| f.frustum_bits.as_mut().unwrap().push(0), "`frustum_bits` has 4 entries");
    check(|f| f.frustum_bits.as_mut().unwrap()[2] |= 0x80, "bits beyond the scene");
    let behind = |f: &mut Frame| {
        let survivors = f.survivor_bits.clone().unwrap();
        f.frustum_bits = Some(survivors.iter().map(|byte| !byte & 0x1F).collect());
    };
    check(behind, "inside the frustum but behind the near plane");
    let culled = |f: &mut Frame| {
        let (gone, bits) = (f.splats[2].index, f.survivor_bits.as_mut().unwrap());
        let spare = (0..21u32).find(|i| bits[*i as usize / 8] >> (i % 8) & 1 == 0).unwrap();
        for index in [gone, spare] {
            bits[index as usize / 8] ^= 1 << (index % 8);
        }
    };
    check(culled, "is visible but no survivor of the cull");
    check(|f| f.preview.as_mut().unwrap().width = 4, "`preview` has 18 entries where 24 are due");
    check(|f| f.preview.as_mut().unwrap().height = 0, "preview is not between");
}

#[test]
fn fovea() {
    check(|f| f.fovea.as_mut().unwrap().gaze[0] = 1.5, "gaze");
    check(|f| f.fovea.as_mut().unwrap().gaze[1] = f32::NAN, "gaze");
    check(|f| f.fovea.as_mut().unwrap().highest_level[1] = 4, "`highest_level`, entry 1: 4");
    check(|f| f.fovea.as_mut().unwrap().highest_level.clear(), "`highest_level` has 0");
    check(|f| f.fovea.as_mut().unwrap().stop_rank_2[0] = 12, "`stop_rank_2`, entry 0: 12");
    check(|f| f.fovea.as_mut().unwrap().extra_alpha[0] = 13, "`extra_alpha`, entry 0: 13");
    check(|f| f.fovea.as_mut().unwrap().blended_2[14] = 13, "`blended_2`, entry 14: 13");
}

#[test]
fn headers() {
    let too_long = powergs_frame::trace::TraceHeader { scene: "s".repeat(65_536), ..header(1) };
    assert!(Writer::new(Vec::new(), &too_long).is_err());
    assert!(Writer::new(Vec::new(), &header(1 << 32)).is_err());
    let mut other = Writer::new(Vec::new(), &header(22)).unwrap();
    let error = other.write_frame(&frame(1, SMALL)).unwrap_err().to_string();
    assert!(error.contains("differs from that of the trace header"), "{error}");
}
