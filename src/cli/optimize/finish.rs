//! What a finished run leaves: tables, the final model, its trace, charts, a summary.

use std::io;

use serde_json::{Value, json};

use super::super::{Context, Exit, Failure, OrExit, out};
use super::folder::Folder;
use super::foveated;
use super::inputs::Inputs;
use powergs_chart::Chart;
use powergs_frame::trace::{EncodedFrame, TraceHeader, Writer};
use powergs_optimize::checkpoint::Progress;
use powergs_optimize::claims::{self, Run};
use powergs_optimize::plan::{Campaign, Outcome, Place, at};
use powergs_optimize::results::{ChangeRecord, FILE, Results, Sources};
use powergs_optimize::setup::{Seen, Setup};
use powergs_optimize::study::ratios;
use powergs_optimize::tune::Model;
use powergs_raster::{Detail, Options, render};
use powergs_report::chart_files;
use powergs_report::document::{Block, Document};
use powergs_report::optimize::{
    Moment, Story, Strip, charts, document, models_csv, ratios_csv, samples_csv,
};
use powergs_scene::write_ply;

/// Longer side of the images of the strip, pixels.
const STRIP_SIDE: u32 = 800;

/// What a run was about.
pub struct Finished<'a> {
    /// Inputs and numbers.
    pub setup: &'a Setup<'a>,
    /// What was to be done.
    pub campaign: &'a Campaign,
    /// Frames shown per second.
    pub fps: f64,
    /// Whether the study of ratios was asked for.
    pub wants_ratios: bool,
    /// Operations of the colour filter for a pixel.
    pub filter_flops: f64,
    /// Why it ended before its jobs were done.
    pub stopped: Option<&'static str>,
}

/// Writes everything that follows from the outcomes.
pub fn finish(
    run: &Finished<'_>,
    inputs: &Inputs,
    folder: &mut Folder,
    progress: &Progress,
    context: &Context,
) -> Result<Exit, Failure> {
    // The report of level 1 is the same with and without levels beyond it.
    let done = &at(&progress.outcomes, Place::default());
    let conclusion = run.campaign.conclusion(done, Place::default());
    folder.write("samples.csv", &samples_csv(done))?;
    folder.write("models.csv", &models_csv(done))?;
    let rows = if run.wants_ratios { ratios(done) } else { Vec::new() };
    if !rows.is_empty() {
        folder.write("ratios.csv", &ratios_csv(&rows))?;
    }
    let mut strip = None;
    if let Some(best) = &conclusion.best {
        let model = folder.load_model(best)?;
        write_model(run.setup, inputs, folder, &model)?;
        strip = Some(pictures(run.setup, &model, best));
    }
    let viewer = foveated::viewer(run, inputs).filter(|_| conclusion.best.is_some());
    let shown = match &viewer {
        Some(viewer) => Some(foveated::finish(run, viewer, inputs, folder, progress)?),
        None => None,
    };
    let results = results(run, inputs, progress, (strip.as_ref(), shown.as_ref()));
    folder.write(FILE, results.to_json().as_bytes())?;
    let whole = Run { label: inputs.name.clone(), results };
    let story = Story {
        name: inputs.name.clone(),
        oracle: inputs.oracle.name(),
        display: inputs.display.name.clone(),
        fps: run.fps,
        done,
        target: run.campaign.target(done, 0).and_then(|t| t.likeness_target()),
        conclusion: &conclusion,
        course: course(&folder.history()?),
        ratios: rows,
        strip,
        claims: claims::check(std::slice::from_ref(&whole)),
    };
    let results = &whole.results;
    let drawn = charts(&story);
    write_charts(folder, &drawn)?;
    let mut page = document(&story, &drawn);
    if let Some(shown) = shown {
        page.extend(foveated::report(run, results, shown, folder, progress)?);
    }
    folder.write("summary.md", page.markdown().as_bytes())?;
    tell(run, &story, results, folder, context)?;
    Ok(if conclusion.best.is_some() { Exit::Done } else { Exit::GoalMissed })
}

/// Draws and writes charts.
pub fn write_charts(folder: &Folder, drawn: &[Chart]) -> Result<(), Failure> {
    for file in chart_files(drawn).or_exit(Exit::Internal, "charts")? {
        folder.write(&file.name, &file.bytes)?;
    }
    Ok(())
}

