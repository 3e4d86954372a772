//! Why a co-design ended early.

use powergs_core::run::RunError;
use powergs_optimize::tune::TuneError;

/// Why a co-design ended early.
#[derive(Debug, thiserror::Error)]
pub enum CodesignError {
    /// The space cannot be: a record that the machine cannot read, a budget without a number.
    #[error("{place}: {message}")]
    Space {
        /// The space file.
        place: String,
        /// What is wrong, and what to do.
        message: String,
    },
    /// Views that say nothing about views that nobody trained on.
    #[error(
        "{views} views: one view cannot train, decide and be reported at once; give at least 2, \
         with --cameras or --orbit"
    )]
    TooFewViews {
        /// How many there are.
        views: usize,
    },
    /// No model of the space reaches the quality.
    #[error("{0}")]
    OutOfReach(String),
    /// No pair keeps the budget.
    #[error("{0}")]
    Infeasible(String),
    /// Numbers that are not finite.
    #[error("model {model}: {error}")]
    Tune {
        /// The model.
        model: String,
        /// What happened.
        error: TuneError,
    },
    /// The store fails, a machine cannot run a frame, or something that cannot happen did.
    #[error(transparent)]
    Run(#[from] RunError),
}
