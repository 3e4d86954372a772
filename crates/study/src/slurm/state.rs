//! What Slurm says about tasks, and what is to be done about each.

use std::collections::BTreeMap;
use std::fmt;

use super::script::SETUP_FAILED;

/// A job that `sbatch --parsable` has taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Submitted {
    /// Number of the array job.
    pub id: String,
    /// The cluster, if there are several.
    pub cluster: Option<String>,
}

/// Reads what `sbatch --parsable` prints: `123` or `123;cluster`. Other lines are notices of the
/// site. `None` if no line is a job.
pub fn submitted(text: &str) -> Option<Submitted> {
    text.lines().rev().find_map(|line| {
        let (id, cluster) = match line.trim().split_once(';') {
            Some((id, cluster)) => (id, Some(cluster.to_owned())),
            None => (line.trim(), None),
        };
        let number = !id.is_empty() && id.len() < 20 && id.bytes().all(|b| b.is_ascii_digit());
        let word = |c: &String| !c.is_empty() && c.chars().all(|c| c.is_ascii_graphic());
        let named = cluster.as_ref().is_none_or(word);
        (number && named).then(|| Submitted { id: id.to_owned(), cluster })
    })
}

/// The state of a task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum State {
    /// It waits, for this reason.
    Pending(String),
    /// It runs, or is about to end.
    Running,
    /// The script ended with 0.
    Completed,
    /// The script ended with another code, or was killed.
    Failed,
    /// Someone has cancelled it.
    Cancelled,
    /// It was taken away.
    Lost(Loss),
}

/// Why a task was lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Loss {
    /// Its node went down or did not start.
    Node,
    /// It used more memory than it had asked for.
    Memory,
    /// It ran longer than it had asked for.
    Time,
    /// Another job took its place.
    Preempted,
    /// The program, or its script, was killed: by this signal, if it is known.
    Killed(Option<u8>),
    /// A line of `setup`, or going to the folder, failed on the node.
    Setup,
    /// The program could not be started on the node.
    Start,
    /// The program refused (exit code 2): the folder is in use or cannot be written.
    Refused,
    /// Slurm does not know it any more and it left no exit code.
    Vanished,
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Loss::Node => write!(f, "its node failed"),
            Loss::Memory => write!(f, "out of memory (raise `mem` in [sbatch])"),
            Loss::Time => write!(f, "time limit (it continues; or raise `time` or `shards`)"),
            Loss::Preempted => write!(f, "preempted"),
            Loss::Killed(Some(signal)) => write!(f, "killed by signal {signal}"),
            Loss::Killed(None) => write!(f, "killed"),
            Loss::Setup => write!(f, "its folder or a line of `setup` failed on the node"),
            Loss::Start => write!(f, "the program could not be started on the node"),
            Loss::Refused => write!(f, "the program refused (exit code 2)"),
            Loss::Vanished => write!(f, "gone without an exit code"),
        }
    }
}

/// The states of tasks, from `squeue --format=%i|%T|%r` or `sacct --parsable2
/// --format=JobID,State`: part number to state. Lines about anything else are left out.
pub fn states(text: &str, job: &str) -> BTreeMap<u32, State> {
    let mut states = BTreeMap::new();
    for line in text.lines() {
        let mut fields = line.trim().split('|');
        let (Some(id), Some(word)) = (fields.next(), fields.next()) else { continue };
        let part = id.split_once('_').filter(|(j, _)| *j == job).map(|(_, part)| part);
        let Some(part) = part.and_then(|p| p.parse().ok()) else { continue };
        states.insert(part, state(word, fields.next().unwrap_or("")));
    }
    states
}

/// A state by its name. What is not known is taken as running: Slurm will say how it ends.
fn state(word: &str, reason: &str) -> State {
    // `sacct` writes `CANCELLED by 1000`, and a `+` behind names that it has cut.
    let word = word.split([' ', '+']).next().unwrap_or("");
    match word {
        "PENDING" | "CONFIGURING" | "REQUEUED" | "REQUEUE_HOLD" | "REQUEUE_FED"
        | "SPECIAL_EXIT" | "RESV_DEL_HOLD" => State::Pending(reason.to_owned()),
        "COMPLETED" => State::Completed,
        "FAILED" => State::Failed,
        "CANCELLED" | "REVOKED" => State::Cancelled,
        "NODE_FAIL" | "BOOT_FAIL" => State::Lost(Loss::Node),
        "OUT_OF_MEMORY" => State::Lost(Loss::Memory),
        "TIMEOUT" | "DEADLINE" => State::Lost(Loss::Time),
        "PREEMPTED" => State::Lost(Loss::Preempted),
        _ => State::Running,
    }
}

/// What is to be done about a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Wait: it is under way.
    Open,
    /// Nothing: it is complete.
    Done,
    /// Submit it again.
    Lost(Loss),
    /// Tell the user: the program ended with this exit code, and would do so again.
    Failed(u8),
    /// Tell the user: someone has cancelled it.
    Cancelled,
    /// Wait a little: it ended, but its exit code is not there yet (shared file systems lag).
    Unclear,
}

/// Judges a part by what Slurm says of its task (`None`: not listed) and by the exit code that the
/// script has noted.
pub fn judge(state: Option<&State>, exit: Option<u8>) -> Verdict {
    if exit == Some(0) {
        return Verdict::Done;
    }
    match state {
        Some(State::Pending(_) | State::Running) => Verdict::Open,
        Some(State::Completed) => Verdict::Done,
        Some(State::Cancelled) => Verdict::Cancelled,
        Some(State::Lost(loss)) => Verdict::Lost(*loss),
        Some(State::Failed) | None => exit.map_or(Verdict::Unclear, by_code),
    }
}

/// Judges a part that ended with `code`, which is not 0.
fn by_code(code: u8) -> Verdict {
    match code {
        2 => Verdict::Lost(Loss::Refused),
        SETUP_FAILED => Verdict::Lost(Loss::Setup),
        126 | 127 => Verdict::Lost(Loss::Start),
        129.. => Verdict::Lost(Loss::Killed(Some(code - 128))),
        _ => Verdict::Failed(code),
    }
}

/// What an unclear part is taken for when waiting did not help.
pub fn given_up(state: Option<&State>) -> Loss {
    match state {
        Some(State::Failed) => Loss::Killed(None),
        _ => Loss::Vanished,
    }
}
