//! Everything that a co-design reads, opened.

use std::fs;
use std::path::{Path, PathBuf};

use super::super::failure::ConfigUsage;
use super::super::references::FileReferences;
use super::super::{Context, Exit, Failure, OrExit, out, sight};
use super::{CodesignArgs, LevelArg, QualityArgs, demo};
use crate::cli::codesign::watch::Watched;
use powergs_codesign::Codesign;
use powergs_codesign::machines::Machines;
use powergs_codesign::space::SpaceFile;
use powergs_frame::display::Display;
use powergs_optimize::campaign::{Campaign, CampaignError};
use powergs_optimize::oracle::CycleOracle;
use powergs_optimize::references::ReferenceImages;
use powergs_optimize::request::{Goal, Goals, Request};
use powergs_optimize::settings::Settings;
use powergs_optimize::target::Level;
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::{Camera, Gaussians};

/// A space file as it was read.
pub struct Space {
    /// What messages call it.
    pub origin: String,
    /// Its text.
    pub text: String,
    /// What it says.
    pub file: SpaceFile,
}

/// The space that `args` name.
///
/// # Errors
/// Exit code 2: no space, one that cannot be read, everything that is wrong with its form.
pub fn space(args: &CodesignArgs) -> Result<Space, Failure> {
    let (origin, text) = match (&args.space, args.demo) {
        (Some(path), _) => {
            let origin = path.display().to_string();
            let text = fs::read_to_string(path).or_exit(Exit::Usage, &origin)?;
            (origin, text)
        }
        (None, true) => ("the space of --demo".into(), demo::SPACE.into()),
        (None, false) => {
            let what = "codesign: no space; give --space FILE (`codesign --help` has a small \
                        one), or try --demo";
            return Err(Failure::new(Exit::Usage, what));
        }
    };
    let mut file = SpaceFile::parse(&text).usage(&origin)?;
    file.machine.folder = args.space.as_deref().and_then(Path::parent).map(Path::to_path_buf);
    Ok(Space { origin, text, file })
}

/// The co-design that `args` ask for, checked.
///
/// # Errors
/// Exit code 2 for what cannot be asked, 3 for inputs that cannot be read.
pub fn codesign(
    args: &CodesignArgs,
    space: &Space,
    context: &Context,
    watched: &Watched<'_>,
) -> Result<Codesign, Failure> {
    if args.dense.model.is_none() && !args.demo {
        let what = "codesign: no model; name a trained one, or try --demo, which generates a scene";
        return Err(Failure::new(Exit::Usage, what));
    }
    let machines = Machines::open(&space.file.machine, &space.text, &space.origin)?;
    for doubt in machines.base.doubts() {
        out::complain(format_args!("warning: {doubt}"));
    }
    let display = machines.base.display().cloned();
    let display =
        display.ok_or_else(|| Failure::new(Exit::Internal, "a system without display"))?;
    let (name, dense) = args.dense.open(context)?;
    let seen = views(args, context, &dense)?;
    let campaign = Campaign::open(
        request(args, space, context, (name, dense, seen), (&machines, display))?,
        watched,
    )?;
    let mut codesign = Codesign::open(campaign, space.file.clone(), &space.text, &space.origin)?;
    codesign.rounds = args.search.rounds;
    codesign.halving = args.search.halving;
    codesign.memory = usize::try_from(context.global.memory.0.0).unwrap_or(usize::MAX);
    Ok(codesign)
}

fn request(
    args: &CodesignArgs,
    space: &Space,
    context: &Context,
    (name, dense, (cameras, whole)): (String, Gaussians, CodesignInputSeen),
    (machines, display): (&Machines, Display),
) -> Result<Request, Failure> {
    let default = if args.demo { demo::ITERATIONS } else { Settings::DEFAULT.iterations };
    let iterations = args.search.iterations.unwrap_or(default);
    let settings = Settings {
        iterations,
        final_iterations: iterations,
        ..args.search.settings.settings().map_err(CampaignError::from)?
    };
    let model = (args.dense.model.as_deref(), false);
    let (power_cameras, full_size) = args.power.cameras(model, context, &cameras, whole)?;
    let (system, fps) = (machines.base.clone(), machines.fps());
    let oracle = CycleOracle { system, fps, memory: context.global.memory };
    Ok(Request {
        references: ReferenceImages::OwnRenders(Box::new(FileReferences::new()?)),
        background: args.views.seen.background(args.dense.model.as_deref()).said(context),
        power_cameras,
        full_size,
        least_gate: 0,
        validation_every: args.views.seen.validation.map_or(0, |k| k.get()),
        goals: Goals { goal: Some(goal(args, space)), ..Goals::default() },
        settings,
        ..Request::new(&name, dense, cameras, oracle, display)
    })
}

/// What models must reach: the flags, the space file, medium.
fn goal(args: &CodesignArgs, space: &Space) -> Goal {
    let QualityArgs { quality, likeness } = &args.quality;
    match (quality, likeness.goal(), space.file.budget.psnr) {
        (Some(LevelArg::H), ..) => Goal::Levels(vec![Level::High]),
        (Some(LevelArg::M), ..) => Goal::Levels(vec![Level::Medium]),
        (Some(LevelArg::L), ..) => Goal::Levels(vec![Level::Low]),
        (None, Some(goal), _) => goal,
        (None, None, Some(psnr_db)) => Goal::Absolute { psnr_db, ssim: 0.0 },
        (None, None, None) => Goal::Levels(vec![Level::Medium]),
    }
}

/// The views as models are compared in them, and the same at the size that the camera file says;
/// `None` where none does.
type CodesignInputSeen = (Vec<Camera>, Option<Vec<Camera>>);

fn views(
    args: &CodesignArgs,
    context: &Context,
    dense: &Gaussians,
) -> Result<CodesignInputSeen, Failure> {
    if args.demo {
        return Ok((demo::views(args.views.size)?, None));
    }
    let source = args.views.seen.source(args.views.size);
    let model = args.dense.model.as_deref();
    let views = source.cameras(model, || SceneBounds::of(dense))?;
    views.warn(context);
    sight::check(dense, &views.cameras, context);
    let whole = source.whole(model, &views.cameras);
    Ok((views.cameras, whole))
}

/// Where the run is.
pub fn place(args: &CodesignArgs, codesign: &Codesign) -> PathBuf {
    let name = || Path::new("runs").join(format!("{}-codesign", codesign.campaign.name));
    args.run.out.clone().unwrap_or_else(name)
}
