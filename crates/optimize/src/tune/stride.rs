//! How much is pruned at a time while the target is reached.

use serde::{Deserialize, Serialize};

/// Checks that a model may need to recover from a prune; after more of them the next is half as
/// large.
const PATIENCE: u32 = 2;
/// After so many it does not recover from it.
const GIVE_UP: u32 = 20;
/// From so many on it is asked whether it will.
const ASK: u32 = 6;
/// The least that strides shrink to, relative to the longest.
const LEAST: f64 = 0.0625;
/// The longest, relative to the same, far above the target.
const MOST: f64 = 4.0;
/// Not far above the target is what is not above it by so many decibels for each longest stride.
const FAR_DB: f64 = 1.0;

/// The stride of a fine-tune that prunes whenever it passes: shorter where it takes long to recover
/// from the last one, longer again where it does not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stride {
    /// Relative to the longest.
    pub length: f64,
    /// Checks that missed since the last prune.
    waited: u32,
    /// What these found, distances from the target in decibels.
    found_db: [f64; GIVE_UP as usize],
    /// The distance from the target before it, decibels.
    before_db: f64,
    /// What a longest stride costs by what the first check after it found, decibels.
    cost_db: f64,
}

impl Stride {
    /// The first, as long as it is where recovering is neither quick nor slow.
    pub const FIRST: Stride = Stride {
        length: 1.0,
        waited: 1,
        found_db: [0.0; GIVE_UP as usize],
        before_db: 0.0,
        cost_db: f64::MAX,
    };

    /// A check missed the target, by so many decibels below 0.
    pub fn missed(&mut self, margin_db: f64) {
        self.observe(margin_db);
        if let Some(found_db) = self.found_db.get_mut(self.waited as usize) {
            *found_db = margin_db;
        }
        self.waited += 1;
    }

    fn observe(&mut self, margin_db: f64) {
        // Only the first check after a prune shows its price; later ones show the recovery.
        if self.waited == 0 {
            self.cost_db = (self.before_db - margin_db) / self.length;
        }
    }

    /// Whether the last prune seems too much. Quality rises with the logarithm of the iterations at
    /// most: what it gained since half of the checks it gains once more in twice as many.
    fn is_hopeless(&self) -> bool {
        let now = self.waited as usize;
        if self.waited < ASK || now > self.found_db.len() {
            return self.waited >= GIVE_UP;
        }
        // Two checks, because each looks at a few views.
        let mean = |end: usize| 0.5 * (self.found_db[end - 1] + self.found_db[end - 2]);
        let gained_db = mean(now) - mean(now / 2);
        mean(now) + gained_db.max(0.0) * (f64::from(GIVE_UP) / f64::from(self.waited)).log2() < 0.0
    }

    /// Whether the last prune was too much; if so the next is half as large.
    pub fn gives_up(&mut self) -> bool {
        let gives_up = self.waited >= GIVE_UP || self.is_hopeless();
        if gives_up {
            (self.length, self.waited) = ((self.length / 2.0).max(LEAST), 1);
        }
        gives_up
    }

    /// A check passed, so far above the target, in decibels: the length of the prune that follows.
    /// It is beyond the longest only so far that the target is not to be missed.
    pub fn passed(&mut self, margin_db: f64) -> f64 {
        self.observe(margin_db);
        let borne = margin_db / self.cost_db.max(FAR_DB);
        self.length = match self.waited {
            0 => 2.0 * self.length,
            waited if waited > PATIENCE => (self.length / 2.0).max(LEAST),
            _ => self.length,
        };
        self.length = self.length.min(borne.clamp(1.0, MOST));
        (self.waited, self.before_db) = (0, margin_db);
        self.length
    }
}
