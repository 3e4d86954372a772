//! What a scene and its frames measure, in the terms in which workload statistics are published.

use std::collections::BTreeMap;

use glam::Vec3;
use powergs_core::workload::{Geometry, bin};
use powergs_frame::splat::{Counters, Intersection};
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, Options, render};
use powergs_scene::camera::edit::resized;
use powergs_scene::synth::Statistic;
use powergs_scene::{Camera, Gaussians};

/// The image size at which pairs with 8x8 tiles were published, pixels.
const PAIRS_SIZE: (u32, u32) = (1920, 1080);
/// An opacity below which a Gaussian counts as faint.
const LOW_OPACITY: f32 = 0.35;
/// An axis ratio from which a Gaussian counts as spiky.
const SPIKY_RATIO: f32 = 3.0;

/// Measured statistics.
pub type SceneStatistics = BTreeMap<Statistic, f64>;

/// What one frame contributes.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameCounts {
    /// Counters with 16x16 tiles and OBB lists.
    pub counters: Counters,
    /// List lengths of those tiles.
    pub tile_lengths: Vec<u32>,
    /// List entries times pixels, summed over tiles: evaluations without early termination.
    pub pair_pixels: u64,
    /// α evaluations that contribute, and all until pixels stop, with 16x16 tiles and lists of
    /// bounding squares.
    pub squares: [u64; 2],
    /// Pairs of bounding squares, with tiles of 16x16 and of 64x64.
    pub square_pairs: [u64; 2],
    /// Pairs with 8x8 tiles at 1920x1080: bounding squares, exact ellipses. Where measured.
    pub pairs_8x8: Option<[u64; 2]>,
}

/// Statistics of a scene and its frames. Those of frames are means over the frames, those of lists
/// are over the tiles of all frames that have a list, the longest list is the longest of all.
pub fn statistics(scene: &Gaussians, frames: &[FrameCounts]) -> SceneStatistics {
    let mut all = model_statistics(scene);
    if frames.is_empty() {
        return all;
    }
    let count = frames.len() as f64;
    let sum = |value: fn(&Counters) -> u64| {
        frames.iter().map(|frame| value(&frame.counters)).sum::<u64>() as f64
    };
    let mut lengths: Vec<u32> =
        frames.iter().flat_map(|f| &f.tile_lengths).copied().filter(|n| *n > 0).collect();
    lengths.sort_unstable();
    let quantile = |q: f64| match lengths.len().checked_sub(1) {
        Some(last) => f64::from(lengths[(q * last as f64).round() as usize]),
        None => 0.0,
    };
    let total: u64 = lengths.iter().map(|n| u64::from(*n)).sum();
    let pair_pixels: u64 = frames.iter().map(|frame| frame.pair_pixels).sum();
    let (visible, evaluations) = (sum(|c| c.intersecting_points), sum(|c| c.alpha_evaluations));
    all.insert(Statistic::Survivors, sum(|c| c.survivors) / sum(|c| c.points).max(1.0));
    all.insert(Statistic::Visible, visible / count);
    all.insert(Statistic::TilesPerSplat, sum(|c| c.tile_pairs) / visible.max(1.0));
    all.insert(Statistic::ListMean, total as f64 / lengths.len().max(1) as f64);
    all.insert(Statistic::ListMedian, quantile(0.5));
    all.insert(Statistic::ListP99, quantile(0.99));
    all.insert(Statistic::ListMax, quantile(1.0));
    all.insert(Statistic::ContributingObb, sum(|c| c.blends) / evaluations.max(1.0));
    let squares = |idx: usize| frames.iter().map(|frame| frame.squares[idx]).sum::<u64>() as f64;
    all.insert(Statistic::ContributingAabb, squares(0) / squares(1).max(1.0));
    let pairs = |idx: usize| frames.iter().map(|frame| frame.square_pairs[idx]).sum::<u64>() as f64;
    all.insert(Statistic::SquaresPerBox, pairs(0) / sum(|c| c.tile_pairs).max(1.0));
    all.insert(Statistic::Squares64Per16, pairs(1) / pairs(0).max(1.0));
    all.insert(Statistic::TerminationSaving, pair_pixels as f64 / evaluations.max(1.0));
    let pairs: Vec<[u64; 2]> = frames.iter().filter_map(|frame| frame.pairs_8x8).collect();
    for (idx, statistic) in [Statistic::PairsAabb, Statistic::PairsExact].into_iter().enumerate() {
        if !pairs.is_empty() && !scene.is_empty() {
            let sum: u64 = pairs.iter().map(|pair| pair[idx]).sum();
            all.insert(statistic, sum as f64 / pairs.len() as f64 / scene.len() as f64);
        }
    }
    all
}

