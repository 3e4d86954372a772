//! What a finished run leaves: tables, the final model, its trace, charts, a summary.

use serde_json::{Value, json};

use super::super::{Context, Exit, Failure, OrExit, out};
use super::folder::Folder;
use super::foveated;
use super::training::TrainingCost;
use powergs_core::run::System;
use powergs_optimize::campaign::{Campaign, Finished};
use powergs_optimize::outcome::Outcome;
use powergs_optimize::results::FILE;
use powergs_optimize::setup::Seen;
use powergs_report::document::{Block, Document};
use powergs_report::optimize::{Story, charts, document, models_csv, ratios_csv, samples_csv};
use powergs_scene::write_ply;

/// Writes everything that a run found, and says it.
pub fn finish(
    campaign: &Campaign,
    finished: &Finished,
    folder: &Folder,
    trainer: Option<&System>,
    context: &Context,
) -> Result<Exit, Failure> {
    // The report of level 1 is the same with and without levels beyond it.
    let done = &finished.first();
    folder.write("samples.csv", samples_csv(done, &finished.conclusion))?;
    let story = Story::of(campaign, finished, done);
    folder.write("models.csv", models_csv(&story))?;
    if !finished.ratios.is_empty() {
        folder.write("ratios.csv", ratios_csv(&finished.ratios))?;
    }
    if let Some(model) = &finished.model {
        folder.stream("final.ply", |mut w| write_ply(model, &mut w))?;
        folder.stream("final.bin", |w| campaign.write_trace(model, w))?;
    }
    for (name, model) in &finished.others {
        folder.stream(&format!("final-{name}.ply"), |mut w| write_ply(model, &mut w))?;
    }
    let foveated = finished.foveated.as_ref().and_then(|f| f.result.as_ref());
    if let Some((_, model)) = foveated {
        folder.stream("model.fov", |mut w| model.write(&mut w))?;
        folder.stream("fr.bin", |w| campaign.write_foveated_trace(model, w))?;
    }
    folder.write(FILE, finished.results.to_json())?;
    let drawn = charts(&story);
    folder.draw(&drawn, &context.drawing)?;
    let mut page = document(&story, &drawn);
    if let Some(found) = &finished.foveated {
        page.extend(foveated::report(campaign, finished, found, folder, &context.drawing)?);
    }
    let cost = trainer.map(|trainer| TrainingCost::of(trainer, campaign, finished)).transpose()?;
    let cost = cost.flatten();
    if let Some(cost) = &cost {
        page.heading("What the training takes on a device");
        page.paragraph(cost.sentence().replace('\n', " "));
    }
    for file in context.drawing.pages(&page).or_exit(Exit::Internal, "report.html")? {
        folder.write(&file.name, file.bytes)?;
    }
    tell(&story, finished, cost.as_ref(), folder, context)?;
    Ok(if finished.model.is_some() { Exit::Done } else { Exit::GoalMissed })
}

fn tell(
    story: &Story<'_>,
    finished: &Finished,
    cost: Option<&TrainingCost>,
    folder: &Folder,
    context: &Context,
) -> Result<(), Failure> {
    let results = &finished.results;
    if context.global.json {
        let mut object = object(story, finished);
        if let Some(cost) = cost {
            object["training"] = cost.json();
        }
        return out::json(&object);
    }
    if let Some(why) = &results.stopped {
        out::complain(why);
    }
    if context.global.quiet {
        if finished.model.is_none() {
            out::complain(story.headline().trim_end());
        }
        return Ok(());
    }
    let mut page = Document::new();
    if let Some(line) = powergs_report::optimize::foveated::saving(results) {
        page.add(Block::Verbatim(format!("{line}\nwithout foveation:\n")));
    }
    page.add(Block::Verbatim(story.headline()));
    if let Some(table) = story.balance() {
        page.table(table);
    }
    page.table(powergs_report::optimize::foveated::headline(results));
    if let Some(cost) = cost {
        page.add(Block::Verbatim(cost.sentence() + "\n"));
    }
    let at = |name: &str| folder.path().join(name).display().to_string().into();
    let mut files = Vec::new();
    if finished.foveated.as_ref().is_some_and(|f| f.result.is_some()) {
        files.push(("foveated".into(), at("model.fov")));
    }
    if finished.model.is_some() {
        files.push(("model".into(), at("final.ply")));
    }
    for (name, _) in &finished.others {
        files.push((name.clone(), at(&format!("final-{name}.ply"))));
    }
    if finished.model.is_some() {
        files.push(("trace".into(), at("final.bin")));
    }
    files.push(("report".into(), at("summary.md")));
    page.add(Block::Facts(files));
    out::document(&page)
}

/// A number as JSON; what is not finite becomes null.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

fn seen(seen: &Seen) -> Value {
    json!({
        "psnr_db": number(seen.quality.psnr_db),
        "ssim": number(seen.quality.ssim),
        "display_w": number(seen.display_w),
    })
}

fn model(outcome: &Outcome) -> Value {
    let mut value = json!({
        "name": outcome.name,
        "role": outcome.role.kind(),
        "rho": outcome.rho,
        "gaussians": outcome.points,
        "iterations": outcome.iterations,
        "lambda_per_w": outcome.lambda,
        "gains": outcome.gains.map(|gains| gains.0),
        "passed": outcome.passed,
        "gate": seen(&outcome.gate),
        "test": seen(&outcome.test),
        "display_w": outcome.watts.display_w,
        "render_w": outcome.watts.render_w,
        "total_w": outcome.watts.total_w(),
        "flip_test": number(outcome.flip_test),
    });
    if let Some(lpips) = outcome.lpips_test {
        value["lpips_test"] = number(lpips);
    }
    value
}

fn object(story: &Story<'_>, finished: &Finished) -> Value {
    let conclusion = story.conclusion;
    let missed: Vec<Value> = conclusion
        .missed
        .iter()
        .map(|m| {
            json!({
                "name": m.name,
                "rho": m.rho,
                "missed_by_db": number(m.by.psnr_db),
                "missed_by_ssim": number(m.by.ssim),
            })
        })
        .collect();
    let fit = conclusion.fit.as_ref().ok();
    let target = story.target;
    let facts = story.facts();
    json!({
        "reached": finished.result.is_some(),
        "stopped": finished.results.stopped,
        "result": finished.result,
        "best": conclusion.best,
        "target_psnr_db": target.map(|t| number(t.psnr_db)),
        "target_ssim": target.map(|t| number(t.ssim)),
        "dense_w": facts.map(|f| f.dense_w),
        "result_w": facts.map(|f| f.result_w),
        "ours_w": facts.and_then(|f| f.ours_w),
        "saved_frac": facts.map(|f| f.saved),
        "optimum_rho": conclusion.optimum.map(|o| o.rho),
        "chosen_rho": conclusion.rho,
        "predicted_w": facts.and_then(|f| f.predicted_w),
        "realised_w": facts.and_then(|f| f.realised_w),
        "r2_display": fit.and_then(|f| f.display.r2),
        "r2_render": fit.and_then(|f| f.render.r2),
        "mre_display": fit.and_then(|f| f.display.mre),
        "mre_render": fit.and_then(|f| f.render.mre),
        "missed": missed,
        "models": story.done.iter().map(model).collect::<Vec<Value>>(),
        "results": finished.results,
    })
}
