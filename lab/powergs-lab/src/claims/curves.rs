//! Claims about power over the pruning ratio, and about λ.

use super::facts::{dense, high, saved};
use super::sentence::{count, fixed, say, signed};
use super::{Answer, Asks, Check, Here, Rule, Sentence, Unit, here};
use powergs_base::format::counted;
use powergs_optimize::fit::OptimumPlace;
use powergs_optimize::results::{FitRecord, ModelRecord, Results};
use powergs_optimize::role::RoleKind;

/// A mean relative error that is a few percent.
const MRE_MOST: f64 = 0.05;
/// A fit that explains the samples.
const R2_LEAST: f64 = 0.9;
/// A minimum this near to an end, of the range of ρ, is none.
const EDGE: f64 = 0.05;
/// λ has settled when its checks are less than this off the target, decibels.
const SETTLED_DB: f64 = 0.25;
/// Iterations in which λ should find its place.
const ITERATIONS: u32 = 1000;

pub(super) const CHECKS: &[Check] = &[
    Check {
        id: "3",
        what: "two-parameter curves fit display and rendering power",
        published: "mean relative error 0.003 and 0.008",
        expects: "errors of at most 0.05, R² over 0.9",
        rule: Rule::Most,
        asks: Asks::Each(fits),
    },
    Check {
        id: "4a",
        what: "rendering power falls with ρ, nearly linearly",
        published: "figure",
        expects: "falls; a straight line has R² over 0.9",
        rule: Rule::Most,
        asks: Asks::Each(render_falls),
    },
    Check {
        id: "4b",
        what: "display power rises with ρ",
        published: "figure",
        expects: "rises",
        rule: Rule::Most,
        asks: Asks::Each(display_rises),
    },
    Check {
        id: "4c",
        what: "the total is U-shaped",
        published: "figure",
        expects: "a minimum off the ends (5 % of the range), in one scene at least",
        rule: Rule::Any,
        asks: Asks::Each(interior),
    },
    Check {
        id: "25",
        what: "PSNR and display power fall as a fixed λ grows",
        published: "figure; sweet spot at λ of 0.2",
        expects: "every step falls, both",
        rule: Rule::Most,
        asks: Asks::Each(sweep),
    },
    Check {
        id: "26",
        what: "λ finds the quality target by itself",
        published: "in less than 1000 iterations",
        expects: "checks within 0.25 dB of it, in the last tenth of at most 1000 iterations",
        rule: Rule::Most,
        asks: Asks::Each(settles),
    },
];

fn first_fit(r: &Results) -> Result<&FitRecord, String> {
    let fit = r.fit(high(r), 1).ok_or("no samples")?;
    match &fit.no_curve {
        Some(why) => Err(format!("no curve: {why}")),
        None => Ok(fit),
    }
}

fn fits(r: &Results) -> Answer {
    let fit = first_fit(r)?;
    if fit.passed < 4 {
        return Err(format!("{} passed: any such curve fits", counted(fit.passed, "sample")));
    }
    let (Some(d), Some(e)) = (fit.mre_display, fit.mre_render) else {
        return Err("a sample without power".into());
    };
    let shown = |v: Option<f64>| v.map_or("none".into(), |v| fixed(v, Unit::One, 3));
    let [d4, e4] = [d, e].map(|v| fixed(v, Unit::One, 4));
    let r2 = [shown(fit.r2_display), shown(fit.r2_render)];
    let text = say("errors {} and {}, ", [d4, e4]).then("R² ", say("{} and {}", r2));
    let explains = |r2: Option<f64>| r2.is_some_and(|r2| r2 > R2_LEAST);
    let good = d <= MRE_MOST && e <= MRE_MOST;
    let answer = here(text, good && explains(fit.r2_display) && explains(fit.r2_render))?;
    let why = good.then(|| "the errors are small, the powers hardly vary".into());
    Ok(Here { why, ..answer })
}

/// The samples of level 1 that reached the target, by ρ.
fn samples(r: &Results) -> Result<Vec<&ModelRecord>, String> {
    let variant = high(r);
    let is = |m: &&ModelRecord| {
        m.role == RoleKind::Sample && m.level == 1 && m.variant == variant && m.passed
    };
    let mut samples: Vec<&ModelRecord> = r.models.iter().filter(is).collect();
    samples.sort_by(|a, b| a.rho.total_cmp(&b.rho));
    let spread = samples.last().zip(samples.first()).map(|(a, b)| a.rho - b.rho);
    match spread {
        Some(spread) if spread > 0.0 => Ok(samples),
        _ => Err("fewer than two samples reached the target".into()),
    }
}

/// Change from the least to the most pruned sample, with the ratios.
fn change(
    samples: &[&ModelRecord],
    of: fn(&ModelRecord) -> f64,
) -> Result<(f64, Sentence), String> {
    let (low, high) = (samples[0], samples[samples.len() - 1]);
    let change = -saved(of(high), of(low))?;
    let [from, to] = [low, high].map(|m| fixed(m.rho, Unit::One, 2));
    let text = say("{} % from ρ {} to {}", [signed(change, Unit::Percent, 1), from, to]);
    Ok((change, text))
}

