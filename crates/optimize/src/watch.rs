//! What a campaign tells whoever started it.

use powergs_core::run::Watch;

use super::outcome::Outcome;
use super::times::Times;
use super::tune::Iteration;

/// Cancellation and progress of a campaign. All methods may be called from any thread.
pub trait CampaignWatch: Watch {
    /// The dense model is about to be rendered in so many views, as their reference.
    fn rendering(&self, views: u64) {
        let _ = views;
    }

    /// One of these views is rendered.
    fn rendered(&self) {}

    /// Work begins; all jobs together have at most so many iterations.
    fn planned(&self, iterations: u64) {
        let _ = iterations;
    }

    /// `n` more of these iterations are done, were done before, or are not needed.
    fn advanced(&self, n: u64) {
        let _ = n;
    }

    /// An iteration of a job: first all that were done before, then each as it is done.
    fn iteration(&self, job: &str, iteration: &Iteration) {
        let _ = (job, iteration);
    }

    /// A job is done.
    fn outcome(&self, outcome: &Outcome) {
        let _ = outcome;
    }

    /// Seconds of a clock that only goes on. Without one nobody is told where the time goes.
    fn seconds(&self) -> f64 {
        0.0
    }

    /// Where the time went, by that clock, of the jobs that were done since the run began or went
    /// on.
    fn took(&self, times: &Times) {
        let _ = times;
    }

    /// Something that people should know, one sentence.
    fn note(&self, text: &str) {
        let _ = text;
    }

    /// Something that is probably not meant, one sentence.
    fn warn(&self, text: &str) {
        let _ = text;
    }
}

impl CampaignWatch for () {}
