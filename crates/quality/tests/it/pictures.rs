//! Pictures that the tests share.

use powergs_base::config::embedded::{DISPLAYS, find};
use powergs_base::picture::Picture;
use powergs_frame::display::Display;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::Value;

/// Smooth waves with noise; values from about −0.1 to 1.2.
pub fn noisy(width: u32, height: u32, seed: u64) -> Picture {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let pixels = (0..width * height)
        .map(|i| {
            let (x, y) = ((i % width) as f32, (i / width) as f32);
            std::array::from_fn(|c| {
                let wave = (0.11 * x + 0.07 * y + c as f32).sin() * 0.45 + 0.55;
                wave + random.random_range(-0.2..0.2)
            })
        })
        .collect();
    Picture { width, height, pixels }
}

/// The same, as a display would show it.
pub fn shown(width: u32, height: u32, seed: u64) -> Picture {
    let mut picture = noisy(width, height, seed);
    for value in picture.pixels.as_flattened_mut() {
        *value = value.clamp(0.0, 1.0);
    }
    picture
}

/// A picture from planes of channels, as the reference vectors store them.
pub fn from_planes(shape: &Value, values: &Value) -> Picture {
    let size = |i: usize| shape[i].as_u64().expect("a size") as u32;
    let (height, width) = (size(1), size(2));
    let values = numbers(values);
    let n = (width * height) as usize;
    let pixels = (0..n).map(|i| [0, 1, 2].map(|c| values[c * n + i] as f32)).collect();
    Picture { width, height, pixels }
}

/// A list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

/// An embedded display.
pub fn display(name: &str) -> Display {
    Display::parse(find(DISPLAYS, name).expect("a preset")).expect("a good preset")
}

/// Runs `work` on `n` threads.
pub fn on_threads<T: Send>(n: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads").install(work)
}
