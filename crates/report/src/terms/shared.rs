//! Words that reports of several kinds have.

use super::{Term, term};

pub(super) const MORE: &[Term] = &[
    term(
        &["at the display rate"],
        "mW",
        "Power at the display rate, or its change: see `power at the display rate`.",
    ),
    term(&["ms", "mm²"], "", "The value of the group of columns, in milliseconds or in mm²."),
    term(
        &["state", "state_l1", "state_l2", "state_l3", "state_l4"],
        "",
        "How the fine-tune of a level ended: whether it passed, or why there is none.",
    ),
    term(
        &["W", "mW", "µW", "watts", "joules_per_frame"],
        "",
        "Power of the row at the display rate (watt, 10⁻³ W, 10⁻⁶ W), or the energy of one frame.",
    ),
    term(
        &["first", "first_low", "first_high", "total_low", "total_high"],
        "",
        "Of Sobol indices: the share of the variance that a key causes alone (first) and together \
         with the others (total), with the ends of the 95 % interval. In a ranking: the best \
         design.",
    ),
    term(&["measure"], "", "The result that the row is about: fps, energy, power or area."),
    term(
        &["misses_display_rate"],
        "",
        "Whether the design has fewer frames per second than the display shows.",
    ),
    term(
        &["same_as"],
        "",
        "An earlier design of the front that differs from this one by noise only.",
    ),
    term(
        &["side"],
        "",
        "Of an assumption: the lower or the higher value; of a comparison: a machine or a report.",
    ),
    term(
        &["with"],
        "",
        "Settings without which the keys of an assumption move nothing; its row is compared with \
         the machine that has them.",
    ),
    term(&["machine"], "", "The machine file, by its name."),
    term(
        &["invalid configuration"],
        "",
        "Values that contradict each other or a range: there is no such machine, and nothing is \
         simulated.",
    ),
];
