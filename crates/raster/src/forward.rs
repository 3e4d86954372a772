//! One frame: project, sort by depth, list, blend.

use std::sync::atomic::{AtomicU32, AtomicU64};

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::blend::{Counted, Dominance, ImageOnly, OPEN, Paint, Record, Tallied, WEIGHT_STEP};
use super::row::{RowTarget, Shared, TileCount, render_row};
use powergs_base::picture::Picture;
use powergs_frame::splat::project::{LANES, View, Visible, colour_block, project_block};
use powergs_frame::splat::runs::{Runs, Touch};
use powergs_frame::splat::{Counters, Intersection, Splat, TileGrid};
use powergs_frame::trace::{Frame, FrameFacts, PixelColumns, Preview};
use powergs_scene::{Camera, Gaussians, ShDegree};

/// Items that are brought together before something is made of them.
const NEAR: usize = 64;
/// Gaussians projected by one task; a power of two.
const PART: usize = 128 * LANES;

/// How to render.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Tile side, pixels (16 in the reference).
    pub tile: u32,
    /// Splat-against-tile test (OBB in the reference).
    pub test: Intersection,
    /// List entries fetched together (256 in the reference).
    pub chunk: u32,
    /// Background colour, sRGB.
    pub background: [f32; 3],
    /// What is recorded besides the image.
    pub detail: Detail,
    /// Instruction set; the best of this processor by default.
    pub level: Level,
}

impl Options {
    /// The reference tiling of traces over a black background: 16x16 tiles, OBB lists, chunks of
    /// 256.
    pub fn reference(detail: Detail) -> Options {
        Options {
            tile: 16,
            test: Intersection::Obb,
            chunk: 256,
            background: [0.0; 3],
            detail,
            level: Level::new(),
        }
    }
}

/// What is recorded besides the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Nothing.
    Image,
    /// The counters of a trace.
    Counters,
    /// The counters of a trace, what every pixel iterated, and per splat what pruning needs.
    Dominance,
    /// Per splat the pixels that it is blended into, and no other counter.
    Hits,
}

/// A rendered frame.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The image, over the background, not clamped.
    pub picture: Picture,
    /// Visible splats in depth order (position is the rank).
    pub splats: Vec<Splat>,
    /// One bit per Gaussian: passed the cull.
    pub survivor_bits: Vec<u8>,
    /// Degree of the scene's spherical harmonics.
    pub sh_degree: ShDegree,
    /// Frame totals; only `points` and `survivors` for [`Detail::Image`].
    pub counters: Counters,
    /// Tests and accepted tiles per splat, by rank.
    pub touches: Vec<Touch>,
    /// Tiles that fetched each splat (`intersect_count`), by rank.
    pub fetches: Vec<u32>,
    /// Pixels in which each splat is the heaviest (`dominance_count`), by rank.
    pub dominance: Vec<u32>,
    /// Pixels that each splat was blended into, by rank, without those that stop at it; only for
    /// [`Detail::Hits`].
    pub hits: Vec<u32>,
    /// The sum over all pixels of the weight with which each splat is blended, by rank; only for
    /// [`Detail::Dominance`].
    pub weights: Vec<f64>,
    /// Per-pixel columns of a trace.
    pub pixels: PixelColumns,
    /// Entries iterated by each pixel (`T_bf_term`), row-major; only for [`Detail::Dominance`].
    pub iterated: Vec<u32>,
    /// Tiles, row-major.
    pub tiles: Vec<TileCount>,
}

/// Renders one view. Cannot fail: scene and camera are checked where they are read.
pub fn render(scene: &Gaussians, camera: &Camera, options: &Options) -> Rendered {
    match options.detail {
        Detail::Image => render_as(scene, camera, options, ImageOnly),
        Detail::Counters => render_as(scene, camera, options, Counted),
        Detail::Dominance => render_as(scene, camera, options, Dominance),
        Detail::Hits => render_as(scene, camera, options, Tallied),
    }
}

