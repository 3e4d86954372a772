//! Everything that a run reads, opened and checked.

use std::path::Path;

use xxhash_rust::xxh3::Xxh3;

use super::super::camera_file::{CameraArgs, Views};
use super::super::inputs;
use super::super::progress::Progress;
use super::super::replay::ModelArg;
use super::super::{Context, Exit, Failure, OrExit, lpips_file, out, scene_file};
use super::shelf::Shelf;
use super::{Args, GateArg, PowerArgs, PowerViewsArg, ViewArgs, demo, foveated, photos};
use powergs_core::run::{FileKind, PaperModel};
use powergs_core::sim::paper::UnitPrices;
use powergs_core::workload::paper::Padding;
use powergs_frame::display::Display;
use powergs_frame::fovea::Screen;
use powergs_optimize::adam::Group;
use powergs_optimize::oracle::{CycleOracle, PaperOracle, PowerOracle};
use powergs_optimize::setup::Reference;
use powergs_optimize::views::{ViewSplit, split};
use powergs_quality::Lpips;
use powergs_raster::{Detail, Options, render};
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::camera::{edit, path};
use powergs_scene::{Camera, Gaussians};

/// What a run reads.
pub struct Inputs {
    /// Name for people and for the folder.
    pub name: String,
    /// The dense model.
    pub dense: Gaussians,
    /// Further models.
    pub externals: Vec<(String, Gaussians)>,
    /// All views.
    pub cameras: Vec<Camera>,
    /// Their references.
    pub references: Shelf,
    /// Whether those are renders of the dense model.
    pub is_self: bool,
    /// Which view does what.
    pub split: ViewSplit,
    /// Views that power is a mean over.
    pub power_views: Vec<Camera>,
    /// The panel.
    pub display: Display,
    /// What rendering costs.
    pub oracle: Box<dyn PowerOracle>,
    /// The machine or price table, as resolved.
    pub oracle_toml: String,
    /// What LPIPS is measured with, and the hash of its file.
    pub lpips: Option<(Lpips, u128)>,
    /// The virtual screen of a foveated run.
    pub screen: Option<Screen>,
    /// The machine whose speed a foveated run reports, and the price of an operation of the colour
    /// filter, picojoules.
    pub clock: Option<(CycleOracle, f64)>,
}

impl Inputs {
    /// Opens and checks everything.
    pub fn load(args: &Args, context: &Context) -> Result<Inputs, Failure> {
        let screen = foveated::screen(args)?;
        let lpips = args.lpips_weights.as_deref().map(lpips_file::read).transpose()?;
        let (name, dense) = dense(args, context)?;
        let display = inputs::display(&args.power.display)?;
        let (oracle, oracle_toml) = oracle(&args.power, demo::oracle(args), screen.is_some())?;
        let clock = screen.map(|_| foveated::clock(&args.power)).transpose()?;
        let externals = externals(args, context)?;
        let (full, cameras) = views(args, context, &dense)?;
        let background = args.views.background.0;
        check_sight(&dense, &cameras, background, context)?;
        let progress = Progress::new(context, cameras.len() as u64, "reference images");
        let references = match &args.views.images {
            Some(folder) => {
                let mut shelf = Shelf::new()?;
                photos::load(folder, &full, &cameras, background, |reference| {
                    progress.advance(1);
                    shelf.push(&reference)
                })?;
                shelf
            }
            None => own_renders(&dense, &cameras, background, &progress)?,
        };
        drop(progress);
        let split = split(&cameras, args.views.validation.map_or(0, |k| k.get()));
        // Views that do not gate have no reason not to train.
        let is_gate = args.views.gate == GateArg::Validation;
        let trains = args.views.train_on_validation || !is_gate;
        let split = if trains { split.validation_trains() } else { split };
        for note in split.notes.iter().filter(|_| !context.global.quiet) {
            out::complain(format!("note: {note}"));
        }
        for &view in lpips.iter().flat_map(|_| &split.test) {
            let Camera { name, width, height, .. } = &cameras[view];
            let checked = lpips.as_ref().map_or(Ok(()), |l| l.0.check_size(*width, *height));
            checked.or_exit(Exit::BadInput, format_args!("--lpips-weights: test view {name}"))?;
        }
        let power_views = power_views(&args.views, &cameras, &split)?;
        let display = match demo::display_ratio(args) {
            Some(ratio) => {
                scaled(display, ratio, &dense, &power_views, background, oracle.as_ref())?
            }
            None => display,
        };
        let is_self = args.views.images.is_none();
        if let Some(screen) = &screen {
            foveated::note_missing(context, screen, &power_views);
        }
        Ok(Inputs {
            name,
            dense,
            externals,
            cameras,
            references,
            is_self,
            split,
            power_views,
            display,
            oracle,
            oracle_toml,
            lpips,
            screen,
            clock,
        })
    }

