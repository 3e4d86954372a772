//! From flags to settings, with every number checked.

use super::super::{Exit, Failure};
use super::{Args, GateArg, LevelArg, RuleArg, ScheduleArg, StudyArg};
use powergs_optimize::lambda::{CEILING, Rule};
use powergs_optimize::plan::{Baseline, Campaign, Variant};
use powergs_optimize::schedule::Plan;
use powergs_optimize::setup::{Gate, Settings};
use powergs_optimize::target::{Level, Quality, TargetRule};

/// Most iterations of one fine-tune.
const MOST_ITERATIONS: u32 = 10_000_000;
/// Samples of the default schedule, and the highest ratio.
const FIVE: (usize, f64) = (5, 0.8);
/// The λ of the sweep, over the dense model's display power.
const SWEEP: [f64; 8] = [0.0, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.3];

fn usage(what: impl Into<String>) -> Failure {
    Failure::new(Exit::Usage, what.into())
}

/// The settings of `args`.
pub fn settings(args: &Args) -> Result<Settings, Failure> {
    let s = &args.search;
    let final_iterations = s.final_iterations.unwrap_or(s.iterations.saturating_mul(2));
    for (flag, n) in [
        ("--iterations", s.iterations),
        ("--final-iterations", final_iterations),
        ("--interval", s.interval),
        ("--checkpoint-every", s.checkpoint_every),
    ] {
        if !(1..=MOST_ITERATIONS).contains(&n) {
            return Err(usage(format!("{flag} {n}: must be 1 to {MOST_ITERATIONS}")));
        }
    }
    for (flag, value, low, high) in [
        ("--first-effort", s.first_effort, 0.1, 100.0),
        ("--adjust-share", s.adjust_share, 0.01, 1.0),
        ("--lambda", s.lambda, 1e-6, CEILING),
        ("--rate-scale", s.rate_scale, 1e-6, 1e3),
        ("--rate-end", s.rate_end, 0.0, 1.0),
        ("--opacity-cap", f64::from(s.opacity_cap), 0.01, 1.0),
        ("--epsilon-db", args.quality.epsilon_db, 0.0, 100.0),
        ("--level-effort", args.fovea.level_effort, 0.01, 100.0),
        ("--level-lambda", args.fovea.level_lambda, 1e-6, CEILING),
        ("--filter-flops", args.fovea.filter_flops, 0.0, 1e6),
    ] {
        if !(low..=high).contains(&value) {
            return Err(usage(format!("{flag} {value}: must be {low} to {high}")));
        }
    }
    Ok(Settings {
        iterations: s.iterations,
        first_effort: s.first_effort,
        final_iterations,
        interval: s.interval,
        adjust_share: s.adjust_share,
        display_weight: s.lambda,
        level_effort: args.fovea.level_effort,
        level_display_weight: args.fovea.level_lambda,
        rule: match s.rule {
            RuleArg::Damped => Rule::Damped,
            RuleArg::Published => Rule::Published,
        },
        epsilon_db: args.quality.epsilon_db,
        opacity_cap: s.opacity_cap,
        rate_scale: s.rate_scale,
        rate_end: s.rate_end,
        seed: s.seed,
        gate: match args.views.gate {
            GateArg::Validation => Gate::Validation,
            GateArg::Test => Gate::Test,
        },
    })
}

