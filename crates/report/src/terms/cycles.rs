//! Where cycles go: what units do and wait for.

use super::{Term, term};

pub(super) const CYCLES: &[Term] = &[
    term(
        &["% of cycles", "cycles"],
        "%",
        "What the units of a kind did, averaged over them: busy, waiting for one of the causes in \
         the columns, or idle. A row adds up to the frame.",
    ),
    term(
        &["busy", "ccu busy", "qsu busy", "bsu busy", "vru busy"],
        "%",
        "Share of the frame in which the unit works.",
    ),
    term(
        &["records"],
        "%",
        "The unit waits because records of Gaussians are still in DRAM or on the way.",
    ),
    term(
        &["list"],
        "%",
        "The unit waits because the list of a tile is still in DRAM or on the way.",
    ),
    term(
        &["spill"],
        "%",
        "The unit waits for keys that did not fit the sorting buffer: they go to DRAM and back \
         in every pass.",
    ),
    term(
        &["features", "feature loads"],
        "%",
        "The unit waits because features or colours of a chunk are still in DRAM or on the way.",
    ),
    term(&["input"], "%", "The unit waits for the unit upstream: its input is not ready yet."),
    term(
        &["output"],
        "%",
        "The unit waits because the buffer behind it is full: the unit downstream is slower.",
    ),
    term(
        &["bank", "bank conflicts"],
        "%",
        "The unit waits because the banks that it wants are serving other accesses.",
    ),
    term(
        &["idle", "without work"],
        "%",
        "The unit has nothing to do: its phase has not begun, or is over.",
    ),
    term(
        &["bottleneck", "bound"],
        "",
        "Every cycle of a frame is given to the unit that leads: in preprocessing the CCU, then \
         the \
         busiest of QSU, BSU and VRU. What that unit does (works, waits, has no work) adds up to \
         the frame. `VRU-bound 80 %`: the VRUs lead and work for 80 % of it.",
    ),
    term(
        &["lanes at work"],
        "%",
        "Share of the pixels of a busy core whose Gaussian contributes and has not stopped.",
    ),
    term(&["DRAM bus busy"], "%", "Share of the frame in which the DRAM transfers data."),
];
