//! Claims about the total power of foveated models, against dense models and the methods that
//! optimise one thing.

use super::facts::{
    baseline, compared, dense, fallbacks, first, foveated, high, losses, losses_text, low, saved,
};
use super::sentence::{count, fixed, joined, less, say, signed, watts};
use super::{Answer, Asks, Check, Here, Rule, Sentence, Unit};
use powergs_optimize::foveated::Method;
use powergs_optimize::results::{FovealRecord, ModelRecord, Results};
use powergs_optimize::role::Baseline;

/// A large factor: more than half is saved.
const LARGE: f64 = 0.5;
/// Tens of percent.
const TENS: f64 = 0.1;
/// `powergs`, claim 16.
const OVER_DENSE: f64 = 0.4;
/// Relative loss of PSNR and SSIM against the foveated baselines, and against the dense model.
const LOSS: (f64, f64) = (0.005, 0.01);

pub(super) const CHECKS: &[Check] = &[
    Check {
        id: "1",
        what: "total power, best case against the dense model",
        published: "up to 86 % less",
        expects: "more than half is saved, in one scene at least",
        rule: Rule::Any,
        asks: Asks::Each(best_case),
    },
    Check {
        id: "2",
        what: "total power against 3DGS and Mini-Splatting",
        published: "52 % and 63 % less",
        expects: "at least a tenth less than the dense model",
        rule: Rule::Most,
        asks: Asks::Each(over_dense),
    },
    Check {
        id: "11",
        what: "PowerGS-H against LightGS-L, FR-Render-H, FR-Display-L",
        published: "16.8, 12.3, 50.6 % less",
        expects: "less than all; most against FR-Display",
        rule: Rule::Most,
        asks: Asks::Each(high_against_others),
    },
    Check {
        id: "12",
        what: "the dense model takes a multiple of PowerGS-L",
        published: "2.7 times; 5 FPS on a mobile GPU",
        expects: "more than twice",
        rule: Rule::Most,
        asks: Asks::Each(factor),
    },
    Check {
        id: "15a",
        what: "the variants against FR-Render and FR-Display",
        published: "13.1 and 52.5 % less",
        expects: "less than both; more is saved over FR-Display",
        rule: Rule::Most,
        asks: Asks::Each(variants),
    },
    Check {
        id: "15b",
        what: "at next to no loss of quality against them",
        published: "0.005 of PSNR and SSIM",
        expects: "relative loss of at most 0.005, each",
        rule: Rule::Most,
        asks: Asks::Each(variants_quality),
    },
    Check {
        id: "16",
        what: "against the dense model at next to no loss",
        published: "over 40 % less, loss below 0.01",
        expects: "over 40 % less at a relative loss of at most 0.01",
        rule: Rule::Most,
        asks: Asks::Each(dense_quality),
    },
    Check {
        id: "17",
        what: "better than LightGaussian in power and quality",
        published: "figures",
        expects: "each of its models takes more power at less PSNR and SSIM than one of ours",
        rule: Rule::Most,
        asks: Asks::Each(front),
    },
    Check {
        id: "28a",
        what: "rendering power: dense and FR-Display over FR-Render over ours",
        published: "0.71, 0.72, 0.14, 0.11 W",
        expects: "this order",
        rule: Rule::Most,
        asks: Asks::Each(render_order),
    },
    Check {
        id: "28b",
        what: "display power: dense and FR-Render over ours over FR-Display",
        published: "0.27, 0.26, 0.21, 0.20 W",
        expects: "this order",
        rule: Rule::Most,
        asks: Asks::Each(display_order),
    },
];

/// An answer that fails for a known reason where levels fell back.
pub(super) fn about(text: Sentence, holds: bool, models: &[&FovealRecord]) -> Answer {
    Ok(Here { text, holds, why: joined(models.iter().filter_map(|f| fallbacks(f)), "; ") })
}

fn against_dense<'a>(r: &'a Results, variant: &str) -> Result<(&'a FovealRecord, f64), String> {
    let ours = foveated(r, variant)?;
    Ok((ours, saved(ours.total_w(), dense(r)?.total_w())?))
}

