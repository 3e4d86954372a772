//! Slurm's commands.

use std::io;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::cli::{Exit, Failure};
use powergs_study::slurm::script::array;
use powergs_study::slurm::state::{Submitted, submitted};

/// Longest part of a message that is shown, characters.
const MESSAGE_MAX: usize = 2000;

/// Why a command gave no answer.
#[derive(Debug)]
pub enum Trouble {
    /// It is not installed.
    Absent(&'static str),
    /// It failed with this message: the cluster may be away for a while.
    Failed(String),
}

impl Trouble {
    /// The end of the program.
    pub fn failure(self) -> Failure {
        match self {
            Trouble::Absent(command) => Failure::new(
                Exit::Usage,
                format!(
                    "`{command}` was not found: run this on a machine with Slurm's commands, or \
                     use --print to write the script only"
                ),
            ),
            Trouble::Failed(message) => Failure::new(Exit::Usage, message),
        }
    }
}

fn run(name: &'static str, command: &mut Command) -> Result<Output, Trouble> {
    match command.stdin(Stdio::null()).output() {
        Ok(output) => Ok(output),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Err(Trouble::Absent(name)),
        Err(e) => Err(Trouble::Failed(format!("{name}: {e}"))),
    }
}

fn message(name: &str, output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    let text: String = text.trim().chars().take(MESSAGE_MAX).collect();
    if text.is_empty() { format!("{name}: {}", output.status) } else { format!("{name}: {text}") }
}

/// Submits `parts` of the script.
pub fn sbatch(script: &Path, parts: &[u32], at_once: Option<u32>) -> Result<Submitted, Trouble> {
    let mut command = Command::new("sbatch");
    command.arg("--parsable").arg(format!("--array={}", array(parts, at_once))).arg(script);
    let output = run("sbatch", &mut command)?;
    if !output.status.success() {
        let text = message("sbatch", &output);
        let hint = if text.contains("Invalid job array specification") {
            "\n  the cluster allows fewer tasks (`scontrol show config` has MaxArraySize): \
             use fewer `shards`"
        } else {
            ""
        };
        return Err(Trouble::Failed(format!("{text}{hint}")));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    submitted(&text).ok_or_else(|| {
        let shown: String = text.trim().chars().take(MESSAGE_MAX).collect();
        Trouble::Failed(format!("sbatch gave no job number but: {shown}"))
    })
}

/// What `squeue` lists of a job, ended tasks too; nothing if it has forgotten the job.
pub fn squeue(job: &Submitted) -> Result<String, Trouble> {
    let mut command = Command::new("squeue");
    command.args(["--noheader", "--array", "--states=all", "--format=%i|%T|%r"]);
    command.arg(format!("--jobs={}", job.id));
    command.args(job.cluster.as_ref().map(|c| format!("--clusters={c}")));
    let output = run("squeue", &mut command)?;
    if !output.status.success() {
        let text = message("squeue", &output);
        let forgotten = text.contains("Invalid job id");
        return if forgotten { Ok(String::new()) } else { Err(Trouble::Failed(text)) };
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// What the accounting knows of a job; nothing where there is none.
pub fn sacct(job: &Submitted) -> String {
    let mut command = Command::new("sacct");
    command.args(["--noheader", "--parsable2", "--allocations", "--format=JobID,State"]);
    command.arg(format!("--jobs={}", job.id));
    command.args(job.cluster.as_ref().map(|c| format!("--clusters={c}")));
    match run("sacct", &mut command) {
        Ok(output) if output.status.success() => {
            String::from_utf8_lossy(&output.stdout).into_owned()
        }
        Ok(_) | Err(_) => String::new(),
    }
}
