//! Co-design.

use super::{Term, term};

pub(super) const CODESIGN: &[Term] = &[
    term(
        &["way", "how it is chosen", "(a)", "(b)", "(c)", "(d)", "(e)"],
        "",
        "How `codesign` chooses a pair: (a) the best machine for the dense model, (b) the best \
         model for the base machine, (c) that machine of (a) and then the best model for it, (d) \
         that model of (b) and then the best machine for it, (e) both together.",
    ),
    term(
        &["pair", "joint pair"],
        "",
        "A model on a machine, which is called by the number of its point; the base machine by its \
         name. The table of machines has the values of their axes.",
    ),
    term(
        &["chosen by"],
        "",
        "Which of the five ways find a machine; empty for one that only stands in other tables.",
    ),
    term(
        &["formats"],
        "",
        "Name of the number formats that the record of a Gaussian has in a model; `exact`: nothing \
         is rounded.",
    ),
    term(
        &["format"],
        "",
        "A format of files that a model may be written in, as `scene convert --format` has them.",
    ),
    term(&["bytes"], "B", "Bytes of a file."),
    term(&["sh_degree"], "", "Degree of the spherical harmonics of a model."),
    term(
        &["calibrated total", "calibrated total, mW", "calibrated total, W"],
        "W",
        "Watts of a pair with the calibrated model of the DRAM, by which pairs are ranked; the \
         other columns have the banked one.",
    ),
    term(
        &["slowest frame, ms", "slowest frame"],
        "ms",
        "Time of the slowest frame of all views: it has to keep the deadline.",
    ),
    term(
        &["is_within_budget"],
        "",
        "Whether a pair keeps the area and the frame time of the budget.",
    ),
    term(
        &["is_on_front"],
        "",
        "Whether no other pair that keeps the deadline beats a pair in watts, area and frame time.",
    ),
    term(&["total_w"], "W", "Display, rendering and standby power at the display rate."),
    term(
        &["views"],
        "",
        "Which views a row is a mean over: all, or the first or second half of them.",
    ),
    term(
        &["gain, %", "gain"],
        "%",
        "What (e) takes less than the best of (a) to (d), of what that takes.",
    ),
    term(
        &["regret, %", "regret"],
        "%",
        "What the pair of the run takes beyond the best pair under another energy table or on \
         other views; missing where it does not keep the budget there.",
    ),
    term(
        &["gate_display_w"],
        "W",
        "Display power of the images of a model, mean over the views that decide.",
    ),
];
