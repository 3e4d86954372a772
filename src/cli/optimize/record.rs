//! `run.toml`: everything that the numbers of a run depend on, and nothing else: no time, no place.

use toml::{Table, Value};

use super::super::{Exit, Failure, OrExit};
use powergs_base::TOOL_VERSION;
use powergs_core::sim::MODEL_VERSION;
use powergs_optimize::campaign::Campaign;
use powergs_optimize::lambda::Rule;
use powergs_optimize::request::Foveation;
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::{Dimming, Gate};
use powergs_optimize::target::TargetRule;

/// The file.
///
/// # Errors
/// Exit code 4: a defect of ours.
pub fn run_toml(campaign: &Campaign) -> Result<String, Failure> {
    let mut root = Table::new();
    root.insert("tool-version".into(), TOOL_VERSION.into());
    root.insert("model-version".into(), i64::from(MODEL_VERSION).into());
    root.insert("model".into(), model(campaign));
    root.insert("views".into(), views(campaign));
    root.insert("power".into(), power(campaign));
    root.insert("target".into(), target(campaign));
    root.insert("search".into(), search(campaign));
    if let Some(fovea) = &campaign.foveation {
        root.insert("foveation".into(), foveation(fovea, campaign));
    }
    if let Some((lpips, hash)) = &campaign.lpips {
        let hash = format!("{hash:032x}").into();
        let rows = [("network", lpips.network().into()), ("weights-xxh3", hash)];
        root.insert("lpips".into(), table(rows));
    }
    let head = "# What this run is made from. The command that was typed: invocation.toml.\n";
    let text = toml::to_string_pretty(&root).or_exit(Exit::Internal, "run.toml")?;
    Ok(format!("{head}{text}"))
}

fn table<const N: usize>(rows: [(&str, Value); N]) -> Value {
    Value::Table(rows.into_iter().map(|(k, v)| (k.to_owned(), v)).collect())
}

fn count(n: usize) -> Value {
    Value::Integer(i64::try_from(n).unwrap_or(i64::MAX))
}

fn names(campaign: &Campaign, views: &[usize]) -> Value {
    views.iter().map(|&v| campaign.cameras[v].name.clone()).collect::<Vec<_>>().into()
}

fn model(campaign: &Campaign) -> Value {
    let others: Vec<String> = campaign.externals.iter().map(|e| e.0.clone()).collect();
    table([
        ("name", campaign.name.clone().into()),
        ("gaussians", count(campaign.dense.len())),
        ("sh-degree", i64::from(campaign.dense.sh_degree).into()),
        ("compared-with", others.into()),
    ])
}

fn views(campaign: &Campaign) -> Value {
    let camera = &campaign.cameras[0];
    let background = campaign.background.map(|v| Value::Float(f64::from(v)));
    table([
        ("reference", if campaign.references.is_own() { "self" } else { "images" }.into()),
        ("width-px", i64::from(camera.width).into()),
        ("height-px", i64::from(camera.height).into()),
        ("background", Value::Array(background.to_vec())),
        ("train", names(campaign, &campaign.split.train)),
        ("validation", names(campaign, &campaign.split.validation)),
        ("test", names(campaign, &campaign.split.test)),
        ("made-to-validate", count(campaign.split.made)),
    ])
}

fn power(campaign: &Campaign) -> Value {
    table([
        ("oracle", campaign.oracle.name().into()),
        ("display", campaign.display.name.clone().into()),
        ("display-scale", campaign.display.scale.into()),
        ("display-fps", campaign.oracle.fps().into()),
        ("views", count(campaign.priced.views)),
        ("views-of", count(campaign.priced.of)),
        ("width-px", i64::from(campaign.priced.size[0]).into()),
        ("height-px", i64::from(campaign.priced.size[1]).into()),
    ])
}

fn target(campaign: &Campaign) -> Value {
    let gate = match campaign.settings.gate {
        Gate::Validation => "validation",
        Gate::Test => "test",
    };
    let mut rows = Table::new();
    let names: Vec<String> = campaign.plan.variants.iter().map(|v| v.name.clone()).collect();
    rows.insert("variants".into(), names.into());
    match campaign.plan.variants[0].rule {
        TargetRule::Share(share) => {
            rows.insert("share-of-dense".into(), share.into());
        }
        TargetRule::Absolute(quality) => {
            rows.insert("psnr-db".into(), quality.psnr_db.into());
            rows.insert("ssim".into(), quality.ssim.into());
        }
    }
    rows.insert("gate".into(), gate.into());
    rows.insert("epsilon-db".into(), campaign.settings.epsilon_db.into());
    Value::Table(rows)
}

fn foveation(foveation: &Foveation, campaign: &Campaign) -> Value {
    let (screen, settings) = (foveation.screen, &campaign.settings);
    table([
        ("screen-deg", screen.fov_deg.into()),
        ("pooling-rate", screen.pooling_rate.into()),
        ("levels", i64::from(campaign.plan.levels).into()),
        ("level-effort", settings.level_effort.into()),
        ("level-lambda", settings.level_display_weight.into()),
        ("filter-flops", foveation.filter.flops.into()),
    ])
}

fn search(campaign: &Campaign) -> Value {
    let (plan, settings) = (&campaign.plan, &campaign.settings);
    let schedule: Value = match &plan.schedule {
        Schedule::Adaptive { count, first } => {
            let first = first.map_or_else(String::new, |first| format!(", {first}"));
            format!("{count} samples: both ends{first}, then around the minimum").into()
        }
        Schedule::Listed(rhos) => rhos.clone().into(),
        Schedule::Published { .. } => "published: 7 coarse and 5 fine samples".into(),
    };
    let dimming = match settings.dimming {
        Dimming::Gains => "gains",
        Dimming::Term(Rule::Damped) => "damped",
        Dimming::Term(Rule::Published) => "published",
    };
    let baselines: Vec<String> = plan.baselines.iter().map(|b| b.name()).collect();
    table([
        ("schedule", schedule),
        ("iterations", i64::from(settings.iterations).into()),
        ("first-effort", settings.first_effort.into()),
        ("held-out-iterations", i64::from(settings.held_out_iterations).into()),
        ("final-iterations", i64::from(settings.final_iterations).into()),
        ("interval", i64::from(settings.interval).into()),
        ("adjust-share", settings.adjust_share.into()),
        ("lambda", settings.display_weight.into()),
        ("dimming", dimming.into()),
        ("opacity-cap", f64::from(settings.opacity_cap).into()),
        ("rate-scale", settings.rate_scale.into()),
        ("rate-end", settings.rate_end.into()),
        ("seed", (settings.seed as i64).into()),
        ("baselines", baselines.into()),
        ("lambda-sweep", plan.sweep_weights.clone().into()),
    ])
}