/// Statistics of the Gaussians alone.
fn model_statistics(scene: &Gaussians) -> SceneStatistics {
    let count = scene.len().max(1) as f64;
    let low = (LOW_OPACITY / (1.0 - LOW_OPACITY)).ln();
    let faint = scene.logit_opacities.iter().filter(|logit| **logit < low).count();
    let ratio = |s: &[f32; 3]| s[0].max(s[1]).max(s[2]) - s[0].min(s[1]).min(s[2]);
    let mut ratios: Vec<f32> = scene.log_scales.iter().map(ratio).collect();
    let spiky = ratios.iter().filter(|ratio| **ratio >= SPIKY_RATIO.ln()).count();
    ratios.sort_unstable_by(f32::total_cmp);
    let median = ratios.get(ratios.len() / 2).map_or(0.0, |ratio| f64::from(*ratio).exp());
    SceneStatistics::from([
        (Statistic::Points, scene.len() as f64),
        (Statistic::LowOpacity, faint as f64 / count),
        (Statistic::Spiky, spiky as f64 / count),
        (Statistic::AxisRatio, median),
        (Statistic::NeighbourDistance, neighbour_distance(&scene.means)),
    ])
}

/// Median distance of neighbours in memory over that of any two, which a hash picks.
fn neighbour_distance(means: &[[f32; 3]]) -> f64 {
    let at = |i: usize| Vec3::from_array(means[i % means.len().max(1)]);
    let median = |pair: &dyn Fn(usize) -> (usize, usize)| {
        let mut all: Vec<f32> = (1..means.len())
            .map(|i| {
                let (one, other) = pair(i);
                at(one).distance(at(other))
            })
            .collect();
        all.sort_unstable_by(f32::total_cmp);
        all.get(all.len() / 2).map_or(0.0, |middle| f64::from(*middle))
    };
    // No random numbers: the same scene gives the same statistics.
    let mix = |i: usize| i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 20;
    let any = median(&|i| (mix(2 * i), mix(2 * i + 1)));
    if any > 0.0 { median(&|i| (i - 1, i)) / any } else { 1.0 }
}

/// Measures one view; `pairs_8x8` asks for the pairs with 8x8 tiles at 1920x1080 too.
pub fn measure(scene: &Gaussians, camera: &Camera, pairs_8x8: bool) -> FrameCounts {
    let options = Options::reference(Detail::Counters);
    let rendered = render(scene, camera, &options);
    let tile = options.tile;
    let tiles_x = camera.width.div_ceil(tile);
    let inside = |at: u32, size: u32| u64::from(tile.min(size - at * tile));
    let pixels = |idx: usize| {
        let (x, y) = (idx as u32 % tiles_x, idx as u32 / tiles_x);
        inside(x, camera.width) * inside(y, camera.height)
    };
    let lengths = rendered.tiles.iter().map(|t| t.entries);
    let pair_pixels = lengths.clone().enumerate().map(|(i, n)| u64::from(n) * pixels(i)).sum();
    let aabb = Options { test: Intersection::Aabb, ..options };
    let squares = render(scene, camera, &aabb).counters;
    let (counters, tile_lengths) = (rendered.counters, lengths.collect());
    let frame = rendered.into_frame(camera, options.background);
    let square_pairs = [16, 64].map(|tile| pairs(&frame, tile, Intersection::Aabb));
    FrameCounts {
        squares: [squares.blends, squares.alpha_evaluations],
        counters,
        tile_lengths,
        pair_pixels,
        square_pairs,
        pairs_8x8: pairs_8x8.then(|| count_pairs_8x8(scene, camera)),
    }
}

fn count_pairs_8x8(scene: &Gaussians, camera: &Camera) -> [u64; 2] {
    let options = Options::reference(Detail::Counters);
    let camera = resized(camera, PAIRS_SIZE.0, PAIRS_SIZE.1);
    let frame = render(scene, &camera, &options).into_frame(&camera, options.background);
    [Intersection::Aabb, Intersection::Ellipse].map(|test| pairs(&frame, 8, test))
}

/// Pairs of splats and tiles of `tile` pixels.
fn pairs(frame: &Frame, tile: u32, test: Intersection) -> u64 {
    let chunk = Options::reference(Detail::Counters).chunk;
    let geometry =
        Geometry { tile, subtile: tile, sort_group: tile, chunk, test, ..Geometry::REFERENCE };
    bin(frame, geometry).counters.tile_pairs
}
