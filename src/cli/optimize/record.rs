//! `run.toml`: everything that the numbers of a run depend on, and nothing else: no time, no place.

use toml::{Table, Value};

use super::super::{Exit, Failure, OrExit};
use powergs_core::sim::made_by;
use powergs_frame::fovea::ScreenWidth;
use powergs_optimize::campaign::Campaign;
use powergs_optimize::request::Foveation;
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::{self, Mark, SETTINGS};
use powergs_optimize::target::TargetRule;

/// The file.
///
/// # Errors
/// Exit code 4: a defect of ours.
pub fn run_toml(campaign: &Campaign) -> Result<String, Failure> {
    let mut root = Table::new();
    made_by(&mut root);
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
        ("judged-width-px", i64::from(campaign.judged.judged[0]).into()),
        ("judged-height-px", i64::from(campaign.judged.judged[1]).into()),
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
        ("standby", campaign.counted.has_standby.into()),
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
    rows.extend(settings("Views", campaign));
    rows.extend(settings("Quality", campaign));
    Value::Table(rows)
}

fn foveation(foveation: &Foveation, campaign: &Campaign) -> Value {
    let mut rows = Table::new();
    let width = match foveation.screens.width {
        ScreenWidth::OfCamera => "camera".into(),
        ScreenWidth::Degrees(degrees) => degrees.into(),
    };
    rows.insert("screen-deg".into(), width);
    rows.insert("pooling-rate".into(), foveation.screens.pooling_rate.into());
    rows.insert("levels".into(), i64::from(campaign.plan.levels).into());
    rows.extend(settings("Foveation", campaign));
    rows.insert("filter-flops".into(), foveation.filter.flops.into());
    Value::Table(rows)
}

fn search(campaign: &Campaign) -> Value {
    let plan = &campaign.plan;
    let schedule: Value = match &plan.schedule {
        Schedule::Adaptive { count, first } => {
            let first = first.map_or_else(String::new, |first| format!(", {first}"));
            format!("{count} samples: both ends{first}, then around the minimum").into()
        }
        Schedule::Listed(rhos) => rhos.clone().into(),
        Schedule::Published { .. } => "published: 7 coarse and 5 fine samples".into(),
    };
    let baselines: Vec<String> = plan.baselines.iter().map(|b| b.name()).collect();
    let mut rows = Table::new();
    rows.insert("schedule".into(), schedule);
    rows.extend(settings("Search", campaign));
    rows.insert("baselines".into(), baselines.into());
    rows.insert("lambda-sweep".into(), plan.sweep_weights.clone().into());
    Value::Table(rows)
}

/// The settings of a part that numbers depend on.
fn settings(part: &str, campaign: &Campaign) -> impl Iterator<Item = (String, Value)> {
    let own =
        SETTINGS.iter().filter(move |setting| setting.part == part && !setting.is(Mark::Harmless));
    own.map(|setting| {
        let value = match setting.of(&campaign.settings) {
            settings::Value::Count(n) => Value::Integer(n as i64),
            settings::Value::Real(x) => Value::Float(x),
            settings::Value::Name(name) => Value::String(name.to_owned()),
        };
        (setting.flag.to_owned(), value)
    })
}
