//! Does a trained model look like its photos? PSNR against the values that came with the model.

use std::path::Path;

use powergs_sim::raster::{Detail, Options, render};
use powergs_sim::scene::files::open_cameras;
use powergs_sim::scene::{OneFile, read};
use serde_json::Value;

#[test]
fn a_trained_model_fits_its_photos() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/snowmiku-posed");
    if !folder.exists() {
        println!("skipped: ../shared/data is absent");
        return;
    }
    let bytes = std::fs::read(folder.join("point_cloud.ply")).unwrap();
    let scene = read(&OneFile(&bytes), "point_cloud.ply", None).unwrap().gaussians;
    let cameras = open_cameras(&folder.join("cameras.json"), None, None).unwrap().cameras;
    let text = std::fs::read_to_string(folder.join("model_eval.json")).unwrap();
    let eval: Value = serde_json::from_str(&text).unwrap();
    for index in [0, 8, 40] {
        let camera = &cameras[index];
        let photo = std::fs::read(folder.join("images").join(&camera.name)).unwrap();
        let limits = powergs_pixels::Limits { side: 1 << 14, bytes: 1 << 30 };
        let photo = powergs_pixels::decode(&photo, limits).unwrap();
        let picture = render(&scene, camera, &Options::reference(Detail::Image)).picture;
        let square: f64 = picture
            .pixels
            .iter()
            .zip(photo.rgba8())
            .flat_map(|(p, q)| (0..3).map(move |c| (p[c].clamp(0.0, 1.0), q[c])))
            .map(|(p, q)| (f64::from(p) - f64::from(q) / 255.0).powi(2))
            .sum();
        let psnr = -10.0 * (square / (3 * picture.pixels.len()) as f64).log10();
        let expected = eval["views"]
            .as_array()
            .unwrap()
            .iter()
            .find(|v| v["img"] == camera.name.as_str() && v["downscale"] == 1)
            .and_then(|v| v["psnr"].as_f64())
            .unwrap();
        // Stated to two decimals by another renderer; JPEG decoders differ in the last bit.
        assert!((psnr - expected).abs() < 0.02, "{}: {psnr:.3}, {expected} dB", camera.name);
    }
}
