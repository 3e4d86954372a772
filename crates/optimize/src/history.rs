//! What happened in every iteration of a run.

use serde::{Deserialize, Serialize};

use super::outcome::Outcome;
use super::tune::Iteration;

/// An iteration of a job.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HistoryRow {
    /// Position of the job: jobs that were done before it.
    pub job: usize,
    /// What happened.
    pub iteration: Iteration,
}

/// The iterations of the jobs that `is_wanted`, in order.
pub fn rows_of<'a>(
    history: &'a [HistoryRow],
    outcomes: &'a [Outcome],
    is_wanted: impl Fn(&Outcome) -> bool + 'a,
) -> impl Iterator<Item = (&'a Outcome, &'a Iteration)> {
    let of_job = |row: &'a HistoryRow| Some((outcomes.get(row.job)?, &row.iteration));
    history.iter().filter_map(of_job).filter(move |(outcome, _)| is_wanted(outcome))
}
