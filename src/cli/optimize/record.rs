//! `run.toml`: everything that the numbers of a run depend on, and nothing else: no time, no place.

use toml::{Table, Value};

use super::super::{Exit, Failure, OrExit};
use super::Args;
use super::inputs::Inputs;
use powergs_base::TOOL_VERSION;
use powergs_core::sim::MODEL_VERSION;
use powergs_frame::fovea::Screen;
use powergs_optimize::plan::Campaign;
use powergs_optimize::schedule::Plan;
use powergs_optimize::setup::{Gate, Settings};
use powergs_optimize::target::TargetRule;

/// The file.
///
/// # Errors
/// Exit code 4: a defect of ours.
pub fn run_toml(
    args: &Args,
    inputs: &Inputs,
    settings: &Settings,
    campaign: &Campaign,
) -> Result<String, Failure> {
    let mut root = Table::new();
    root.insert("tool-version".into(), TOOL_VERSION.into());
    root.insert("model-version".into(), i64::from(MODEL_VERSION).into());
    root.insert("model".into(), model(inputs));
    root.insert("views".into(), views(args, inputs));
    root.insert("power".into(), power(args, inputs));
    root.insert("target".into(), target(campaign, settings));
    root.insert("search".into(), search(campaign, settings));
    if let Some(screen) = &inputs.screen {
        root.insert("foveation".into(), foveation(screen, args, settings, campaign.levels));
    }
    if let Some((lpips, hash)) = &inputs.lpips {
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

fn names(inputs: &Inputs, views: &[usize]) -> Value {
    views.iter().map(|&v| inputs.cameras[v].name.clone()).collect::<Vec<_>>().into()
}

fn model(inputs: &Inputs) -> Value {
    let others: Vec<String> = inputs.externals.iter().map(|e| e.0.clone()).collect();
    table([
        ("name", inputs.name.clone().into()),
        ("gaussians", count(inputs.dense.len())),
        ("sh-degree", i64::from(inputs.dense.sh_degree).into()),
        ("compared-with", others.into()),
    ])
}

fn views(args: &Args, inputs: &Inputs) -> Value {
    let camera = &inputs.cameras[0];
    let background = args.views.background.0.map(|v| Value::Float(f64::from(v)));
    table([
        ("reference", if inputs.is_self { "self" } else { "images" }.into()),
        ("width-px", i64::from(camera.width).into()),
        ("height-px", i64::from(camera.height).into()),
        ("background", Value::Array(background.to_vec())),
        ("train", names(inputs, &inputs.split.train)),
        ("validation", names(inputs, &inputs.split.validation)),
        ("test", names(inputs, &inputs.split.test)),
        ("power-views", count(inputs.power_views.len())),
    ])
}

fn power(args: &Args, inputs: &Inputs) -> Value {
    table([
        ("oracle", inputs.oracle.name().into()),
        ("display", inputs.display.name.clone().into()),
        ("display-scale", inputs.display.scale.into()),
        ("display-fps", args.power.fps.into()),
    ])
}

fn target(campaign: &Campaign, settings: &Settings) -> Value {
    let gate = match settings.gate {
        Gate::Validation => "validation",
        Gate::Test => "test",
    };
    let mut rows = Table::new();
    let names: Vec<String> = campaign.variants.iter().map(|v| v.name.clone()).collect();
    rows.insert("variants".into(), names.into());
    match campaign.variants[0].rule {
        TargetRule::Share(share) => {
            rows.insert("share-of-dense".into(), share.into());
        }
        TargetRule::Absolute(quality) => {
            rows.insert("psnr-db".into(), quality.psnr_db.into());
            rows.insert("ssim".into(), quality.ssim.into());
        }
    }
    rows.insert("gate".into(), gate.into());
    rows.insert("epsilon-db".into(), settings.epsilon_db.into());
    Value::Table(rows)
}

fn foveation(screen: &Screen, args: &Args, settings: &Settings, levels: u8) -> Value {
    table([
        ("screen-deg", screen.fov_deg.into()),
        ("pooling-rate", screen.pooling_rate.into()),
        ("levels", i64::from(levels).into()),
        ("level-effort", settings.level_effort.into()),
        ("level-lambda", settings.level_display_weight.into()),
        ("filter-flops", args.fovea.filter_flops.into()),
    ])
}

fn search(campaign: &Campaign, settings: &Settings) -> Value {
    let schedule: Value = match &campaign.schedule {
        Plan::Adaptive { count, highest } => {
            format!("{count} samples up to {highest}, moved below the first that misses").into()
        }
        Plan::Listed(rhos) => rhos.clone().into(),
        Plan::Published { .. } => "published: 7 coarse and 5 fine samples".into(),
    };
    let baselines: Vec<String> = campaign.baselines.iter().map(|b| b.name()).collect();
    table([
        ("schedule", schedule),
        ("iterations", i64::from(settings.iterations).into()),
        ("first-effort", settings.first_effort.into()),
        ("final-iterations", i64::from(settings.final_iterations).into()),
        ("interval", i64::from(settings.interval).into()),
        ("adjust-share", settings.adjust_share.into()),
        ("lambda", settings.display_weight.into()),
        ("rule", format!("{:?}", settings.rule).to_lowercase().into()),
        ("opacity-cap", f64::from(settings.opacity_cap).into()),
        ("rate-scale", settings.rate_scale.into()),
        ("rate-end", settings.rate_end.into()),
        ("seed", (settings.seed as i64).into()),
        ("baselines", baselines.into()),
        ("lambda-sweep", campaign.sweep.clone().into()),
    ])
}
