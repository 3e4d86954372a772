//! Claims about level 1 shown everywhere: no foveation.

use super::facts::{baseline, dense, high, ours, saved};
use super::sentence::{fixed, less, say, watts};
use super::{Answer, Asks, Check, Rule, Sentence, Unit, here};
use crate::results::Results;
use crate::role::Baseline;

pub(super) const CHECKS: &[Check] = &[
    Check {
        id: "23",
        what: "without foveation: dense over display-only over render-only, not below ours",
        published: "1.11, 1.06, 0.56, 0.54 W",
        expects: "this order of power",
        rule: Rule::All,
        asks: Asks::Each(order),
    },
    Check {
        id: "24",
        what: "without foveation: less than render-only",
        published: "4 % less",
        expects: "less",
        rule: Rule::All,
        asks: Asks::Each(over_render_only),
    },
];

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
