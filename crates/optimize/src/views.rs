//! Which views train, which gate, which test; and the order in which views train.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use serde::Serialize;

use super::invalid::Invalid;
use powergs_scene::camera::path::Path;
use powergs_scene::{Camera, Split};

/// Where a camera file names no split, one view in so many, by name, is a test view: the published
/// rule (`llffhold`).
const HELD_OUT: usize = 8;
/// With fewer training views than this the training views validate too.
const FEW: usize = 4;

/// Indices into the list of views. Every list holds at least one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ViewSplit {
    /// Seen in training.
    pub train: Vec<usize>,
    /// Taken from the training views: they gate the quality and steer λ.
    pub validation: Vec<usize>,
    /// Reported, never used for a decision (unless asked for).
    pub test: Vec<usize>,
    /// What the user should know, one sentence each.
    pub notes: Vec<String>,
}

/// Splits `cameras` (at least one). Test views are those that the file calls so, else every eighth
/// in the order of names. Of the others every `every`-th, beginning in the middle of the first
/// group, validates; 0 means as many as there are test views, but at most a quarter.
pub fn split(cameras: &[Camera], every: usize) -> ViewSplit {
    assert!(!cameras.is_empty(), "a split needs a view");
    let mut notes = Vec::new();
    let named = cameras.iter().any(|c| c.split == Some(Split::Test));
    let mut order: Vec<usize> = (0..cameras.len()).collect();
    order.sort_by(|&a, &b| cameras[a].name.cmp(&cameras[b].name).then(a.cmp(&b)));
    let is_test = |position: usize, view: usize| {
        if named {
            cameras[view].split == Some(Split::Test)
        } else {
            position.is_multiple_of(HELD_OUT)
        }
    };
    let (mut test, mut rest) = (Vec::new(), Vec::new());
    for (position, &view) in order.iter().enumerate() {
        if is_test(position, view) { test.push(view) } else { rest.push(view) }
    }
    if rest.is_empty() {
        notes.push("no view is left for training: the test views train and validate too".into());
        rest.clone_from(&test);
    }
    if test.is_empty() {
        notes.push("no test views: the training views are reported".into());
        test.clone_from(&rest);
    }
    let every = if every == 0 { rest.len().div_ceil(test.len()).max(4) } else { every };
    let (mut train, mut validation) = (Vec::new(), Vec::new());
    if rest.len() < FEW || every < 2 {
        notes.push(format!("the {} training views validate too", rest.len()));
        (train, validation) = (rest.clone(), rest);
    } else {
        for (position, &view) in rest.iter().enumerate() {
            let validates = position % every == (every / 2).min(rest.len() - 1);
            if validates { validation.push(view) } else { train.push(view) }
        }
        if validation.is_empty() {
            validation.push(train.remove(rest.len() / 2));
        }
    }
    for list in [&mut train, &mut validation, &mut test] {
        list.sort_unstable();
    }
    ViewSplit { train, validation, test, notes }
}

impl ViewSplit {
    /// Lets the validation views train too. A model that was trained on them could not keep its
    /// quality there without them, whatever power is spent.
    pub fn validation_trains(mut self) -> ViewSplit {
        self.train.extend(&self.validation);
        self.train.sort_unstable();
        self.train.dedup();
        self
    }
}

/// Most frames of a path.
const PATH_MOST: usize = 100_000;

/// The views that power is a mean over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PowerViews {
    /// All views.
    All,
    /// The test views, as the published code does.
    Test,
    /// So many frames of a smooth path through the views.
    Path(usize),
}

impl PowerViews {
    /// The cameras.
    ///
    /// # Errors
    /// [`Invalid::Path`]: a path without frames, or through a single view.
    pub(crate) fn of(self, cameras: &[Camera], split: &ViewSplit) -> Result<Vec<Camera>, Invalid> {
        match self {
            PowerViews::All => Ok(cameras.to_vec()),
            PowerViews::Test => Ok(split.test.iter().map(|&v| cameras[v].clone()).collect()),
            PowerViews::Path(frames) => Path::through(cameras)
                .filter(|_| (1..=PATH_MOST).contains(&frames))
                .map(|path| path.frames(frames))
                .ok_or(Invalid::Path),
        }
    }
}

/// The training view of an iteration: every epoch is another permutation of all views. The result
/// depends on nothing but the arguments, so a run can be continued anywhere.
#[derive(Debug, Clone)]
pub struct ViewOrder {
    seed: u64,
    count: usize,
    epoch: Option<u64>,
    permutation: Vec<usize>,
}

impl ViewOrder {
    /// An order of `count` views, at least one.
    pub fn new(seed: u64, count: usize) -> ViewOrder {
        assert!(count > 0, "an order needs a view");
        ViewOrder { seed, count, epoch: None, permutation: Vec::new() }
    }

    /// The position, below `count`, of the view that trains at `iteration`.
    pub fn at(&mut self, iteration: u64) -> usize {
        let epoch = iteration / self.count as u64;
        if self.epoch != Some(epoch) {
            self.shuffle(epoch);
        }
        self.permutation[(iteration % self.count as u64) as usize]
    }

    fn shuffle(&mut self, epoch: u64) {
        let stream = epoch.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed ^ stream);
        self.permutation = (0..self.count).collect();
        for last in (1..self.count).rev() {
            let other = rng.random_range(0..=last as u64) as usize;
            self.permutation.swap(last, other);
        }
        self.epoch = Some(epoch);
    }
}
