//! Which views train, which gate, which test, which power is counted over; and the order in which
//! views train.

use std::collections::BTreeMap;
use std::fmt;
use std::num::NonZeroUsize;
use std::ops::Range;

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use serde::{Deserialize, Serialize};

use super::invalid::Invalid;
use powergs_core::run::frames::eyes;
use powergs_frame::scene::are_pairs;
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
    /// The last so many that validate were made for this between the views of the user.
    pub made: usize,
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
    ViewSplit { train, validation, test, made: 0, notes }
}

impl ViewSplit {
    /// Lets views that were made for it, whose positions follow those of all others, validate too.
    pub(crate) fn also_validate(&mut self, made: Range<usize>) {
        self.made += made.len();
        self.validation.extend(made);
    }

    /// Lets at most `most` views gate and as many test, evenly spaced in their order. Those that
    /// are left out do nothing.
    pub(crate) fn sample(&mut self, most: usize) {
        for list in [&mut self.validation, &mut self.test] {
            let (n, taken) = (list.len(), list.len().min(most));
            *list = (0..taken).map(|i| list[i * n / taken]).collect();
        }
    }

    /// Lets other views gate and test in the place of those that `by` names.
    pub(crate) fn judge_by(&mut self, by: &BTreeMap<usize, usize>) {
        for view in self.validation.iter_mut().chain(&mut self.test) {
            *view = by.get(view).copied().unwrap_or(*view);
        }
    }

    /// Lets the validation views train too. A model that was trained on them could not keep its
    /// quality there without them, whatever power is spent.
    pub fn validation_trains(mut self) -> ViewSplit {
        self.train.extend(&self.validation);
        self.train.sort_unstable();
        self.train.dedup();
        self
    }
}

/// How far views are from the nearest one that trains, world units, medians. Models are best where
/// they train: of two that gate and test, those farther away come out lower.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainingDistance {
    /// Of the views that were made to gate.
    pub made: f64,
    /// Of the test views.
    pub test: f64,
}

impl TrainingDistance {
    /// Of a split of `cameras`; `None` where no views were made.
    pub(crate) fn of(cameras: &[Camera], split: &ViewSplit) -> Option<TrainingDistance> {
        let made = &split.validation[split.validation.len() - split.made..];
        let nearest = |view: &usize| {
            let here = cameras[*view].centre;
            let far = split.train.iter().map(|train| here.distance(cameras[*train].centre));
            far.fold(f64::INFINITY, f64::min)
        };
        let median = |views: &[usize]| {
            let mut far: Vec<f64> = views.iter().map(nearest).collect();
            far.sort_by(f64::total_cmp);
            far.get(far.len() / 2).copied()
        };
        Some(TrainingDistance { made: median(made)?, test: median(&split.test)? })
    }
}

/// Most frames of a path.
const PATH_MOST: usize = 100_000;
/// Where views are shown with more pixels than they train with, power is a mean over so many of
/// them where nobody says otherwise: frames of full size take long to simulate, and models are
/// compared over the same ones.
const USUAL: usize = 16;

/// The cameras that power is counted with.
#[derive(Debug, Clone, PartialEq)]
pub enum PowerCameras {
    /// The views of the run, as models are compared in them.
    Same,
    /// The views of the run as they are shown, at another size: one for each, in their order.
    Shown(Vec<Camera>),
    /// Other views of the scene.
    Others(Vec<Camera>),
}

impl PowerCameras {
    /// Whether each is as large as one of `views`.
    pub(crate) fn have_sizes_of(&self, views: &[Camera]) -> bool {
        let size = |c: &Camera| [c.width, c.height];
        match self {
            PowerCameras::Same => true,
            PowerCameras::Shown(cameras) | PowerCameras::Others(cameras) => {
                cameras.iter().all(|c| views.iter().any(|view| size(view) == size(c)))
            }
        }
    }
}

/// Which of its cameras power is a mean over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PowerViews {
    /// All views, or where they are shown with more pixels than they train with, at most 16 of
    /// them.
    Usual,
    /// All views.
    All,
    /// The test views, as the published code does; of other cameras those that their file calls
    /// so.
    Test,
    /// So many, evenly spaced in their order.
    Spread(NonZeroUsize),
    /// So many frames of a smooth path through the views.
    Path(usize),
}

