//! The foveated part of a run: its screen and machine, and what it leaves: one model of four
//! levels, its trace, and measurements of every method.

use std::io;

use super::super::inputs;
use super::super::{Context, Exit, Failure, OrExit, gaze};
use super::finish::{Finished, write_charts};
use super::folder::Folder;
use super::inputs::{Inputs, published_prices};
use super::{Args, PowerArgs, album, demo};
use powergs_frame::fovea::{GAZE_CYCLE, LEVELS, Screen, ScreenGaze, TileLevels};
use powergs_frame::splat::TileGrid;
use powergs_frame::trace::{EncodedFrame, TraceHeader, Writer};
use powergs_optimize::checkpoint::Progress;
use powergs_optimize::foveated::{FilterCost, Foveal, Levels, Method, Viewer, lines};
use powergs_optimize::oracle::CycleOracle;
use powergs_optimize::plan::Place;
use powergs_optimize::results::Results;
use powergs_raster::{Detail, Options, render_foveated};
use powergs_report::document::Document;
use powergs_report::optimize::foveated::{
    Album, Show, charts, document, foveated_csv, levels_csv, regions_csv,
};
use powergs_scene::{Camera, Foveated, Gaussians};

/// Operations of a pixel in a rendering unit and cycle: the published costs of an α and of a blend.
const OPERATIONS: f64 = 13.0 + 11.0;

/// The virtual screen of `args`; `None` without `--foveated`.
pub fn screen(args: &Args) -> Result<Option<Screen>, Failure> {
    if !args.fovea.foveated {
        return Ok(None);
    }
    let pooling_rate = demo::pooling_rate(args);
    let screen = Screen { pooling_rate, ..args.fovea.screen.unwrap_or(Screen::PUBLISHED) };
    screen.check().or_exit(Exit::Usage, "--screen, --pooling-rate")?;
    Ok(Some(screen))
}

