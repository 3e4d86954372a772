//! Bins a trace frame under a geometry: lists, chunks, sub-tile work.
//!
//! Rows of tiles are independent, so they are binned in parallel; only "who loads a splat first" is
//! decided over the whole frame, in raster order of tiles.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::fovea::TileFovea;
use super::group::count_groups;
use super::storage::Storage;
use super::tile::{RowPart, bin_row};
use super::{ChunkWork, Cull, FrameDetail, FrameWorkload, Geometry, Pixels};
use powergs_frame::splat::runs::{Runs, Touch};
use powergs_frame::splat::{Counters, TileGrid};
use powergs_frame::trace::Frame;

/// Nobody loaded it.
pub(super) const NOBODY: u32 = u32::MAX;

/// Bins `frame` under `geometry`. At the reference geometry every counter equals the rasteriser's;
/// at another one the stop ranks are still those of the reference tiling, and the difference is
/// what its intersection test leaves out.
pub fn bin(frame: &Frame, geometry: Geometry) -> FrameWorkload {
    bin_for(frame, geometry, FrameDetail::default())
}

/// As [`bin`], with what some machines need besides.
pub fn bin_for(frame: &Frame, geometry: Geometry, detail: FrameDetail) -> FrameWorkload {
    let camera = &frame.facts.camera;
    let grid = TileGrid::new(camera.width, camera.height, geometry.tile);
    let fovea = frame.fovea.as_ref().map(|fovea| TileFovea::new(fovea, grid));
    let runs = match &fovea {
        None => Runs::new(&frame.splats, grid, geometry.test),
        Some(fovea) => {
            let levels = fovea.levels();
            Runs::foveated(&frame.splats, grid, geometry.test, levels)
        }
    };
    let first_tile: Vec<AtomicU32> =
        (0..frame.splats.len()).map(|_| AtomicU32::new(NOBODY)).collect();
    let mut parts: Vec<RowPart> = (0..grid.ny)
        .into_par_iter()
        .map(|ty| {
            let part = bin_row(frame, &runs, fovea.as_ref(), (geometry, detail), ty);
            for (i, tile) in part.tiles.iter().enumerate() {
                let index = ty * grid.nx + i as u32;
                for &rank in &part.list[tile.list_start as usize..][..tile.loaded as usize] {
                    first_tile[rank as usize].fetch_min(index, Ordering::Relaxed);
                }
            }
            part
        })
        .collect();
    let first_tile: Vec<u32> = first_tile.into_iter().map(AtomicU32::into_inner).collect();
    let storage = Storage::new(frame, &runs.touches, geometry.cull);
    parts.par_iter_mut().enumerate().for_each(|(ty, part)| {
        count_first_loads(part, ty as u32 * grid.nx, &first_tile, geometry.chunk);
        if fovea.is_some() {
            count_level_loads(part, ty as u32 * grid.nx, &first_tile, &runs.touches);
        }
        find_completion(part, &storage.slot);
    });
    let pixels = detail.pixels.then(|| {
        let mut iterated = Vec::with_capacity(grid.width as usize * grid.height as usize);
        for part in &mut parts {
            iterated.append(&mut part.iterated);
        }
        Pixels { splats: frame.splats.clone(), iterated }
    });
    let groups = count_groups(&runs, fovea.as_ref(), geometry, &mut parts);
    let mut counters = assemble_counters(frame, &runs, &parts);
    if let (Cull::Frustum, Some(all)) = (geometry.cull, storage.prefix.last()) {
        counters.survivors = all.survivors.into();
    }
    counters.fetched_points = first_tile.iter().filter(|&&tile| tile != NOBODY).count() as u64;
    let fovea = fovea.map(|fovea| fovea.work(&runs.touches, &first_tile, &parts));
    FrameWorkload {
        counters,
        camera: Some(camera.clone()),
        sh_degree: frame.facts.colour_degree(),
        fovea,
        groups,
        index: frame.splats.par_iter().map(|s| s.index).collect(),
        depth: frame.splats.par_iter().map(|s| s.depth).collect(),
        slot: storage.slot,
        storage: storage.prefix,
        detail,
        pixels,
        ..assemble(geometry, grid, parts)
    }
}