fn render_falls(r: &Results) -> Answer {
    let samples = samples(r)?;
    let (change, text) = change(&samples, |m| m.render_w)?;
    let points: Vec<(f64, f64)> = samples.iter().map(|m| (m.rho, m.render_w)).collect();
    let Some(r2) = straightness(&points) else { return here(text, change < 0.0) };
    let text = text.then(", straight line R² ", fixed(r2, Unit::One, 3));
    here(text, change < 0.0 && r2 > R2_LEAST)
}

fn display_rises(r: &Results) -> Answer {
    let (change, text) = change(&samples(r)?, |m| m.display_w)?;
    here(text, change > 0.0)
}

/// R² of the line of least squares; `None` with fewer than three points, or if nothing varies.
fn straightness(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>();
    let xx = sum(&|p| (p.0 - mx).powi(2));
    let xy = sum(&|p| (p.0 - mx) * (p.1 - my));
    let yy = sum(&|p| (p.1 - my).powi(2));
    (points.len() > 2 && xx > 0.0 && yy > 0.0).then(|| xy * xy / (xx * yy))
}

fn interior(r: &Results) -> Answer {
    let fit = first_fit(r)?;
    let place = fit.optimum_place.ok_or("no optimum")?;
    let rho = fit.optimum_rho.unwrap_or(0.0);
    let text = say("{} at ρ {}", [place.name().replace('_', " ").into(), fixed(rho, Unit::One, 3)]);
    let Some([low, high]) = fit.rho_range else {
        return here(text, place == OptimumPlace::Interior);
    };
    let room = EDGE * (high - low);
    let is_inside = (low + room..=high - room).contains(&rho);
    let [from, to] = [low, high].map(|rho| fixed(rho, Unit::One, 2));
    here(
        text.then(" of ", say("{} to {}", [from, to])),
        place == OptimumPlace::Interior && is_inside,
    )
}

fn sweep(r: &Results) -> Answer {
    let mut models: Vec<(f64, &ModelRecord)> =
        r.models.iter().filter_map(|m| Some((m.sweep_lambda?, m))).collect();
    if models.len() < 2 {
        return Err("no sweep of λ (optimize --study lambda)".into());
    }
    models.sort_by(|a, b| a.0.total_cmp(&b.0));
    let steps = models.len() - 1;
    let falls = |of: fn(&ModelRecord) -> Option<f64>| {
        let pairs = models.windows(2).map(|w| (of(w[0].1), of(w[1].1)));
        pairs.filter(|p| matches!(p, (Some(a), Some(b)) if b < a)).count()
    };
    let psnr = falls(|m| m.test.psnr_db);
    let display = falls(|m| Some(m.display_w));
    let unit = dense(r)?.gate.display_w;
    if unit <= 0.0 {
        return Err("the dense model shows black: no display power".into());
    }
    let most = fixed(models[steps].0 / unit, Unit::PerWatt, 3);
    let text = say(
        "PSNR falls in {} of {} steps, display power in {}; λ up to {}/W",
        [count(psnr), count(steps), count(display), most],
    );
    here(text, psnr == steps && display == steps)
}

/// The samples that λ steered. One that has not arrived and had fewer iterations than λ may take
/// says nothing; the rendering end has no λ. The model that is kept may be another than the last
/// one: the cheapest that reached the target.
fn settles(r: &Results) -> Answer {
    let is = |m: &&ModelRecord| m.role == RoleKind::Sample && m.level == 1 && m.passed;
    let passed = || r.models.iter().filter(is);
    let samples: Vec<(f64, u32)> =
        passed().filter_map(|m| Some((m.steered_db?, m.iterations))).collect();
    if samples.is_empty() && passed().any(|m| m.lambda_per_w.is_some()) {
        return Err("priced anew: where λ steered is in the run before".into());
    }
    if samples.is_empty() {
        return Err("no sample with a display term reached the target".into());
    }
    let is_near =
        |(off, iterations): &(f64, u32)| off.abs() <= SETTLED_DB && *iterations <= ITERATIONS;
    let near = samples.iter().filter(|sample| is_near(sample)).count();
    let cut_off = samples.iter().filter(|s| !is_near(s) && s.1 < ITERATIONS).count();
    if cut_off > 0 {
        return Err(format!(
            "{} ended off the target with fewer than {ITERATIONS} iterations (optimize --rhos 0 \
             --iterations {ITERATIONS})",
            counted(cut_off, "sample")
        ));
    }
    let most =
        samples.iter().map(|s| s.0).fold(0.0, |a, b| if b.abs() > f64::abs(a) { b } else { a });
    let iterations = samples.iter().map(|s| s.1).max().unwrap_or(0);
    let farthest = fixed(most, Unit::Decibels, 2);
    let text = say(
        "{} of {} samples, the farthest {} dB above it, in at most {} iterations",
        [count(near), count(samples.len()), farthest, count(iterations as usize)],
    );
    here(text, near == samples.len())
}