fn best_case(r: &Results) -> Answer {
    foveated(r, high(r))?;
    let all = r.variants.iter().filter_map(|v| against_dense(r, &v.name).ok());
    let best = all.reduce(|a, b| if b.1 > a.1 { b } else { a });
    let (ours, share) = best.ok_or("no model of ours reached the target")?;
    about(say("{} ({})", [less(share), ours.label().into()]), share > LARGE, &[ours])
}

fn over_dense(r: &Results) -> Answer {
    let (ours, share) = against_dense(r, high(r))?;
    about(say("{} ({})", [less(share), ours.label().into()]), share >= TENS, &[ours])
}

fn high_against_others(r: &Results) -> Answer {
    let (high, low) = (high(r), low(r));
    let ours = foveated(r, high)?;
    let render = compared(r, Method::FrRender, high)?;
    let display = compared(r, Method::FrDisplay, low)?;
    let light = baseline(r, Baseline::LightGaussian(86), &r.variants[0].name)?;
    let against = |w: f64| saved(ours.total_w(), w);
    let [a, b, c] = [light.total_w(), render.total_w(), display.total_w()].map(against);
    let (a, b, c) = (a?, b?, c?);
    let [own, b_name, c_name] = [ours, render, display].map(|f| f.label().into());
    let text = say(
        "{}: {} than lightgs-86, {} than {}, {} than {}",
        [own, less(a), less(b), b_name, less(c), c_name],
    );
    let holds = a > 0.0 && b > 0.0 && c > a.max(b);
    about(text, holds, &[ours])
}

fn factor(r: &Results) -> Answer {
    let ours = foveated(r, low(r))?;
    let dense = dense(r)?;
    if ours.total_w() <= 0.0 {
        return Err("a model without power".into());
    }
    let factor = dense.total_w() / ours.total_w();
    let speed = r.dense_fps.map_or(Sentence::default(), |fps| {
        let fps = fixed(fps, Unit::FramesPerSecond, 0);
        say("; dense {} FPS on the simulated accelerator", [fps])
    });
    let times = fixed(factor, Unit::One, 2);
    about(say("{} times {}{}", [times, ours.label().into(), speed]), factor > 2.0, &[ours])
}

/// All variants with a model of ours and both comparisons.
fn triples(r: &Results) -> Result<Vec<[&FovealRecord; 3]>, String> {
    let of = |variant: &str| {
        Ok([
            foveated(r, variant)?,
            compared(r, Method::FrRender, variant)?,
            compared(r, Method::FrDisplay, variant)?,
        ])
    };
    let all: Vec<Result<[&FovealRecord; 3], String>> =
        r.variants.iter().map(|v| of(&v.name)).collect();
    let why = all.iter().find_map(|t| t.as_ref().err().cloned());
    let found: Vec<[&FovealRecord; 3]> = all.into_iter().flatten().collect();
    match why {
        Some(why) if found.is_empty() => Err(why),
        _ => Ok(found),
    }
}

fn variants(r: &Results) -> Answer {
    let triples = triples(r)?;
    let mean = |i: usize| -> Result<f64, String> {
        let shares = triples.iter().map(|t| saved(t[0].total_w(), t[i].total_w()));
        Ok(shares.sum::<Result<f64, String>>()? / triples.len() as f64)
    };
    let (render, display) = (mean(1)?, mean(2)?);
    let names: Vec<&str> = triples.iter().map(|t| t[0].variant.as_str()).collect();
    let names = names.join(", ").into();
    let text = say("{} and {} (mean of {})", [less(render), less(display), names]);
    let ours: Vec<&FovealRecord> = triples.iter().map(|t| t[0]).collect();
    about(text, render > 0.0 && display > render, &ours)
}

fn variants_quality(r: &Results) -> Answer {
    let (mut texts, mut why, mut holds) = (Vec::new(), Vec::new(), true);
    for [ours, render, display] in triples(r)? {
        let model = first(r, ours)?;
        for other in [render, display] {
            let theirs = first(r, other)?;
            let loss = losses(r, model, theirs)?;
            let is_small = loss.is_within(LOSS.0);
            holds &= is_small;
            texts.push(losses_text(loss).then(" against ", other.label()));
            let margins = model.margin_db.zip(theirs.margin_db);
            if let Some((a, b)) = margins.filter(|_| !is_small) {
                let [b, a] = [b, a].map(|db| signed(db, Unit::Decibels, 2));
                let values = [other.label().into(), b, a];
                why.push(say("{} ends {} dB from the target, ours {} dB", values));
            }
        }
    }
    let why = joined(why, ", ").map(|why| say("over the gate views {}", [why]));
    Ok(Here { text: joined(texts, "; ").unwrap_or_default(), holds, why })
}

