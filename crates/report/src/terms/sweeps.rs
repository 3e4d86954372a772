//! Sweeps and their analysis.

use super::{Term, term};

pub(super) const SWEEPS: &[Term] = &[
    term(
        &["design"],
        "",
        "One machine of a sweep: a number (#12) for a point of the space, or the baseline.",
    ),
    term(&["baseline"], "", "The base machine of a sweep as it is, without any axis."),
    term(
        &["front", "Pareto front"],
        "",
        "The designs that no other design beats in all objectives at once.",
    ),
    term(
        &["knee"],
        "",
        "The design of the front with the smallest merit: the best compromise if every objective \
         counts the same between its best and its worst value on the front.",
    ),
    term(
        &["merit"],
        "",
        "Mean of the objectives of a design, each scaled so that the best value on the front is 0 \
         and the worst is 1. The knee has the smallest. In a what-if table: frames per second \
         and mm².",
    ),
    term(&["objective"], "", "What a front makes small or large: any column of the results."),
    term(&["settings"], "", "Values of the axes of a design."),
    term(&["axis"], "", "What a sweep varies: one key, several together, or named sets of keys."),
    term(&["values"], "", "How many values the axis has."),
    term(
        &["main effect", "main effect, %"],
        "%",
        "How far the mean over all designs moves between the values of the axis, relative to the \
         mean of all.",
    ),
    term(
        &["alone at most", "alone at most, %"],
        "%",
        "The largest change between two designs that differ in this axis only.",
    ),
    term(&["dead"], "", "The axis moves none of the objectives."),
    term(
        &["ranked under"],
        "",
        "The energy table, the trace or the price of DRAM that the ranking is repeated under.",
    ),
    term(
        &["Kendall τ", "kendall", "τ"],
        "",
        "Agreement of two rankings from -1 to 1: the share of pairs of designs in the same \
         order, minus the share in the opposite one.",
    ),
    term(
        &["Spearman ρ", "spearman"],
        "",
        "Correlation of the ranks of two rankings, from -1 to 1.",
    ),
    term(&["fronts"], "", "On how many of the fronts the design is."),
    term(
        &["kept", "front kept", "top kept"],
        "",
        "How many designs of the front, or of the best, stay there under another table, trace or \
         price.",
    ),
    term(&["break the condition"], "", "Designs that no longer meet the condition."),
    term(
        &["marginal value", "marginal"],
        "",
        "What the next mm² or mW buys from one design of the front to the next.",
    ),
    term(
        &["confirmed", "with banked", "standing"],
        "",
        "Of a design of the front that was simulated again with `banked`: the knee or on the front \
         there, beaten by another one, late (misses the display rate), unmet (the condition), \
         failed.",
    ),
    term(
        &["banked"],
        "",
        "The DRAM model that is reported with: every command of every bank (`docs/dram.md`).",
    ),
    term(
        &["calibrated"],
        "",
        "The DRAM model for many machines: as cheap as `bandwidth`, with rates and latencies from \
         one `banked` run (`docs/dram.md`).",
    ),
    term(
        &["±", "±, %", "difference_frac"],
        "",
        "What the `calibrated` model of the DRAM says too much (+) or too little (-), as a share \
         of what `banked` says.",
    ),
    term(
        &["display rate", "misses_display_rate"],
        "",
        "Whether every frame of a design is ready within a display period: met, or missed.",
    ),
    term(
        &["same as", "same_as"],
        "",
        "Designs that are equal in every objective but for noise (`--epsilon`).",
    ),
    term(&["role"], "", "In pareto.csv: `knee`, `front`, or the design that `--design` names."),
    term(
        &[".si"],
        "",
        "A column KEY.si has the value of a key as a number in base units (bytes, Hz, bytes per \
         second); KEY has it as it is written.",
    ),
    term(&["energy table"], "", "The energy table that a row was priced with."),
];
