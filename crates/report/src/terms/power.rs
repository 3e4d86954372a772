//! Energy and power.

use super::{Term, term};

pub(super) const POWER: &[Term] = &[
    term(
        &["mW at the display rate", "power at the display rate", "W at the display rate"],
        "mW",
        "Power of the accelerator and its DRAM while it renders one frame per display period \
         (`--fps`): the energy of that work, and standby all the time. The power to compare \
         designs with.",
    ),
    term(
        &["power at full rate"],
        "mW",
        "Power while frames are rendered back to back, as fast as the machine can.",
    ),
    term(
        &["energy per frame", "mJ per frame", "energy"],
        "mJ",
        "Energy of one frame at full rate: its accesses and operations, and standby for the time \
         that the frame takes. At the display rate a frame also pays standby while the machine \
         waits for the next one, so this times the display rate is less than the power.",
    ),
    term(
        &["frame time", "ms per frame"],
        "ms",
        "Time from the first cycle of a frame to the last.",
    ),
    term(
        &["frame rate", "frames per second", "FPS", "throughput_fps"],
        "frames per second",
        "Frames per second if they are rendered back to back.",
    ),
    term(
        &["deadline"],
        "ms",
        "The display period, 1 / `--fps`; a frame that takes longer has missed it.",
    ),
    term(
        &["display power", "display"],
        "mW",
        "Power of the panel for the pictures of the trace (`--display`), beside the accelerator.",
    ),
    term(
        &["accelerator and display", "accelerator + display"],
        "mW",
        "Power at the display rate and the display's own power together.",
    ),
    term(&["dram"], "", "Energy or power of DRAM accesses, without its standby."),
    term(&["sram"], "", "Energy or power of accesses to the buffers on the chip."),
    term(&["flop"], "", "Energy or power of arithmetic."),
    term(&["leakage"], "", "Leakage of units and buffers, paid all the time."),
    term(&["background"], "", "DRAM that is on and idle, paid all the time."),
    term(&["refresh"], "", "Refresh of the DRAM, paid all the time."),
    term(&["total"], "", "Sum of the row or column."),
];
