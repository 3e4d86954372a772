//! What a co-design tells whoever started it.

use powergs_optimize::tune::Iteration;
use powergs_study::sweep::run::SweepWatch;

use super::compare::Comparison;
use super::fit::Fitted;
use super::model::ModelPoint;

/// Cancellation and progress of a co-design. All methods may be called from any thread.
pub trait CodesignWatch: SweepWatch {
    /// All fine-tunes together have at most so many iterations.
    fn fitting(&self, models: usize, iterations: u64) {
        let _ = (models, iterations);
    }

    /// `n` more of these iterations are done, were done before, or are not needed.
    fn advanced(&self, n: u64) {
        let _ = n;
    }

    /// An iteration of the fine-tune of a model.
    fn iteration(&self, model: &ModelPoint, iteration: &Iteration) {
        let _ = (model, iteration);
    }

    /// A model is made, or was before.
    fn fitted(&self, model: &Fitted) {
        let _ = model;
    }

    /// The pairs of a model are about to be priced.
    fn pricing(&self, model: &ModelPoint, banked: bool) {
        let _ = (model, banked);
    }

    /// One of the five is confirmed.
    fn confirmed(&self, comparison: &Comparison) {
        let _ = comparison;
    }
}

impl CodesignWatch for () {}
