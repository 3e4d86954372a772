//! Views as models are judged in them: in the size whose watts are counted. Models may train in
//! another one, which takes less time, and what is left of a model between the pixels of a small
//! image shows in a large one.

use serde::{Deserialize, Serialize};

use super::views::{PowerCameras, Priced};
use powergs_scene::Camera;
use powergs_scene::camera::edit::resized;

/// Where views are judged with more pixels than they train with, this many gate and test at
/// most: each look at one takes as long as several iterations.
pub(crate) const MOST_JUDGED: usize = 24;

/// The sizes of what trains and of what is judged, with that of the power.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct JudgedSize {
    /// Width and height of the largest view that trains, pixels.
    pub trained: [u32; 2],
    /// Width and height of the largest view that gates or tests, pixels.
    pub judged: [u32; 2],
    /// Whether it gates and tests in the size that its power is counted at.
    pub is_priced: bool,
}

impl JudgedSize {
    /// What to know with the watts: where models train in another size than that in which their
    /// quality and power are, or where these two differ.
    pub fn note(&self) -> Option<String> {
        let text = |[width, height]: [u32; 2]| format!("{width}x{height}");
        match (self.is_priced, self.trained == self.judged) {
            (true, true) => None,
            (true, false) => Some(format!("trained at {}", text(self.trained))),
            (false, _) => Some(format!("quality at {}", text(self.judged))),
        }
    }
}

/// All views in the size that their power is counted at, in the order of `views`; `None` where that
/// is the size that they have.
pub(crate) fn in_priced_size(
    views: &[Camera],
    power: &PowerCameras,
    priced: &Priced,
) -> Option<Vec<Camera>> {
    match power {
        PowerCameras::Same => None,
        PowerCameras::Shown(shown) => {
            let is_other = |(shown, view): (&Camera, &Camera)| !has_size_of(shown, view);
            shown.iter().zip(views).any(is_other).then(|| shown.clone())
        }
        PowerCameras::Others(_) if power.have_sizes_of(views) => None,
        PowerCameras::Others(_) => {
            let [width, height] = priced.size;
            Some(views.iter().map(|view| resized(view, width, height)).collect())
        }
    }
}

/// Whether a view is as large as another.
pub(crate) fn has_size_of(one: &Camera, other: &Camera) -> bool {
    (one.width, one.height) == (other.width, other.height)
}
