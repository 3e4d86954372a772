//! What a finished co-design leaves: tables, the joint pair, charts, pages.

use serde_json::{Map, Value, json};
use toml::Table;
use xxhash_rust::xxh3::xxh3_128;

use super::super::{Context, Exit, Failure, OrExit, out};
use super::folder::Folder;
use super::inputs::Space;
use powergs_codesign::compare::{Comparison, Way};
use powergs_codesign::export::{Exported, smallest};
use powergs_codesign::pricing::{MachinePoint, Price};
use powergs_codesign::{Codesign, Finished};
use powergs_core::sim::made_by;
use powergs_report::codesign::{
    charts, document, found_machines, headline, models_csv, pairs_csv, ways,
};
use powergs_report::document::{Block, Document};
use powergs_report::format::wrapped;
use powergs_scene::export::Target;
use powergs_scene::write_ply;

/// `run.toml`: what the run is made from; no time, no place.
///
/// # Errors
/// Exit code 4: a defect of ours.
pub fn run_toml(codesign: &Codesign, space: &Space) -> Result<String, Failure> {
    let campaign = &codesign.campaign;
    let camera = &campaign.cameras[0];
    let mut root = Table::new();
    made_by(&mut root);
    let mut set = |key: &str, value: toml::Value| {
        root.insert(key.to_owned(), value);
    };
    let count = |n: usize| toml::Value::Integer(i64::try_from(n).unwrap_or(i64::MAX));
    set("model", campaign.name.clone().into());
    set("gaussians", count(campaign.dense.len()));
    set("views", count(campaign.given.count));
    set("width-px", i64::from(camera.width).into());
    set("height-px", i64::from(camera.height).into());
    set("models", count(codesign.models.len()));
    set("iterations", i64::from(codesign.iterations).into());
    set("halving", codesign.halving.into());
    set("seed", (campaign.settings.seed as i64).into());
    set("inputs-xxh3", format!("{:032x}", campaign.inputs()).into());
    set("base", codesign.machines.base.label().into());
    set("display-fps", codesign.machines.fps().into());
    set("space-xxh3", format!("{:032x}", xxh3_128(space.text.as_bytes())).into());
    let head = "# What this run is made from. The command that was typed: invocation.toml.\n";
    let text = toml::to_string_pretty(&root).or_exit(Exit::Internal, "run.toml")?;
    Ok(format!("{head}{text}"))
}

/// Writes everything that a run found, and says it.
///
/// # Errors
/// Exit code 2: the folder cannot be written.
pub fn finish(
    codesign: &Codesign,
    finished: &Finished,
    folder: &Folder,
    context: &Context,
) -> Result<Exit, Failure> {
    folder.write("pairs.csv", pairs_csv(finished))?;
    folder.write("models.csv", models_csv(finished))?;
    let joint = finished.of(Way::Joint).and_then(|c| c.found.as_ref().ok());
    let mut picture = None;
    if let Some(found) = joint {
        let model = &finished.models[found.pair.0];
        let scene = codesign.scene(folder.store(), model)?;
        folder.stream("joint.ply", |mut w| write_ply(&scene, &mut w))?;
        // The folder may have that of another space.
        let best = smallest(&finished.exports).map(|export| export.target);
        for export in &finished.exports {
            let name = format!("joint.{}", ending(export.target));
            match &export.file {
                Ok(file) if Some(export.target) == best => folder.write(&name, file)?,
                Ok(_) | Err(_) => folder.remove(&name)?,
            }
        }
        folder.stream("joint.bin", |w| codesign.campaign.write_trace(&scene, w))?;
        folder.write("joint.toml", codesign.machine_toml(&model.point, found.pair.1)?)?;
        picture = Some(codesign.picture(folder.store(), model)?);
    }
    let drawn = charts(finished, picture.as_ref());
    folder.draw(&drawn, &context.drawing)?;
    let page = document(finished, &drawn);
    for file in context.drawing.pages(&page).or_exit(Exit::Internal, "report.html")? {
        folder.write(&file.name, file.bytes)?;
    }
    tell(finished, folder, context)?;
    Ok(Exit::Done)
}