/// Everything that the run found, with what its colours lost.
fn results(
    run: &Finished<'_>,
    inputs: &Inputs,
    progress: &Progress,
    (strip, shown): (Option<&Strip>, Option<&foveated::Outcome>),
) -> Results {
    let camera = &inputs.cameras[0];
    let missing = inputs.screen.map(|s| foveated::missing(&s, &inputs.power_views));
    let mut results = Results::of(&Sources {
        scene: &inputs.name,
        is_self: inputs.is_self,
        size: [camera.width, camera.height],
        screen: inputs.screen,
        missing: &missing.unwrap_or_default(),
        oracle: &inputs.oracle.name(),
        fps: run.fps,
        display: (&inputs.display.name, inputs.display.scale),
        stopped: run.stopped,
        campaign: run.campaign,
        done: &progress.outcomes,
        measured: shown.map_or(&[], |s| &s.measured),
        dense_fps: shown.map(|s| s.dense_fps),
    });
    results.mean_change = strip.map(|strip| ChangeRecord {
        view: strip.view.clone(),
        level_1: strip.mean_change(),
        dense: Some(strip.mean_dense()),
        regions: shown.and_then(|s| s.change),
    });
    results
}

fn tell(
    run: &Finished<'_>,
    story: &Story<'_>,
    results: &Results,
    folder: &Folder,
    context: &Context,
) -> Result<(), Failure> {
    if context.global.json {
        return out::json(&object(run, story, results));
    }
    if let Some(why) = run.stopped {
        out::complain(why);
    }
    if context.global.quiet {
        if story.conclusion.best.is_none() {
            out::complain(story.headline().trim_end());
        }
        return Ok(());
    }
    let place = folder.path().join("summary.md");
    let mut page = Document::new();
    page.add(Block::Verbatim(story.headline()));
    page.table(powergs_report::optimize::foveated::headline(results));
    page.add(Block::Facts(vec![("report".into(), place.display().to_string().into())]));
    out::document(&page)
}

/// The final model as INRIA PLY, and its trace over the power views.
fn write_model(
    setup: &Setup<'_>,
    inputs: &Inputs,
    folder: &Folder,
    model: &Model,
) -> Result<(), Failure> {
    folder.stream("final.ply", |mut w| write_ply(&model.scene, &mut w))?;
    let header = TraceHeader {
        generator: concat!("powergs-sim ", env!("CARGO_PKG_VERSION")).to_owned(),
        scene: format!("{}-optimised", inputs.name),
        points: model.scene.len() as u64,
    };
    let options = Options { background: setup.background, ..Options::reference(Detail::Counters) };
    folder.stream("final.bin", |w| {
        let mut writer = Writer::new(w, &header).map_err(io::Error::other)?;
        for camera in setup.power_views {
            let frame = render(&model.scene, camera, &options).into_frame(camera, setup.background);
            let encoded = EncodedFrame::encode(&frame).map_err(io::Error::other)?;
            writer.write_encoded(encoded).map_err(io::Error::other)?;
        }
        writer.finish().map(drop).map_err(io::Error::other)
    })
}

/// The first test view, before and after.
fn pictures(setup: &Setup<'_>, model: &Model, best: &str) -> Strip {
    let camera = &setup.cameras[setup.split.test[0]];
    let options = Options { background: setup.background, ..Options::reference(Detail::Image) };
    let shown = |scene| {
        let picture = render(scene, camera, &options).picture;
        if picture.width.max(picture.height) > STRIP_SIDE {
            picture.shrunk(STRIP_SIDE)
        } else {
            picture
        }
    };
    let (dense, ours) = (shown(setup.dense), shown(&model.scene));
    Strip {
        view: camera.name.clone(),
        width: dense.width,
        height: dense.height,
        dense: dense.to_rgb8(),
        ours: ours.to_rgb8(),
        name: if best == "final" { "optimised".into() } else { format!("optimised ({best})") },
    }
}

/// The checks in `history.csv`, which this program wrote.
fn course(history: &str) -> Vec<Moment> {
    let moment = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |i: usize| cells.get(i).copied().filter(|c| !c.is_empty());
        Some(Moment {
            job: cell(0)?.to_owned(),
            iteration: cell(1)?.parse().ok()?,
            lambda: cell(8)?.parse().ok()?,
            psnr_db: cell(10)?.parse().ok()?,
        })
    };
    history.lines().skip(1).filter_map(moment).collect()
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

fn object(run: &Finished<'_>, story: &Story<'_>, results: &Results) -> Value {
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
        "reached": conclusion.best.is_some(),
        "stopped": run.stopped,
        "best": conclusion.best,
        "target_psnr_db": target.map(|t| number(t.psnr_db)),
        "target_ssim": target.map(|t| number(t.ssim)),
        "dense_w": facts.map(|f| f.dense_w),
        "ours_w": facts.map(|f| f.ours_w),
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
        "results": results,
    })
}
