//! How much is pruned at a time while the target is reached.

use serde::{Deserialize, Serialize};

/// Checks that a model may need to recover from a prune; after more of them the next is half as
/// large.
const PATIENCE: u32 = 2;
/// The least that strides shrink to, relative to the first.
const LEAST: f64 = 0.125;

/// The stride of a fine-tune that prunes whenever it passes: shorter where it takes long to recover
/// from the last one, longer again where it does not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stride {
    /// Relative to the first.
    pub length: f64,
    /// Checks that missed since the last prune.
    waited: u32,
}

impl Stride {
    /// The first.
    pub const FIRST: Stride = Stride { length: 1.0, waited: 0 };

    /// A check missed the target.
    pub fn missed(&mut self) {
        self.waited += 1;
    }

    /// A check passed: the length of the prune that follows.
    pub fn passed(&mut self) -> f64 {
        self.length = match self.waited {
            0 => (2.0 * self.length).min(1.0),
            waited if waited > PATIENCE => (self.length / 2.0).max(LEAST),
            _ => self.length,
        };
        self.waited = 0;
        self.length
    }
}