/// What the name of a file in this format ends with.
fn ending(target: Target) -> &'static str {
    match target {
        Target::CompressedPly => "compressed.ply",
        Target::GlbSpz => "glb",
        other => other.name(),
    }
}

fn tell(finished: &Finished, folder: &Folder, context: &Context) -> Result<(), Failure> {
    if context.global.json {
        return out::json(&object(finished));
    }
    if context.global.quiet {
        return Ok(());
    }
    let mut page = Document::new();
    page.add(Block::Verbatim(wrapped(&headline(finished), 80) + "\n"));
    page.table(ways(finished));
    page.table(found_machines(finished));
    let at = |name: &str| folder.path().join(name).display().to_string().into();
    let compressed = smallest(&finished.exports).map(|e| format!("joint.{}", ending(e.target)));
    let compressed = compressed.map(|name| ("compressed".into(), at(&name)));
    page.add(Block::Facts(
        std::iter::once(("model".into(), at("joint.ply")))
            .chain(compressed)
            .chain([("machine".into(), at("joint.toml")), ("report".into(), at("summary.md"))])
            .collect(),
    ));
    out::document(&page)
}

fn price(price: &Price) -> Value {
    let [preprocessing, sorting, rendering, standby] = price.stages_w;
    json!({
        "total_w": price.total_w,
        "display_w": price.display_w,
        "preprocessing_w": preprocessing,
        "sorting_w": sorting,
        "rendering_w": rendering,
        "standby_w": standby,
        "area_mm2": price.area_mm2,
        "frame_time_ms_max": price.frame_ms,
        "dram_bytes": price.dram_bytes,
    })
}

/// What a machine has on the axes, by their keys.
fn settings(finished: &Finished, point: MachinePoint) -> Map<String, Value> {
    let row = finished.rows.iter().find(|row| row.settings.contains_key(&point));
    let Some(row) = row else { return Map::new() };
    let values = &row.settings[&point];
    row.axes().into_iter().map(|(i, key)| (key.to_owned(), json!(values[i]))).collect()
}

fn object(finished: &Finished) -> Value {
    let way = |comparison: &Comparison| {
        let found = comparison.found.as_ref().ok().map(|found| {
            json!({
                "model": finished.models[found.pair.0].point.name(),
                "machine": found.pair.1,
                "settings": settings(finished, found.pair.1),
                "confirmed": price(&found.confirmed),
                "calibrated": price(&found.calibrated),
            })
        });
        json!({
            "way": comparison.way.letter().to_string(),
            "words": comparison.way.words(),
            "found": found,
        })
    };
    let alternative = |a: &powergs_codesign::stability::Alternative| {
        json!({
            "energy_table": a.table,
            "views": a.views,
            "watts": a.watts,
            "gain_w": a.gain_w(),
            "regret_w": a.regret_w,
        })
    };
    let exported = |e: &Exported| {
        json!({
            "format": e.target.name(),
            "bytes": e.bytes(),
            "gate_psnr_db": e.gate.map(|gate| gate.quality.psnr_db),
            "passed": e.passed,
        })
    };
    json!({
        "exports": finished.exports.iter().map(exported).collect::<Vec<_>>(),
        "left": finished.left.iter().map(|(point, _)| point.name()).collect::<Vec<_>>(),
        "scene": finished.about.scene,
        "budget": {
            "area_mm2": finished.budget.area_mm2,
            "frame_time_ms": finished.budget.frame_ms,
        },
        "ways": finished.comparisons.iter().map(way).collect::<Vec<_>>(),
        "gain_w": finished.gain_w(),
        "alternatives": finished.alternatives.iter().map(alternative).collect::<Vec<_>>(),
        "front": finished.front.len(),
    })
}
