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