impl PowerViews {
    /// The cameras, and what they are.
    ///
    /// # Errors
    /// [`Invalid`]: a path without frames, or through a single view; no test views among other
    /// cameras.
    pub(crate) fn of(
        self,
        views: &[Camera],
        split: &ViewSplit,
        shown: &PowerCameras,
        photos: Option<[u32; 2]>,
    ) -> Result<(Vec<Camera>, Priced), Invalid> {
        let all = match shown {
            PowerCameras::Same => views,
            PowerCameras::Shown(cameras) | PowerCameras::Others(cameras) => cameras,
        };
        // A frame of the display is a pair where views are the eyes of pairs.
        let eyes = eyes(all);
        let frames = all.len() / eyes;
        let spread = |n: usize| {
            let n = n.min(frames);
            let frame = |i: usize| &all[i * frames / n * eyes..][..eyes];
            (0..n).flat_map(|i| frame(i).to_vec()).collect::<Vec<Camera>>()
        };
        let mut taken = match self {
            PowerViews::Usual if pixels(all) > pixels(views) => spread(USUAL),
            PowerViews::Usual | PowerViews::All => all.to_vec(),
            PowerViews::Spread(n) => spread(n.get()),
            PowerViews::Test => match shown {
                PowerCameras::Others(cameras) => {
                    let is_test = |c: &&Camera| c.split == Some(Split::Test);
                    cameras.iter().filter(is_test).cloned().collect()
                }
                PowerCameras::Same | PowerCameras::Shown(_) => {
                    split.test.iter().map(|&v| all[v].clone()).collect()
                }
            },
            PowerViews::Path(frames) => Path::through(all)
                .filter(|_| (1..=PATH_MOST).contains(&frames))
                .map(|path| path.frames(frames))
                .ok_or(Invalid::Path)?,
        };
        // What was taken from pairs, and is none any more, counts view by view.
        if !are_pairs(&taken) {
            taken.iter_mut().for_each(|camera| camera.eye = None);
        }
        let eyes = if are_pairs(&taken) { eyes } else { 1 };
        let largest = taken.iter().max_by_key(|c| area(c)).ok_or(Invalid::NoTestViews)?;
        let size = [largest.width, largest.height];
        let priced = Priced {
            views: taken.len() / eyes,
            of: all.len() / eyes,
            eyes,
            is_path: matches!(self, PowerViews::Path(_)),
            is_other: matches!(shown, PowerCameras::Others(_)),
            size,
            is_mixed: taken.iter().any(|c| [c.width, c.height] != size),
            photos: photos.filter(|[w, h]| u64::from(*w) * u64::from(*h) > area(largest)),
        };
        Ok((taken, priced))
    }
}

/// Pixels of a view.
pub(crate) fn area(camera: &Camera) -> u64 {
    u64::from(camera.width) * u64::from(camera.height)
}

/// Pixels of the largest view.
pub(crate) fn pixels(cameras: &[Camera]) -> u64 {
    cameras.iter().map(area).max().unwrap_or(0)
}

/// Width and height of the largest view, pixels.
pub(crate) fn largest(cameras: &[Camera]) -> [u32; 2] {
    let largest = cameras.iter().max_by_key(|camera| area(camera));
    largest.map_or([0; 2], |camera| [camera.width, camera.height])
}

fn one() -> usize {
    1
}

/// The published extent of cameras, world units: 1.1 times the largest distance from their mean.
pub(crate) fn extent(centres: impl ExactSizeIterator<Item = DVec3> + Clone) -> f64 {
    let n = centres.len().max(1) as f64;
    let mean = centres.clone().sum::<DVec3>() / n;
    let farthest = centres.map(|c| c.distance(mean)).fold(0.0, f64::max);
    // A single camera has no extent; 1 is as good as any other.
    if farthest > 0.0 { 1.1 * farthest } else { 1.0 }
}

/// What power was counted over. Written, it stands beside watts: `16 of 50 views of 540x960`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Priced {
    /// Views that power is a mean over.
    pub views: usize,
    /// Views that there were to choose from.
    pub of: usize,
    /// Eyes of each: 2 where they are pairs, and watts are those of both eyes and both panels.
    #[serde(default = "one")]
    pub eyes: usize,
    /// Whether they are frames of a path through them.
    pub is_path: bool,
    /// Whether they are other views than those that models are compared in.
    pub is_other: bool,
    /// Width and height of the largest, pixels.
    pub size: [u32; 2],
    /// Whether some are smaller.
    pub is_mixed: bool,
    /// Width and height of the photos or of the camera file, pixels, where they are larger.
    pub photos: Option<[u32; 2]>,
}

impl Priced {
    /// `540x960`.
    pub fn size_text(&self) -> String {
        let [width, height] = self.size;
        let eyes = if self.eyes > 1 { format!("{} x ", self.eyes) } else { String::new() };
        format!("{eyes}{}{width}x{height}", if self.is_mixed { "up to " } else { "" })
    }

    /// What to know where the watts are those of smaller images than the photos.
    pub fn note(&self) -> Option<String> {
        let [width, height] = self.photos?;
        Some(format!(
            "power was counted at {}, below the {width}x{height} of the cameras: at full size \
             rendering is a larger part of it, and more pruning pays. Give the size that is shown \
             (--power-size; with --foveated --size)",
            self.size_text()
        ))
    }
}

impl fmt::Display for Priced {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Priced { views, of, .. } = *self;
        let size = self.size_text();
        // Pairs are others anyhow: models are compared in single views.
        let other = if self.is_other && self.eyes == 1 { "other " } else { "" };
        let view = if self.eyes > 1 { "pair" } else { "view" };
        let s = if of == 1 { "" } else { "s" };
        match (self.is_path, views == of) {
            (true, _) => write!(f, "{views} frames of a path of {size}"),
            (false, true) => write!(f, "{views} {other}{view}{s} of {size}"),
            (false, false) => write!(f, "{views} of {of} {other}{view}{s} of {size}"),
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
        // An odd factor spreads the bits of small numbers, so that the orders of epochs are unlike.
        let stream = epoch.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed ^ stream);
        self.permutation = (0..self.count).collect();
        for last in (1..self.count).rev() {
            // Drawn as `u64`, so that machines of any word size draw the same.
            let other = rng.random_range(0..=last as u64) as usize;
            self.permutation.swap(last, other);
        }
        self.epoch = Some(epoch);
    }
}
