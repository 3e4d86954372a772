//! Frames with their lists of tiles, as work of every dataflow that has them.

use super::{Work, WorkKey, WorkKind};
use crate::workload::demand::{Unbinnable, demand};
use crate::workload::{Cull, FrameDetail, FrameWorkload, Geometry, bin_for};
use powergs_base::budget::Budget;
use powergs_frame::scene::ShDegree;
use powergs_frame::splat::{Counters, Intersection};
use powergs_frame::trace::Frame;

/// Lists of tiles.
pub struct TileLists;

impl WorkKind for TileLists {
    fn name(&self) -> &'static str {
        "lists of tiles"
    }

    fn demand(&self, frame: &Frame, numbers: &[u32], budget: Budget) -> Result<u64, Unbinnable> {
        let (geometry, detail) = of_numbers(numbers);
        demand(frame, geometry, detail, budget)
    }

    fn prepare(&self, frame: &Frame, numbers: &[u32]) -> Box<dyn Work> {
        let (geometry, detail) = of_numbers(numbers);
        Box::new(bin_for(frame, geometry, detail))
    }
}

/// The key of workloads of a geometry, of machines that need nothing besides.
pub fn work_key(geometry: Geometry) -> WorkKey {
    work_key_for(geometry, FrameDetail::default())
}

/// The key of workloads of a geometry with what machines need besides.
pub(crate) fn work_key_for(geometry: Geometry, detail: FrameDetail) -> WorkKey {
    let Geometry { tile, subtile, sort_group, chunk, test, cull } = geometry;
    let mut numbers = vec![tile, subtile, sort_group, chunk, test as u32, cull as u32];
    numbers.extend(Some(detail.number()).filter(|&number| number > 0));
    WorkKey { kind: &TileLists, numbers }
}

/// Geometry and detail of a key.
fn of_numbers(numbers: &[u32]) -> (Geometry, FrameDetail) {
    let [tile, subtile, sort_group, chunk, test, cull, ref rest @ ..] = *numbers else {
        panic!("a key of lists of tiles has six numbers: {numbers:?}")
    };
    let detail = FrameDetail::of_number(rest.first().copied().unwrap_or(0));
    let cull = if cull == Cull::Frustum as u32 { Cull::Frustum } else { Cull::Depth };
    let tests = [Intersection::Aabb, Intersection::Obb, Intersection::Ellipse];
    let test = tests.into_iter().find(|known| *known as u32 == test);
    let test = test.expect("a key of a geometry");
    (Geometry { tile, subtile, sort_group, chunk, test, cull }, detail)
}

impl Work for FrameWorkload {
    fn key(&self) -> WorkKey {
        work_key_for(self.geometry, self.detail)
    }

    fn counters(&self) -> &Counters {
        &self.counters
    }

    fn sh_degree(&self) -> ShDegree {
        self.sh_degree
    }

    fn tiles(&self) -> usize {
        self.tiles.len()
    }

    fn bytes(&self) -> usize {
        FrameWorkload::bytes(self)
    }
}

/// Colour records are aligned to at most this: a burst of LPDDR memories, and a usual buffer word.
const ALIGNMENT_MAX: u64 = 32;

/// What colours at this distance are aligned to.
pub(crate) fn alignment_of(pitch: u64) -> u64 {
    1 << pitch.trailing_zeros().min(ALIGNMENT_MAX.ilog2())
}
