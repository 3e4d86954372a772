//! The reference machine of the `calibrated` model of the memory: the machine itself as far as it
//! decides which requests there are (records, fetch, batches, geometry, cache, schedule, clock,
//! device, second master), with units and buffers that keep the memory busy, always the same ones.

use super::Assignment;
use super::schedule::Plan;
use super::subtiles::{self, Discipline};
use super::{FrameContext, ResolvedUnits, UnitRules, VruImpl, pipeline};
use crate::kernel::Memo;
use crate::kernel::calibration::{CalibrationRecorder, Recording};
use crate::machine::{BufferSpec, Machine};
use crate::workload::FrameWorkload;
use powergs_base::quantity::Bytes;

/// Takes a frame through a [reference](refer).
pub(super) fn measure(
    workload: &FrameWorkload,
    reference: &Machine,
    context: &FrameContext,
    memo: &Memo,
    recorder: &mut CalibrationRecorder,
) -> Option<Recording> {
    let units = ResolvedUnits::for_frame(reference, workload);
    let make = |discipline: &Discipline| subtiles::runs(workload, discipline);
    let runs = units.vru.discipline.map(|discipline| memo.get(discipline, make));
    let runs = runs.as_ref().map(|runs| runs.as_slice());
    let context = FrameContext { runs, calibration: None, ..*context };
    let plan = Plan::new(workload, reference, &units, &context);
    pipeline::run(workload, reference, &units, &plan, context, memo, recorder).recording
}

/// Units of the reference machine: enough to keep the memory busy.
const CCUS: u32 = 8;

/// Its cores.
const CORES: u32 = 8;

/// Rendering units of a core of it, or one for each sub-tile if those are more.
const UNITS_PER_CORE: u32 = 32;

/// Operations of a CCU of it in a cycle: a record a cycle.
const OPERATIONS: u32 = 1 << 20;

/// Bytes of its buffers that a CCU or a core has to itself, at least.
const SHARE: u64 = 8 << 10;

/// Chunks that the feature buffer of one of its cores holds.
const CHUNKS: u64 = 7;

/// Tiles whose pixels the pixel buffer of one of its cores holds.
const TILES: u64 = 5;

/// Makes a machine the one whose run on the device calibrates others: the same requests, of other
/// units.
pub(super) fn refer(reference: &mut Machine) {
    let m = reference.tiles_mut();
    m.rules = UnitRules::default();
    m.schedule.assignment = Assignment::Greedy;
    let ccu = &mut m.ccu;
    (ccu.units, ccu.operations_per_cycle, ccu.intersection_units) = (CCUS, OPERATIONS, 1);
    // Their own engines would be slower than that.
    (ccu.cull_operations_per_cycle, ccu.colour_operations_per_cycle) = (0, 0);
    (ccu.latency, ccu.queue) = (16, 16);
    let gsu = &mut m.gsu;
    (gsu.qsu_per_core, gsu.keys_per_cycle, gsu.qsu_latency) = (4, 1, 10);
    (gsu.bsu_per_core, gsu.bsu_width, gsu.bsu_latency, gsu.queue) = (2, 16, 4, 1);
    let kept = &mut m.gradients.buffer.capacity;
    // What a core keeps decides what goes through the memory.
    *kept = Bytes(kept.0 / u64::from(m.vru.cores.max(1)) * u64::from(CORES));
    let g = &mut m.gradients;
    (g.lanes, g.sum_cycles, g.operations_per_cycle) = (1 << 12, 1, 1 << 16);
    (g.misses, g.cache.banks) = (1 << 12, 1 << 12);
    let vru = &mut m.vru;
    (vru.cores, vru.units_per_core) = (CORES, UNITS_PER_CORE.max(m.geometry.subtiles()));
    (vru.pixels_per_unit, vru.latency, vru.recurrence, vru.blend_stall) = (4, 16, 4, 0);
    (vru.subtile_skipping, vru.tile_overlap, vru.stop_latency) = (true, false, 0);
    vru.implementation = VruImpl::Serial;
    (vru.subtile_queue, vru.pixel_state, vru.entries_per_cycle) = (1, Bytes(0), 1);
    (vru.colour_operations_per_cycle, vru.colour_latency) = (OPERATIONS, 16);
    // A look-up takes a cycle.
    (m.codebook.word, m.codebook.banks) = (m.codebook.entry, 1);
    m.pixels.per_cycle = 1 << 10;
    m.levels.operations_per_cycle = 1 << 16;
    let (records, chunk) = (&m.record, u64::from(m.geometry.chunk));
    let all = records.position.0 + records.geometry.0 + records.colour.0;
    let feature = records.feature.0 + m.fovea.feature.0;
    let tile = u64::from(m.geometry.tile).pow(2) * records.pixel.0;
    let batch = u64::from(m.ccu.batch) * all;
    let b = &mut m.buffers;
    let share = |n: u32, bytes: u64| Bytes(u64::from(n) * bytes.max(SHARE));
    b.gaussian_in.capacity = share(CCUS, batch);
    b.tile_list.capacity = share(CCUS, 0);
    b.sorting.capacity = share(CORES, 2 * SHARE);
    b.feature.capacity = share(CORES, CHUNKS * chunk * feature);
    b.pixel_out.capacity = share(CORES, TILES * tile);
    // Conflicts in buffers: none.
    let free = |spec: &mut BufferSpec| (spec.word, spec.banks) = (Bytes(64), 16);
    [&mut b.gaussian_in, &mut b.tile_list, &mut b.sorting, &mut b.feature, &mut b.pixel_out]
        .into_iter()
        .for_each(free);
}
