//! Everything that a run reads, opened.

use std::path::Path;

use super::super::camera_file::{CameraArgs, Views};
use super::super::inputs;
use super::super::power_views::fits_memory;
use super::super::progress::Progress;
use super::super::references::FileReferences;
use super::super::replay::ModelArg;
use super::super::{Context, Exit, Failure, lpips_file, out, scene_file, sight};
use super::photo_references::{PhotoFile, PhotoReferences};
use super::photos::PhotoFolder;
use super::{KeepArg, OptimizeArgs, PowerArgs, demo, photos};
use powergs_optimize::oracle::{CycleOracle, PaperOracle, PowerOracle};
use powergs_optimize::photos::Photo;
use powergs_optimize::references::{ReferenceImages, ReferenceSink};
use powergs_optimize::renderer::Processor;
use powergs_optimize::request::{Foveation, Goals, Request};
use powergs_optimize::settings::Settings;
use powergs_optimize::views::PowerViews;
use powergs_scene::camera::lens::without_lens;
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::open_model;
use powergs_scene::{Camera, Gaussians};

/// The machine, the panel and the display rate where none is given.
const MACHINE: &str = "gscore";
/// See [`MACHINE`].
const DISPLAY: &str = "oled-powergs";
/// See [`MACHINE`]; frames a second.
const FPS: f64 = 60.0;

/// What `args` ask for, with everything that they name.
pub fn request(
    args: &OptimizeArgs,
    context: &Context,
    settings: Settings,
    goals: Goals,
) -> Result<Request, Failure> {
    let foveation = foveation(args, context)?;
    let lpips = args.lpips_weights.as_deref().map(lpips_file::read).transpose()?;
    let (name, dense) = args.dense.open(context)?;
    let display = inputs::display(args.power.display.as_deref().unwrap_or(DISPLAY))?;
    let oracle = oracle(&args.power, demo::oracle(args), foveation.is_some(), context)?;
    let externals = externals(args, context)?;
    let InputSeen { cameras, photos, whole } = views(args, context, &dense)?;
    let (power_cameras, full_size) = args.power.shown.cameras(
        (args.dense.model.as_deref(), args.fovea.foveated),
        context,
        &cameras,
        whole,
    )?;
    let background = args.seen.background(args.dense.model.as_deref()).said(context);
    let mut images = FileReferences::new()?;
    let references = if photos.is_empty() {
        ReferenceImages::OwnRenders(Box::new(images))
    } else {
        let progress = Progress::new(context, cameras.len() as u64, "reference images");
        for (file, photo) in &photos {
            images.push(photos::reference(file, photo, background)?)?;
            progress.advance(1);
        }
        ReferenceImages::Photos(Box::new(PhotoReferences { images, photos, background }))
    };
    Ok(Request {
        name,
        dense,
        externals,
        cameras,
        references,
        background,
        validation_every: args.seen.validation.map_or(0, |k| k.get()),
        least_gate: args.views.least_gate,
        power_cameras,
        power_views: match args.power.path_frames {
            Some(frames) => PowerViews::Path(frames),
            None => args.power.power_views.unwrap_or(PowerViews::Usual),
        },
        full_size,
        goals,
        renderer: Box::new(Processor),
        oracle,
        display,
        display_ratio: demo::display_ratio(args),
        settings,
        foveation,
        lpips,
        keep_all: args.keep == KeepArg::All,
    })
}

/// The virtual screens and the machine; `None` without `--foveated`.
fn foveation(args: &OptimizeArgs, context: &Context) -> Result<Option<Foveation>, Failure> {
    if !args.fovea.foveated {
        return Ok(None);
    }
    let clock = clock(&args.power, context)?;
    Ok(Some(Foveation::new(demo::screens(args), clock, args.fovea.filter_flops)?))
}

fn externals(args: &OptimizeArgs, context: &Context) -> Result<Vec<(String, Gaussians)>, Failure> {
    let mut externals = Vec::new();
    for (name, path) in &args.compare.others {
        let scene = open_model(path, None)?;
        scene_file::warn(&scene, context);
        externals.push((name.clone(), scene.gaussians));
    }
    Ok(externals)
}

/// The views of a run.
struct InputSeen {
    /// As models are compared in them.
    cameras: Vec<Camera>,
    /// Their photos, with `--images`.
    photos: Vec<PhotoFile>,
    /// The same views at the size that the camera file says; `None` where none does.
    whole: Option<Vec<Camera>>,
}