/// What `args` ask for. `is_self`: the references are the dense model's own renders.
/// `levels`: those that the views show.
pub fn campaign(args: &Args, is_self: bool, levels: u8) -> Result<Campaign, Failure> {
    let mut baselines = Vec::new();
    if args.compare.baselines {
        baselines.extend(Baseline::ALL);
    }
    let has_variants = !args.fovea.variants.is_empty();
    let ratio = args.compare.study.contains(&StudyArg::Ratio);
    // The study compares with these two, and so do variants.
    for needed in [Baseline::DisplayOnly, Baseline::RenderOnly] {
        if (ratio || has_variants) && !baselines.contains(&needed) {
            baselines.push(needed);
        }
    }
    let externals: Vec<String> = args.compare.others.iter().map(|(n, _)| n.clone()).collect();
    for (i, name) in externals.iter().enumerate() {
        let taken = |b: &Baseline| b.name() == *name;
        let ours = ["dense", "final", "held-out"].contains(&name.as_str())
            || name.starts_with("sample-")
            || name.starts_with("lambda-")
            || Baseline::ALL.iter().any(taken);
        if ours || externals[..i].contains(name) {
            return Err(usage(format!("--baseline {name}=…: the name is taken; use another")));
        }
    }
    let sweep =
        if args.compare.study.contains(&StudyArg::Lambda) { SWEEP.to_vec() } else { vec![] };
    let (schedule, variants) = (schedule(args)?, variants(args, is_self)?);
    for variant in variants.iter().skip(1) {
        if externals.iter().any(|name| name.starts_with(&format!("{}-", variant.name))) {
            let what = format!(
                "--baseline {0}-…: names that begin so belong to variant {0}",
                variant.name
            );
            return Err(usage(what));
        }
    }
    // Its own renders it has never been trained on, and a given number is no share.
    let is_share = matches!(variants[0].rule, TargetRule::Share(_));
    let is_gated = args.views.gate == GateArg::Validation;
    let holds_out = is_share && is_gated && !args.views.train_on_validation;
    Ok(Campaign { schedule, baselines, externals, sweep, variants, holds_out, levels })
}

fn schedule(args: &Args) -> Result<Plan, Failure> {
    let rhos = &args.search.rhos;
    if rhos.is_empty() {
        return Ok(match args.search.schedule {
            ScheduleArg::Five => Plan::Adaptive { count: FIVE.0, highest: FIVE.1 },
            ScheduleArg::Published => Plan::PUBLISHED,
        });
    }
    let ascending = rhos.windows(2).all(|w| w[0] < w[1]);
    if !ascending || rhos.iter().any(|r| !(0.0..1.0).contains(r)) || rhos.len() > 1000 {
        let what = "--rhos: at most 1000 ratios, ascending, from 0 to below 1: 0,0.2,0.4";
        return Err(usage(what));
    }
    Ok(Plan::Listed(rhos.clone()))
}

fn rule(args: &Args, is_self: bool) -> Result<TargetRule, Failure> {
    let q = &args.quality;
    if let Some(share) = q.quality {
        if is_self {
            return Err(usage(
                "--quality: against its own renders the dense model is perfect, so a share of its \
                 PSNR says nothing; give --quality-db, or --level H, M or L",
            ));
        }
        if !(0.01..=1.5).contains(&share) {
            return Err(usage(format!("--quality {share}: a share, such as 0.99")));
        }
        return Ok(TargetRule::Share(share));
    }
    if let Some(psnr_db) = q.quality_db {
        let ssim = q.quality_ssim.unwrap_or(0.0);
        if !(1.0..=120.0).contains(&psnr_db) || !(0.0..=1.0).contains(&ssim) {
            let what = "--quality-db must be 1 to 120 dB, --quality-ssim 0 to 1";
            return Err(usage(what));
        }
        return Ok(TargetRule::Absolute(Quality::likeness(psnr_db, ssim)));
    }
    let fallback = if is_self { LevelArg::M } else { LevelArg::H };
    Ok(rule_of(level(q.level.unwrap_or(fallback)), is_self))
}

fn level(arg: LevelArg) -> Level {
    match arg {
        LevelArg::H => Level::High,
        LevelArg::M => Level::Medium,
        LevelArg::L => Level::Low,
    }
}

fn rule_of(level: Level, is_self: bool) -> TargetRule {
    if is_self { TargetRule::Absolute(level.absolute()) } else { TargetRule::Share(level.share()) }
}

/// The quality of the run, under its name if it is a named one, and further ones.
fn variants(args: &Args, is_self: bool) -> Result<Vec<Variant>, Failure> {
    let rule = rule(args, is_self)?;
    let known = Level::ALL.into_iter().find(|l| rule_of(*l, is_self) == rule);
    let name = known.map_or("own", Level::name).to_owned();
    let mut variants = vec![Variant { name, rule }];
    for level in args.fovea.variants.iter().map(|l| level(*l)) {
        if variants.iter().all(|v| v.name != level.name()) {
            let rule = rule_of(level, is_self);
            variants.push(Variant { name: level.name().to_owned(), rule });
        }
    }
    Ok(variants)
}
