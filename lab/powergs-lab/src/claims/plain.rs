//! Claims about level 1 shown everywhere: no foveation.

use super::facts::{baseline, dense, high, ours, saved};
use super::sentence::{fixed, less, say, watts};
use super::{Answer, Asks, Check, Rule, Sentence, Unit, here};
use powergs_optimize::results::Results;
use powergs_optimize::role::Baseline;

pub(super) const CHECKS: &[Check] = &[
    Check {
        id: "23",
        what: "without foveation: dense over display-only over render-only, not below ours",
        published: "1.11, 1.06, 0.56, 0.54 W",
        expects: "this order of power",
        rule: Rule::Most,
        asks: Asks::Each(order),
    },
    Check {
        id: "24",
        what: "without foveation: less than render-only",
        published: "4 % less",
        expects: "less",
        rule: Rule::Most,
        asks: Asks::Each(over_render_only),
    },
    Check {
        id: "29",
        what: "pruning alone prunes no less than both together, dimming alone dims no less",
        published: "follows from the method",
        expects: "ρ of render-only not 0.02 below, display power of display-only not 1 % over ours",
        rule: Rule::Most,
        asks: Asks::Each(ends),
    },
];

/// Ratios that differ by less are the same.
const SAME_RHO: f64 = 0.02;
/// Powers that differ by less are the same, relative.
const SAME_POWER: f64 = 0.01;

fn order(r: &Results) -> Answer {
    let variant = high(r);
    let all = [
        dense(r)?,
        baseline(r, Baseline::DisplayOnly, variant)?,
        baseline(r, Baseline::RenderOnly, variant)?,
        ours(r, variant)?,
    ];
    let [a, b, c, d] = all.map(|m| m.total_w());
    let text = say("{}, {}, {}, {}", [a, b, c, d].map(watts));
    here(text, a > b && b > c && c >= d)
}

fn over_render_only(r: &Results) -> Answer {
    let variant = high(r);
    let (other, ours) = (baseline(r, Baseline::RenderOnly, variant)?, ours(r, variant)?);
    let share = saved(ours.total_w(), other.total_w())?;
    let quality = match (ours.test.psnr_db, other.test.psnr_db) {
        (Some(a), Some(b)) => {
            say(", at {} dB against {} dB", [a, b].map(|db| fixed(db, Unit::Decibels, 2)))
        }
        _ => Sentence::default(),
    };
    here(say("{}{}", [less(share), quality]), share > 0.0)
}

fn ends(r: &Results) -> Answer {
    let variant = high(r);
    let ours = ours(r, variant)?;
    let render = baseline(r, Baseline::RenderOnly, variant)?;
    let display = baseline(r, Baseline::DisplayOnly, variant)?;
    let rhos = [render, ours].map(|m| fixed(m.rho, Unit::One, 2));
    let powers = [display, ours].map(|m| watts(m.display_w));
    let text = say("ρ {} and {}", rhos).then("; display ", say("{} and {}", powers));
    let prunes = render.rho >= ours.rho - SAME_RHO;
    let dims = display.display_w <= ours.display_w * (1.0 + SAME_POWER);
    here(text, prunes && dims)
}
