//! `sweep FILE`: plans, works, and finishes.

use std::path::{Path, PathBuf};

use super::args::SweepArgs;
use super::confirm::{self, SweepConfirm};
use super::meter::Meter;
use super::slurm::SweepParts;
use super::{dry_run, finish};
use crate::cli::invocation::Started;
use crate::cli::slurm::{self, Asked};
use crate::cli::{Context, Exit, Failure, inputs, out};
use powergs_base::format::counted;
use powergs_core::run::{FileStore, Store};
use powergs_study::sweep::run::finish::Finished;
use powergs_study::sweep::run::search::search;
use powergs_study::sweep::run::state;
use powergs_study::sweep::run::{
    OpenedSweep, Plan, ResultSink, Shard, SharedResults, StandIn, SweepFolder, SweepWatch, work,
};

/// Runs the command.
pub fn run(args: &SweepArgs, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    let mut request = args.definition.request();
    if args.confirm == Some(0) {
        request.stand_in = StandIn::Always;
    }
    let mut sweep = OpenedSweep::open(&request)?;
    let memory = allowed(&mut sweep, context);
    for trace in sweep.traces.iter().filter(|t| t.looks_paired && !context.global.quiet) {
        out::complain(inputs::unpaired(&trace.label.label));
    }
    for doubt in sweep.designs.doubts().into_iter().filter(|_| !context.global.quiet) {
        out::complain(format_args!("warning: {doubt}"));
    }
    if args.shard.is_some() && args.confirm.is_some() {
        let what = "--confirm: a part of a sweep has no front; give it to `sweep merge`";
        return Err(Failure::new(Exit::Usage, what));
    }
    let most = confirm::most(args.confirm, &sweep);
    if args.dry_run {
        return dry_run::run(&mut sweep, most, memory, context);
    }
    let path = folder(args.run.out.as_deref(), &sweep.name);
    let store = FileStore::new(&path);
    let shard = args.shard.map_or(Shard::WHOLE, |s| s.0);
    if (args.shard.is_some() || args.slurm.is_some()) && sweep.designs.is_adaptive() {
        let what = "--shard: an adaptive search (sampling.method = \"nsga2\") runs in one process: \
                    every generation needs all results of the one before; leave --shard out, or \
                    take another method";
        return Err(Failure::new(Exit::Usage, what));
    }
    if let Some(file) = &args.slurm {
        let asked = Asked { settings: file, print: args.print };
        let parts = SweepParts { args, sweep: &sweep, context };
        return slurm::run(asked, parts, &path, context);
    }
    if args.run.resume && args.shard.is_none() && !path.join(state::FILE).exists() {
        let what = format!("{}: no sweep to resume; leave --resume out", path.display());
        return Err(Failure::new(Exit::Usage, what));
    }
    let part = args.shard.map(|s| s.0);
    let mut folder = SweepFolder::open(&store, &sweep.state, args.run.existing(), part)?;
    let finished = Finished::read(&store, &sweep.state);
    let finished = finished.filter(|finished| finish::is_whole(finished, most, &path));
    if let Some(finished) = finished {
        return finish::again(&finished, &path, context);
    }
    request.remember(&store)?;
    sweep.hand_out.iter().try_for_each(|hand_out| hand_out.keep(&store))?;
    let meter = Meter::new(context);
    let damaged = folder.records.damaged();
    if damaged > 0 {
        let what = "cut off or damaged; they are simulated again";
        meter.note(&format!("{}: {}: {what}", store.place(""), counted(damaged, "record")));
    }
    let mut shared = match &args.store {
        Some(path) => SharedResults::open(&FileStore::new(path), &sweep.state, shard, &meter)?,
        None => SharedResults::default(),
    };
    let plan = if sweep.designs.is_adaptive() {
        search(&mut sweep, &mut folder, &mut shared, memory, &meter)?
    } else {
        let Some(plan) = Plan::new(&sweep.designs, &meter) else {
            return Ok(interrupted(&path, args));
        };
        let machines = plan.machines(shard);
        let sink = ResultSink { folder: &mut folder, shared: &mut shared };
        let done = work(&mut sweep, &plan, &machines, sink, memory, &meter)?;
        done.then_some(plan)
    };
    meter.clear();
    let Some(plan) = plan else { return Ok(interrupted(&path, args)) };
    if args.shard.is_some() {
        if !context.global.quiet {
            let Shard { number, of } = shard;
            let what = format!("part {number} of {of} is done; when all are: sweep merge");
            out::complain(format_args!("{what} {}", path.display()));
        }
        return Ok(Exit::Done);
    }
    let confirm = SweepConfirm { most, shared: &mut shared, memory };
    finish::finish(&mut folder, &path, &mut sweep, &plan, confirm, started, context)
}

/// Memory for binned frames, bytes, which is also that of each of them.
pub fn allowed(sweep: &mut OpenedSweep<'_>, context: &Context) -> usize {
    sweep.allow(context.global.memory);
    usize::try_from(context.global.memory.0.0).unwrap_or(usize::MAX)
}

fn interrupted(path: &Path, args: &SweepArgs) -> Exit {
    let flags = if args.shard.is_some() { "the same --shard" } else { "--resume" };
    let what = "interrupted; what is done is kept: run again with";
    out::complain(format_args!("{}: {what} {flags}", path.display()));
    Exit::Interrupted
}

/// The default folder of a sweep.
fn folder(out: Option<&Path>, name: &str) -> PathBuf {
    out.map_or_else(|| Path::new("reports").join(name), Path::to_path_buf)
}
