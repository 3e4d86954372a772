//! How much a unit has of each of its parts: what a wider or deeper unit is larger by.
//!
//! Storage is counted in bits. A batch of a CCU is a request (address, length, place in the input
//! buffer) and a bit for each of its records, whether it survives. A core keeps a descriptor of
//! each list that it holds or has asked for (address, length, tile) and one of each chunk that it
//! fetches ahead. A pixel is its transmittance and its colour in FP16; a unit whose next tile
//! enters while the last one drains holds two of each (A62).

use super::Machine;
use crate::accel::bsu::network;
use crate::action::Part;

/// Bits of a request of a CCU.
const REQUEST_BITS: f64 = 64.0;
/// Bits that describe a list.
const LIST_BITS: f64 = 128.0;
/// Bits that describe a chunk.
const CHUNK_BITS: f64 = 64.0;
/// Bits of a pixel: transmittance and three colours.
const PIXEL_BITS: f64 = 64.0;

/// How much of a part one unit of the machine has.
pub(super) fn amount(machine: &Machine, part: Part) -> f64 {
    let (ccu, gsu, vru) = (&machine.ccu, &machine.gsu, &machine.vru);
    let accumulators = f64::from(machine.fovea.accumulators.max(1));
    match part {
        Part::CcuThroughput => f64::from(ccu.initiation_interval).recip(),
        Part::CcuIntersectionUnits => f64::from(ccu.intersection_units),
        // A machine that cannot show foveated frames has the published unit.
        Part::CcuLevelTests if machine.fovea.accumulators == 0 => 1.0,
        Part::CcuLevelTests => f64::from(machine.fovea.level_tests),
        Part::CcuBatches => f64::from(ccu.queue) * (REQUEST_BITS + f64::from(ccu.batch)),
        Part::QsuPivots => f64::from(gsu.pivots),
        Part::QsuComparators => f64::from(gsu.pivots) * f64::from(gsu.keys_per_cycle),
        Part::BsuNetwork => network(gsu.bsu_width) as f64,
        Part::BsuQueue => {
            let bits = f64::from(gsu.queue) * LIST_BITS + f64::from(vru.speculation) * CHUNK_BITS;
            bits / f64::from(gsu.bsu_per_core)
        }
        Part::VruBlend => accumulators / (1.0 + f64::from(vru.blend_stall)),
        Part::VruPixels => {
            let copies = if vru.tile_overlap { 2.0 } else { 1.0 };
            f64::from(vru.pixels_per_unit) * accumulators * copies * PIXEL_BITS
        }
        Part::VruRecurrence => f64::from(vru.recurrence).recip(),
        Part::CacheWays => f64::from(machine.cache.ways),
    }
}
