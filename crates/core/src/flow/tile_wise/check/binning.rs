//! Consistency of the keys that say how lists are made.

use crate::flow::tile_wise::TileWise;
use crate::flow::tile_wise::{BinningImpl, GsuImpl, Overlap};
use crate::machine::check::Found;
use powergs_base::quantity::Bytes;

/// The largest line and the largest block of a list.
const LINE_MAX: Bytes = Bytes(4096);
const BLOCK_MAX: Bytes = Bytes(1 << 20);

/// Adds what is wrong with them.
pub(super) fn check(m: &TileWise, found: &mut Found) {
    let b = &m.binning;
    if b.implementation == BinningImpl::Free {
        return;
    }
    let entry = Bytes(m.list_entry());
    if b.line < entry || b.line > LINE_MAX {
        let message = format!(
            "`binning.line` = {} must be from the {entry} of a list entry (`record.depth-bits`, \
             `record.id-bits`, `record.entry-bitmap`) to {LINE_MAX}",
            b.line
        );
        found.add("binning.line", message);
        if b.line < entry {
            found.ends_with("binning.line", Bytes(entry.0.next_power_of_two()));
        }
    }
    if b.combining.capacity.0 > 0 && b.combining.capacity < b.line {
        let message = format!(
            "`binning.combining.capacity` = {} holds no line of `binning.line` = {}: enlarge it, \
             or set it to 0 B for no combining",
            b.combining.capacity, b.line
        );
        found.add("binning.combining.capacity", message);
        found.ends_with("binning.combining.capacity", b.line);
    }
    if !(1..=16).contains(&b.pointer_size.0) {
        let message =
            format!("`binning.pointer-size` = {} must be from 1 B to 16 B", b.pointer_size);
        found.add("binning.pointer-size", message);
    }
    let fits = b.block.0.is_multiple_of(b.line.0.max(1)) && b.block > b.pointer_size;
    if b.implementation == BinningImpl::Append && (!fits || b.block > BLOCK_MAX) {
        let message = format!(
            "`binning.block` = {} must be a multiple of `binning.line` = {}, hold more than \
             `binning.pointer-size` = {}, and be at most {BLOCK_MAX}",
            b.block, b.line, b.pointer_size
        );
        found.add("binning.block", message);
    }
    let mut excludes = |key, value: String, remedy: &str, set: &str| {
        let message = format!(
            "`{key}` = {value} contradicts `binning.impl` = \"{}\": {remedy}, or set \
             `binning.impl` = \"free\"",
            b.implementation.name()
        );
        found.add(key, message);
        found.ends_with(key, set);
    };
    if m.gsu.implementation == GsuImpl::Update || m.gsu.keeps_lists() {
        let remedy = "lists that are kept lie back to back; set \"split\"";
        excludes("gsu.impl", format!("\"{}\"", m.gsu.implementation.name()), remedy, "split");
    }
    if b.implementation == BinningImpl::TwoPass && m.schedule.overlap != Overlap::None {
        let overlap = "\"tiles\" or \"frames\"".to_owned();
        let remedy = "nothing overlaps with two passes over all splats; set \"none\"";
        excludes("schedule.overlap", overlap, remedy, "none");
    }
}
