//! `--slurm`: submits the parts of a command as an array job, follows it, submits lost parts again,
//! and finishes.
//!
//! A part is one task, the command with `--shard I/N`, and is complete when that ends with exit
//! code 0. What must outlive this program is in `DIR/slurm`: the script, the number of the job, and
//! the logs and exit codes of the tasks. Ctrl-C leaves the job running; the same command follows it
//! again.

mod follow;
mod job;
mod tools;

use std::ffi::OsString;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{Context, Exit, Failure, OrExit, invocation, out};
use follow::{End, Follower};
use job::Job;
use powergs_base::config::document::TEXT_MAX;
use powergs_core::run::store::atomic::write_atomically;
use powergs_study::slurm::Settings;
use powergs_study::slurm::script::{self, Call};

/// The folder of jobs in that of the run.
pub const FOLDER: &str = "slurm";

/// A command whose parts are processes with `--shard`.
pub trait SlurmParts {
    /// Its word: `sweep`.
    const COMMAND: &'static str;

    /// What a part is called with after it, without `--out` and `--shard`.
    fn arguments(&self) -> Vec<OsString>;

    /// What the program is called with when all parts are done, `out` being the run folder: for
    /// those who submit the script by hand.
    fn finish(&self, out: &Path) -> Vec<OsString>;

    /// Makes the run folder ready for its parts.
    ///
    /// # Errors
    /// A folder of something else, or of another run.
    fn begin(&self, out: &Path) -> Result<(), Failure>;

    /// Puts the parts together: all are there.
    ///
    /// # Errors
    /// Those of the command.
    fn end(self, out: &Path) -> Result<Exit, Failure>;
}

/// What is asked of Slurm.
#[derive(Debug, Clone, Copy)]
pub struct Asked<'a> {
    /// `sbatch.toml`.
    pub settings: &'a Path,
    /// Whether the script is only to be written to standard output.
    pub print: bool,
}

/// What is submitted.
#[derive(Debug, Clone, Copy)]
struct Request<'a> {
    /// What each task is called with after the command, without `--out` and `--shard`.
    arguments: &'a [OsString],
    /// The run folder, absolute.
    out: &'a Path,
}

/// Submits `parts` of a run in the folder `out`, follows them and finishes; or only writes the
/// script to standard output.
///
/// # Errors
/// Settings that are wrong, no Slurm, a folder that belongs to another run, parts that failed or
/// were lost too often.
pub fn run<P: SlurmParts>(
    asked: Asked<'_>,
    parts: P,
    out: &Path,
    context: &Context,
) -> Result<Exit, Failure> {
    let settings = settings(asked.settings)?;
    let path = std::path::absolute(out);
    let path = path.or_exit(Exit::Usage, out.display())?;
    let arguments = parts.arguments();
    let request = Request { arguments: &arguments, out: &path };
    let text = script_of(&parts, &request, &settings)?;
    if asked.print {
        out::write(|w| w.write_all(&text))?;
        return Ok(Exit::Done);
    }
    parts.begin(&path)?;
    let mut job = Job::open(&request, &settings)?;
    write_atomically(&job.script(), |w| w.write_all(&text))?;
    match Follower::new(&mut job, &settings, context).run()? {
        End::Complete => parts.end(&path),
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

fn script_of<P: SlurmParts>(
    parts: &P,
    request: &Request<'_>,
    settings: &Settings,
) -> Result<Vec<u8>, Failure> {
    let program = invocation::program().or_exit(Exit::Usage, "the path of this program")?;
    let folder = std::env::current_dir().or_exit(Exit::Usage, "the working folder")?;
    let finish = parts.finish(request.out);
    fn bytes(words: &[OsString]) -> Vec<&[u8]> {
        words.iter().map(|word| word.as_encoded_bytes()).collect()
    }
    let call = Call {
        program: program.as_os_str().as_encoded_bytes(),
        command: P::COMMAND,
        arguments: bytes(request.arguments),
        finish: bytes(&finish),
        out: request.out.as_os_str().as_encoded_bytes(),
        folder: folder.as_os_str().as_encoded_bytes(),
    };
    script::script(settings, &call).or_exit(Exit::Usage, "--out")
}

/// A flag with its value as one word: a value that begins with a dash stays a value.
pub fn flag(name: &str, value: impl Into<OsString>) -> OsString {
    let mut word = OsString::from(format!("--{name}="));
    word.push(value.into());
    word
}

/// Says how to come back, and how to cancel.
fn leave(job: &Job) {
    let mut words = invocation::words();
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