fn render_as<R: Record>(
    scene: &Gaussians,
    camera: &Camera,
    options: &Options,
    record: R,
) -> Rendered {
    let (parts, survivor_bits) = project(scene, camera, options.level, Vec::new());
    let (splats, paints) = in_depth_order(&parts, Default::default());
    drop(parts);
    let grid = TileGrid::new(camera.width, camera.height, options.tile);
    let runs = Runs::new(&splats, grid, options.test);
    let len = |is_counted: bool| if is_counted { splats.len() } else { 0 };
    let fetches: Vec<AtomicU32> = (0..len(R::COUNT)).map(|_| AtomicU32::new(0)).collect();
    let tally: Vec<AtomicU64> =
        (0..len(R::PIXELS || R::WEIGHTS)).map(|_| AtomicU64::new(0)).collect();
    let shared = Shared {
        runs: &runs,
        paints: &paints,
        background: options.background,
        chunk: options.chunk,
        fetches: &fetches,
        tally: &tally,
        level: options.level,
    };
    let mut rendered = Rendered::sized::<R>(camera);
    let mut heaviest = vec![OPEN; if R::DOMINANCE { rendered.picture.pixels.len() } else { 0 }];
    rendered.tiles = targets(&mut rendered, &mut heaviest, grid)
        .into_par_iter()
        .enumerate()
        .flat_map_iter(|(ty, mut out)| render_row(&shared, ty as u32, record, &mut out))
        .collect();
    if R::DOMINANCE {
        rendered.dominance = vec![0; splats.len()];
        for rank in heaviest.iter().filter(|&&rank| rank != OPEN) {
            rendered.dominance[*rank as usize] += 1;
        }
    }
    rendered.survivor_bits = survivor_bits;
    rendered.sh_degree = scene.degree();
    rendered.touches = runs.touches;
    rendered.fetches = fetches.into_iter().map(AtomicU32::into_inner).collect();
    let tally = tally.into_iter().map(AtomicU64::into_inner);
    if R::PIXELS {
        rendered.hits = tally.map(|n| u32::try_from(n).unwrap_or(u32::MAX)).collect();
    } else {
        rendered.weights = tally.map(|n| n as f64 * f64::from(WEIGHT_STEP)).collect();
    }
    rendered.splats = splats;
    rendered.counters = totals(scene, &rendered);
    rendered
}

/// Projects the scene; visible splats of each part of [`PART`] Gaussians in index order, in the
/// room of those of another frame, and one bit per Gaussian that survived.
pub(super) fn project(
    scene: &Gaussians,
    camera: &Camera,
    level: Level,
    room: Vec<Vec<Visible>>,
) -> (Vec<Vec<Visible>>, Vec<u8>) {
    project_then(scene, &View::new(camera), level, room, |visible, part| {
        part.clear();
        part.extend_from_slice(visible);
    })
}

/// As [`project`], of a view, with what `then` makes of the visible splats of each part.
pub(super) fn project_then<T: Send + Default>(
    scene: &Gaussians,
    view: &View,
    level: Level,
    mut made: Vec<T>,
    then: impl Fn(&[Visible], &mut T) + Sync,
) -> (Vec<T>, Vec<u8>) {
    made.resize_with(scene.len().div_ceil(PART), T::default);
    let bits: Vec<Vec<u8>> = made
        .par_iter_mut()
        .enumerate()
        .map_init(Vec::new, |visible: &mut Vec<Visible>, (part, made)| {
            let (first, end) = (part * PART, ((part + 1) * PART).min(scene.len()));
            // In the room of a part before: what is made of it is often much less.
            visible.clear();
            let mut bits = Vec::with_capacity((end - first).div_ceil(8) + 1);
            for i in (first..end).step_by(LANES) {
                let stop = (i + LANES).min(end);
                let mask = dispatch!(level, simd =>
                    project_block(simd, scene, view, i, stop, visible));
                bits.extend_from_slice(&mask.to_le_bytes());
            }
            bits.truncate((end - first).div_ceil(8));
            for some in visible.chunks_mut(LANES) {
                dispatch!(level, simd => colour_block(simd, scene, view, some));
            }
            then(visible, made);
            bits
        })
        .collect();
    (made, bits.concat())
}

/// Splats, and their form for blending, in ascending depth, ties by index in the scene; in the room
/// of those of another frame.
pub(super) fn in_depth_order(
    parts: &[Vec<Visible>],
    room: (Vec<Splat>, Vec<Paint>),
) -> (Vec<Splat>, Vec<Paint>) {
    let depth = |v: &Visible| v.splat.depth;
    in_depth_order_by(parts, depth, room, |_, Visible { splat, colour }| {
        (splat, Paint::new(&splat, colour))
    })
}

/// Two things that `make` makes of every item of `parts`, of which it is told the part, in
/// ascending depth, ties by place. No part has more than [`PART`].
pub(super) fn in_depth_order_by<
    V: Copy + Sync,
    A: Send + Default + Clone,
    B: Send + Default + Clone,
