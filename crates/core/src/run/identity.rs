//! What decides timing, as a hash.

use serde::Serialize;
use xxhash_rust::xxh3::xxh3_128;

use crate::machine::Machine;
use crate::machine::{DramModel, DramSpec};

/// Hash of a configuration without its name and description.
///
/// # Errors
/// A value that JSON cannot express.
pub fn content_id<T: Serialize>(value: &T) -> Result<u128, serde_json::Error> {
    let mut value = serde_json::to_value(value)?;
    if let Some(object) = value.as_object_mut() {
        object.remove("name");
        object.remove("description");
    }
    Ok(xxh3_128(value.to_string().as_bytes()))
}

/// Hash of what decides timing; `device` is the [`content_id`] of the DRAM device, if there is one.
/// Machines that agree in it have the same cycles and action counts on the same frame.
///
/// Names, prices and gating are left out, and so are keys that cannot move anything: those of the
/// DRAM models that are not used, and those that the dataflow leaves out.
pub fn timing_id(machine: &Machine, device: Option<u128>) -> u128 {
    let Machine {
        name: _,
        description: _,
        energy: _,
        gating: _,
        device: _,
        clock: _,
        tables,
        dram,
    } = machine;
    let mut bytes = machine.flow().timing(machine);
    let flow = tables.flow().key();
    bytes.extend(format!("{flow}\n").into_bytes());
    let mut add = |part: Result<Vec<u8>, serde_json::Error>| {
        bytes.extend(part.expect("a machine has only tables, numbers and strings"));
        bytes.push(b'\n');
    };
    let DramSpec {
        model,
        bandwidth: _,
        efficiency,
        latency,
        device: _,
        channels,
        mapping,
        controller_latency,
        owner: _,
        standby_share: _,
        second_master: _,
        third_master: _,
        fourth_master: _,
    } = dram;
    for other in dram.masters().iter().enumerate().filter(|(_, master)| master.is_on()) {
        add(serde_json::to_vec(&other));
    }
    match model {
        DramModel::Bandwidth => {
            add(serde_json::to_vec(&(model, machine.dram_peak(), efficiency, latency)));
        }
        DramModel::Calibrated | DramModel::Banked => {
            add(serde_json::to_vec(&(model, channels, mapping, controller_latency)));
            bytes.extend(device.unwrap_or_default().to_le_bytes());
        }
    }
    xxh3_128(&bytes)
}
