//! What binning a frame takes: counted before any list is built.

use rayon::prelude::*;

use super::{ChunkWork, FrameDetail, Geometry, TileWork};
use powergs_base::budget::{Budget, OverBudget};
use powergs_frame::splat::runs::{Run, Touch};
use powergs_frame::splat::{Cover, Splat, TileGrid};
use powergs_frame::trace::Frame;

/// A frame that cannot be binned under a geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Unbinnable {
    /// Lists that take more memory than is allowed.
    #[error("{pairs} (splat, tile) pairs: binning them {over}")]
    Memory {
        /// Tiles that the splats touch, together.
        pairs: u64,
        /// What they take.
        over: OverBudget,
    },
    /// Lists whose places do not fit into 32 bits.
    #[error(
        "{0} (splat, tile) pairs, and a frame has at most 4294967295; take larger tiles or a \
         smaller image"
    )]
    Pairs(u64),
}

/// Memory that binning `frame` under `geometry` takes, bytes, at most about so much.
///
/// # Errors
/// [`Unbinnable`]: more than `budget`, or more pairs than a frame can have.
pub fn demand(
    frame: &Frame,
    geometry: Geometry,
    detail: FrameDetail,
    budget: Budget,
) -> Result<u64, Unbinnable> {
    let camera = &frame.facts.camera;
    let grid = TileGrid::new(camera.width, camera.height, geometry.tile);
    // Bounding squares are quickly counted, and mostly few enough.
    let squares = count(&frame.splats, |splat| {
        let rect = splat.tile_rect(&grid);
        [rect.area(), u64::from(rect.y1 - rect.y0)]
    });
    let (most, rows) = (squares[0], squares[1]);
    let kept = match detail.pixels {
        true => size_of_val(&*frame.splats) + size_of_val(&*frame.pixels.stop_rank),
        false => 0,
    } as u64;
    let bytes = bytes(frame, geometry, grid, most, rows) + kept;
    if budget.check(bytes).is_ok() && most <= u64::from(u32::MAX) {
        return Ok(bytes);
    }
    let [pairs, rows] = count(&frame.splats, |splat| {
        let cover = Cover::new(splat, grid, geometry.test);
        let rows = (cover.rect.y0..cover.rect.y1).filter_map(|y| cover.row(y));
        rows.fold([0, 0], |[n, rows], row| [n + u64::from(row.x1 - row.x0), rows + 1])
    });
    let bytes = self::bytes(frame, geometry, grid, pairs, rows) + kept;
    budget.check(bytes).map_err(|over| Unbinnable::Memory { pairs, over })?;
    if pairs > u64::from(u32::MAX) { Err(Unbinnable::Pairs(pairs)) } else { Ok(bytes) }
}

fn count(splats: &[Splat], of: impl Fn(&Splat) -> [u64; 2] + Sync + Send) -> [u64; 2] {
    let add = |a: [u64; 2], b: [u64; 2]| [a[0] + b[0], a[1] + b[1]];
    splats.par_iter().with_min_len(4096).map(of).reduce(|| [0; 2], add)
}

/// Everything that is in memory while `pairs` in `rows` of tiles become lists. Vectors that grow
/// take up to twice their length, and lists are there twice while rows are put together.
fn bytes(frame: &Frame, geometry: Geometry, grid: TileGrid, pairs: u64, rows: u64) -> u64 {
    let size = |bytes: usize| bytes as u64;
    let pair = 2 * (size(size_of::<u32>()) + size(geometry.bitmap_bytes()));
    let chunks = (pairs / u64::from(geometry.chunk.max(1))).saturating_add(size(grid.len()));
    let stops = size(size_of::<[u32; 4]>()) * u64::from(geometry.subtiles());
    let splat = size(size_of::<Touch>()) + 4 * size(size_of::<u32>());
    [
        (pairs, pair),
        (rows, 2 * size(size_of::<Run>())),
        (chunks, 3 * size(size_of::<ChunkWork>())),
        (size(grid.len()), 2 * (size(size_of::<TileWork>()) + stops)),
        (size(frame.splats.len()), splat),
    ]
    .into_iter()
    .fold(0, |sum: u64, (count, each)| sum.saturating_add(count.saturating_mul(each)))
}
