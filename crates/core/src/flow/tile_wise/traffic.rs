//! Actions and DRAM bytes of a frame on a machine, from its totals alone.
//!
//! Nothing here depends on time. The pipeline moves the same bytes request by request; every run
//! checks that both agree.

use crate::flow::steps::StepPart;
use crate::flow::tile_wise::FrameContext;
use crate::flow::tile_wise::batch::Batch;
use crate::flow::tile_wise::bsu::Sort;
use crate::flow::tile_wise::cache;
use crate::flow::tile_wise::gradients::GradientWork;
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::rules::RuleCheck;
use crate::flow::tile_wise::schedule::{Job, Plan, SortProgress};
use crate::flow::tile_wise::vru::Render;
use crate::flow::tile_wise::{FeatureSource, Fetch};
use crate::kernel::blocks::BlockStream;
use crate::kernel::traffic::{StageTraffic, Traffic};
use crate::stage::{DRAM_READ, DRAM_WRITE, sram_read, sram_write};
use crate::workload::{FrameWorkload, TileWork};
use powergs_energy::action::{ActionCounts, Phase};

/// Records that a chunk loads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ChunkLoad {
    /// Feature records from DRAM: misses of the cache, or all without one.
    pub features: u64,
    /// Feature records from the cache.
    pub hits: u64,
    /// Colour records from DRAM.
    pub colours: u64,
    /// Records of further levels' colours from DRAM.
    pub levels: u64,
    /// Features of second levels from DRAM.
    pub seconds: u64,
}

impl ChunkLoad {
    /// Of the chunk at this position in [`FrameWorkload::chunks`].
    pub fn new(
        workload: &FrameWorkload,
        chunk: usize,
        units: &ResolvedUnits,
        context: &FrameContext,
    ) -> ChunkLoad {
        let work = &workload.chunks[chunk];
        let hits = context.hits.map_or(0, |hits| u64::from(hits[chunk]));
        let (colours, levels) = match units.ccu.spec.fetch {
            Fetch::LazyColour => (u64::from(work.first_loads), u64::from(work.level_loads)),
            Fetch::Everything | Fetch::GeometryFirst | Fetch::VisibleColour => (0, 0),
        };
        let features = u64::from(work.entries) - hits;
        // The cache keeps both levels of a record together.
        let seconds = u64::from(work.seconds) * features / u64::from(work.entries.max(1));
        ChunkLoad { features, hits, colours, levels, seconds }
    }

    /// Bytes that the chunk reads from DRAM.
    pub fn bytes(&self, units: &ResolvedUnits) -> u64 {
        let record = &units.ccu.record;
        let fovea = &units.vru.fovea;
        self.features * record.feature.0
            + self.colours * record.colour.0
            + self.levels * fovea.record.0
            + self.seconds * fovea.feature.0
    }
}

/// Bytes that rendering reads and that nobody wrote: features, where a machine keeps a published
/// count that has no writes for them.
pub(super) fn unwritten(
    workload: &FrameWorkload,
    units: &ResolvedUnits,
    context: &FrameContext,
) -> u64 {
    let record = &units.ccu.record;
    if record.feature_source == FeatureSource::Ccu {
        return 0;
    }
    let loads = (0..workload.chunks.len()).map(|c| ChunkLoad::new(workload, c, units, context));
    let second = units.vru.fovea.feature.0;
    loads.map(|load| load.features * record.feature.0 + load.seconds * second).sum()
}

/// Pairs that the CCUs write to lists: all, or the new ones where lists are updated, or those of
/// lists that later frames take over.
pub fn pairs_written(workload: &FrameWorkload, context: &FrameContext) -> u64 {
    match (context.reuse, context.table) {
        (Some(tiles), _) => tiles.iter().map(|tile| u64::from(tile.new)).sum(),
        (None, Some(table)) => table.written(),
        (None, None) => workload.counters.tile_pairs,
    }
}

/// Calls `each` for the chunks of a job in the order of rendering: the tile, the position of the
/// chunk in it, and the sort that must precede it.
pub fn for_each_chunk(
    workload: &FrameWorkload,
    plan: &Plan,
    job: &Job,
    mut each: impl FnMut(&TileWork, u32, Sort),
) {
    let mut front = SortProgress::default();
    for &tile in plan.tiles_of(job) {
        let tile = &workload.tiles[tile as usize];
        for index in 0..tile.chunks {
            let sort = front.next(workload, job, tile, index);
            each(tile, index, sort);
        }
    }
}

