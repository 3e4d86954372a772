//! Lists of tiles: what their making declares. How pairs get into them is measured outside of time
//! ([`workload::binning`](crate::workload::binning)); CCUs do it.

use super::measures;
use super::{BinningSpec, CcuSpec, ScheduleSpec};
use crate::flow::tile_wise::{BinningImpl, Overlap};
use crate::machine::{BufferSpec, Machine};
use crate::stage::{Bias, StageDecl, buffer, buffer_id, omit};
use powergs_energy::action::{BufferId, Memory, Phase};

/// What the making of lists declares.
pub const LISTS: StageDecl = StageDecl {
    buffers: &[
        buffer("pointers", "binning.pointers", |m| memory(m, &m.of_type::<BinningSpec>().pointers))
            .full(),
        buffer("combining", "binning.combining", |m| {
            memory(m, &m.of_type::<BinningSpec>().combining)
        })
        .full(),
    ],
    stats: &measures::STATS,
    omits: &[
        omit(
            "how pairs get from the order of the CCUs into the lists of tiles",
            Bias::Optimistic,
            "A90",
        )
        .by("binning.impl = \"free\"", |m| {
            m.of_type::<BinningSpec>().implementation == BinningImpl::Free
        }),
        omit("lists of early tiles used before preprocessing ends", Bias::Pessimistic, "A28")
            .by("schedule.overlap = \"none\"", |m| {
                m.of_type::<ScheduleSpec>().overlap == Overlap::None
            }),
    ],
    ..StageDecl::new(
        "lists",
        "making of tile lists",
        Phase::Preprocessing,
        "How CCUs get pairs into the lists of tiles. Keys: `binning`.",
    )
};

/// Where the next entry of each tile goes.
pub const POINTERS: BufferId = buffer_id("pointers");

/// Entries of each tile on their way to DRAM.
pub const COMBINING: BufferId = buffer_id("combining");

fn memory(m: &Machine, spec: &BufferSpec) -> Memory {
    let is_there =
        m.of_type::<BinningSpec>().implementation != BinningImpl::Free && spec.capacity.0 > 0;
    let memory = spec.shared(m.of_type::<CcuSpec>().units);
    Memory { banks: if is_there { memory.banks } else { 0 }, ..memory }
}
