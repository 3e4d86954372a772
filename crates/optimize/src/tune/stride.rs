//! How much is pruned at a time while the target is reached.

use serde::{Deserialize, Serialize};

/// Checks that a model may need to recover from a prune; after more of them the next is half as
/// large.
const PATIENCE: u32 = 2;
/// After so many it does not recover from it.
const GIVE_UP: u32 = 20;
/// The least that strides shrink to, relative to the longest.
pub const LEAST: f64 = 0.125;

/// The stride of a fine-tune that prunes whenever it passes: shorter where it takes long to recover
/// from the last one, longer again where it does not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stride {
    /// Relative to the longest.
    pub length: f64,
    /// Checks that missed since the last prune.
    waited: u32,
}

impl Stride {
    /// A first stride of this length, relative to the longest.
    pub const fn first(length: f64) -> Stride {
        // As long as it is where recovering is neither quick nor slow.
        Stride { length, waited: 1 }
    }

    /// A check missed the target.
    pub fn missed(&mut self) {
        self.waited += 1;
    }

    /// Whether the last prune was too much; if so the next is half as large.
    pub fn gives_up(&mut self) -> bool {
        let gives_up = self.waited >= GIVE_UP;
        if gives_up {
            (self.length, self.waited) = ((self.length / 2.0).max(LEAST), 1);
        }
        gives_up
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
