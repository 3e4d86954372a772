//! Actions and DRAM bytes of a frame on a machine, from its totals alone.
//!
//! Nothing here depends on time. The pipeline moves the same bytes request by request; every run
//! checks that both agree.

use crate::flow::RegionWork;
use crate::flow::tile_wise::FrameContext;
use crate::flow::tile_wise::batch::Batch;
use crate::flow::tile_wise::cache;
use crate::flow::tile_wise::gradients::GradientWork;
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::rules::RuleCheck;
use crate::flow::tile_wise::schedule::{Plan, SortProgress};
use crate::flow::tile_wise::vru::Render;
use crate::flow::tile_wise::{FeatureSource, Fetch};
use crate::stage::{DRAM_READ, DRAM_WRITE, sram_read, sram_write};
use crate::workload::FrameWorkload;
use powergs_energy::action::{ActionCounts, Phase};
use powergs_frame::fovea::LEVELS;

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

/// What is done for the tiles of a frame, apart from speculation: by region of a foveated frame,
/// and all in the first place of a plain one.
///
/// A tile belongs to the region of the level at its centre. Where a job sorts several tiles
/// together, the sort belongs to the region of its first tile. Preprocessing, the feature cache,
/// speculative work and static energy belong to no region.
pub(super) fn tile_work(
    workload: &FrameWorkload,
    units: &ResolvedUnits,
    plan: &Plan,
    context: &FrameContext,
    check: &mut RuleCheck,
) -> [RegionWork; LEVELS] {
    let regions = workload.fovea.as_ref().map(|fovea| &fovea.regions);
    let region_of = |tile: u32| regions.map_or(0, |regions| usize::from(regions[tile as usize]));
    let rules = &units.rules;
    // Nobody asks for those of a plain frame.
    let cycles = |render: &Render| regions.map_or(0, |_| rules.vru.cycles(&units.vru, render));
    let mut all: [RegionWork; LEVELS] = Default::default();
    for job in &plan.jobs {
        let tiles = plan.tiles_of(job);
        let Some(&first) = tiles.first() else { continue };
        let own = &mut all[region_of(first)].actions;
        rules.qsu.charge(&units.qsu, &job.keys, own, check);
        if job.keys.merged {
            rules.bsu.charge(&units.bsu, &job.chunks(), own, check);
        }
        let spill = job.keys.round_trips() * units.qsu.overflow(&job.keys);
        let depths = job.depths * units.qsu.depth;
        own.charge(Phase::Sorting, DRAM_READ, job.read + depths + spill);
        own.charge(Phase::Sorting, DRAM_WRITE, job.kept + spill);
        let mut front = SortProgress::default();
        for &index in tiles {
            let tile = &workload.tiles[index as usize];
            let own = &mut all[region_of(index)];
            own.tiles += 1;
            own.entries += u64::from(tile.loaded);
            for k in 0..tile.chunks {
                let sort = front.next(workload, job, tile, k);
                let at = (tile.chunk_start + k) as usize;
                let (chunk, run) = (workload.chunks[at], context.run(at));
                let render = Render { chunk, run, ..Render::default() };
                rules.bsu.charge(&units.bsu, &sort, &mut own.actions, check);
                rules.vru.charge(&units.vru, &render, &mut own.actions, check);
                if let Some(unit) = &units.colour {
                    unit.charge(&chunk, &mut own.actions);
                }
                own.cycles = own.cycles.saturating_add(cycles(&render));
                let bytes = ChunkLoad::new(workload, at, units, context).bytes(units);
                own.actions.charge(Phase::Rendering, DRAM_READ, bytes);
            }
            // A tile without any chunk finishes its pixels, too.
            let end = Render { last: Some(*tile), ..Render::default() };
            rules.vru.charge(&units.vru, &end, &mut own.actions, check);
            own.cycles = own.cycles.saturating_add(cycles(&end));
            own.actions.charge(Phase::Rendering, DRAM_WRITE, units.vru.pixel_bytes(tile));
        }
    }
    all
}

/// All actions of a frame whose tiles take this, without speculation.
pub(super) fn actions(
    workload: &FrameWorkload,
    units: &ResolvedUnits,
    tiles: &[RegionWork],
    context: &FrameContext,
    check: &mut RuleCheck,
) -> ActionCounts {
    let mut actions = ActionCounts::default();
    tiles.iter().for_each(|region| actions.add(&region.actions));
    let (ccu, pairs) = (&units.ccu, pairs_written(workload, context));
    let passes = Batch::passes(workload, pairs, context.lists, ccu.spec.clusters);
    for whole in &passes {
        units.rules.ccu.charge(ccu, whole, &mut actions, check);
        let read = ccu.read_bytes(whole) + ccu.read_back(whole);
        actions.charge(Phase::Preprocessing, DRAM_READ, read);
        actions.charge(Phase::Preprocessing, DRAM_WRITE, ccu.written(whole));
    }
    if passes.len() > 1 {
        ccu.charge_sum(workload.tiles.len() as u64, &mut actions);
    }
    if workload.fovea.is_some() {
        ccu.charge_levels(workload.tiles.len() as u64, &mut actions);
    }
    context.first.iter().for_each(|unit| actions.add(&unit.actions));
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
        let record = ccu.record.feature.0.next_multiple_of(units.cache_word.max(1));
        actions.charge(Phase::Rendering, sram_read(cache::RECORDS), hits * record);
        actions.charge(Phase::Rendering, sram_write(cache::RECORDS), misses * record);
    }
    actions
}