fn find_completion(part: &mut RowPart, slot: &[u32]) {
    for tile in &mut part.tiles {
        let list = &part.list[tile.list_start as usize..][..tile.entries as usize];
        tile.complete_after = list.iter().map(|&rank| slot[rank as usize] + 1).max().unwrap_or(0);
    }
}

fn count_first_loads(part: &mut RowPart, first_index: u32, first_tile: &[u32], chunk: u32) {
    for (index, tile) in (first_index..).zip(&part.tiles) {
        let loaded = &part.list[tile.list_start as usize..][..tile.loaded as usize];
        let chunks = &mut part.chunks[tile.chunk_start as usize..][..tile.chunks as usize];
        for (work, entries) in chunks.iter_mut().zip(loaded.chunks(chunk as usize)) {
            work.first_loads =
                entries.iter().filter(|&&rank| first_tile[rank as usize] == index).count() as u32;
        }
    }
}

/// Further levels of the entries that are loaded first in their chunk.
fn count_level_loads(part: &mut RowPart, first_index: u32, first_tile: &[u32], touches: &[Touch]) {
    for (index, tile) in (first_index..).zip(&part.tiles) {
        let mut start = tile.list_start as usize;
        for work in &mut part.chunks[tile.chunk_start as usize..][..tile.chunks as usize] {
            let entries = &part.list[start..][..work.entries as usize];
            let mine = entries.iter().filter(|&&rank| first_tile[rank as usize] == index);
            let further = |&rank: &u32| u32::from(touches[rank as usize].levels.max(1) - 1);
            work.level_loads = mine.map(further).sum();
            start += work.entries as usize;
        }
    }
}

fn assemble_counters(frame: &Frame, runs: &Runs, parts: &[RowPart]) -> Counters {
    let mut counters = Counters {
        points: frame.facts.points,
        survivors: frame.facts.survivors,
        ..Counters::default()
    };
    for touch in &runs.touches {
        counters.touch(touch);
    }
    for tile in parts.iter().flat_map(|part| &part.tiles) {
        counters.tile_loads += u64::from(tile.loaded);
        counters.alpha_evaluations += tile.alpha_evaluations;
        counters.blends += tile.blends;
    }
    counters
}

fn assemble(geometry: Geometry, grid: TileGrid, parts: Vec<RowPart>) -> FrameWorkload {
    let mut workload = FrameWorkload {
        width: grid.width,
        height: grid.height,
        tiles_x: grid.nx,
        tiles_y: grid.ny,
        tiles: Vec::with_capacity(grid.len()),
        chunks: Vec::with_capacity(parts.iter().map(|p| p.chunks.len()).sum()),
        list: Vec::with_capacity(parts.iter().map(|p| p.list.len()).sum()),
        bitmaps: Vec::with_capacity(parts.iter().map(|p| p.bitmaps.len()).sum()),
        stops: Vec::with_capacity(parts.iter().map(|p| p.stops.len()).sum()),
        ..FrameWorkload::empty(geometry)
    };
    for part in parts {
        let (list, chunk) = (workload.list.len() as u32, workload.chunks.len() as u32);
        workload.tiles.extend(part.tiles.into_iter().map(|mut tile| {
            tile.list_start += list;
            tile.chunk_start += chunk;
            tile
        }));
        workload.list.extend(part.list);
        workload.bitmaps.extend(part.bitmaps);
        workload.stops.extend(part.stops);
        workload.chunks.extend(part.chunks);
    }
    let pairs = |chunk: &ChunkWork| u64::from(chunk.skipping.subtile_pairs);
    let pairs: u64 = workload.chunks.iter().map(pairs).sum();
    workload.alpha_evaluations_executed = pairs * u64::from(geometry.subtile).pow(2);
    workload
}
