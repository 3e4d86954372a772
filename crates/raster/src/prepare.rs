//! What comes before blending: visible splats in depth order, and the tiles that each touches.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::blend::Paint;
use powergs_frame::splat::project::{LANES, View, Visible, colour_block, project_block};
use powergs_frame::splat::runs::Runs;
use powergs_frame::splat::{Intersection, Splat, TileGrid};
use powergs_scene::{Camera, Gaussians};

/// Items that are brought together before something is made of them.
const NEAR: usize = 64;
/// Gaussians projected by one task; a power of two.
const PART: usize = 128 * LANES;

/// A view that is ready to be blended. The next one is made in its memory.
#[derive(Debug, Default)]
pub(super) struct Prepared {
    /// Visible splats in the order of the scene, by part of [`PART`] Gaussians.
    visible: Vec<Vec<Visible>>,
    /// One bit per Gaussian: passed the cull.
    pub survivor_bits: Vec<u8>,
    keys: Vec<u64>,
    /// Visible splats in depth order, ties by index in the scene.
    pub splats: Vec<Splat>,
    /// As blending wants them.
    pub paints: Vec<Paint>,
    /// The tiles that they touch.
    pub runs: Runs,
}

impl Prepared {
    /// Projects a scene, sorts what is visible and tests it against the tiles of `grid`.
    pub fn prepare(
        &mut self,
        scene: &Gaussians,
        camera: &Camera,
        grid: TileGrid,
        test: Intersection,
        level: Level,
    ) {
        let Prepared { visible, survivor_bits, keys, splats, paints, runs } = self;
        project(scene, camera, level, visible, survivor_bits);
        let depth = |v: &Visible| v.splat.depth;
        in_depth_order(visible, depth, keys, (splats, paints), |_, Visible { splat, colour }| {
            (splat, Paint::new(&splat, colour))
        });
        runs.renew(splats, grid, test);
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        self.visible.iter().map(Vec::capacity).sum::<usize>() * size_of::<Visible>()
            + self.survivor_bits.capacity()
            + self.keys.capacity() * size_of::<u64>()
            + self.splats.capacity() * size_of::<Splat>()
            + self.paints.capacity() * size_of::<Paint>()
            + self.runs.bytes()
    }
}

/// The splats of a view that are visible and their colours, front to back by what `key` makes of
/// their depths, ties by index in the scene.
pub fn front_to_back(
    scene: &Gaussians,
    camera: &Camera,
    level: Level,
    key: impl Fn(f32) -> f32 + Sync,
) -> (Vec<Splat>, Vec<[f32; 3]>) {
    let (mut visible, mut splats, mut colours) = (Vec::new(), Vec::new(), Vec::new());
    project(scene, camera, level, &mut visible, &mut Vec::new());
    in_depth_order(
        &visible,
        |visible| key(visible.splat.depth),
        &mut Vec::new(),
        (&mut splats, &mut colours),
        |_, visible| (visible.splat, visible.colour),
    );
    (splats, colours)
}

/// Projects the scene: the visible splats of each part of [`PART`] Gaussians in index order, and
/// one bit per Gaussian that survived.
pub(super) fn project(
    scene: &Gaussians,
    camera: &Camera,
    level: Level,
    visible: &mut Vec<Vec<Visible>>,
    survivor_bits: &mut Vec<u8>,
) {
    project_then(scene, &View::new(camera), level, visible, survivor_bits, |visible, part| {
        // No more than the view that sees most of the part needs.
        part.clear();
        part.reserve_exact(visible.len());
        part.extend_from_slice(visible);
    });
}

/// As [`project`], of a view, with what `then` makes of the visible splats of each part.
pub(super) fn project_then<T: Send + Default>(
    scene: &Gaussians,
    view: &View,
    level: Level,
    made: &mut Vec<T>,
    survivor_bits: &mut Vec<u8>,
    then: impl Fn(&[Visible], &mut T) + Sync,
) {
    made.resize_with(scene.len().div_ceil(PART), T::default);
    survivor_bits.resize(scene.len().div_ceil(8), 0);
    made.par_iter_mut().zip(survivor_bits.par_chunks_mut(PART / 8)).enumerate().for_each_init(
        Vec::new,
        |visible: &mut Vec<Visible>, (part, (made, bits))| {
            let (first, end) = (part * PART, ((part + 1) * PART).min(scene.len()));
            // In the room of a part before: what is made of it is often much less.
            visible.clear();
            for (i, bits) in (first..end).step_by(LANES).zip(bits.chunks_mut(LANES / 8)) {
                let stop = (i + LANES).min(end);
                let mask = dispatch!(level, simd =>
                    project_block(simd, scene, view, i, stop, visible));
                bits.copy_from_slice(&mask.to_le_bytes()[..bits.len()]);
            }
            for some in visible.chunks_mut(LANES) {
                dispatch!(level, simd => colour_block(simd, scene, view, some));
            }
            then(visible, made);
        },
    );
}

/// Two things that `make` makes of every item of `parts`, of which it is told the part, in
/// ascending depth, ties by place. No part has more than [`PART`].
pub(super) fn in_depth_order<
    V: Copy + Sync,
    A: Send + Default + Clone,
    B: Send + Default + Clone,
>(
    parts: &[Vec<V>],
    depth: impl Fn(&V) -> f32 + Sync,
    keys: &mut Vec<u64>,
    (a, b): (&mut Vec<A>, &mut Vec<B>),
    make: impl Fn(usize, V) -> (A, B) + Sync,
) {
    // Depth, part, position in the part: positive floats order like their bits.
    let depth = &depth;
    keys.resize(parts.iter().map(Vec::len).sum(), 0);
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
    // No two keys are equal, so that the order is the same in every run.
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
}
