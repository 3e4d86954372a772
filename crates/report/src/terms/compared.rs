//! Comparisons and what-if experiments.

use super::{Term, term};

pub(super) const COMPARED: &[Term] = &[
    term(
        &["speed-up", "speedup"],
        "",
        "Frame rate over that of the first machine on the same trace; over several traces the \
         geometric mean.",
    ),
    term(
        &["energy gain", "energy_gain"],
        "",
        "Energy per frame of the first machine over that of this one on the same trace; over \
         several traces the geometric mean.",
    ),
    term(&["ratio"], "", "Value of a side over that of the first."),
    term(
        &["verdict", "meets all"],
        "",
        "What a machine on a trace falls short of: the display rate (frames missed), `--budget`, \
         `--latency`, `--where`; `meets all` where it is nothing.",
    ),
    term(
        &["task", "train", "track", "render"],
        "",
        "What a frame of a machine is: a picture for a display, a step of training (by what is \
         updated) or of tracking, and which share of the pixels is rendered. Steps have no display \
         and no deadline.",
    ),
    term(
        &["slowest, ms", "slowest_ms", "slowest"],
        "ms",
        "The slowest frame; from 100 frames on what 99 % of them take at most.",
    ),
    term(
        &["latency, ms", "latency_ms"],
        "ms",
        "The slowest frame from its first read to its last write: where frames overlap, longer \
         than from one to the next.",
    ),
    term(
        &["power_at_fps", "W at own rate"],
        "1/s",
        "Frames or steps a second at which the power beside it is drawn: the display rate, or what \
         is reached of it.",
    ),
    term(&["is_met"], "", "Whether everything that was asked for is met."),
    term(
        &["power_scope", "power is of"],
        "",
        "What powers and energies are of: the block that renders with its memory, a module, a \
         board (`[scope]` of energy tables).",
    ),
    term(&["missed"], "1", "Frames that take longer than a period of the display."),
    term(&["die, mm²"], "mm²", "Area of the die, PHY and memory controllers included."),
    term(
        &["not the same", "basis"],
        "",
        "What the numbers of machines are of, as far as it differs: task, memory and its price, \
         PHY, second master, node, scope of area and power.",
    ),
    term(
        &["least", "largest"],
        "",
        "The least and the largest gain over the traces, around the geometric mean.",
    ),
    term(
        &["FPS per W", "FPS per W (frames per J)", "fps_per_w"],
        "1/J",
        "Frame rate over power at full rate: frames per joule.",
    ),
    term(
        &["FPS per mm2", "FPS per mm²", "FPS per mm² of die", "fps_per_mm2"],
        "FPS/mm²",
        "Frame rate over the area of the die.",
    ),
    term(
        &["area_core_mm2"],
        "mm²",
        "Area of the die without PHY and memory controllers: what papers print.",
    ),
    term(
        &["node", "node_nm"],
        "nm",
        "Technology node of the energy table. Areas, energies and powers of different nodes are \
         not put into ratios.",
    ),
    term(
        &["DRAM", "DRAM MB per frame", "dram_mb_per_frame"],
        "MB",
        "Bytes read and written in DRAM for a frame.",
    ),
    term(
        &["DRAM peak", "dram_peak_gb_s"],
        "GB/s",
        "Peak rate of the DRAM: all channels, every beat.",
    ),
    term(&["frame_time_p99_ms"], "ms", "99 % of the frames take at most this long."),
    term(&["energy_per_frame_mj"], "mJ", "Energy of one frame at full rate."),
    term(
        &["waits", "ccu waits", "qsu waits", "bsu waits", "vru waits"],
        "%",
        "Share of the frame in which a unit with work waits for the cause behind the colon.",
    ),
];
