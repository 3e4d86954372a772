//! Sensitivity.

use super::{Term, term};

pub(super) const SENSITIVITY: &[Term] = &[
    term(&["file"], "", "Which file has the key: machine, energy table or DRAM device."),
    term(&["key", "keys"], "", "A key of that file; powergs-sim explain KEY defines it."),
    term(&["value"], "", "What the key has."),
    term(
        &["step", "step, %", "near"],
        "%",
        "The small step down and up that elasticities are measured with.",
    ),
    term(&["far"], "", "The large step: half and double of the value."),
    term(&["other"], "", "Another name that the key can have."),
    term(
        &[
            "elasticity",
            "elasticity_fps",
            "elasticity_energy",
            "elasticity_power",
            "elasticity_area",
        ],
        "",
        "d ln y / d ln x: by how many percent a result changes when the key changes by one \
         percent.",
    ),
    term(
        &["low", "low .. high", "high"],
        "",
        "Results, or values, at the lower and at the higher step.",
    ),
    term(&["fps"], "", "Frame rate, or its change or elasticity."),
    term(&["power"], "", "Power at the display rate, or its change or elasticity."),
    term(
        &["assumption"],
        "",
        "A modelling choice of this program, numbered A1, A2, ...: powergs-sim explain A1.",
    ),
    term(&["knob"], "", "The keys that vary an assumption."),
    term(&["base"], "", "The value that the machine has."),
    term(
        &["levels"],
        "",
        "The values that a key takes in the experiment; of a foveated model: its levels.",
    ),
    term(&["trace"], "", "The trace, or its label."),
    term(&["frames"], "", "How many frames were simulated."),
    term(
        &["ST", "S1", "ST low", "ST high", "S1 low", "S1 high"],
        "",
        "Sobol indices: the share of the variance that a key causes alone (S1) and together with \
         all others (ST), with confidence intervals.",
    ),
    term(
        &["mu*", "μ*", "μ", "mu_percent", "mu_star_percent", "sigma_percent", "sigma", "σ", "mu"],
        "",
        "Of Morris: mean absolute elementary effect (how much a key matters) and its spread (how \
         much that depends on the others).",
    ),
    term(&["status"], "", "Whether the key or the row has a result, or why it has none."),
    term(
        &["reach"],
        "",
        "In sensitivity.csv: which step the row is: near or far, down or up, or another name.",
    ),
    term(&["reason", "refused", "why"], "", "Why there is no result."),
    term(&["dead on these frames"], "", "Keys that move nothing here, by the reason."),
    term(&["no other value is valid"], "", "Keys whose other values contradict the machine."),
    term(&["tried"], "", "Values that were tried."),
    term(
        &["elasticity_sides"],
        "",
        "Which steps the elasticity is from: both sides, or only the one that is a valid machine.",
    ),
    term(
        &["elasticity_shape"],
        "",
        "Whether the frame rate is alike on both sides of the value (smooth), at least twice as \
         steep on one of them (kinked), or known on one side only (one-sided).",
    ),
    term(
        &["far_change"],
        "",
        "The largest change of any result at half or at double, or by another name, relative.",
    ),
    term(&["largest_change"], "", "The largest change of any result of the key, relative."),
    term(
        &[
            "fps_change",
            "fps_change_low",
            "fps_change_high",
            "energy_change",
            "energy_change_low",
            "energy_change_high",
            "power_change",
            "power_change_low",
            "power_change_high",
            "area_change",
            "area_change_low",
            "area_change_high",
        ],
        "",
        "Relative change of the result; with `_low` and `_high`: at the lower and the higher far \
         step.",
    ),
    term(&["power_display_rate_w"], "W", "Power at the display rate."),
];