/// The machine whose speed is reported, and the price of an operation, picojoules.
pub fn clock(args: &PowerArgs) -> Result<(CycleOracle, f64), Failure> {
    let system = inputs::system(&args.arch, &args.sets, args.energy.as_deref())?;
    if system.machine().fovea.accumulators == 0 {
        let what = format!(
            "--foveated: the machine {} cannot show foveated frames (fovea.accumulators is 0); \
             give --set fovea.accumulators=1 or 2, or another --arch",
            system.machine().name
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    let flop_pj = published_prices()?.0.flop_pj;
    Ok((CycleOracle { system, fps: args.fps }, flop_pj))
}

/// Where somebody looks in each view.
fn looking(screen: &Screen, views: usize) -> Vec<ScreenGaze> {
    let gaze = |i: usize| GAZE_CYCLE[i % GAZE_CYCLE.len()];
    (0..views).map(|i| ScreenGaze { point: gaze(i), screen: *screen }).collect()
}

/// Levels that some view shows, from 1.
pub fn levels(screen: &Screen, views: &[Camera]) -> u8 {
    let of_view = |(camera, looking): (&Camera, ScreenGaze)| {
        let (width, height) = (camera.width, camera.height);
        let map = looking.eccentricity_map([width, height]).ok()?;
        let tiles = TileLevels::new(&map, TileGrid::new(width, height, 16)).tiles;
        tiles.iter().map(|t| t.first + u8::from(t.blends)).max()
    };
    let most = views.iter().zip(looking(screen, views.len())).filter_map(of_view).max();
    1 + most.unwrap_or(0)
}

/// The regions that no view has, 0 for R1.
pub fn missing(screen: &Screen, views: &[Camera]) -> Vec<u8> {
    gaze::missing(views, &looking(screen, views.len()))
}

/// Says which regions no view has.
pub fn note_missing(context: &Context, screen: &Screen, views: &[Camera]) {
    gaze::note_missing(context, views, &looking(screen, views.len()));
}

/// A foveated run, measured.
pub struct Outcome {
    /// All methods of all variants.
    pub measured: Vec<Foveal>,
    /// Speed of the dense model on the machine, frames a second.
    pub dense_fps: f64,
    /// Pictures of one view: ours and FR-Render of the first variant.
    pub album: Option<Album>,
    /// Mean change of red, green and blue against the dense model in each region of that view,
    /// codes of 8 bits.
    pub change: Option<[Option<[f64; 3]>; LEVELS]>,
}

/// What foveated models of a run are measured with; `None` if it is not foveated.
pub fn viewer<'a>(run: &Finished<'a>, inputs: &'a Inputs) -> Option<Viewer<'a>> {
    let (clock, flop_pj) = inputs.clock.as_ref()?;
    let vru = &clock.system.machine().vru;
    let lanes = f64::from(vru.cores) * f64::from(vru.units_per_core);
    let cost = FilterCost {
        flops: run.filter_flops,
        flop_pj: *flop_pj,
        flops_per_cycle: lanes * OPERATIONS,
    };
    Some(Viewer { setup: run.setup, screen: inputs.screen?, clock, cost })
}

/// Composes and measures everything; writes `model.fov` and `fr.bin`.
pub fn finish(
    run: &Finished<'_>,
    viewer: &Viewer<'_>,
    inputs: &Inputs,
    folder: &Folder,
    progress: &Progress,
) -> Result<Outcome, Failure> {
    let internal = "internal error in a foveated frame";
    let dense_fps = viewer.plain_fps(run.setup.dense).or_exit(Exit::Internal, internal)?;
    let mut outcome = Outcome { measured: Vec::new(), dense_fps, album: None, change: None };
    let (mut ours, mut pruned) = (None, None);
    for levels in lines(run.campaign, &progress.outcomes) {
        let model = compose(folder, &levels)?;
        let (method, is_first) = (levels.method, levels.variant == 0);
        let measured = viewer.measure(levels, &model).or_exit(Exit::Internal, internal)?;
        outcome.measured.push(measured);
        match method {
            Method::PowerGs if is_first => {
                folder.stream("model.fov", |mut w| model.write(&mut w))?;
                write_trace(viewer, inputs, folder, &model)?;
                ours = Some(model);
            }
            Method::FrRender if is_first => pruned = Some(model),
            Method::PowerGs | Method::FrRender | Method::FrDisplay | Method::RtgsD22 => {}
        }
    }
    if let Some(ours) = ours {
        let (pictures, change) = album::album(viewer, &ours, pruned.as_ref(), inputs.is_self)
            .or_exit(Exit::Internal, internal)?;
        (outcome.album, outcome.change) = (Some(pictures), Some(change));
    }
    Ok(outcome)
}

/// Writes tables and charts; returns the foveated part of the summary.
pub fn report(
    run: &Finished<'_>,
    results: &Results,
    shown: Outcome,
    folder: &Folder,
    progress: &Progress,
) -> Result<Document, Failure> {
    folder.write("levels.csv", &levels_csv(results))?;
    folder.write("foveated.csv", &foveated_csv(results))?;
    folder.write("regions.csv", &regions_csv(results))?;
    let fit = |level: u8| {
        let place = Place { variant: 0, level };
        let fit = run.campaign.conclusion(&progress.outcomes, place).fit.ok()?;
        Some((format!("level {}", level + 1), fit))
    };
    let fits = (0..run.campaign.levels).filter_map(fit).collect();
    let show = Show { results, fits, album: shown.album };
    let drawn = charts(&show);
    write_charts(folder, &drawn)?;
    Ok(document(&show, &drawn))
}

/// The four levels as one model.
fn compose(folder: &Folder, levels: &Levels) -> Result<Foveated, Failure> {
    let mut models: Vec<Gaussians> = Vec::with_capacity(levels.jobs.len());
    for job in &levels.jobs {
        models.push(folder.load_model(job)?.scene);
    }
    let internal = || Failure::new(Exit::Internal, "a foveated model without four levels");
    let models: [Gaussians; Foveated::LEVELS] = models.try_into().map_err(|_| internal())?;
    Foveated::compose(&models).or_exit(Exit::Internal, "the levels of a run")
}

fn write_trace(
    viewer: &Viewer<'_>,
    inputs: &Inputs,
    folder: &Folder,
    model: &Foveated,
) -> Result<(), Failure> {
    let setup = viewer.setup;
    let header = TraceHeader {
        generator: concat!("powergs-sim ", env!("CARGO_PKG_VERSION")).to_owned(),
        scene: format!("{}-foveated", inputs.name),
        points: model.len() as u64,
    };
    let options = Options { background: setup.background, ..Options::reference(Detail::Counters) };
    folder.stream("fr.bin", |w| {
        let mut writer = Writer::new(w, &header).map_err(io::Error::other)?;
        for (i, camera) in setup.power_views.iter().enumerate() {
            let frame = render_foveated(model, camera, &viewer.looking(i), &options);
            let frame = frame.map_err(io::Error::other)?.into_frame(camera, setup.background);
            let encoded = EncodedFrame::encode(&frame).map_err(io::Error::other)?;
            writer.write_encoded(encoded).map_err(io::Error::other)?;
        }
        writer.finish().map(drop).map_err(io::Error::other)
    })
}
