//! `sweep --slurm`: submits a sweep as an array job, follows it, submits lost parts again, merges.
//!
//! What must outlive this program is in `DIR/slurm`: the script, the number of the job, and the
//! logs and exit codes of the tasks. Ctrl-C leaves the job running; the same command follows it
//! again.

mod arguments;
mod follow;
mod job;
mod tools;

use std::ffi::OsString;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::args::{MergeArgs, SweepArgs};
use super::parts;
use crate::cli::{Context, Exit, Failure, OrExit, out};
use follow::{End, Follower};
use job::Job;
use powergs_base::config::document::TEXT_MAX;
use powergs_core::run::FileStore;
use powergs_core::run::store::atomic::write_atomically;
use powergs_study::sweep::run::{Existing, OpenedSweep, folder};
use powergs_study::sweep::slurm::Settings;
use powergs_study::sweep::slurm::script::{self, Call};

/// What is submitted.
#[derive(Debug, Clone, Copy)]
struct Request<'a> {
    /// What each task is called with after `sweep`, without `--out` and `--shard`.
    arguments: &'a [OsString],
    /// The output folder.
    out: &'a Path,
}

/// Submits a sweep as `file` (`sbatch.toml`) says, follows it and merges its parts; with `--print`
/// only writes the script to standard output.
///
/// # Errors
/// Settings that are wrong, no Slurm, a folder that belongs to another sweep, parts that failed or
/// were lost too often.
pub fn run(
    file: &Path,
    args: &SweepArgs,
    sweep: &OpenedSweep<'_>,
    out: &Path,
    context: &Context,
) -> Result<Exit, Failure> {
    let settings = settings(file)?;
    let path = std::path::absolute(out);
    let path = path.or_exit(Exit::Usage, out.display())?;
    let arguments = arguments::of(args, context.global.memory);
    let request = Request { arguments: &arguments, out: &path };
    let text = script_of(&request, &settings)?;
    if args.print {
        out::write(|w| w.write_all(&text))?;
        return Ok(Exit::Done);
    }
    let existing = if args.resume { Existing::Resume } else { Existing::Refuse };
    folder::begin(&FileStore::new(&path), &sweep.state, existing)?;
    let mut job = Job::open(&request, &settings)?;
    write_atomically(&job.script(), |w| w.write_all(&text))?;
    match Follower::new(&mut job, &settings, context).run()? {
        End::Complete => parts::merge(
            &MergeArgs {
                folder: path,
                from: Vec::new(),
                confirm: args.confirm,
                charts: args.charts.clone(),
            },
            context,
        ),
        End::Left => {
            leave(&job);
            Ok(Exit::Interrupted)
        }
        End::Incomplete(failure) => Err(failure),
    }
}

fn settings(path: &Path) -> Result<Settings, Failure> {
    let file = File::open(path).or_exit(Exit::Usage, path.display())?;
    let mut text = String::new();
    let mut limited = file.take(TEXT_MAX as u64 + 1);
    limited.read_to_string(&mut text).or_exit(Exit::Usage, path.display())?;
    Settings::parse(&text).or_exit(Exit::Usage, path.display())
}

fn script_of(request: &Request<'_>, settings: &Settings) -> Result<Vec<u8>, Failure> {
    let program = std::env::current_exe().or_exit(Exit::Usage, "the path of this program")?;
    let folder = std::env::current_dir().or_exit(Exit::Usage, "the working folder")?;
    let call = Call {
        program: program.as_os_str().as_encoded_bytes(),
        arguments: request.arguments.iter().map(|a| a.as_encoded_bytes()).collect(),
        out: request.out.as_os_str().as_encoded_bytes(),
        folder: folder.as_os_str().as_encoded_bytes(),
    };
    script::script(settings, &call).or_exit(Exit::Usage, "--out")
}

/// Says how to come back, and how to cancel.
fn leave(job: &Job) {
    let mut words: Vec<OsString> = std::env::args_os().collect();
    if !words.iter().any(|word| word == "--resume") {
        words.push("--resume".into());
    }
    let line: Vec<String> = words
        .iter()
        .map(|w| String::from_utf8_lossy(&script::quoted(w.as_encoded_bytes())).into_owned())
        .collect();
    let numbers = job.live().collect::<Vec<_>>().join(" ");
    out::complain(format_args!(
        "the job keeps running\n  to follow it again: {}\n  to cancel it:       scancel {numbers}",
        line.join(" ")
    ));
}
