//! Random scenes, and frozen ones (`tests/data/README.md`).

use glam::{DMat3, DVec3};
use powergs_frame::scene::{Camera, Gaussians};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::Value;

pub fn floats(v: &Value) -> Vec<f64> {
    fn walk(v: &Value, out: &mut Vec<f64>) {
        match v {
            Value::Array(items) => items.iter().for_each(|i| walk(i, out)),
            other => out.push(other.as_f64().expect("a number")),
        }
    }
    let mut out = Vec::new();
    walk(v, &mut out);
    out
}

pub fn rows<const N: usize>(v: &Value) -> Vec<[f32; N]> {
    floats(v).chunks(N).map(|c| std::array::from_fn(|i| c[i] as f32)).collect()
}

/// A file of `tests/data`.
pub fn load(name: &str) -> Value {
    let path = format!("{}/../../tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A camera from a row-major world-to-camera matrix; the principal point is the image centre.
pub fn camera(width: u32, height: u32, tan: [f64; 2], view: &[f64]) -> Camera {
    let rotation = DMat3::from_cols_array(&[
        view[0], view[4], view[8], view[1], view[5], view[9], view[2], view[6], view[10],
    ]);
    let translation = DVec3::new(view[3], view[7], view[11]);
    let (w, h) = (f64::from(width), f64::from(height));
    Camera {
        name: "reference".into(),
        width,
        height,
        fx: w / (2.0 * tan[0]),
        fy: h / (2.0 * tan[1]),
        cx: w / 2.0,
        cy: h / 2.0,
        world_to_camera: rotation,
        centre: -(rotation.transpose() * translation),
        split: None,
        eye: None,
    }
}

/// Random Gaussians in front of a camera that looks along +z, some behind it, some off the image,
/// some huge, some opaque.
pub fn random_scene(seed: u64, n: usize, degree: u8) -> Gaussians {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut scene = Gaussians { sh_degree: degree, ..Gaussians::default() };
    for _ in 0..n {
        let z: f32 = rng.random_range(-0.5..6.0);
        let spread = z.abs().max(0.5) * 0.9;
        scene.means.push([rng.random_range(-spread..spread), rng.random_range(-spread..spread), z]);
        let size: f32 = rng.random_range(-5.0..-1.0);
        scene.log_scales.push(std::array::from_fn(|_| size + rng.random_range(-1.5f32..0.5)));
        scene.rotations.push(std::array::from_fn(|_| rng.random_range(-1.0f32..1.0)));
        scene.logit_opacities.push(rng.random_range(-6.0..6.0));
        for _ in 0..3 * scene.sh_coefficients() {
            scene.sh.push(rng.random_range(-0.7..0.7));
        }
    }
    scene
}

pub fn front_camera(width: u32, height: u32) -> Camera {
    let view = [1.0, 0.0, 0.0, 0.02, 0.0, 1.0, 0.0, -0.03, 0.0, 0.0, 1.0, 0.1, 0.0, 0.0, 0.0, 1.0];
    camera(width, height, [0.6, 0.6 * f64::from(height) / f64::from(width)], &view)
}

fn logit(p: f32) -> f32 {
    (f64::from(p) / (1.0 - f64::from(p))).ln() as f32
}

/// `[coefficient][channel]` per Gaussian to `[channel][coefficient]`.
fn channel_major(sh: &[f64]) -> Vec<f32> {
    sh.chunks(48)
        .flat_map(|g| (0..3).flat_map(move |c| (0..16).map(move |k| g[k * 3 + c] as f32)))
        .collect()
}

/// The case, its scene, its camera and its background.
pub fn forward_input() -> (Value, Gaussians, Camera, [f32; 3]) {
    let case = load("forward_counters.json")["cases"][0].clone();
    let input = &case["input"];
    let scene = Gaussians {
        means: rows(&input["means"]),
        log_scales: rows::<3>(&input["scales"]).iter().map(|s| s.map(f32::ln)).collect(),
        rotations: rows(&input["quats"]),
        logit_opacities: floats(&input["opacity"]).iter().map(|&o| logit(o as f32)).collect(),
        sh_degree: 3,
        sh: channel_major(&floats(&input["sh"])),
        antialiased: false,
    };
    let tan = ["tanfovx", "tanfovy"].map(|k| input[k].as_f64().unwrap());
    let size = ["W", "H"].map(|k| input[k].as_u64().unwrap() as u32);
    let camera = camera(size[0], size[1], tan, &floats(&input["view"]));
    let background = rows(&input["bg"])[0];
    (case, scene, camera, background)
}

pub fn ints(v: &Value) -> Vec<u32> {
    floats(v).iter().map(|&x| x as u32).collect()
}
