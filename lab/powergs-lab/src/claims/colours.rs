//! Claims about what becomes of the colours.

use super::sentence::{say, signed};
use super::{Answer, Asks, Check, Here, Rule, Sentence, Unit, here};
use powergs_frame::fovea::{LEVELS, REGIONS};
use powergs_optimize::results::{ChangeRecord, Results};

pub(super) const CHECKS: &[Check] = &[
    Check {
        id: "27a",
        what: "a yellow-green tint: blue, the most expensive channel, loses most",
        published: "yellow-green tint",
        expects: "mean blue falls more than mean red and green",
        rule: Rule::Most,
        asks: Asks::Each(blue),
    },
    Check {
        id: "27b",
        what: "the tint is stronger in the periphery",
        published: "stronger in the periphery",
        expects: "blue falls more in the outermost region than in R1, against red and green",
        rule: Rule::Most,
        asks: Asks::Each(periphery),
    },
];

fn change(r: &Results) -> Result<&ChangeRecord, String> {
    r.mean_change.as_ref().ok_or_else(|| "no model of ours reached the target".into())
}

fn shown(change: [f64; 3]) -> Sentence {
    say("{}, {}, {}", change.map(|c| signed(c, Unit::Codes, 2)))
}

fn blue(r: &Results) -> Answer {
    let change = change(r)?;
    let [red, green, blue] = change.level_1;
    let text = say("red, green, blue {} of 255", [shown([red, green, blue])]);
    let dense = change.dense.map(|dense| [0, 1, 2].map(|c| change.level_1[c] / dense[c]));
    let shares = dense.filter(|s| s.iter().all(|v| v.is_finite()));
    let why = shares.map(|shares| {
        let shares = shares.map(|s| signed(s, Unit::Percent, 1));
        say("as shares of what the view has {}, {}, {} %", shares)
    });
    Ok(Here { text, holds: blue < red && blue < green, why })
}

/// How much more blue falls than the mean of red and green.
fn tint([r, g, b]: [f64; 3]) -> f64 {
    (r + g) / 2.0 - b
}

fn periphery(r: &Results) -> Answer {
    let regions = change(r)?.regions.ok_or("not foveated (optimize --foveated)")?;
    let fovea = regions[0].ok_or("no R1 in this view")?;
    let outer = (1..LEVELS).rev().find_map(|i| Some((i, regions[i]?)));
    let (i, outer) = outer.ok_or("no region beyond R1 in this view")?;
    let text = say("R1 {}; {} {} of 255", [shown(fovea), REGIONS[i].into(), shown(outer)]);
    here(text, tint(outer) > tint(fovea))
}