fn dense_quality(r: &Results) -> Answer {
    let (ours, share) = against_dense(r, high(r))?;
    let loss = losses(r, first(r, ours)?, dense(r)?)?;
    let text = say("{} ({}), {}", [less(share), ours.label().into(), losses_text(loss)]);
    about(text, share > OVER_DENSE && loss.is_within(LOSS.1), &[ours])
}

fn front(r: &Results) -> Answer {
    let ours: Vec<(&FovealRecord, &ModelRecord)> = r
        .variants
        .iter()
        .filter_map(|v| foveated(r, &v.name).ok())
        .filter_map(|f| Some((f, first(r, f).ok()?)))
        .collect();
    if ours.is_empty() {
        foveated(r, high(r))?;
    }
    let is_light =
        |m: &&ModelRecord| matches!(m.baseline, Some(Baseline::LightGaussian(_))) && m.level == 1;
    let light: Vec<&ModelRecord> = r.models.iter().filter(is_light).collect();
    if light.is_empty() {
        return Err("no lightgs models (optimize --baselines)".into());
    }
    let beaten = |other: &&&ModelRecord| {
        ours.iter().any(|(f, m)| {
            let better =
                |a: Option<f64>, b: Option<f64>| matches!((a, b), (Some(a), Some(b)) if a >= b);
            f.total_w() < other.total_w()
                && better(m.test.psnr_db, other.test.psnr_db)
                && better(m.test.ssim, other.test.ssim)
        })
    };
    let n = light.iter().filter(beaten).count();
    let cheaper = light.iter().filter(|o| ours.iter().any(|(f, _)| f.total_w() < o.total_w()));
    let counts = [n, light.len(), cheaper.count()].map(count);
    let text = say("{} of {} models beaten in all three, {} in power", counts);
    let left = light.iter().filter(|m| !beaten(m));
    let model = |name: &str, w: f64, m: &ModelRecord| {
        let db = fixed(m.test.psnr_db.unwrap_or(0.0), Unit::Decibels, 2);
        let ssim = fixed(m.test.ssim.unwrap_or(0.0), Unit::One, 4);
        say("{} {} {} dB, SSIM {}", [name.into(), watts(w), db, ssim])
    };
    let not = joined(left.map(|m| model(&m.name, m.total_w(), m)), ", ").unwrap_or_default();
    let own = joined(ours.iter().map(|(f, m)| model(&f.label(), f.total_w(), m)), ", ");
    let why = Some(say("not beaten: {}; ours: {}", [not, own.unwrap_or_default()]));
    Ok(Here { text, holds: n == light.len(), why })
}

/// Dense, FR-Render, FR-Display, ours.
fn four(r: &Results) -> Result<(&ModelRecord, [&FovealRecord; 3]), String> {
    let variant = high(r);
    let fr = |method| compared(r, method, variant);
    Ok((dense(r)?, [fr(Method::FrRender)?, fr(Method::FrDisplay)?, foveated(r, variant)?]))
}

fn render_order(r: &Results) -> Answer {
    let (dense, [render, display, ours]) = four(r)?;
    let all = [dense.render_w, display.render_w, render.render_w, ours.render_w];
    let text = say("{}, {}, {}, {}", all.map(watts));
    let [a, b, c, d] = all;
    let counts = [render, ours].map(|f| count(f.gaussians[0] as usize));
    let more = say("FR-Render has {} Gaussians in level 1, ours has {}", counts);
    let why = joined([render, ours].into_iter().filter_map(fallbacks).chain([more]), "; ");
    Ok(Here { text, holds: a.min(b) > c && c > d, why })
}

fn display_order(r: &Results) -> Answer {
    let (dense, [render, display, ours]) = four(r)?;
    let all = [dense.display_w, render.display_w, ours.display_w, display.display_w];
    let text = say("{}, {}, {}, {}", all.map(watts));
    let [a, b, c, d] = all;
    about(text, a.min(b) > c && c > d, &[ours, display])
}
