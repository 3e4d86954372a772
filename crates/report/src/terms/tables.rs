//! Heads and rows of the tables of a run.

use super::{Term, term};

pub(super) const TABLES: &[Term] = &[
    term(
        &["doubled", "if doubled", "one step", "what if", "what_if", "what-if"],
        "",
        "The what-if experiment: some frames are simulated again with each resource doubled. The \
         row `nothing` is the machine as it is.",
    ),
    term(
        &["change", "%", "frame time: %", "power: %", "area: %", "merit: %"],
        "%",
        "Relative change against the first row or column.",
    ),
    term(&["frame time: ms"], "ms", "Mean frame time of the frames that were tried."),
    term(
        &["area: mm²"],
        "mm²",
        "Area of the die with the resource doubled: PHY and controllers of channels that are added \
         are in it.",
    ),
    term(
        &["merit: FPS/mm²", "FPS/mm²"],
        "1/s/mm²",
        "Frames per second, back to back, per mm² of chip: what `next` goes by.",
    ),
    term(&["difference"], "", "Value of a side minus that of the first."),
    term(
        &["buffer"],
        "",
        "A buffer of the machine, with the name that it has in the machine file.",
    ),
    term(&["KiB"], "KiB", "Capacity of the buffer, all cores together."),
    term(&["peak %", "peak"], "%", "The fullest that the buffer ever was, of its capacity."),
    term(&["mean %"], "%", "How full the buffer is on average over the frame."),
    term(&["filled"], "B", "Bytes written into the buffer in a frame."),
    term(&["consumed"], "B", "Bytes of it that a unit has read."),
    term(
        &["discarded"],
        "B",
        "Bytes that were fetched and never read: the tile was finished before.",
    ),
    term(&["effect"], "", "Something that real hardware has and the model leaves out."),
    term(
        &["simulated time is", "bias"],
        "",
        "Which way the frame time is wrong for a missing effect: optimistic (real frames take \
         longer), pessimistic (less long), either.",
    ),
    term(&["see"], "", "The assumption that says more: powergs-sim explain A21."),
    term(&["statistic"], "", "A measured number; powergs-sim explain NAME defines each of them."),
    term(&["mean"], "", "Arithmetic mean over the frames."),
    term(&["p50", "median"], "", "Half of the frames are at or below this value."),
    term(&["p95"], "", "95 % of the frames are at or below this value (nearest rank)."),
    term(
        &["p99"],
        "",
        "99 % of the frames are at or below this value (nearest rank); with fewer than 100 frames \
         it is the maximum.",
    ),
    term(&["max"], "", "The largest value of all frames."),
    term(&["min"], "", "The smallest value of all frames."),
    term(
        &["region", "region, a frame", "R1", "R2", "R3", "R4"],
        "",
        "Of a foveated frame: R1 is the part around the gaze, R4 the outermost; each is drawn with \
         its own level of the model.",
    ),
    term(&["tiles"], "", "Tiles of the image that belong to the row."),
    term(&["splats loaded"], "", "Splats that were fetched for the tiles of the row."),
    term(&["VRU cycles"], "cycles", "Cycles in which the rendering units worked on the row."),
    term(&["block"], "", "A unit or buffer of the chip."),
    term(
        &["area", "area mm2", "area mm²", "area of the die, mm²"],
        "mm²",
        "Area of the die, PHY and controllers of the memory included, or of a block of it. DRAM is \
         another chip.",
    ),
    term(
        &["peak mW"],
        "mW",
        "Power of a block that works in every cycle. A frame never has all blocks at their peak.",
    ),
    term(
        &["row"],
        "",
        "In results.csv: `frame`, or the aggregate `mean`, `p50`, `p95`, `p99`, `max`.",
    ),
    term(&["frame"], "", "Position of the frame in its trace, from 0."),
    term(&["name"], "", "Name of the view, of the statistic or of the row."),
    term(
        &["kind"],
        "",
        "In compare.csv: `measure` (of the first table) or `mean` (of a statistic).",
    ),
    term(&["incomplete"], "", "Whether the run was interrupted before its last frame."),
    term(
        &["roofline"],
        "FLOP/s",
        "Operations per DRAM byte against operations per second, under the peak rates of the \
         machine.",
    ),
];
