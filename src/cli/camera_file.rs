//! The camera flags that commands share.
//!
//! The order of operations is fixed: read (or orbit), `--split`, `--every`, `--path-frames`,
//! `--frames`, `--size`, `--stereo`, `--fov`.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::{Context, Exit, Failure, out};
use powergs_scene::camera::check::MAX_SIZE;
use powergs_scene::camera::fov::{FieldOfView, Headset, headset};
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::camera::views::{OrbitRequest, ViewError, ViewSelection};
use powergs_scene::camera::{CameraFile, Frame, Lens};
use powergs_scene::files::open_cameras;
use powergs_scene::{Camera, Split};

/// Which frames of a trace, or views of a camera file, there are.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct FrameArgs {
    /// Only frames A to B, B excluded, counted from 0: 0..24, 10.., ..5
    #[arg(long, value_name = "A..B", value_parser = frame_range)]
    pub frames: Option<FrameRange>,
}

/// Where views come from and what is done to them.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Cameras")]
pub struct CameraArgs {
    /// Camera file: INRIA cameras.json, NeRF transforms.json, a camera path of nerfstudio, or a
    /// folder with one of them or with COLMAP's cameras and images (.bin or .txt)
    #[arg(long, value_name = "PATH", required_unless_present = "orbit")]
    pub cameras: Option<PathBuf>,
    /// Instead of a file: N views on a circle around the scene
    #[arg(long, value_name = "N", conflicts_with = "cameras")]
    pub orbit: Option<usize>,
    /// Orbit: angle above the horizon, degrees [default: 20]
    #[arg(long, value_name = "DEG", conflicts_with = "cameras", allow_hyphen_values = true)]
    pub orbit_elevation: Option<f64>,
    /// Orbit: distance from the centre, world units [default: the scene fills the image]
    #[arg(long, value_name = "R", conflicts_with = "cameras", allow_negative_numbers = true)]
    pub orbit_radius: Option<f64>,
    /// Orbit: vertical field of view, degrees [default: 50]
    #[arg(long, value_name = "DEG", conflicts_with = "cameras", allow_negative_numbers = true)]
    pub orbit_fov: Option<f64>,
    /// Orbit: the axis that points up; photo captures mostly have -y, NeRF sets z [default: -y]
    #[arg(long, value_enum, conflicts_with = "cameras", allow_hyphen_values = true)]
    pub orbit_up: Option<Up>,
    /// Only views of this split, where the file names splits
    #[arg(long, value_enum)]
    pub split: Option<SplitArg>,
    /// Only every K-th view, starting with the first
    #[arg(long, value_name = "K")]
    pub every: Option<std::num::NonZeroUsize>,
    /// A smooth path of N frames through the views
    #[arg(long, value_name = "N")]
    pub path_frames: Option<usize>,
    /// Only some frames.
    #[command(flatten)]
    pub only: FrameArgs,
    /// Image size, pixels; another aspect keeps the vertical field of view
    #[arg(long, value_name = "WxH", value_parser = image_size)]
    pub size: Option<(u32, u32)>,
    /// Pairs of views, this far apart (world units): NAME_left, NAME_right. A display shows both
    /// in one period
    #[arg(long, value_name = "EYE_DISTANCE", allow_negative_numbers = true)]
    pub stereo: Option<f64>,
    /// Field of view, degrees: 90, 90x96, or the edges of an off-centre one of each eye,
    /// OUTER+INNERxUP+DOWN
    #[arg(long, value_name = "H[xV]")]
    pub fov: Option<FieldOfView>,
    /// Size and field of view of a headset, an eye: quest-3, quest-2, vive-focus-3,
    /// pimax-crystal, rift-cv1; --size and --fov win
    #[arg(long, value_name = "NAME", value_parser = headset)]
    pub headset: Option<Headset>,
}

/// The axis that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Up {
    /// +x
    #[value(name = "x")]
    X,
    /// +y
    #[value(name = "y")]
    Y,
    /// +z
    #[value(name = "z")]
    Z,
    /// -x
    #[value(name = "-x")]
    MinusX,
    /// -y
    #[value(name = "-y")]
    MinusY,
    /// -z
    #[value(name = "-z")]
    MinusZ,
}

impl Up {
    fn vector(self) -> DVec3 {
        match self {
            Up::X => DVec3::X,
            Up::Y => DVec3::Y,
            Up::Z => DVec3::Z,
            Up::MinusX => DVec3::NEG_X,
            Up::MinusY => DVec3::NEG_Y,
            Up::MinusZ => DVec3::NEG_Z,
        }
    }
}

/// A split on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum SplitArg {
    /// Views seen in training
    Train,
    /// Held-out views
    Test,
}

impl SplitArg {
    fn split(self) -> Split {
        match self {
            SplitArg::Train => Split::Train,
            SplitArg::Test => Split::Test,
        }
    }
}

/// A half-open range of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRange {
    /// First frame.
    pub start: usize,
    /// One after the last frame; `None`: to the end.
    pub end: Option<usize>,
}

impl fmt::Display for FrameRange {
    /// As `--frames` takes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let end = self.end.map_or(String::new(), |end| end.to_string());
        write!(f, "{}..{end}", self.start)
    }
}

