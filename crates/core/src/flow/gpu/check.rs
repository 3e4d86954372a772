//! Keys of a GPU that contradict each other.

use super::{BlendSpec, Gpu, WARP};
use crate::machine::Machine;
use crate::machine::check::{Found, SIZE_MAX};

/// How far the bandwidth of a data sheet may be from that of its bus: they are rounded.
const ROUNDED: f64 = 0.02;

/// Adds every contradiction.
pub(super) fn check(machine: &Machine, found: &mut Found) {
    let m = machine.gpu();
    let sizes = [
        ("sm.shared", m.sm.shared),
        ("l2.capacity", m.l2.capacity),
        ("l2.sector", m.l2.sector),
        ("convert.position", m.convert.position),
        ("convert.shape", m.convert.shape),
        ("convert.colour", m.convert.colour),
        ("convert.mark", m.convert.mark),
        ("convert.covariance", m.convert.covariance),
        ("convert.result", m.convert.result),
        ("pairs.key", m.pairs.key),
        ("pairs.value", m.pairs.value),
        ("pairs.read", m.pairs.read),
        ("blend.entry", m.blend.entry),
        ("blend.feature", m.blend.feature),
        ("blend.shared", m.blend.shared),
        ("blend.pixel", m.blend.pixel),
        ("training.loss-bytes", m.training.loss_bytes),
        ("training.state", m.training.state),
        ("training.record", m.training.record),
        ("training.zeroed", m.training.zeroed),
    ];
    for (key, size) in sizes {
        if size > SIZE_MAX {
            found.add(key, format!("`{key}` = {size} is above {SIZE_MAX}"));
        }
    }
    if m.l2.sector.0 == 0 {
        found.add("l2.sector", "`l2.sector` must be above 0 B: what a read takes at least".into());
    }
    let bus = m.bus.rate().0 / 1e9;
    let rate = machine.dram.bandwidth.filter(|_| !machine.dram.has_device());
    let peak = rate.map_or(bus, |rate| rate.0 / 1e9);
    if (peak / bus - 1.0).abs() > ROUNDED {
        let message = format!(
            "`dram.bandwidth` = {peak} GB/s is not that of its bus: {} bits at {} Gbit/s are \
             {bus:.1} GB/s; leave it out, or set the other",
            m.bus.width, m.bus.gigabits
        );
        found.add("dram.bandwidth", message);
    }
    for (key, value) in [("blend.tile", m.blend.tile), ("blend.warp-width", m.blend.warp_width)] {
        if !value.is_power_of_two() {
            found.add(key, format!("`{key}` = {value} must be a power of two"));
        }
    }
    let BlendSpec { tile, warp_width: wide, .. } = m.blend;
    let high = WARP / wide.clamp(1, WARP);
    if wide > tile || high > tile {
        let message = format!(
            "`blend.warp-width` = {wide}: the {wide}x{high} pixels of a warp do not fit into a \
             tile of {tile}x{tile} (`blend.tile`)"
        );
        found.add("blend.warp-width", message);
    }
    if m.blending() == 0 {
        let threads = tile * tile;
        let message = format!(
            "no block of {threads} threads fits into a multiprocessor: it takes {} of {} \
             registers, {} of {} warps and {} B of {} shared memory",
            threads * m.blend.registers,
            m.sm.registers,
            threads.div_ceil(WARP),
            m.sm.warps,
            u64::from(m.blend.batch) * m.blend.shared.0,
            m.sm.shared
        );
        found.add("blend.registers", message);
    }
    if m.sm.resident(super::BLOCK, m.convert.registers, 0) == 0 {
        let message = format!(
            "no block of {} threads of {} registers (`convert.registers`) fits into a \
             multiprocessor of {} registers and {} warps",
            super::BLOCK,
            m.convert.registers,
            m.sm.registers,
            m.sm.warps
        );
        found.add("convert.registers", message);
    }
    attached(m, found);
    if m.rops.is_there() && m.blend.tile > 16 {
        let message =
            format!("`blend.tile` = {}: bins of raster operations have 16 at most", m.blend.tile);
        found.add("blend.tile", message);
    }
}

/// A unit beside the GPU.
fn attached(m: &Gpu, found: &mut Found) {
    let a = &m.attached;
    if !a.is_there() {
        return;
    }
    if !(1e6..=1e11).contains(&a.clock.0) {
        let message = format!("`attached.clock` = {} must be from 1 MHz to 100 GHz", a.clock);
        found.add("attached.clock", message);
    }
    if a.cache.capacity > SIZE_MAX {
        let size = a.cache.capacity;
        let message = format!("`attached.cache.capacity` = {size} is above {SIZE_MAX}");
        found.add("attached.cache.capacity", message);
    } else if a.cache.capacity.0 > 0 && !(1..=a.cache.capacity.0).contains(&a.cache.word.0) {
        let message = format!(
            "`attached.cache.word` = {} must be from 1 B to the capacity, {}",
            a.cache.word, a.cache.capacity
        );
        found.add("attached.cache.word", message);
    }
}
