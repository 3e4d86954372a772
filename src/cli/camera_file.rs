//! Opening camera files, and the camera flags that commands share.
//!
//! The order of operations is fixed: read (or orbit), `--split`, `--every`, `--path-frames`,
//! `--frames`, `--size`, `--stereo`.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::{Context, Exit, Failure, OrExit, out, picture_file};
use powergs_scene::camera::check::{MAX_DISTANCE, MAX_SIZE};
use powergs_scene::camera::orbit::{Orbit, SceneBounds};
use powergs_scene::camera::{CameraError, CameraFile, colmap, edit, json, path};
use powergs_scene::{Camera, Split};

/// Most views that a generator makes.
const MAX_VIEWS: usize = 1_000_000;
/// Image size of an orbit without `--size`, pixels.
const ORBIT_SIZE: (u32, u32) = (1920, 1080);
/// Largest JSON camera file, bytes.
const MAX_JSON: u64 = 1 << 30;

/// Where views come from and what is done to them.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Cameras")]
pub struct CameraArgs {
    /// Camera file: INRIA cameras.json, NeRF transforms.json, or a folder with COLMAP's cameras
    /// and images (.bin or .txt)
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
    /// Only frames A to B, B excluded, counted from 0: 0..24, 10.., ..5
    #[arg(long, value_name = "A..B", value_parser = frame_range)]
    pub frames: Option<FrameRange>,
    /// Image size, pixels; another aspect keeps the vertical field of view
    #[arg(long, value_name = "WxH", value_parser = image_size)]
    pub size: Option<(u32, u32)>,
    /// Pairs of views, this far apart (world units): NAME_left, NAME_right
    #[arg(long, value_name = "EYE_DISTANCE", allow_negative_numbers = true)]
    pub stereo: Option<f64>,
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

/// Views, ready to render.
#[derive(Debug, Clone, PartialEq)]
pub struct Views {
    /// At least one.
    pub cameras: Vec<Camera>,
    /// The layout that they came from.
    pub format: &'static str,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
}

impl Views {
    /// Prints the warnings on standard error, unless `--quiet`.
    pub fn warn(&self, context: &Context) {
        for warning in self.warnings.iter().filter(|_| !context.global.quiet) {
            out::complain(format!("warning: {warning}"));
        }
    }
}

impl CameraArgs {
    /// The views that the flags ask for. `bounds` is asked only for an orbit.
    pub fn cameras(&self, bounds: impl FnOnce() -> SceneBounds) -> Result<Views, Failure> {
        let mut views = match (&self.cameras, self.orbit) {
            (Some(path), _) => {
                let file = read(path, self.size)?;
                Views { cameras: file.cameras, format: file.format, warnings: file.warnings }
            }
            (None, Some(n)) => {
                let cameras = self.orbit(n, bounds)?;
                Views { cameras, format: "orbit", warnings: Vec::new() }
            }
            (None, None) => return Err(usage("no views: give --cameras FILE or --orbit N")),
        };
        self.select(&mut views)?;
        if let Some((width, height)) = self.size {
            views.cameras.iter_mut().for_each(|c| *c = edit::resized(c, width, height));
        }
        if let Some(distance) = self.stereo {
            if !(distance > 0.0 && distance <= MAX_DISTANCE) {
                return Err(usage(format!("--stereo {distance}: must be positive, world units")));
            }
            views.cameras = views.cameras.iter().flat_map(|c| edit::stereo(c, distance)).collect();
        }
        Ok(views)
    }

    /// `--split`, `--every`, `--path-frames`, `--frames`.
    fn select(&self, views: &mut Views) -> Result<(), Failure> {
        let cameras = &mut views.cameras;
        if let Some(split) = self.split.map(SplitArg::split) {
            let name = split.name();
            if cameras.iter().all(|c| c.split.is_none()) {
                let what = "the camera file names no splits; use --every or --frames";
                return Err(usage(format!("--split {name}: {what}")));
            }
            let total = cameras.len();
            cameras.retain(|c| c.split == Some(split));
            if cameras.is_empty() {
                return Err(usage(format!("--split {name}: none of the {total} views is in it")));
            }
        }
        if let Some(every) = self.every {
            *cameras = cameras.iter().step_by(every.get()).cloned().collect();
        }
        if let Some(n) = self.path_frames {
            check_count("--path-frames", n)?;
            let path = path::Path::through(cameras);
            let what = "--path-frames: a path needs at least two views, there is one; use --orbit";
            *cameras = path.ok_or_else(|| usage(what))?.frames(n);
        }
        let Some(FrameRange { start, end }) = self.frames else { return Ok(()) };
        let count = cameras.len();
        if start >= count {
            let what = format!("--frames {start}..: there are only {count} views, from 0");
            return Err(usage(what));
        }
        if let Some(end) = end.filter(|end| *end > count) {
            views.warnings.push(format!("--frames {start}..{end}: there are only {count} views"));
        }
        *cameras = cameras.drain(start..end.unwrap_or(count).min(count)).collect();
        Ok(())
    }

