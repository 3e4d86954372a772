//! The flags that select views, and orbits.

use clap::Parser;
use glam::DVec3;
use powergs_sim::cli::camera_file::CameraArgs;
use powergs_sim::cli::{Exit, Failure};
use powergs_sim::scene::camera::inria;
use powergs_sim::scene::camera::orbit::SceneBounds;
use powergs_sim::scene::{Camera, Gaussians, Split};
use powergs_testkit::camera_files::poses;

#[derive(Debug, Parser)]
struct Flags {
    #[command(flatten)]
    cameras: CameraArgs,
}

/// The views that `flags` ask for, of seven poses of which the first two are `test`.
fn views(flags: &str) -> Result<(Vec<Camera>, Vec<String>), Failure> {
    let mut poses = poses(7);
    poses.iter_mut().enumerate().for_each(|(i, c)| {
        c.name = i.to_string();
        c.split = Some(if i < 2 { Split::Test } else { Split::Train });
    });
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), inria::write(&poses)).unwrap();
    let path = file.path().to_str().unwrap();
    let args = ["x", "--cameras", path].into_iter().chain(flags.split_whitespace());
    let flags =
        Flags::try_parse_from(args).map_err(|e| Failure::new(Exit::Usage, e.to_string()))?;
    let views = flags.cameras.cameras(None, || panic!("no orbit"))?;
    Ok((views.cameras, views.notes))
}

fn names(flags: &str) -> Vec<String> {
    views(flags).unwrap().0.into_iter().map(|c| c.name).collect()
}

#[test]
fn flags_apply_in_the_documented_order() {
    assert_eq!(names("--split train --every 2 --frames 1..3"), ["4", "6"]);
    assert_eq!(names("--every 3 --frames 1.. --stereo 0.1").len(), 4);
    assert_eq!(names("--path-frames 5 --frames ..2"), ["path_0000", "path_0001"]);
    let stereo = views("--frames 6.. --size 400x300 --stereo 0.064").unwrap().0;
    assert_eq!((stereo[1].name.as_str(), stereo[1].width), ("6_right", 400));
    let (cameras, warnings) = views("--frames 5..24").unwrap();
    assert_eq!((cameras.len(), warnings.len()), (2, 1));
    assert!(warnings[0].contains("only 7 views"), "{warnings:?}");
}

#[test]
fn flags_that_leave_nothing_say_why() {
    for (flags, words) in [
        ("--frames 7..9", "only 7 views"),
        ("--frames 3..3", "the range is empty"),
        ("--frames 4", "write it as 0..24"),
        ("--size 0x10", "write it as 1920x1080"),
        ("--size 99999x10", "65536"),
        ("--every 0", "non-zero"),
        ("--stereo -1", "--stereo"),
        ("--stereo nan", "--stereo"),
        ("--path-frames 0", "must be 1 to"),
        ("--every 7 --path-frames 9", "at least two views"),
        ("--orbit 3", "cannot be used with"),
        ("--orbit-fov 3", "cannot be used with"),
    ] {
        let failure = views(flags).unwrap_err();
        assert_eq!(failure.exit, Exit::Usage, "{flags}");
        assert!(failure.to_string().contains(words), "{flags}: {failure}");
    }
}

#[test]
fn orbit_looks_at_the_robust_centre() {
    let mut means = vec![[1.0, 2.0, 3.0]; 90];
    means.extend([[5.0, 2.0, 3.0]; 20]);
    means.extend([[1000.0, f32::NAN, 0.0], [1e6, 1e6, 1e6]]);
    let bounds = SceneBounds::of(&Gaussians { means, ..Gaussians::default() });
    assert_eq!(bounds.centre, DVec3::new(1.0, 2.0, 3.0));
    let args = ["x", "--orbit", "4", "--orbit-radius", "10", "--orbit-up", "-y"];
    let flags = Flags::try_parse_from(args).unwrap();
    let cameras = flags.cameras.cameras(None, || bounds).unwrap().cameras;
    assert_eq!(cameras.len(), 4);
    for camera in &cameras {
        assert!((camera.centre.distance(bounds.centre) - 10.0).abs() < 1e-9);
        let target = camera.centre + camera.forward() * 10.0;
        assert!((target - bounds.centre).length() < 1e-9, "{target}");
        // Up is -y, so cameras above the centre have a smaller y and look down, along +y.
        assert!(camera.centre.y < 2.0 && camera.forward().y > 0.0);
        assert!(camera.world_to_camera.row(1).y > 0.0, "image down is +y");
        assert!((camera.world_to_camera.determinant() - 1.0).abs() < 1e-12);
    }
}
