//! What nerfstudio leaves: camera paths, and how it moved a data set.

use glam::{DMat3, DVec3};
use powergs_scene::camera::{CameraFile, Frame, Placement, json};

fn path(fields: &str, camera: &str) -> String {
    format!(
        r#"{{"render_height": 48, "render_width": 64, {fields} "camera_path": [{{
            "camera_to_world": [1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1], {camera} "aspect": 1.3}}]}}"#
    )
}

fn read(text: &str) -> CameraFile {
    json::read(text, None).unwrap()
}

#[test]
fn a_camera_path_is_read_in_the_frame_of_the_model() {
    let file = read(&path(r#""camera_type": "perspective","#, r#""fov": 90,"#));
    assert_eq!((file.format, file.frame), ("nerfstudio camera path", Frame::Model));
    let camera = &file.cameras[0];
    assert_eq!((camera.width, camera.height, camera.name.as_str()), (64, 48, "path_0000"));
    // Half of the height at 45 degrees.
    assert!((camera.fx - 24.0).abs() < 1e-9 && camera.fx == camera.fy);
    assert_eq!(camera.centre, DVec3::new(5.0, 6.0, 7.0));
    // OpenGL looks along -z.
    assert_eq!(camera.forward(), DVec3::NEG_Z);
    let wide = read(&path(r#""default_fov": 50,"#, ""));
    assert!((wide.cameras[0].vertical_fov().to_degrees() - 50.0).abs() < 1e-9);
}

#[test]
fn what_is_no_pinhole_is_refused() {
    let error = |text: &str| json::read(text, None).unwrap_err().to_string();
    let panorama = error(&path(r#""camera_type": "equirectangular","#, r#""fov": 90,"#));
    assert!(panorama.contains("`equirectangular` is neither a pinhole nor a lens"), "{panorama}");
    let frame = |model: &str| {
        format!(
            r#"{{"camera_model": "{model}", "w": 64, "h": 48, "fl_x": 60, "frames": [{{
            "file_path": "a.png", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0]]}}]}}"#
        )
    };
    for model in ["EQUIRECTANGULAR", "ORTHOPHOTO", "VR180_L", "OMNIDIRECTIONALSTEREO_R"] {
        let error = error(&frame(model));
        assert!(error.contains("key `camera_model`") && error.contains(model), "{error}");
    }
    for model in ["PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "SIMPLE_RADIAL", "perspective"] {
        assert_eq!(read(&frame(model)).cameras.len(), 1, "{model}");
    }
    assert_eq!(read(&frame("OPENCV_FISHEYE")).warnings.len(), 1);
    for fov in ["-5", "0", "180", "\"x\""] {
        assert!(error(&path("", &format!("\"fov\": {fov},"))).contains("`fov`"));
    }
    let short = path("", r#""fov": 90,"#).replace("0,0,0,1]", "0,0,1]");
    assert!(error(&short).contains("sixteen numbers"));
}

/// p' = s (R p + t), for points that `applied_transform` has moved before.
#[test]
fn cameras_follow_the_model() {
    let turn = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(1.0);
    let shift = DVec3::new(0.5, -1.0, 2.0);
    let rows: Vec<String> = (0..3)
        .map(|i| format!("[{}, {}, {}, {}]", turn.row(i).x, turn.row(i).y, turn.row(i).z, shift[i]))
        .collect();
    let text = format!(r#"{{"transform": [{}], "scale": 0.25}}"#, rows.join(","));
    let placement = Placement::read(&text).unwrap();
    let applied = "[[0,1,0,0],[1,0,0,0],[0,0,-1,3]]";
    let frame = |extra: &str| {
        format!(
            r#"{{{extra} "w": 64, "h": 48, "fl_x": 60, "frames": [{{"file_path": "a.png",
            "transform_matrix": [[0,0,1,4],[1,0,0,5],[0,1,0,6]]}}]}}"#
        )
    };
    let plain = read(&frame(""));
    let moved = placement.of(&plain.cameras[0]);
    let want = (turn * DVec3::new(4.0, 5.0, 6.0) + shift) * 0.25;
    assert!((moved.centre - want).length() < 1e-12);
    assert!((moved.forward() - turn * plain.cameras[0].forward()).length() < 1e-12);
    assert_eq!((moved.fx, moved.width), (60.0, 64));
    // The camera was at (5, 4, 3 - 6) before it was moved.
    let extra = format!(r#""applied_transform": {applied}, "applied_scale": 0.5,"#);
    let Frame::Data(done) = read(&frame(&extra)).frame else { panic!("cameras of a data set") };
    let moved = placement.after(&done).of(&plain.cameras[0]);
    let want = (turn * DVec3::new(5.0, 4.0, -3.0) + shift) * 0.5;
    assert!((moved.centre - want).length() < 1e-12, "{} {want}", moved.centre);
    for bad in ["{}", r#"{"transform": [[2,0,0,0],[0,1,0,0],[0,0,1,0]], "scale": 1}"#, "[]", "x"] {
        assert!(Placement::read(bad).is_err(), "{bad}");
    }
    for scale in ["0", "-1", "1e300", "null"] {
        let text = text.replace("0.25", scale);
        assert!(Placement::read(&text).unwrap_err().to_string().contains("`scale`"), "{scale}");
    }
}