/// Views, ready to render.
#[derive(Debug, Clone, PartialEq)]
pub struct Views {
    /// At least one.
    pub cameras: Vec<Camera>,
    /// The layout that they came from.
    pub format: &'static str,
    /// By the name of the view, the lenses that photos were taken through.
    pub lenses: BTreeMap<String, Lens>,
    /// What rendering the views leaves out: lenses, one sentence each.
    pub warnings: Vec<String>,
    /// What looks odd in the file, and what is to know about the selection, one sentence each.
    pub notes: Vec<String>,
}

impl Views {
    /// Prints what is to know of views that are rendered on standard error, unless `--quiet`.
    pub fn warn(&self, context: &Context) {
        warn(self.warnings.iter().chain(&self.notes), context);
    }

    /// The same where photos are freed of their lenses.
    pub fn warn_of_selection(&self, context: &Context) {
        warn(self.notes.iter(), context);
    }
}

fn warn<'a>(warnings: impl Iterator<Item = &'a String>, context: &Context) {
    for warning in warnings.filter(|_| !context.global.quiet) {
        out::complain(format!("warning: {warning}"));
    }
}

impl CameraArgs {
    /// The views that the flags ask for, of the model at `model` if it is a file. `bounds` is asked
    /// only for an orbit.
    pub fn cameras(
        &self,
        model: Option<&Path>,
        bounds: impl FnOnce() -> SceneBounds,
    ) -> Result<Views, Failure> {
        let (file, orbit) = (&self.cameras, self.orbit);
        let CameraFile { cameras, format, lenses, warnings, doubts, .. } = match (file, orbit) {
            (Some(path), _) => open_cameras(path, self.image_size(), model)?,
            (None, Some(n)) => {
                let cameras = self.orbit_request(n).cameras(bounds).map_err(usage)?;
                let (lenses, warnings, doubts) = Default::default();
                let (format, frame) = ("orbit", Frame::Model);
                CameraFile { cameras, format, lenses, warnings, doubts, frame }
            }
            (None, None) => {
                let what = "no views: give --cameras FILE or --orbit N";
                return Err(Failure::new(Exit::Usage, what));
            }
        };
        let (cameras, of_selection) = self.selection().of(cameras).map_err(usage)?;
        let notes = doubts.into_iter().chain(of_selection).collect();
        Ok(Views { cameras, format, lenses, warnings, notes })
    }

    /// `views` of these flags as their camera file shows them, at its size; `None` where no file
    /// says one.
    pub fn whole(&self, model: Option<&Path>, views: &[Camera]) -> Option<Vec<Camera>> {
        if self.orbit.is_some() {
            return None;
        }
        if self.size.is_none() {
            return Some(views.to_vec());
        }
        // A file that says no size is read with one only.
        let path = self.cameras.as_ref()?;
        let cameras = open_cameras(path, None, model).ok()?.cameras;
        let selection = ViewSelection { size: None, ..self.selection() };
        Some(selection.of(cameras).ok()?.0)
    }

    fn selection(&self) -> ViewSelection {
        ViewSelection {
            split: self.split.map(SplitArg::split),
            every: self.every,
            path_frames: self.path_frames,
            frames: self.only.frames.map(|range| (range.start, range.end)),
            size: self.image_size(),
            stereo: self.stereo,
            fov: self.fov.or(self.headset.map(|headset| headset.fov)),
        }
    }

    fn orbit_request(&self, views: usize) -> OrbitRequest {
        OrbitRequest {
            views,
            elevation_deg: self.orbit_elevation,
            radius: self.orbit_radius,
            fov_deg: self.orbit_fov,
            up: self.orbit_up.unwrap_or(Up::MinusY).vector(),
            size: self.image_size(),
        }
    }

    /// The size that is asked for, directly or as that of a headset.
    fn image_size(&self) -> Option<(u32, u32)> {
        self.size.or(self.headset.map(|headset| headset.size))
    }
}

/// The flags have the names of the options.
fn usage(error: ViewError) -> Failure {
    Failure::new(Exit::Usage, format!("--{error}"))
}

pub(super) fn image_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| {
        let side = |s: &str| s.parse().ok().filter(|v| (1..=MAX_SIZE).contains(v));
        Some((side(w)?, side(h)?))
    });
    sides.ok_or_else(|| format!("write it as 1920x1080, each 1 to {MAX_SIZE} pixels"))
}

/// Parses `0..24`, `10..` and `..5`.
pub fn frame_range(text: &str) -> Result<FrameRange, String> {
    let range = text.split_once("..").and_then(|(start, end)| {
        let start = if start.is_empty() { 0 } else { start.parse().ok()? };
        let end = if end.is_empty() { None } else { Some(end.parse().ok()?) };
        Some(FrameRange { start, end })
    });
    let range = range.ok_or("write it as 0..24 (24 excluded), 10.. or ..5")?;
    if range.end.is_some_and(|end| end <= range.start) {
        return Err("the range is empty; the end is excluded, so 3..4 is frame 3".to_string());
    }
    Ok(range)
}