/// The views, and their photos with `--images`.
fn views(args: &OptimizeArgs, context: &Context, dense: &Gaussians) -> Result<InputSeen, Failure> {
    if args.demo {
        return Ok(InputSeen { cameras: demo::views(args.size)?, photos: Vec::new(), whole: None });
    }
    let images = args.views.images.as_deref();
    let seen = &args.seen;
    let file = seen.cameras.clone().or_else(|| images.and_then(photos::camera_file));
    if file.is_none() && seen.orbit.is_none() {
        let what = match images {
            Some(folder) => format!(
                "{}: no cameras.json, transforms.json or sparse/0 there or beside it; give \
                 --cameras",
                folder.display()
            ),
            None => "no views: give --cameras FILE, --orbit N, or --images DIR".into(),
        };
        return Err(Failure::new(Exit::Usage, what));
    }
    if images.is_some() && seen.orbit.is_some() {
        let what = "--orbit: photos have poses of their own; give --cameras, or no --images";
        return Err(Failure::new(Exit::Usage, what));
    }
    let size = if images.is_some() { None } else { args.size };
    let source = CameraArgs { cameras: file, ..seen.source(size) };
    let model = args.dense.model.as_deref();
    let views: Views = source.cameras(model, || SceneBounds::of(dense))?;
    sight::check(dense, &views.cameras, context);
    let seen = match images {
        Some(folder) => {
            let (cameras, photos) = photographed(args, context, folder, &views)?;
            let straight = |camera: &Camera| match views.lenses.get(&camera.name) {
                Some(lens) => without_lens(camera, lens).unwrap_or_else(|| camera.clone()),
                None => camera.clone(),
            };
            let whole = Some(views.cameras.iter().map(straight).collect());
            InputSeen { cameras, photos, whole }
        }
        None => {
            views.warn(context);
            let whole = source.whole(model, &views.cameras);
            InputSeen { cameras: views.cameras, photos: Vec::new(), whole }
        }
    };
    fits_memory(&seen.cameras, context)?;
    Ok(seen)
}

/// The views as their photos show them.
fn photographed(
    args: &OptimizeArgs,
    context: &Context,
    folder: &Path,
    views: &Views,
) -> Result<(Vec<Camera>, Vec<PhotoFile>), Failure> {
    views.warn_of_selection(context);
    let photos = PhotoFolder::open(folder)?;
    let files = photos.of_views(&views.cameras)?;
    if args.seen.every.is_none() {
        photos.note_unused(&files, context);
    }
    let shown = photos::measured(&files, &views.cameras, &views.lenses, args.size)?;
    let used: Vec<Camera> = shown.iter().map(|photo| photo.view.clone()).collect();
    if !context.global.quiet {
        say_changes(views, &shown);
    }
    Ok((used, files.into_iter().zip(shown).collect()))
}

/// Says what photos and cameras go through before they are compared.
pub fn say_changes(views: &Views, shown: &[Photo]) {
    let bent = views.cameras.iter().filter(|c| views.lenses.contains_key(&c.name)).count();
    if bent > 0 {
        out::complain(format!(
            "note: {bent} of {} photos are freed of the bends of their lenses; views are pinhole, \
             up to {}x{}",
            shown.len(),
            shown.iter().map(|p| p.view.width).max().unwrap_or(0),
            shown.iter().map(|p| p.view.height).max().unwrap_or(0),
        ));
    }
    let is_other =
        |(camera, photo): &(&Camera, &Photo)| photo.size != (camera.width, camera.height);
    let mut others = views.cameras.iter().zip(shown).filter(is_other);
    if let Some((camera, photo)) = others.next() {
        out::complain(format!(
            "note: {} of {} photos have another size than their cameras ({}: {}x{} and {}x{}); the \
             smaller one is taken",
            1 + others.count(),
            shown.len(),
            camera.name,
            photo.size.0,
            photo.size.1,
            camera.width,
            camera.height
        ));
    }
}

fn clock(args: &PowerArgs, context: &Context) -> Result<CycleOracle, Failure> {
    let machine = args.arch.as_deref().unwrap_or(MACHINE);
    let system = inputs::system(machine, &args.sets, args.energy.as_deref())?;
    Ok(CycleOracle { system, fps: args.fps.unwrap_or(FPS), memory: context.global.memory })
}

/// `is_timed`: a machine gives the frame time even if the paper model gives the power.
fn oracle(
    args: &PowerArgs,
    model: ModelArg,
    is_timed: bool,
    context: &Context,
) -> Result<Box<dyn PowerOracle>, Failure> {
    if model != ModelArg::Paper {
        return Ok(Box::new(clock(args, context)?));
    }
    if !is_timed && (!args.sets.is_empty() || args.energy.is_some()) {
        let what = "--set, --energy: the paper model has no machine; use --oracle cycle";
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok(Box::new(PaperOracle::published(args.fps.unwrap_or(FPS))?))
}
