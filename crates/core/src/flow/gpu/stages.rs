//! The one stage of a GPU: its multiprocessors run every kernel.

use super::{L2Spec, SmSpec, TrainSpec, WARP};
use crate::kernel::stream::{reads, writes};
use crate::stage::{
    Bias, DoubleDecl, From, StageDecl, Stall, WaitDecl, buffer, buffer_id, double, omit, part,
    stage_id, work, work_id,
};
use powergs_energy::action::{ActionId, BufferId, Memory, Phase, StageId};

/// What it declares.
pub const SM_DECL: StageDecl = StageDecl {
    units: Some(|m| m.of_type::<SmSpec>().units),
    works: &[
        work("warp-instruction", WARP, "One instruction of a warp, whatever its threads do.")
            .a_cycle(|m| m.of_type::<SmSpec>().issue()),
        work("warp-exponential", 0, "The exponential of an alpha, a warp of them.")
            .a_cycle(|m| f64::from(m.of_type::<SmSpec>().special) / f64::from(WARP)),
    ],
    buffers: &[buffer("l2", "l2", |m| {
        let l2: &L2Spec = m.of_type();
        Memory {
            bank: l2.capacity,
            banks: u32::from(l2.capacity.0 > 0),
            word: l2.sector,
            two_ports: false,
        }
    })
    .full()],
    streams: &[
        reads("scene", "Gaussians, as stored", &[], ["splats", "keys-in"]).of(Phase::Preprocessing),
        writes("results", "converted Gaussians", ["pairs-out", "keys-out"])
            .of(Phase::Preprocessing),
        reads("counts", "numbers of pairs, and what keys are made of", &[], ["keys-in", "scene"])
            .of(Phase::Sorting),
        writes("pairs-out", "pairs in the order of storage", ["keys-out", "results"])
            .of(Phase::Sorting),
        reads("keys-in", "pairs in front of a pass", &["pairs-out"], ["counts", "scene"])
            .of(Phase::Sorting),
        writes("keys-out", "pairs behind a pass", ["pairs-out", "results"]).of(Phase::Sorting),
        reads("splats", "lists of tiles, and their Gaussians", &["results"], ["scene", "keys-in"])
            .scattered()
            .of(Phase::Rendering),
        writes("picture", "finished pixels", ["pairs-out", "results"]).of(Phase::Rendering),
        reads("blended-in", "pictures, and lists in reverse", &["picture"], ["splats", "scene"])
            .scattered()
            .of(Phase::Rendering),
        writes("gradients-out", "gradients by pixels and by Gaussians", ["picture", "results"])
            .of(Phase::Rendering),
        reads(
            "parameters-in",
            "Gaussians, their gradients and moments",
            &["gradients-out"],
            ["scene", "keys-in"],
        )
        .of(Phase::Preprocessing),
        writes("parameters-out", "the same, updated", ["results", "pairs-out"])
            .of(Phase::Preprocessing),
    ],
    parts: &[part("lanes", "Lanes of single precision.", |m| {
        f64::from(m.of_type::<SmSpec>().lanes)
    })],
    waits: &[
        WaitDecl {
            name: "pass",
            what: "pairs of a pass of the sort",
            short: "pairs from DRAM",
            because: "pairs of a pass of the sort were in DRAM or on their way",
            symbol: 'p',
            from: From::Memory,
        },
        WaitDecl {
            name: "launch",
            what: "the next kernel",
            short: "launch",
            because: "the next kernel had not been launched",
            symbol: 'g',
            from: From::Neighbour,
        },
    ],
    also_waits: &["records", "features"],
    doubles: &[
        double("sm.units", &["sm.units"], &["A137"]),
        double("sm.lanes, schedulers", &["sm.lanes", "sm.special", "sm.schedulers"], &["A137"]),
        double("l2.capacity", &["l2.capacity"], &["A139"]),
        DoubleDecl {
            is_there: |m| !m.dram.has_device() && m.dram.bandwidth.is_none(),
            ..double("bus.width", &["bus.width"], &["A4"])
        },
    ],
    omits: &[
        omit(
            "conflicts of banks of shared memory, misses of instruction caches",
            Bias::Optimistic,
            "",
        ),
        omit("kernels that overlap in their ends and beginnings", Bias::Pessimistic, "A138"),
        omit("clocks that fall under load", Bias::Optimistic, ""),
        omit(
            "densification: Gaussians that are cloned, split and removed",
            Bias::Optimistic,
            "A144",
        )
        .by("train.sum = \"warp\"", |m| m.of_type::<TrainSpec>().trains()),
    ],
    behind: &["A137", "A138", "A139", "A144"],
    ..StageDecl::new(
        "sm",
        "streaming multiprocessors (SM)",
        Phase::Rendering,
        "Multiprocessors of a GPU: they run the kernels that convert, pair, sort and blend. Keys: \
         `sm`, `convert`, `pairs`, `radix`, `blend`, `train`.",
    )
};

/// The stage.
pub const SM: StageId = stage_id("sm");
/// An instruction of a warp.
pub const INSTRUCTION: ActionId = work_id("warp-instruction");
/// Exponentials of a warp.
pub const EXPONENTIAL: ActionId = work_id("warp-exponential");
/// The L2 cache.
pub const L2: BufferId = buffer_id("l2");
/// Waits for the next kernel.
pub const LAUNCH: Stall = Stall::of("launch");
