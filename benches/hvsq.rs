//! HVSQ of pictures of 512x512 pixels at the four poolings of the regions, with its gradient, as
//! training evaluates it.
//!
//! `cargo bench --bench hvsq` prints times on one and two threads; the aim is 60 ms on two.

use std::time::Instant;

use powergs_sim::picture::Picture;
use powergs_sim::quality::Hvsq;

/// The poolings of R1 to R4, pixels.
const POOLINGS: [f64; 4] = [1.0, 3.0, 7.0, 12.0];

/// Repetitions; the median is reported.
const ROUNDS: usize = 15;

/// A picture with structure of all sizes, and some noise.
fn picture(side: u32, seed: u32) -> Picture {
    let pixel = |i: u32| {
        let (x, y) = ((i % side) as f32, (i / side) as f32);
        let dice = i.wrapping_mul(0x9e37_79b9).wrapping_add(seed).wrapping_mul(0x85eb_ca6b);
        let noise = (dice >> 16) as f32 / 65536.0;
        let wave = |k: f32| 0.5 + 0.5 * (k * x + 0.7 * k * y).sin();
        [0.01, 0.1, 0.6].map(|k| 0.8 * wave(k) + 0.2 * noise)
    };
    Picture { width: side, height: side, pixels: (0..side * side).map(pixel).collect() }
}

fn median_ms(mut work: impl FnMut()) -> f64 {
    work();
    let mut times: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[ROUNDS / 2]
}

fn main() {
    for side in [256, 512, 1024] {
        let (shown, wanted) = (picture(side, 1), picture(side, 2));
        let mut line = format!("HVSQ {side}x{side}, poolings 1, 3, 7, 12:");
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let (values, evaluated) = pool.expect("a thread pool").install(|| {
                let mut hvsq = Hvsq::new(side, side, &POOLINGS).expect("a measure");
                let reference = hvsq.reference(&wanted);
                let mut gradient = vec![[0.0; 3]; shown.pixels.len()];
                let values = median_ms(|| drop(hvsq.values(&shown, &reference)));
                let evaluate = || drop(hvsq.evaluate(&shown, &reference, &[1.0; 4], &mut gradient));
                (values, median_ms(evaluate))
            });
            line += &format!(
                "\n  {threads} threads: values {values:.1} ms, with gradient {evaluated:.1} ms"
            );
        }
        println!("{line}");
    }
}
