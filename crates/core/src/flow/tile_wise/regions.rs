//! Work of the tiles in each region of a foveated frame.
//!
//! A tile belongs to the region of the level at its centre, R1 to R4. Where a job sorts several
//! tiles together, the sort belongs to the region of its first tile. Preprocessing, the feature
//! cache, speculative work and static energy belong to no region.

use crate::flow::RegionWork;
use crate::flow::tile_wise::FrameContext;
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::rules::RuleCheck;
use crate::flow::tile_wise::schedule::{Plan, SortProgress};
use crate::flow::tile_wise::traffic::ChunkLoad;
use crate::flow::tile_wise::vru::Render;
use crate::machine::Machine;
use crate::stage::{DRAM_READ, DRAM_WRITE};
use crate::workload::FrameWorkload;
use powergs_energy::action::Phase;
use powergs_frame::fovea::LEVELS;

/// The regions of a foveated frame; `None` for plain ones.
pub(super) fn regions(
    workload: &FrameWorkload,
    machine: &Machine,
    units: &ResolvedUnits,
    plan: &Plan,
    context: &FrameContext,
    check: &mut RuleCheck,
) -> Option<[RegionWork; LEVELS]> {
    let fovea = workload.fovea.as_ref()?;
    let region_of = |tile: u32| usize::from(fovea.regions[tile as usize]);
    let rules = &units.rules;
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
                own.cycles = own.cycles.saturating_add(rules.vru.cycles(&units.vru, &render));
                let bytes = ChunkLoad::new(workload, at, units, context).bytes(units);
                own.actions.charge(Phase::Rendering, DRAM_READ, bytes);
            }
            let end = Render { last: Some(*tile), ..Render::default() };
            rules.vru.charge(&units.vru, &end, &mut own.actions, check);
            own.cycles = own.cycles.saturating_add(rules.vru.cycles(&units.vru, &end));
            let pixels = units.vru.pixel_bytes(tile);
            own.actions.charge(Phase::Rendering, DRAM_WRITE, pixels);
        }
    }
    debug_assert_eq!(machine.tiles().geometry, workload.geometry);
    Some(all)
}
