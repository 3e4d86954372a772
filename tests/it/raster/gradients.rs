//! Gradients against frozen references and against themselves.

use powergs_sim::raster::train::{Gradients, Options, Tape, Which};
use powergs_sim::scene::{Camera, Gaussians};
use serde_json::Value;

use super::support::{camera, floats, load, rows};

/// `[coefficient][channel]` per Gaussian to `[channel][coefficient]`.
fn channel_major(sh: &[f64]) -> Vec<f32> {
    sh.chunks(48)
        .flat_map(|g| (0..3).flat_map(move |c| (0..16).map(move |k| g[k * 3 + c] as f32)))
        .collect()
}

fn reference(case: &Value) -> (Gaussians, Camera, Options) {
    let scene = Gaussians {
        means: rows(&case["means"]),
        log_scales: rows(&case["log_scales"]),
        rotations: rows(&case["quats_raw"]),
        logit_opacities: rows::<1>(&case["logit_opacity"]).into_flattened(),
        sh_degree: 3,
        sh: channel_major(&floats(&case["sh"])),
    };
    let tan = ["tanfovx", "tanfovy"].map(|k| case[k].as_f64().unwrap());
    let size = ["W", "H"].map(|k| case[k].as_u64().unwrap() as u32);
    let camera = camera(size[0], size[1], tan, &floats(&case["view"]));
    let background = rows::<3>(&case["bg"])[0];
    (scene, camera, Options { background, ..Options::reference() })
}

/// Planes of red, green and blue to pixels.
fn pixels(planes: &Value) -> Vec<[f32; 3]> {
    let values = floats(planes);
    let n = values.len() / 3;
    (0..n).map(|i| std::array::from_fn(|c| values[c * n + i] as f32)).collect()
}

#[test]
fn reference_gradients_match() {
    for case in load("raster_gradients.json")["cases"].as_array().unwrap() {
        let (scene, camera, options) = reference(case);
        let weights = pixels(&case["loss_weights"]);
        let mut tape = Tape::new();
        let picture = tape.forward(&scene, &camera, &options);
        let image = pixels(&case["image"]);
        let loss: f64 = picture
            .pixels
            .as_flattened()
            .iter()
            .zip(weights.as_flattened())
            .map(|(p, w)| f64::from(*p) * f64::from(*w))
            .sum();
        for (got, want) in picture.pixels.as_flattened().iter().zip(image.as_flattened()) {
            assert!((got - want).abs() < 2e-5, "{got} {want}");
        }
        assert!((loss - case["loss"].as_f64().unwrap()).abs() < 1e-3, "{loss}");
        let mut gradients = Gradients::new();
        tape.backward(&scene, &weights, Which::All, &mut gradients);
        let expected = &case["grad"];
        let sh: Vec<f32> = channel_major(&floats(&expected["sh"]));
        let want = ["means", "log_scales", "quats_raw", "logit_opacity"]
            .map(|k| rows::<1>(&expected[k]).into_flattened());
        let names = ["means", "log_scales", "quats_raw", "logit_opacity", "sh"];
        for (name, (got, want)) in
            names.iter().zip(gradients.flat().iter().zip(want.iter().chain([&sh])))
        {
            let largest = want.iter().fold(0.0f32, |a, b| a.max(b.abs()));
            let worst =
                got.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0f32, f32::max) / largest;
            eprintln!("{name}: {worst:e}");
            assert_eq!(got.len(), want.len());
            // Single against double precision; the reference asks for 1e-3.
            assert!(worst < 1e-4, "{name}: {worst}");
        }
    }
}
