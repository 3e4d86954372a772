//! What decides timing, as a hash.

use serde::Serialize;
use xxhash_rust::xxh3::xxh3_128;

use crate::accel::Machine;
use crate::accel::machine::{BinningMethod, DramModel, DramSpec};

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
/// DRAM models that are not used, and those of a cache that is not there (`inert.toml`).
pub fn timing_id(machine: &Machine, device: Option<u128>) -> u128 {
    let Machine {
        name: _,
        description: _,
        energy: _,
        gating: _,
        device: _,
        clock,
        geometry,
        record,
        codebook,
        ccu,
        gsu,
        vru,
        fovea,
        buffers,
        binning,
        cache,
        schedule,
        dram,
        rules,
    } = machine;
    let mut bytes = Vec::with_capacity(4096);
    let mut add = |part: Result<Vec<u8>, serde_json::Error>| {
        bytes.extend(part.expect("a machine has only tables, numbers and strings"));
        bytes.push(b'\n');
    };
    add(serde_json::to_vec(&(clock, geometry, record, ccu, gsu, vru, buffers, schedule)));
    add(serde_json::to_vec(fovea));
    if binning.method != BinningMethod::Free {
        add(serde_json::to_vec(binning));
    }
    if codebook.entries > 0 {
        add(serde_json::to_vec(codebook));
    }
    if cache.capacity.0 > 0 {
        add(serde_json::to_vec(cache));
    }
    let DramSpec {
        model,
        bandwidth: _,
        efficiency,
        latency,
        device: _,
        channels,
        mapping,
        controller_latency,
        second_master,
    } = dram;
    if second_master.is_on() {
        add(serde_json::to_vec(second_master));
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
    for (unit, rule) in rules.names() {
        bytes.extend(format!("{unit} rule {rule:?}\n").into_bytes());
    }
    xxh3_128(&bytes)
}
