//! The physical floor of rasterisation on this machine, measured in the same run as the code:
//! 16-pixel rows that blend anything at some cycles of 16-lane SIMD each, plus compulsory bytes at
//! DRAM speed (the cost model of `evidence/performance.md`).

use std::hint::black_box;
use std::sync::LazyLock;
use std::time::Instant;

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16};
use fearless_simd_macros::simd;
use powergs_sim::raster::Rendered;
use powergs_sim::scene::Gaussians;
use powergs_sim::splat::{Ellipse, TileGrid};
use powergs_sim::trace::NEVER;
use rayon::prelude::*;

/// Reads a clock, seconds.
pub type Now = fn() -> f64;

/// The clock on the wall.
pub fn wall() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// What cannot be avoided.
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// Cycles of 16-lane vectors per row of 16 pixels that a splat blends in.
    pub cycles_per_row: f64,
    /// Times that the parameters of visible splats and the image cross the DRAM interface.
    pub crossings: u64,
}

/// What this machine can do.
#[derive(Debug, Clone, Copy)]
pub struct Peaks {
    /// Clock under load, GHz.
    pub clock_ghz: f64,
    /// DRAM read rate of all threads, GB/s.
    pub read_gb_s: f64,
    /// Lanes of the widest single-precision vector.
    pub lanes: f64,
    /// Threads.
    pub threads: f64,
}

impl Peaks {
    /// Measures clock and memory by `now`; best of several rounds.
    pub fn measure(now: Now) -> Peaks {
        let threads = rayon::current_num_threads();
        let clock = (0..5).map(|_| clock_ghz(now)).fold(0.0, f64::max);
        let data = vec![1u64; 32 << 20];
        let read = (0..5).map(|_| read_gb_s(&data, now)).fold(0.0, f64::max);
        Peaks { clock_ghz: clock, read_gb_s: read, lanes: lanes(), threads: threads as f64 }
    }
}

/// A chain of dependent fused multiply-adds on the widest vectors, four cycles each on current x86
/// and Arm processors, on all threads at once: the clock under SIMD load.
fn clock_ghz(now: Now) -> f64 {
    let level = Level::new();
    (0..rayon::current_num_threads())
        .into_par_iter()
        .map(|_| dispatch!(level, simd => fma_chain_ghz(simd, now)))
        .reduce(|| f64::INFINITY, f64::min)
}

#[simd]
fn fma_chain_ghz<S: Simd>(simd: S, now: Now) -> f64 {
    const LINKS: u32 = 20_000_000;
    const LATENCY: f64 = 4.0;
    let scale = f32x16::splat(simd, black_box(0.5));
    let step = f32x16::splat(simd, black_box(0.5));
    let start = now();
    let mut x = f32x16::splat(simd, black_box(0.3));
    for _ in 0..LINKS {
        x = x.mul_add(scale, step);
    }
    black_box::<[f32; 16]>(x.into());
    LATENCY * f64::from(LINKS) / (now() - start) / 1e9
}

fn read_gb_s(data: &[u64], now: Now) -> f64 {
    let start = now();
    let sum: u64 = data
        .par_chunks(1 << 18)
        .map(|part| part.iter().fold(0u64, |a, &b| a.wrapping_add(b)))
        .reduce(|| 0, u64::wrapping_add);
    black_box(sum);
    size_of_val(data) as f64 / (now() - start) / 1e9
}

#[cfg(target_arch = "x86_64")]
fn lanes() -> f64 {
    if is_x86_feature_detected!("avx512f") {
        16.0
    } else if is_x86_feature_detected!("avx2") {
        8.0
    } else {
        4.0
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn lanes() -> f64 {
    4.0
}

/// The floor of one frame, milliseconds.
#[derive(Debug, Clone, Copy)]
pub struct Floor {
    /// Rows of 16 pixels of (splat, tile) pairs that blend anything.
    pub rows: u64,
    /// Compulsory bytes: parameters of visible splats and the image.
    pub bytes: u64,
    /// The floor, milliseconds.
    pub milliseconds: f64,
}

/// The floor of `rendered` (reference tiling, with counters) on a machine with `peaks`.
pub fn floor(scene: &Gaussians, rendered: &Rendered, peaks: Peaks, cost: Cost) -> Floor {
    let rows = blending_rows(rendered);
    let parameters = 4 * (11 + 3 * scene.sh_coefficients() as u64);
    let once =
        parameters * rendered.splats.len() as u64 + 12 * rendered.picture.pixels.len() as u64;
    let bytes = cost.crossings * once;
    let cycles = rows as f64 * cost.cycles_per_row * 16.0 / peaks.lanes / peaks.threads;
    let milliseconds = cycles / peaks.clock_ghz * 1e-6 + bytes as f64 / peaks.read_gb_s * 1e-6;
    Floor { rows, bytes, milliseconds }
}

fn blending_rows(rendered: &Rendered) -> u64 {
    let grid = TileGrid::new(rendered.picture.width, rendered.picture.height, 16);
    rendered
        .splats
        .par_iter()
        .enumerate()
        .map(|(rank, splat)| {
            let Some(conic) = splat.conic() else { return 0 };
            let Some(ellipse) = Ellipse::new(splat, conic) else { return 0 };
            let rect = splat.tile_rect(&grid);
            let mut rows = 0;
            for y in rect.y0 * 16..(rect.y1 * 16).min(grid.height) {
                let Some((a, b)) = ellipse.columns(i64::from(y), i64::from(y) + 1) else {
                    continue;
                };
                for tx in rect.x0..rect.x1 {
                    let (x0, _, x1, _) = grid.pixels(tx, y / 16);
                    let hit = (i64::from(x0).max(a)..i64::from(x1).min(b)).any(|x| {
                        let i = y as usize * grid.width as usize + x as usize;
                        let stop = rendered.pixels.stop_rank[i];
                        stop == NEVER || rank as u32 <= stop
                    });
                    rows += u64::from(hit);
                }
            }
            rows
        })
        .sum()
}
