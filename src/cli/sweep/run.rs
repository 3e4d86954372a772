//! `sweep FILE`: plans, works, and finishes.

use powergs_core::run::Frames;
use std::path::Path;

use super::args::SweepArgs;
use super::finish::{self, Finished};
use super::folder::{Existing, Shard, SweepFolder};
use super::meter::Meter;
use super::opened::{Opened, folder};
use super::plan::Plan;
use super::store::Store;
use super::work::{Sink, Work, run as work};
use super::{dry_run, search};
use crate::cli::invocation::Started;
use crate::cli::progress::Progress;
use crate::cli::{Context, Exit, Failure, out};

/// Runs the command.
pub fn run(args: &SweepArgs, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    let mut opened = Opened::open(&args.definition)?;
    if args.dry_run {
        return dry_run::run(&mut opened, args.memory, context);
    }
    let path = folder(args.out.as_deref(), &opened.name);
    let shard = args.shard.map_or(Shard::WHOLE, |s| s.0);
    if (args.shard.is_some() || args.slurm.is_some()) && opened.is_adaptive() {
        let what = "--shard: an adaptive search (sampling.method = \"nsga2\") runs in one process: \
                    every generation needs all results of the one before; leave --shard out, or \
                    take another method";
        return Err(Failure::new(Exit::Usage, what));
    }
    if let Some(file) = &args.slurm {
        return super::slurm::run(file, args, &opened, &path, context);
    }
    if args.resume && args.shard.is_none() && !path.join(super::state::FILE).exists() {
        let what = format!("{}: no sweep to resume; leave --resume out", path.display());
        return Err(Failure::new(Exit::Usage, what));
    }
    let existing = match (args.resume, args.force) {
        (true, _) => Existing::Resume,
        (_, true) => Existing::Replace,
        _ => Existing::Refuse,
    };
    let mut folder = SweepFolder::open(&path, &opened.state, existing, args.shard.map(|s| s.0))?;
    if let Some(finished) = Finished::read(&path, &opened.state) {
        return finish::say(&finished, &path, context);
    }
    folder.remember(&args.definition)?;
    note_damaged(&folder, &path);
    let mut store = Store::open(args.store.as_deref(), &opened.state, shard)?;
    let plan = if opened.is_adaptive() {
        search::run(&mut opened, &mut folder, &mut store, args.memory, context)?
    } else {
        let Some(plan) = plan(&opened, context) else { return Ok(interrupted(&path, args)) };
        let machines = plan.machines(shard);
        let meter = Meter::new(context, frames(&opened, machines.len()), &opened.objectives);
        let sink = Sink { folder: &mut folder, store: &mut store };
        let opened = &mut opened;
        let memory = args.memory;
        let done =
            work(Work { opened, plan: &plan, sink, memory, meter: &meter, context }, &machines)?;
        done.then_some(plan)
    };
    let Some(plan) = plan else { return Ok(interrupted(&path, args)) };
    if args.shard.is_some() {
        if !context.global.quiet {
            let Shard { number, of } = shard;
            let what = format!("part {number} of {of} is done; when all are: sweep merge");
            out::complain(format_args!("{what} {}", path.display()));
        }
        return Ok(Exit::Done);
    }
    finish::finish(&mut folder, &mut opened, &plan, started, context)
}

/// Walks the space.
pub fn plan(opened: &Opened, context: &Context) -> Option<Plan> {
    let selected = opened.space.selected();
    let progress = Progress::new(
        context,
        selected.size_hint().1.unwrap_or(usize::MAX) as u64,
        "designs looked at",
    );
    Plan::of(opened, selected, context, |n| progress.advance(n))
}

/// Frames of all machines on all traces.
pub fn frames(opened: &Opened, machines: usize) -> u64 {
    let frames: usize = opened.traces.iter().map(|t| t.source.range().len()).sum();
    frames as u64 * machines as u64
}

fn note_damaged(folder: &SweepFolder, path: &Path) {
    let damaged = folder.records.index.damaged;
    if damaged > 0 {
        let what = "cut off or damaged; they are simulated again";
        out::complain(format_args!("note: {}: {damaged} records are {what}", path.display()));
    }
}

fn interrupted(path: &Path, args: &SweepArgs) -> Exit {
    let flags = if args.shard.is_some() { "the same --shard" } else { "--resume" };
    let what = "interrupted; what is done is kept: run again with";
    out::complain(format_args!("{}: {what} {flags}", path.display()));
    Exit::Interrupted
}

/// A value that the user should see in an error.
pub fn usage(what: impl std::fmt::Display) -> Failure {
    Failure::new(Exit::Usage, what.to_string())
}
