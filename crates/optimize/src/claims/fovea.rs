//! Claims about the total power of foveated models, against dense models and the methods that
//! optimise one thing.

use super::facts::{
    baseline, compared, dense, fallbacks, first, foveated, high, less, losses, losses_text, low,
    saved, watts,
};
use super::{Answer, Asks, Check, Here, Rule};
use crate::foveated::Method;
use crate::results::{FovealRecord, ModelRecord, Results};
use crate::role::Baseline;

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
        rule: Rule::All,
        asks: Asks::Each(over_dense),
    },
    Check {
        id: "11",
        what: "PowerGS-H against LightGS-L, FR-Render-H, FR-Display-L",
        published: "16.8, 12.3, 50.6 % less",
        expects: "less than all; most against FR-Display",
        rule: Rule::All,
        asks: Asks::Each(high_against_others),
    },
    Check {
        id: "12",
        what: "the dense model takes a multiple of PowerGS-L",
        published: "2.7 times; 5 FPS on a mobile GPU",
        expects: "more than twice",
        rule: Rule::All,
        asks: Asks::Each(factor),
    },
    Check {
        id: "15a",
        what: "the variants against FR-Render and FR-Display",
        published: "13.1 and 52.5 % less",
        expects: "less than both; more is saved over FR-Display",
        rule: Rule::All,
        asks: Asks::Each(variants),
    },
    Check {
        id: "15b",
        what: "at next to no loss of quality against them",
        published: "0.005 of PSNR and SSIM",
        expects: "relative loss of at most 0.005, each",
        rule: Rule::All,
        asks: Asks::Each(variants_quality),
    },
    Check {
        id: "16",
        what: "against the dense model at next to no loss",
        published: "over 40 % less, loss below 0.01",
        expects: "over 40 % less at a relative loss of at most 0.01",
        rule: Rule::All,
        asks: Asks::Each(dense_quality),
    },
    Check {
        id: "17",
        what: "better than LightGaussian in power and quality",
        published: "figures",
        expects: "each of its models takes more power at less PSNR and SSIM than one of ours",
        rule: Rule::All,
        asks: Asks::Each(front),
    },
    Check {
        id: "28a",
        what: "rendering power: dense and FR-Display over FR-Render over ours",
        published: "0.71, 0.72, 0.14, 0.11 W",
        expects: "this order",
        rule: Rule::All,
        asks: Asks::Each(render_order),
    },
    Check {
        id: "28b",
        what: "display power: dense and FR-Render over ours over FR-Display",
        published: "0.27, 0.26, 0.21, 0.20 W",
        expects: "this order",
        rule: Rule::All,
        asks: Asks::Each(display_order),
    },
];

/// An answer that fails for a known reason where levels fell back.
pub(super) fn about(text: String, holds: bool, models: &[&FovealRecord]) -> Answer {
    let why: Vec<String> = models.iter().filter_map(|f| fallbacks(f)).collect();
    Ok(Here { text, holds, why: (!why.is_empty()).then(|| why.join("; ")) })
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
    about(format!("{} ({})", less(share), ours.label()), share > LARGE, &[ours])
}

fn over_dense(r: &Results) -> Answer {
    let (ours, share) = against_dense(r, high(r))?;
    about(format!("{} ({})", less(share), ours.label()), share >= TENS, &[ours])
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
    let text = format!(
        "{}: {} than lightgs-86, {} than {}, {} than {}",
        ours.label(),
        less(a),
        less(b),
        render.label(),
        less(c),
        display.label()
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
    let speed = r
        .dense_fps
        .map_or(String::new(), |fps| format!("; dense {fps:.0} FPS on the simulated accelerator"));
    about(format!("{factor:.2} times {}{speed}", ours.label()), factor > 2.0, &[ours])
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
    let text = format!("{} and {} (mean of {})", less(render), less(display), names.join(", "));
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
            let is_small = loss.0.is_none_or(|l| l <= LOSS.0) && loss.1 <= LOSS.0;
            holds &= is_small;
            texts.push(format!("{} against {}", losses_text(loss), other.label()));
            let margins = model.margin_db.zip(theirs.margin_db);
            if let Some((a, b)) = margins.filter(|_| !is_small) {
                let name = other.label();
                why.push(format!("{name} ends {b:+.2} dB from the target, ours {a:+.2} dB"));
            }
        }
    }
    let why = (!why.is_empty()).then(|| format!("over the gate views {}", why.join(", ")));
    Ok(Here { text: texts.join("; "), holds, why })
}

fn dense_quality(r: &Results) -> Answer {
    let (ours, share) = against_dense(r, high(r))?;
    let loss = losses(r, first(r, ours)?, dense(r)?)?;
    let text = format!("{} ({}), {}", less(share), ours.label(), losses_text(loss));
    let kept = loss.0.is_none_or(|l| l <= LOSS.1) && loss.1 <= LOSS.1;
    about(text, share > OVER_DENSE && kept, &[ours])
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
    let text =
        format!("{n} of {} models beaten in all three, {} in power", light.len(), cheaper.count());
    let left = light.iter().filter(|m| !beaten(m));
    let quality = |m: &ModelRecord| {
        let (db, ssim) = (m.test.psnr_db.unwrap_or(0.0), m.test.ssim.unwrap_or(0.0));
        format!("{db:.2} dB, SSIM {ssim:.4}")
    };
    let not = left.map(|m| format!("{} {} {}", m.name, watts(m.total_w()), quality(m)));
    let own =
        ours.iter().map(|(f, m)| format!("{} {} {}", f.label(), watts(f.total_w()), quality(m)));
    let (not, own): (Vec<String>, Vec<String>) = (not.collect(), own.collect());
    let why = Some(format!("not beaten: {}; ours: {}", not.join(", "), own.join(", ")));
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
    let text = all.map(watts).join(", ");
    let [a, b, c, d] = all;
    let (n, m) = (render.gaussians[0], ours.gaussians[0]);
    let more = format!("FR-Render has {n} Gaussians in level 1, ours has {m}");
    let why: Vec<String> = [render, ours].into_iter().filter_map(fallbacks).chain([more]).collect();
    Ok(Here { text, holds: a.min(b) > c && c > d, why: Some(why.join("; ")) })
}

fn display_order(r: &Results) -> Answer {
    let (dense, [render, display, ours]) = four(r)?;
    let all = [dense.display_w, render.display_w, ours.display_w, display.display_w];
    let text = all.map(watts).join(", ");
    let [a, b, c, d] = all;
    about(text, a.min(b) > c && c > d, &[ours, display])
}