    fn orbit(
        &self,
        views: usize,
        bounds: impl FnOnce() -> SceneBounds,
    ) -> Result<Vec<Camera>, Failure> {
        check_count("--orbit", views)?;
        let elevation = self.orbit_elevation.unwrap_or(20.0);
        if elevation.is_nan() || elevation.abs() >= 90.0 {
            return Err(usage("--orbit-elevation: must be between -90 and 90 degrees"));
        }
        let fov = self.orbit_fov.unwrap_or(50.0);
        if !(fov > 0.0 && fov < 170.0) {
            return Err(usage("--orbit-fov: must be above 0 and below 170 degrees"));
        }
        let bounds = bounds();
        let size = self.size.unwrap_or(ORBIT_SIZE);
        let (elevation, vertical_fov) = (elevation.to_radians(), fov.to_radians());
        let fitting = || Orbit::fitting_radius(bounds.extent, vertical_fov, size);
        let radius = self.orbit_radius.unwrap_or_else(fitting);
        if !(radius > 0.0 && radius + bounds.centre.length() <= MAX_DISTANCE) {
            return Err(usage(format!("--orbit-radius {radius}: must be positive, world units")));
        }
        let (centre, up) = (bounds.centre, self.orbit_up.unwrap_or(Up::MinusY).vector());
        Ok(Orbit { views, centre, radius, elevation, up, vertical_fov, size }.cameras())
    }
}

fn usage(what: impl Into<String>) -> Failure {
    Failure::new(Exit::Usage, what.into())
}

fn check_count(flag: &str, n: usize) -> Result<(), Failure> {
    if (1..=MAX_VIEWS).contains(&n) {
        return Ok(());
    }
    Err(usage(format!("{flag} {n}: must be 1 to {MAX_VIEWS}")))
}

/// Reads a camera file or a COLMAP folder. `size` serves files that do not say the image size;
/// without it the first image beside the file is asked.
pub fn read(path: &Path, size: Option<(u32, u32)>) -> Result<CameraFile, Failure> {
    if path.is_dir() {
        return read_colmap(path);
    }
    let text = read_text(path)?;
    let file = match json::read(&text, size) {
        Err(CameraError::NoSize { view, file_path }) => match image_size_beside(path, &file_path) {
            Some(size) => json::read(&text, Some(size)),
            None => Err(CameraError::NoSize { view, file_path }),
        },
        other => other,
    };
    file.or_exit(Exit::BadInput, path.display())
}

fn read_text(path: &Path) -> Result<String, Failure> {
    let mut bytes = Vec::new();
    let file = open(path)?;
    let read = file.take(MAX_JSON + 1).read_to_end(&mut bytes);
    read.or_exit(Exit::BadInput, path.display())?;
    let bad = |what: &str| Failure::new(Exit::BadInput, format!("{}: {what}", path.display()));
    if bytes.len() as u64 > MAX_JSON {
        return Err(bad("is over 1 GiB; this is not a camera file"));
    }
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        bad(&format!("byte {at}: not UTF-8 text; give a JSON camera file or a COLMAP folder"))
    })
}

fn open(path: &Path) -> Result<BufReader<File>, Failure> {
    Ok(BufReader::new(File::open(path).or_exit(Exit::BadInput, path.display())?))
}

/// COLMAP in `folder`, or in the `sparse/0` under it.
fn read_colmap(folder: &Path) -> Result<CameraFile, Failure> {
    for folder in [folder.to_path_buf(), folder.join("sparse/0"), folder.join("sparse")] {
        let pair = |end: &str| (folder.join(format!("cameras.{end}")), format!("images.{end}"));
        for end in ["bin", "txt"] {
            let (cameras, images) = pair(end);
            if cameras.is_file() {
                let (cameras, images) = (open(&cameras)?, open(&folder.join(images))?);
                let file = match end {
                    "bin" => colmap::read_binary(cameras, images),
                    _ => colmap::read_text(cameras, images),
                };
                return file.or_exit(Exit::BadInput, folder.display());
            }
        }
    }
    let what = "no cameras.bin or cameras.txt here or in sparse/0; give the COLMAP model folder";
    Err(Failure::new(Exit::BadInput, format!("{}: {what}", folder.display())))
}

/// The size of the image that a `transforms.json` names; Blender leaves its extension out.
fn image_size_beside(file: &Path, file_path: &str) -> Option<(u32, u32)> {
    let folder = file.parent()?;
    let candidates = ["", ".png", ".jpg"].map(|end| folder.join(format!("{file_path}{end}")));
    let size = candidates
        .iter()
        .filter(|p| p.is_file())
        .find_map(|p| powergs_pixels::size(&picture_file::bytes(p).ok()?).ok())?;
    (1..=MAX_SIZE).contains(&size.0).then_some(size)
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
