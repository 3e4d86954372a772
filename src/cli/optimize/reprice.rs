//! `optimize --reprice RUN`: the models of a finished run on another machine, panel or display
//! rate. What the run was made from is what was typed then.

use super::super::power_views::PowerViewArgs;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use serde::Deserialize;

use super::super::invocation::Started;
use super::super::{Cli, Command, Context, Exit, Failure, OrExit, out};
use super::folder::{Folder, LAYOUT};
use super::watch::Watched;
use super::{OptimizeArgs, PowerArgs, finish, free, interrupted, opened, record, training};
use powergs_core::run::FileStore;

/// The part of `invocation.toml` that is needed.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Invocation {
    command: Vec<String>,
    working_folder: PathBuf,
}

/// Prices the models of the run in `from` as `args` say, and reports them in a folder of their own.
///
/// # Errors
/// Exit code 2: no run, or one that has to be run anew; 3: a damaged one, or inputs that changed.
pub fn run(
    from: &Path,
    args: &OptimizeArgs,
    started: Started,
    context: &Context,
) -> Result<Exit, Failure> {
    let typed = typed(from)?;
    let power = merged(&typed.power, &args.power, args.size);
    let typed = OptimizeArgs { power, ..typed };
    let trainer = args.power.train_on.as_deref().map(training::trainer).transpose()?;
    let watched = Watched::new(context, None);
    let mut campaign = opened(&typed, context, &watched)?;
    let path = args.run.out.clone().unwrap_or_else(|| {
        let path = PathBuf::from(format!("{}-repriced", from.display()));
        if args.run.resume { path } else { free(path) }
    });
    // Before --force empties anything.
    apart(from, &path)?;
    let source = FileStore::new(from);
    campaign.can_reprice(&source)?;
    let folder = Folder::new(&path, &LAYOUT);
    let _lock = folder.open(args.run.existing())?;
    let cameras = campaign.cameras.clone();
    let record = record::run_toml(&campaign)?;
    let run = campaign.reprice(&source, folder.store(), args.realise, &watched)?;
    watched.record(&path, &cameras)?;
    let finished = match run {
        Some(run) if args.realise => run.work(&watched)?,
        Some(run) => Some(run.priced()?),
        None => None,
    };
    watched.finish()?;
    folder.write("run.toml", record)?;
    folder.write("invocation.toml", started.invocation_toml())?;
    let Some(finished) = finished else { return Ok(interrupted(&path, context)) };
    if !args.realise && !context.global.quiet {
        out::complain(
            "note: no model was trained; --realise makes that of the new optimum as well, and up \
             to two samples around it",
        );
    }
    finish::finish(&campaign, &finished, &folder, trainer.as_ref(), context)
}

/// Refuses to report into the run that is read, or into a folder around it.
fn apart(from: &Path, out: &Path) -> Result<(), Failure> {
    // A folder that is not there yet is neither.
    let Ok(out) = fs::canonicalize(out) else { return Ok(()) };
    if fs::canonicalize(from).is_ok_and(|from| from.starts_with(&out)) {
        let what = format!(
            "--out {}: is the run that --reprice reads, or a folder around it; give --out another",
            out.display()
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok(())
}

/// The arguments that a run was started with; files are where they were then.
fn typed(from: &Path) -> Result<OptimizeArgs, Failure> {
    let place = from.join("invocation.toml");
    let name = place.display();
    let text = fs::read_to_string(&place).map_err(|e| {
        let what = format!("{name}: {e}; --reprice takes the folder of a finished run");
        Failure::new(Exit::Usage, what)
    })?;
    let invocation: Invocation = toml::from_str(&text).or_exit(Exit::BadInput, &name)?;
    let unknown = |why: &dyn std::fmt::Display| {
        let what = format!(
            "{name}: its command is none of this version: {why}; run it anew with this program"
        );
        Failure::new(Exit::BadInput, what)
    };
    let cli = Cli::try_parse_from(&invocation.command).map_err(|e| unknown(&first_line(&e)))?;
    let Command::Optimize(args) = cli.command else {
        return Err(unknown(&"it is not `optimize`"));
    };
    let mut args = *args;
    if let Some(first) = &args.reprice {
        let what = format!(
            "{}: was priced anew itself; give {}, where its models are from",
            from.display(),
            first.display()
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    root(&mut args, &invocation.working_folder);
    Ok(args)
}

fn first_line(error: &clap::Error) -> String {
    error.to_string().lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned()
}

/// Relative paths begin in the folder where they were typed.
fn root(args: &mut OptimizeArgs, folder: &Path) {
    let paths = [&mut args.dense.model, &mut args.views.images, &mut args.seen.cameras];
    let files = args.compare.others.iter_mut().map(|(_, file)| file);
    for path in paths.into_iter().flatten().chain(&mut args.lpips_weights).chain(files) {
        *path = folder.join(&*path);
    }
    // Names of machines, tables and panels are no files.
    let power = &mut args.power;
    if let Some(path) = &mut power.shown.power_cameras {
        *path = folder.join(&*path);
    }
    let names = [&mut power.arch, &mut power.energy, &mut power.display];
    for name in names.into_iter().flatten() {
        let path = folder.join(&*name);
        if path.is_file() {
            *name = path.to_string_lossy().into_owned();
        }
    }
}

/// What power is: as it is typed now, else as it was then. Another machine has none of the changes
/// of that one.
fn merged(then: &PowerArgs, now: &PowerArgs, size: Option<(u32, u32)>) -> PowerArgs {
    let views = match (now.power_views, now.path_frames) {
        (None, None) => (then.power_views, then.path_frames),
        given => given,
    };
    let is_other = now.arch.is_some();
    let kept = |sets: &[String]| if is_other { Vec::new() } else { sets.to_vec() };
    let mut sets = kept(&then.sets);
    sets.extend(now.sets.iter().cloned());
    PowerArgs {
        arch: now.arch.clone().or_else(|| then.arch.clone()),
        sets,
        energy: now.energy.clone().or_else(|| then.energy.clone().filter(|_| !is_other)),
        // Who names a machine wants it to count.
        oracle: now.oracle.or(if is_other { Some(CYCLE) } else { then.oracle }),
        display: now.display.clone().or_else(|| then.display.clone()),
        display_ratio: now.display_ratio.or(then.display_ratio),
        fps: now.fps.or(then.fps),
        // Models have the size that they were trained at; what is new is that of the price.
        shown: PowerViewArgs {
            power_size: now.shown.power_size.or(size).or(then.shown.power_size),
            power_cameras: now
                .shown
                .power_cameras
                .clone()
                .or_else(|| then.shown.power_cameras.clone()),
            power_stereo: now.shown.power_stereo.or(then.shown.power_stereo),
        },
        train_on: now.train_on.clone(),
        power_views: views.0,
        path_frames: views.1,
    }
}

/// What counts power on a machine that was named.
const CYCLE: super::super::replay::ModelArg = super::super::replay::ModelArg::Cycle;
