//! A camera, and a small COLMAP model in its binary form: what readers are tested and fuzzed
//! with.

use glam::{DMat3, DVec3};
use powergs_frame::scene::Camera;

/// A view with an off-centre principal point that is turned and away from the origin.
pub fn sample() -> Camera {
    Camera {
        name: "a.jpg".to_string(),
        width: 800,
        height: 600,
        fx: 700.0,
        fy: 710.0,
        cx: 410.0,
        cy: 290.0,
        world_to_camera: DMat3::from_rotation_y(0.3) * DMat3::from_rotation_x(-0.2),
        centre: DVec3::new(1.0, 2.0, -3.0),
        split: None,
        eye: None,
    }
}

/// Cameras along a bent way, each turned a little more.
pub fn poses(n: usize) -> Vec<Camera> {
    (0..n)
        .map(|i| {
            let t = i as f64;
            Camera {
                centre: DVec3::new(t * t * 0.3, (t * 1.3).sin(), 0.2 * t),
                world_to_camera: DMat3::from_rotation_y(0.4 * t) * DMat3::from_rotation_x(0.1 * t),
                fx: 700.0 + t,
                ..sample()
            }
        })
        .collect()
}

/// Two cameras and two images, as `(cameras.bin, images.bin)`.
pub fn binary_files() -> (Vec<u8>, Vec<u8>) {
    let mut cameras = 2u64.to_le_bytes().to_vec();
    let mut put = |id: u32, model: i32, size: [u64; 2], parameters: [f64; 4]| {
        cameras.extend(id.to_le_bytes());
        cameras.extend(model.to_le_bytes());
        size.iter().for_each(|v| cameras.extend(v.to_le_bytes()));
        parameters.iter().for_each(|v| cameras.extend(v.to_le_bytes()));
    };
    put(1, 1, [640, 480], [500.0, 500.0, 320.0, 240.0]);
    put(2, 2, [320, 240], [250.0, 160.0, 120.0, 0.01]);
    let mut images = 2u64.to_le_bytes().to_vec();
    let mut put = |id: u32, pose: [f64; 7], camera: u32, name: &str, points: &[[f64; 3]]| {
        images.extend(id.to_le_bytes());
        pose.iter().for_each(|v| images.extend(v.to_le_bytes()));
        images.extend(camera.to_le_bytes());
        images.extend(name.as_bytes());
        images.push(0);
        images.extend((points.len() as u64).to_le_bytes());
        points.iter().flatten().for_each(|v| images.extend(v.to_le_bytes()));
    };
    put(7, [0.0, 1.0, 0.0, 0.0, 1.0, 2.0, 3.0], 1, "z.png", &[[10.5, 20.5, -1.0]]);
    put(3, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 2, "a b.png", &[]);
    (cameras, images)
}

/// The two files as one input of the fuzz target: the length of the first, then both.
pub fn joined(cameras: &[u8], images: &[u8]) -> Vec<u8> {
    [&(cameras.len() as u16).to_le_bytes(), cameras, images].concat()
}

/// Seeds of the fuzz targets: target, name, bytes.
pub fn seeds() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let (cameras, images) = binary_files();
    let transforms = br#"{"w":8,"h":6,"fl_x":5,"frames":[{"file_path":"a","transform_matrix":
        [[1,0,0,0],[0,0,-1,-4],[0,1,0,0.5],[0,0,0,1]]}]}"#;
    let inria = br#"[{"id":0,"img_name":"a","width":8,"height":6,"position":[0,0,0],
        "rotation":[[1,0,0],[0,1,0],[0,0,1]],"fx":5,"fy":5}]"#;
    vec![
        ("cameras_colmap", "two", joined(&cameras, &images)),
        ("cameras_json", "transforms", transforms.to_vec()),
        ("cameras_json", "inria", inria.to_vec()),
    ]
}
