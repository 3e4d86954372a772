//! Claims about the colour filter in two stages, and about other panels.

use super::facts::{compared, dense, fallbacks, foveated, high};
use super::fovea::about;
use super::sentence::{fixed, joined, less, say, signed, watts};
use super::{Answer, Asks, Check, Here, Rule, Sentence, Unit};
use powergs_frame::fovea::{LEVELS, REGIONS};
use powergs_optimize::foveated::Method;
use powergs_optimize::results::{FovealRecord, Results, saving_at};

/// The published range of display power over rendering power.
const RATIOS: (f64, f64) = powergs_optimize::ratio_study::RATIOS;
/// A level or a region may be this far above level 1: they are of other poolings.
const SLACK: f64 = 1.1;

pub(super) const CHECKS: &[Check] = &[
    Check {
        id: "19a",
        what: "the more the display takes, the more is saved over FR-Render",
        published: "20 % less at 2.66",
        expects: "the saving rises from 0.38 to 2.66",
        rule: Rule::Most,
        asks: Asks::Each(ratio_render),
    },
    Check {
        id: "19b",
        what: "the more the display takes, the less is saved over FR-Display",
        published: "23 % less at 2.66",
        expects: "the saving falls from 0.38 to 2.66",
        rule: Rule::Most,
        asks: Asks::Each(ratio_display),
    },
    Check {
        id: "19c",
        what: "saving over the dense model at 2.66",
        published: "38 % less",
        expects: "less",
        rule: Rule::Most,
        asks: Asks::Each(ratio_dense),
    },
    Check {
        id: "20a",
        what: "less power than FR-Render with the colour filter (RTGS+D22)",
        published: "0.32 W against 0.34 W, 6 % less",
        expects: "less",
        rule: Rule::Most,
        asks: Asks::Each(filter_power),
    },
    Check {
        id: "20b",
        what: "and faster",
        published: "84 against 78 FPS, 8 % (on a GPU)",
        expects: "faster, on the simulated accelerator",
        rule: Rule::Most,
        asks: Asks::Each(filter_speed),
    },
    Check {
        id: "21a",
        what: "the colour filter costs quality beyond the fovea",
        published: "HVSQ 2.1, 2.6, 3.4, 5.0 e-5 in R1 to R4",
        expects: "HVSQ above that of FR-Render without the filter in every region beyond R1",
        rule: Rule::Most,
        asks: Asks::Each(filter_quality),
    },
    Check {
        id: "21b",
        what: "ours keeps the target everywhere",
        published: "HVSQ 2.1 e-5 in all four",
        expects: "whole test views: no level above 1.1 times the HVSQ of level 1",
        rule: Rule::Most,
        asks: Asks::Each(flat_levels),
    },
    Check {
        id: "21c",
        what: "ours keeps it in every region of the shown frames",
        published: "not separately",
        expects: "no region above 1.1 times the HVSQ of level 1 over whole test views",
        rule: Rule::Most,
        asks: Asks::Each(flat),
    },
    Check {
        id: "21d",
        what: "ours is better than RTGS+D22 in the periphery",
        published: "up to 2.4 times",
        expects: "a lower HVSQ in the outermost region",
        rule: Rule::Most,
        asks: Asks::Each(outermost),
    },
];

/// Savings at both ends of the range.
fn ends(r: &Results, other: (f64, f64)) -> Result<(f64, f64), String> {
    let ours = foveated(r, high(r))?;
    let at = |ratio| saving_at(dense(r)?, (ours.display_w, ours.render_w), other, ratio);
    Ok((at(RATIOS.0)?, at(RATIOS.1)?))
}

fn ends_text((low, high): (f64, f64)) -> Sentence {
    let [first, last] = [RATIOS.0, RATIOS.1].map(|ratio| fixed(ratio, Unit::One, 2));
    say("{} at {}, {} at {} (our model held fixed)", [less(low), first, less(high), last])
}

fn ratio_render(r: &Results) -> Answer {
    let other = compared(r, Method::FrRender, high(r))?;
    let ends = ends(r, (other.display_w, other.render_w))?;
    about(ends_text(ends), ends.1 > ends.0, &[foveated(r, high(r))?])
}

fn ratio_display(r: &Results) -> Answer {
    let other = compared(r, Method::FrDisplay, high(r))?;
    let ends = ends(r, (other.display_w, other.render_w))?;
    about(ends_text(ends), ends.1 < ends.0, &[foveated(r, high(r))?])
}

fn ratio_dense(r: &Results) -> Answer {
    let other = dense(r)?;
    let ends = ends(r, (other.display_w, other.render_w))?;
    about(ends_text(ends), ends.1 > 0.0, &[foveated(r, high(r))?])
}

