//! How much a unit has of each of its parts: what a wider or deeper unit is larger by.
//!
//! Storage is counted in bits. A batch of a CCU is a request (address, length, place in the input
//! buffer) and a bit for each of its records, whether it survives. A core keeps a descriptor of
//! each list that it holds or has asked for (address, length, tile) and one of each chunk that it
//! fetches ahead. A pixel is its transmittance and its colour (`vru.pixel-state`); a unit whose
//! next tile enters while the last one drains holds two of each (A62), and so does one whose pixels
//! are swapped while it works on others (A86). Units that are divided over the sub-tiles hold all
//! pixels of the tile. Queues hold feature records (A89). A cache compares the tags of its ways,
//! with the distances that it evicts by (A102).

use super::{Machine, Organisation, Switch};
use crate::accel::bsu::network;
use powergs_energy::action::Part;

/// Bits of a request of a CCU.
const REQUEST_BITS: f64 = 64.0;
/// Bits that describe a list.
const LIST_BITS: f64 = 128.0;
/// Bits that describe a chunk.
const CHUNK_BITS: f64 = 64.0;
/// Bits of the record that a published unit holds: 19 B.
const RECORD_BITS: f64 = 152.0;

/// Bits of the tag of a cached record.
const TAG_BITS: f64 = 24.0;

/// Queues of a core: one for each sub-tile, or one behind the scan.
fn queues(machine: &Machine) -> f64 {
    match (machine.vru.organisation, machine.vru.switch) {
        (Organisation::SubtileParallel, _) => f64::from(machine.geometry.subtiles()),
        (Organisation::SubtileSerial, Switch::Scan) => 1.0,
        (Organisation::SubtileSerial, Switch::Free | Switch::State) => 0.0,
    }
}

/// How much of a part one unit of the machine has.
pub(super) fn amount(machine: &Machine, part: Part) -> f64 {
    let (ccu, gsu, vru) = (&machine.ccu, &machine.gsu, &machine.vru);
    let accumulators = f64::from(machine.fovea.accumulators.max(1));
    match part {
        Part::CcuOperations => f64::from(ccu.operations_per_cycle),
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
            let swapped = if machine.state_bytes().0 > 0 { 2.0 } else { 1.0 };
            let held = match vru.organisation {
                Organisation::SubtileSerial => vru.pixels_per_unit,
                Organisation::SubtileParallel => {
                    let share = machine.geometry.tile.pow(2).div_ceil(vru.units_per_core);
                    share.max(vru.pixels_per_unit)
                }
            };
            let bits = 8.0 * vru.pixel_state.0 as f64;
            f64::from(held) * accumulators * copies * swapped * bits
        }
        Part::VruQueue => {
            let bits = 8.0 * machine.record.feature.0 as f64;
            let entries = f64::from(vru.subtile_queue) * queues(machine);
            RECORD_BITS + entries * bits / f64::from(vru.units_per_core)
        }
        Part::VruRecurrence => f64::from(vru.recurrence).recip(),
        Part::CacheWays => {
            let tag = TAG_BITS + f64::from(machine.cache.carried_bits());
            f64::from(machine.cache.ways) * tag / TAG_BITS
        }
    }
}