>(
    parts: &[Vec<V>],
    depth: impl Fn(&V) -> f32 + Sync,
    (mut a, mut b): (Vec<A>, Vec<B>),
    make: impl Fn(usize, V) -> (A, B) + Sync,
) -> (Vec<A>, Vec<B>) {
    // Depth, part, position in the part: positive floats order like their bits.
    let depth = &depth;
    let mut keys = vec![0u64; parts.iter().map(Vec::len).sum()];
    let mut rest = &mut keys[..];
    let of_parts: Vec<&mut [u64]> = parts
        .iter()
        .map(|items| rest.split_off_mut(..items.len()).expect("a key for every item"))
        .collect();
    parts.par_iter().zip(of_parts).enumerate().for_each(|(part, (items, keys))| {
        for (i, (key, item)) in keys.iter_mut().zip(items).enumerate() {
            *key = u64::from(depth(item).to_bits()) << 32 | (part * PART + i) as u64;
        }
    });
    keys.par_sort_unstable();
    a.resize(keys.len(), A::default());
    b.resize(keys.len(), B::default());
    let outputs = a.par_chunks_mut(NEAR).zip(b.par_chunks_mut(NEAR));
    keys.par_chunks(NEAR).zip(outputs).with_min_len(16).for_each(|(keys, (a, b))| {
        // Brought together first, so that cache misses overlap.
        let place = |key: &u64| (*key as u32 as usize / PART, *key as u32 as usize % PART);
        let mut near = [None; NEAR];
        for (near, (part, i)) in near.iter_mut().zip(keys.iter().map(place)) {
            *near = Some((part, parts[part][i]));
        }
        for ((a, b), (part, item)) in a.iter_mut().zip(b).zip(near.into_iter().flatten()) {
            (*a, *b) = make(part, item);
        }
    });
    (a, b)
}

/// The lines of each row of tiles. Columns that are not recorded stay empty.
fn targets<'a>(
    rendered: &'a mut Rendered,
    heaviest: &'a mut [u32],
    grid: TileGrid,
) -> Vec<RowTarget<'a>> {
    let lines = (grid.width * grid.tile) as usize;
    let mut stop_rank = rendered.pixels.stop_rank.chunks_mut(lines);
    let mut blended = rendered.pixels.blended.chunks_mut(lines);
    let mut iterated = rendered.iterated.chunks_mut(lines);
    let mut heaviest = heaviest.chunks_mut(lines);
    rendered
        .picture
        .pixels
        .chunks_mut(lines)
        .map(|pixels| RowTarget {
            pixels,
            stop_rank: stop_rank.next().unwrap_or_default(),
            blended: blended.next().unwrap_or_default(),
            iterated: iterated.next().unwrap_or_default(),
            heaviest: heaviest.next().unwrap_or_default(),
        })
        .collect()
}

fn totals(scene: &Gaussians, rendered: &Rendered) -> Counters {
    let mut counters = Counters {
        points: scene.len() as u64,
        survivors: rendered.survivor_bits.iter().map(|b| u64::from(b.count_ones())).sum(),
        fetched_points: rendered.fetches.iter().filter(|&&n| n > 0).count() as u64,
        ..Counters::default()
    };
    for touch in &rendered.touches {
        counters.touch(touch);
    }
    for tile in &rendered.tiles {
        counters.tile_loads += u64::from(tile.loaded);
        counters.alpha_evaluations += tile.alpha_evaluations;
        counters.blends += tile.blends;
    }
    counters
}

/// Longer side of the picture that a trace carries for reports, pixels.
const PREVIEW_SIDE: u32 = 480;

impl Rendered {
    fn sized<R: Record>(camera: &Camera) -> Rendered {
        let n = camera.width as usize * camera.height as usize;
        let counts = if R::COUNT { n } else { 0 };
        Rendered {
            picture: Picture {
                width: camera.width,
                height: camera.height,
                pixels: vec![[0.0; 3]; n],
            },
            splats: Vec::new(),
            survivor_bits: Vec::new(),
            sh_degree: ShDegree::ZERO,
            counters: Counters::default(),
            touches: Vec::new(),
            fetches: Vec::new(),
            dominance: Vec::new(),
            hits: Vec::new(),
            weights: Vec::new(),
            pixels: PixelColumns { stop_rank: vec![0; counts], blended: vec![0; counts] },
            iterated: vec![0; if R::DOMINANCE { n } else { 0 }],
            tiles: Vec::new(),
        }
    }

    /// The trace frame of this rendering. Must have been rendered with the reference tiling and
    /// counters.
    pub fn into_frame(self, camera: &Camera, background: [f32; 3]) -> Frame {
        assert!(!self.pixels.stop_rank.is_empty(), "a trace frame needs Detail::Counters");
        Frame {
            facts: FrameFacts {
                camera: camera.clone(),
                points: self.counters.points,
                survivors: self.counters.survivors,
                sh_degree: Some(self.sh_degree),
                background,
                mean_linear_rgb: Some(self.picture.mean_linear_rgb()),
            },
            splats: self.splats,
            survivor_bits: Some(self.survivor_bits),
            pixels: self.pixels,
            fovea: None,
            preview: Some(preview(&self.picture)),
        }
    }
}

/// The picture that a trace carries.
pub(super) fn preview(picture: &Picture) -> Preview {
    let small = picture.shrunk(PREVIEW_SIDE);
    Preview { width: small.width, height: small.height, rgb: small.to_rgb8() }
}