    /// Levels that some power view shows, from 1.
    pub fn levels(&self) -> u8 {
        self.screen.map_or(1, |screen| foveated::levels(&screen, &self.power_views))
    }

    /// A hash of everything here that numbers depend on, and of `settings`.
    pub fn fingerprint(&self, settings: &str) -> u128 {
        let mut hash = Xxh3::new();
        hash.update(settings.as_bytes());
        hash.update(self.oracle_toml.as_bytes());
        if let Some((clock, flop_pj)) = &self.clock {
            hash.update(format!("{:?}{flop_pj}", clock.system.machine()).as_bytes());
        }
        hash.update(format!("{:?}{:?}", self.display, self.cameras).as_bytes());
        hash.update(format!("{:?}{:?}", self.split, self.power_views).as_bytes());
        for scene in std::iter::once(&self.dense).chain(self.externals.iter().map(|e| &e.1)) {
            hash.update(&[scene.sh_degree]);
            for group in Group::ALL {
                hash.update(bytemuck::cast_slice(group.of(scene)));
            }
        }
        hash.update(&self.references.digest().to_le_bytes());
        hash.digest128()
    }
}

fn dense(args: &Args, context: &Context) -> Result<(String, Gaussians), Failure> {
    let Some(path) = args.model.as_deref().filter(|_| !args.demo) else {
        return Ok(("demo".into(), demo::model()?));
    };
    let scene = scene_file::load(path, args.lod)?;
    scene.warn(context);
    if scene.gaussians.is_empty() {
        let what = format!("{}: the model has no Gaussians", path.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    Ok((name_of(&scene.path), scene.gaussians))
}

/// A name for people: that of the file, or of the folder around it where every trainer and
/// exporter uses the same one.
fn name_of(path: &Path) -> String {
    let is_common = |name: &String| {
        ["meta", "lod-meta", "point_cloud"].contains(&name.as_str())
            || name.starts_with("iteration_")
    };
    let stems = path.ancestors().filter_map(|p| p.file_stem());
    let mut names = stems.map(|s| s.to_string_lossy().into_owned());
    names.find(|name| !is_common(name)).unwrap_or_else(|| "model".into())
}

fn externals(args: &Args, context: &Context) -> Result<Vec<(String, Gaussians)>, Failure> {
    let mut externals = Vec::new();
    for (name, path) in &args.compare.others {
        let scene = scene_file::load(path, None)?;
        scene.warn(context);
        externals.push((name.clone(), scene.gaussians));
    }
    Ok(externals)
}

/// The views as their file has them, and as they are used.
fn views(
    args: &Args,
    context: &Context,
    dense: &Gaussians,
) -> Result<(Vec<Camera>, Vec<Camera>), Failure> {
    if args.demo {
        let views = demo::views(args.views.size)?;
        return Ok((views.clone(), views));
    }
    let images = args.views.images.as_deref();
    let file = args.views.cameras.clone().or_else(|| images.and_then(photos::camera_file));
    if file.is_none() && args.views.orbit.is_none() {
        let what = match images {
            Some(folder) => format!(
                "{}: no cameras.json or transforms.json there or beside it; give --cameras",
                folder.display()
            ),
            None => "no views: give --cameras FILE, --orbit N, or --images DIR".into(),
        };
        return Err(Failure::new(Exit::Usage, what));
    }
    if images.is_some() && args.views.orbit.is_some() {
        let what = "--orbit: photos have poses of their own; give --cameras, or no --images";
        return Err(Failure::new(Exit::Usage, what));
    }
    let source = CameraArgs {
        cameras: file,
        orbit: args.views.orbit,
        orbit_elevation: None,
        orbit_radius: None,
        orbit_fov: None,
        orbit_up: None,
        split: None,
        every: args.views.every,
        path_frames: None,
        frames: None,
        size: if images.is_some() { None } else { args.views.size },
        stereo: None,
    };
    let views: Views = source.cameras(|| SceneBounds::of(dense))?;
    views.warn(context);
    let full = views.cameras;
    let used = match args.views.size.filter(|_| images.is_some()) {
        Some(size) => full.iter().map(|c| smaller(c, size)).collect::<Result<Vec<_>, _>>()?,
        None => full.clone(),
    };
    Ok((full, used))
}

/// A view of a photo that is averaged down.
fn smaller(camera: &Camera, (width, height): (u32, u32)) -> Result<Camera, Failure> {
    let fitting = f64::from(camera.width) * f64::from(height) / f64::from(camera.height);
    let enlarges = width > camera.width || height > camera.height;
    if enlarges || (fitting - f64::from(width)).abs() > 1.0 {
        let what = format!(
            "--size {width}x{height}: the photo of {} is {}x{}; give a smaller size of its aspect, \
             for this height {fitting:.0}x{height}",
            camera.name, camera.width, camera.height
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok(edit::resized(camera, width, height))
}

/// Views that see nothing cannot train: all of them is an error, some are a warning.
fn check_sight(
    dense: &Gaussians,
    cameras: &[Camera],
    background: [f32; 3],
    context: &Context,
) -> Result<(), Failure> {
    let options = Options { background, ..Options::reference(Detail::Image) };
    let blind: Vec<&str> = cameras
        .iter()
        .filter(|c| render(dense, c, &options).picture.pixels.iter().all(|p| *p == background))
        .map(|c| c.name.as_str())
        .collect();
    if blind.len() == cameras.len() {
        let what = "no view sees anything of the model: are these the cameras of this scene?";
        return Err(Failure::new(Exit::BadInput, what));
    }
    if !blind.is_empty() && !context.global.quiet {
        let names = blind.join(", ");
        out::complain(format!("warning: {} views see nothing of the model: {names}", blind.len()));
    }
    Ok(())
}

/// The panel at which the dense model's display power is `ratio` times its rendering power.
fn scaled(
    display: Display,
    ratio: f64,
    dense: &Gaussians,
    views: &[Camera],
    background: [f32; 3],
    oracle: &dyn PowerOracle,
) -> Result<Display, Failure> {
    if !(0.001..=1000.0).contains(&ratio) {
        let what = format!("--display-ratio {ratio}: must be 0.001 to 1000");
        return Err(Failure::new(Exit::Usage, what));
    }
    let watts = oracle.watts(dense, views, background, &display);
    let watts = watts.or_exit(Exit::Internal, "internal error in the dense model")?;
    if watts.display_w <= 0.0 {
        let what = "--display-ratio: the dense model's images cost no display power";
        return Err(Failure::new(Exit::BadInput, what));
    }
    let factor = ratio * watts.render_w / watts.display_w;
    let static_power = powergs_base::quantity::Watts(display.static_power.0 * factor);
    Ok(Display { scale: display.scale * factor, static_power, ..display })
}

fn own_renders(
    dense: &Gaussians,
    cameras: &[Camera],
    background: [f32; 3],
    progress: &Progress,
) -> Result<Shelf, Failure> {
    let options = Options { background, ..Options::reference(Detail::Image) };
    let mut shelf = Shelf::new()?;
    for camera in cameras {
        shelf.push(&Reference::new(&render(dense, camera, &options).picture))?;
        progress.advance(1);
    }
    Ok(shelf)
}

fn power_views(
    args: &ViewArgs,
    cameras: &[Camera],
    split: &ViewSplit,
) -> Result<Vec<Camera>, Failure> {
    if let Some(frames) = args.path_frames {
        let what = "--path-frames: a path needs 1 to 100000 frames and at least two views";
        let refused = || Failure::new(Exit::Usage, what);
        let path = path::Path::through(cameras).filter(|_| (1..=100_000).contains(&frames));
        return Ok(path.ok_or_else(refused)?.frames(frames));
    }
    Ok(match args.power_views {
        PowerViewsArg::All => cameras.to_vec(),
        PowerViewsArg::Test => split.test.iter().map(|&v| cameras[v].clone()).collect(),
    })
}

/// `is_timed`: a machine says how fast frames are, whatever counts their power.
fn oracle(
    args: &PowerArgs,
    model: ModelArg,
    is_timed: bool,
) -> Result<(Box<dyn PowerOracle>, String), Failure> {
    if model == ModelArg::Paper {
        if !is_timed && (!args.sets.is_empty() || args.energy.is_some()) {
            let what = "--set, --energy: the paper model has no machine; use --oracle cycle";
            return Err(Failure::new(Exit::Usage, what));
        }
        let (prices, text) = published_prices()?;
        return Ok((Box::new(PaperOracle { prices, fps: args.fps }), text));
    }
    let system = inputs::system(&args.arch, &args.sets, args.energy.as_deref())?;
    let energy = system.read(FileKind::Energy).map_or("", |file| &file.text);
    let text = format!("{}\n{energy}", system.machine_toml());
    Ok((Box::new(CycleOracle { system, fps: args.fps }), text))
}

/// The published prices, and the table that they are from.
pub fn published_prices() -> Result<(UnitPrices, String), Failure> {
    let model = PaperModel::new(Padding::TrueTiles)?;
    Ok((model.prices, model.table().text.clone()))
}
