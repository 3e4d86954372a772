//! Which views are taken: a part of those of a file, a path through them, a circle around a scene.

use std::num::NonZeroUsize;
use std::ops::Range;

use glam::DVec3;
use powergs_base::format::counted;
use powergs_frame::scene::{Camera, Split, are_pairs};

use super::check::MAX_DISTANCE;
use super::edit;
use super::fov::FieldOfView;
use super::orbit::{Orbit, SceneBounds};
use super::path::Path;

/// Most views that are generated.
const MAX_VIEWS: usize = 1_000_000;
/// Image size of an orbit that does not say it, pixels.
const ORBIT_SIZE: (u32, u32) = (1920, 1080);

/// What is done to a list of views, in this order.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ViewSelection {
    /// Only views of this split.
    pub split: Option<Split>,
    /// Only every K-th view, starting with the first.
    pub every: Option<NonZeroUsize>,
    /// A smooth path of so many frames through the views.
    pub path_frames: Option<usize>,
    /// Only the views from the first position to the second, which is excluded; `None`: to the end.
    pub frames: Option<(usize, Option<usize>)>,
    /// Another image size, pixels; another aspect keeps the vertical field of view.
    pub size: Option<(u32, u32)>,
    /// Pairs of views so far apart, world units: `NAME_left`, `NAME_right`.
    pub stereo: Option<f64>,
    /// Another field of view; of a pair that of each eye.
    pub fov: Option<FieldOfView>,
}

/// Views that cannot be had. The message begins with what was asked for, named as its option.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ViewError(String);

fn wrong(what: impl Into<String>) -> ViewError {
    ViewError(what.into())
}

fn check_count(option: &str, n: usize) -> Result<(), ViewError> {
    if (1..=MAX_VIEWS).contains(&n) {
        return Ok(());
    }
    Err(wrong(format!("{option} {n}: must be 1 to {MAX_VIEWS}")))
}

impl ViewSelection {
    /// The views that are taken of `cameras`, and what whoever asked should know, one sentence
    /// each.
    ///
    /// # Errors
    /// [`ViewError`]: nothing would be left, or a number is out of its range.
    pub fn of(&self, mut cameras: Vec<Camera>) -> Result<(Vec<Camera>, Vec<String>), ViewError> {
        let mut warnings = Vec::new();
        if let Some(split) = self.split {
            cameras = in_split(cameras, split)?;
        }
        if let Some(every) = self.every {
            cameras = cameras.into_iter().step_by(every.get()).collect();
        }
        if let Some(n) = self.path_frames {
            check_count("path-frames", n)?;
            let what = "path-frames: a path needs at least two views, there is one; use --orbit";
            cameras = Path::through(&cameras).ok_or_else(|| wrong(what))?.frames(n);
        }
        if let Some((start, end)) = self.frames {
            let count = cameras.len();
            if start >= count {
                let what =
                    format!("frames {start}..: only {} there, from 0", counted(count, "view"));
                return Err(wrong(what));
            }
            if let Some(end) = end.filter(|end| *end > count) {
                warnings.push(format!(
                    "--frames {start}..{end}: only {} there",
                    counted(count, "view")
                ));
            }
            let range: Range<usize> = start..end.unwrap_or(count).min(count);
            cameras = cameras.drain(range).collect();
        }
        if let Some((width, height)) = self.size {
            cameras.iter_mut().for_each(|c| *c = edit::resized(c, width, height));
        }
        if let Some(distance) = self.stereo {
            if !(distance > 0.0 && distance <= MAX_DISTANCE) {
                return Err(wrong(format!("stereo {distance}: must be positive, world units")));
            }
            if let Some(camera) = cameras.iter().find(|c| c.eye.is_some()) {
                let name = &camera.name;
                return Err(wrong(format!("stereo {distance}: {name} is half of a pair already")));
            }
            cameras = cameras.iter().flat_map(|c| edit::stereo(c, distance)).collect();
        }
        if let Some(fov) = self.fov {
            cameras.iter_mut().for_each(|c| *c = fov.of(c));
        }
        if cameras.iter().any(|c| c.eye.is_some()) && !are_pairs(&cameras) {
            let what = "the views that are left of the file's pairs are no pairs: each counts as a \
                        frame of its own";
            warnings.push(what.into());
            cameras.iter_mut().for_each(|c| c.eye = None);
        }
        Ok((cameras, warnings))
    }
}

fn in_split(mut cameras: Vec<Camera>, split: Split) -> Result<Vec<Camera>, ViewError> {
    let name = split.name();
    if cameras.iter().all(|c| c.split.is_none()) {
        let what = "the camera file names no splits; use --every or --frames";
        return Err(wrong(format!("split {name}: {what}")));
    }
    let total = cameras.len();
    cameras.retain(|c| c.split == Some(split));
    if cameras.is_empty() {
        return Err(wrong(format!("split {name}: none of {} is in it", counted(total, "view"))));
    }
    Ok(cameras)
}

/// A circle of views around a scene; what is not given follows from the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitRequest {
    /// How many views.
    pub views: usize,
    /// Angle above the horizon, degrees; `None`: 20.
    pub elevation_deg: Option<f64>,
    /// Distance from the centre, world units; `None`: the scene fills the image.
    pub radius: Option<f64>,
    /// Vertical field of view, degrees; `None`: 50.
    pub fov_deg: Option<f64>,
    /// The axis that points up.
    pub up: DVec3,
    /// Image size, pixels; `None`: 1920x1080.
    pub size: Option<(u32, u32)>,
}

impl OrbitRequest {
    /// The views around a scene, whose bounds are asked for when everything else is right.
    ///
    /// # Errors
    /// [`ViewError`]: a number that is out of its range.
    pub fn cameras(&self, bounds: impl FnOnce() -> SceneBounds) -> Result<Vec<Camera>, ViewError> {
        let (views, up) = (self.views, self.up);
        check_count("orbit", views)?;
        let elevation = self.elevation_deg.unwrap_or(20.0);
        if elevation.is_nan() || elevation.abs() >= 90.0 {
            return Err(wrong("orbit-elevation: must be between -90 and 90 degrees"));
        }
        let fov = self.fov_deg.unwrap_or(50.0);
        if !(fov > 0.0 && fov < 170.0) {
            return Err(wrong("orbit-fov: must be above 0 and below 170 degrees"));
        }
        let SceneBounds { centre, extent } = bounds();
        let size = self.size.unwrap_or(ORBIT_SIZE);
        let (elevation, vertical_fov) = (elevation.to_radians(), fov.to_radians());
        let fitting = || Orbit::fitting_radius(extent, vertical_fov, size);
        let radius = self.radius.unwrap_or_else(fitting);
        if !(radius > 0.0 && radius + centre.length() <= MAX_DISTANCE) {
            return Err(wrong(format!("orbit-radius {radius}: must be positive, world units")));
        }
        Ok(Orbit { views, centre, radius, elevation, up, vertical_fov, size }.cameras())
    }
}