/// The DRAM bytes of a frame, without speculation.
pub(crate) fn traffic(
    workload: &FrameWorkload,
    units: &ResolvedUnits,
    plan: &Plan,
    context: &FrameContext,
) -> Traffic {
    let ccu = &units.ccu;
    let pairs = pairs_written(workload, context);
    let passes = Batch::passes(workload, pairs, context.lists, ccu.spec.clusters);
    let preprocessing = StageTraffic {
        read: passes.iter().map(|whole| ccu.read_bytes(whole) + ccu.read_back(whole)).sum(),
        write: passes.iter().map(|whole| ccu.written(whole)).sum(),
    };
    let mut sorting = StageTraffic::default();
    for job in &plan.jobs {
        let spill = job.keys.round_trips() * units.qsu.overflow(&job.keys);
        sorting.read += job.read + job.depths * units.qsu.depth + spill;
        sorting.write += job.kept + spill;
    }
    let loads = (0..workload.chunks.len()).map(|c| ChunkLoad::new(workload, c, units, context));
    let pixels = workload.tiles.iter().map(|tile| units.vru.pixel_bytes(tile)).sum::<u64>();
    let [known_in, known_out] =
        context.pixels.map_or([0; 2], |some| BlockStream::bytes(&some.blocks));
    let rendering = StageTraffic {
        read: loads.map(|load| load.bytes(units)).sum::<u64>() + known_in,
        write: pixels + known_out,
    };
    let mut stages = [preprocessing, sorting, rendering];
    if let Some(gradients) = GradientWork::new(workload, units, context) {
        for part in StepPart::ALL {
            let [read, write] = gradients.bytes(part);
            let stage = &mut stages[part.phase() as usize];
            (stage.read, stage.write) = (stage.read + read, stage.write + write);
        }
    }
    Traffic { stages }
}

/// All actions of a frame, without speculation.
pub(super) fn actions(
    workload: &FrameWorkload,
    units: &ResolvedUnits,
    plan: &Plan,
    context: &FrameContext,
    check: &mut RuleCheck,
) -> ActionCounts {
    let mut actions = ActionCounts::default();
    let rules = &units.rules;
    let (pairs, clusters) = (pairs_written(workload, context), units.ccu.spec.clusters);
    let passes = Batch::passes(workload, pairs, context.lists, clusters);
    for whole in &passes {
        rules.ccu.charge(&units.ccu, whole, &mut actions, check);
    }
    if passes.len() > 1 {
        units.ccu.charge_sum(workload.tiles.len() as u64, &mut actions);
    }
    if workload.fovea.is_some() {
        units.ccu.charge_levels(workload.tiles.len() as u64, &mut actions);
    }
    for job in &plan.jobs {
        rules.qsu.charge(&units.qsu, &job.keys, &mut actions, check);
        if job.keys.merged {
            rules.bsu.charge(&units.bsu, &job.chunks(), &mut actions, check);
        }
        for_each_chunk(workload, plan, job, |tile, index, sort| {
            let chunk = workload.chunks_of(tile)[index as usize];
            rules.bsu.charge(&units.bsu, &sort, &mut actions, check);
            let run = context.run((tile.chunk_start + index) as usize);
            let render = Render { chunk, run, ..Render::default() };
            rules.vru.charge(&units.vru, &render, &mut actions, check);
            if let Some(unit) = &units.colour {
                unit.charge(&chunk, &mut actions);
            }
        });
    }
    // Apart from chunks, because a tile without any finishes its pixels, too.
    for tile in &workload.tiles {
        let end = Render { last: Some(*tile), ..Render::default() };
        rules.vru.charge(&units.vru, &end, &mut actions, check);
    }
    if let Some(some) = context.pixels {
        some.charge(&mut actions);
    }
    if let Some(gradients) = GradientWork::new(workload, units, context) {
        gradients.charge(&mut actions);
    }
    // What a derived eye takes from the buffer between the eyes is charged there.
    if context.hits.is_some() && !context.derived {
        let loads = (0..workload.chunks.len()).map(|c| ChunkLoad::new(workload, c, units, context));
        let (hits, misses) =
            loads.fold((0, 0), |sum, load| (sum.0 + load.hits, sum.1 + load.features));
        let record = units.ccu.record.feature.0.next_multiple_of(units.cache_word.max(1));
        actions.charge(Phase::Rendering, sram_read(cache::RECORDS), hits * record);
        actions.charge(Phase::Rendering, sram_write(cache::RECORDS), misses * record);
    }
    for (stage, bytes) in
        Phase::WORK.into_iter().zip(traffic(workload, units, plan, context).stages)
    {
        actions.charge(stage, DRAM_READ, bytes.read);
        actions.charge(stage, DRAM_WRITE, bytes.write);
    }
    actions
}
