//! From flags to what is asked of the library, and from its refusals back to flags.

use super::super::{Exit, Failure};
use super::{OptimizeArgs, Quality, ScheduleArg, StudyArg};
use powergs_optimize::campaign::CampaignError;
use powergs_optimize::invalid::Invalid;
use powergs_optimize::request::{Foveation, FoveationError, Goal, Goals};
use powergs_optimize::role::Baseline;
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::{SETTINGS, Settings};

/// The settings of `args`, checked.
pub fn settings(args: &OptimizeArgs) -> Result<Settings, Failure> {
    let settings = args.settings.settings().map_err(refused)?;
    Foveation::check_filter(args.fovea.filter_flops).map_err(refused)?;
    Ok(settings)
}

/// What `args` ask for, checked.
pub fn goals(args: &OptimizeArgs, settings: &Settings) -> Result<Goals, Failure> {
    let schedule = match (args.search.rhos.as_slice(), args.search.schedule) {
        ([], ScheduleArg::Five) => Schedule::FIVE,
        ([], ScheduleArg::Published) => Schedule::PUBLISHED,
        (rhos, _) => Schedule::listed(rhos).map_err(refused)?,
    };
    let goals = Goals {
        goal: args
            .quality
            .quality
            .clone()
            .map(|quality| match quality {
                Quality::Named(levels) => Goal::Levels(levels),
                Quality::Share(share) => Goal::Share(share),
            })
            .or_else(|| args.likeness.goal()),
        schedule,
        baselines: if args.compare.baselines { Baseline::ALL.to_vec() } else { Vec::new() },
        ratio_study: args.compare.study.contains(&StudyArg::Ratio),
        lambda_study: args.compare.study.contains(&StudyArg::Lambda),
        train_on_validation: args.views.train_on_validation,
    };
    let names: Vec<String> = args.compare.others.iter().map(|(name, _)| name.clone()).collect();
    let is_own = args.views.images.is_none();
    goals.plan(settings.gate, is_own, &names, 1).map_err(refused)?;
    Ok(goals)
}

/// Exit code 2, in the words of the command line.
fn refused(invalid: Invalid) -> Failure {
    let what = match invalid {
        Invalid::Range { key, value, low, high } => {
            format!("{} {value}: must be {low} to {high}", flag(key))
        }
        Invalid::Kind { key, wanted } => format!("{}: {wanted}", flag(key)),
        Invalid::Rhos { .. } | Invalid::Share(_) => format!("--{invalid}"),
        Invalid::ShareOfPerfect => {
            "--quality: against its own renders the dense model is perfect, so a share of its PSNR \
             says nothing; give --quality-db, or --quality H, M or L"
                .into()
        }
        Invalid::Likeness => "--quality-db must be 1 to 120 dB, --quality-ssim 0 to 1".into(),
        Invalid::NameTaken(name) => {
            format!("--baseline {name}=…: the name is taken; use another")
        }
        Invalid::VariantName(variant) => {
            format!("--baseline {variant}-…: names that begin so belong to quality {variant}")
        }
        Invalid::Path => {
            "--path-frames: a path needs 1 to 100000 frames and at least two views".into()
        }
        Invalid::NoTestViews => {
            "--power-views test: the cameras of --power-cameras name no test views; give all or a \
             number"
                .into()
        }
        Invalid::LevelsAtOtherSize => {
            "--foveated: levels are for the size that they are trained at, so their power is \
             counted there; leave out --power-size, give --power-cameras of that size, or \
             give --size"
                .into()
        }
        Invalid::Screen(error) => format!("--screen, --pooling-rate: {error}"),
        Invalid::NoFovea(machine) => format!(
            "--foveated: the machine {machine} cannot show foveated frames (fovea.accumulators is \
             0); give --set fovea.accumulators=1 or 2, or another --arch"
        ),
        invalid @ (Invalid::OnlyRecorded { .. } | Invalid::Trains(_) | Invalid::Alone(_)) => {
            format!("--arch: {invalid}")
        }
        Invalid::NoLevels { machine, flow } => format!(
            "--foveated: the machine {machine} cannot show foveated frames: no machine with \
             `dataflow = \"{flow}\"` does; give another --arch (gscore)"
        ),
    };
    Failure::new(Exit::Usage, what)
}

/// The flag of a key of the library.
fn flag(key: &str) -> String {
    let setting = SETTINGS.iter().find(|setting| setting.key == key);
    let flag = setting.map_or_else(|| key.replace('_', "-"), |setting| setting.flag.to_owned());
    format!("--{flag}")
}

impl From<FoveationError> for Failure {
    fn from(error: FoveationError) -> Failure {
        match error {
            FoveationError::Invalid(invalid) => refused(invalid),
            FoveationError::Run(error) => error.into(),
        }
    }
}

impl From<CampaignError> for Failure {
    fn from(error: CampaignError) -> Failure {
        let exit = match error {
            CampaignError::Invalid(invalid) => return refused(invalid),
            CampaignError::Run(error) => return error.into(),
            CampaignError::Lpips { view, error } => {
                let what = format!("--lpips-weights: test view {view}: {error}");
                return Failure::new(Exit::BadInput, what);
            }
            CampaignError::NoDisplayPower => {
                let what = "--display-ratio: the dense model's images cost no display power";
                return Failure::new(Exit::BadInput, what);
            }
            CampaignError::NoRun | CampaignError::HoldsRun => Exit::Usage,
            CampaignError::NothingSeen | CampaignError::Tune { .. } => Exit::BadInput,
            CampaignError::Sim { .. } | CampaignError::Foveated(_) => Exit::Internal,
        };
        Failure { exit, error: error.into() }
    }
}
