//! Where the time of a campaign goes.

/// Where the time of a campaign goes, seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Times {
    /// Iterations.
    pub iterations_s: f64,
    /// Checks of the quality.
    pub checks_s: f64,
    /// Scores for pruning.
    pub scores_s: f64,
    /// What is measured of finished models.
    pub models_s: f64,
}

impl Times {
    /// Adds those of further work.
    pub(crate) fn add(&mut self, other: Times) {
        self.iterations_s += other.iterations_s;
        self.checks_s += other.checks_s;
        self.scores_s += other.scores_s;
        self.models_s += other.models_s;
    }

    /// All of it.
    pub fn total_s(&self) -> f64 {
        self.iterations_s + self.checks_s + self.scores_s + self.models_s
    }
}