/// Ours and RTGS+D22.
fn two(r: &Results) -> Result<[&FovealRecord; 2], String> {
    Ok([foveated(r, high(r))?, compared(r, Method::RtgsD22, high(r))?])
}

fn filter_power(r: &Results) -> Answer {
    let [ours, filtered] = two(r)?;
    let (a, b) = (ours.total_w(), filtered.total_w());
    let share = super::facts::saved(a, b)?;
    let filter = watts(filtered.filter_w);
    let text = say("{} against {}, {} (the filter {})", [watts(a), watts(b), less(share), filter]);
    // Less power at less quality is no win.
    let quality = ours.worst().zip(filtered.worst()).map(|((a, _), (b, _))| {
        say("its worst region has HVSQ {} against {} e-5", [hvsq(b), hvsq(a)])
    });
    let why = joined(fallbacks(ours).into_iter().chain(quality), "; ");
    Ok(Here { text, holds: share > 0.0, why })
}

fn filter_speed(r: &Results) -> Answer {
    let [ours, filtered] = two(r)?;
    let (Some(a), Some(b)) = (ours.fps, filtered.fps) else { return Err("no speed".into()) };
    let [own, other] = [a, b].map(|fps| fixed(fps, Unit::FramesPerSecond, 0));
    let change = signed(a / b - 1.0, Unit::Percent, 1);
    about(say("{} against {} FPS, {} %", [own, other, change]), a > b, &[ours])
}

fn hvsq(value: f64) -> Sentence {
    fixed(value, Unit::Hvsq, 2)
}

fn all_hvsq(values: &[Option<f64>]) -> Sentence {
    let shown = |v: &Option<f64>| v.map_or("none".into(), hvsq);
    joined(values.iter().map(shown), ", ").unwrap_or_default()
}

/// The regions that both have, from `first` on.
fn shared(a: &FovealRecord, b: &FovealRecord, first: usize) -> Vec<(usize, f64, f64)> {
    (first..LEVELS).filter_map(|i| Some((i, a.hvsq[i]?, b.hvsq[i]?))).collect()
}

fn filter_quality(r: &Results) -> Answer {
    let plain = compared(r, Method::FrRender, high(r))?;
    let filtered = compared(r, Method::RtgsD22, high(r))?;
    let regions = shared(filtered, plain, 1);
    if regions.is_empty() {
        return Err("no test view has a region beyond R1".into());
    }
    let both = [filtered, plain].map(|f| all_hvsq(&f.hvsq));
    let text = say("{} with, {} e-5 without", both);
    about(text, regions.iter().all(|(_, a, b)| a > b), &[])
}

/// As published: each level as a whole picture at its own pooling, not its region alone, whose HVSQ
/// depends on what it shows.
fn flat_levels(r: &Results) -> Answer {
    let ours = foveated(r, high(r))?;
    let [first, upper @ ..] = ours.level_hvsq(r);
    let first = first.ok_or("level 1 has no HVSQ")?;
    if upper.iter().all(Option::is_none) {
        return Err("no level beyond the first has a model of its own".into());
    }
    let text = say("{} e-5; level 1 {} e-5", [all_hvsq(&upper), hvsq(first)]);
    // What the levels had to reach, over other views.
    let target = super::facts::first(r, ours)?.gate.hvsq;
    let gate = target.map(|v| say("over the gate views level 1 has {} e-5", [hvsq(v)]));
    let why = joined(fallbacks(ours).into_iter().chain(gate), "; ");
    let holds = upper.iter().flatten().all(|v| *v <= SLACK * first);
    Ok(Here { text, holds, why })
}

fn flat(r: &Results) -> Answer {
    let ours = foveated(r, high(r))?;
    let first = ours.level_hvsq(r)[0].ok_or("level 1 has no HVSQ")?;
    let worst = ours.worst().ok_or("no test view has a region")?;
    let text = say("{}; level 1 {} e-5", [all_hvsq(&ours.hvsq), hvsq(first)]);
    let why = "a mean over whole views counts empty places, a region is where the detail is";
    Ok(Here { text, holds: worst.0 <= SLACK * first, why: Some(why.into()) })
}

fn outermost(r: &Results) -> Answer {
    let [ours, filtered] = two(r)?;
    let regions = shared(ours, filtered, 1);
    let &(i, a, b) = regions.last().ok_or("no test view has a region beyond R1")?;
    let factor = (a > 0.0).then(|| say(", {} times", [fixed(b / a, Unit::One, 2)]));
    let values = [REGIONS[i].into(), hvsq(a), hvsq(b), factor.unwrap_or_default()];
    let text = say("{}: {} against {} e-5{}", values);
    about(text, a < b, &[ours])
}
