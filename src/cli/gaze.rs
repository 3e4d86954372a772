//! Where somebody looks: the flags of commands that show foveated models.

use std::path::PathBuf;

use super::filter::pair;
use super::{Context, Exit, Failure, OrExit, out};
use powergs_frame::fovea::stream::Eye;
use powergs_frame::fovea::{GAZE_CYCLE, GazeStream, REGIONS, Screen, ScreenGaze};
use powergs_scene::Camera;

/// Where somebody looks in each view, and on which screen.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Foveation (with a .fov model)")]
pub struct GazeArgs {
    /// Where somebody looks: shares of width and height, from the upper left corner
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    pub gaze: Option<(f64, f64)>,
    /// Instead: view i gets gaze i modulo N of the nine at 1/4, 1/2 and 3/4 of both sides
    #[arg(long, value_name = "N", conflicts_with = "gaze")]
    #[arg(value_parser = clap::value_parser!(u8).range(1..=9))]
    pub gaze_cycle: Option<u8>,
    /// Instead: a CSV file of an eye tracker: time_s,x,y or time_s,left_x,left_y,right_x,right_y.
    /// Between samples the last one is held
    #[arg(long, value_name = "FILE", conflicts_with_all = ["gaze", "gaze_cycle"])]
    pub gaze_stream: Option<PathBuf>,
    /// Frames a second of the views, for --gaze-stream
    #[arg(long, value_name = "FPS", default_value_t = 60.0)]
    #[arg(value_parser = super::replay::display_rate)]
    pub gaze_rate: f64,
    /// The longest time for which a gaze is held, seconds; a longer gap is an error
    #[arg(long, value_name = "SECONDS", default_value_t = 0.1, value_parser = seconds)]
    pub gaze_gap: f64,
    /// Which eye of the stream: views of --stereo have their own
    #[arg(long, value_enum, default_value = "left")]
    pub eye: EyeArg,
    /// The virtual screen: its width in degrees, or powergs (90), wide-100, wide-110
    #[arg(long, value_name = "DEGREES|NAME", default_value = "powergs")]
    #[arg(value_parser = Screen::parse, allow_hyphen_values = true)]
    pub screen: Screen,
    /// Pooling angle per squared eccentricity, 1/rad: larger, and small images have all levels
    #[arg(long, value_name = "RATE", default_value_t = Screen::PUBLISHED.pooling_rate)]
    #[arg(allow_hyphen_values = true)]
    pub pooling_rate: f64,
}

/// An eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum EyeArg {
    /// The left one.
    Left,
    /// The right one.
    Right,
}

/// Degrees, or the name of a screen. What cannot be is refused where it is used.
pub fn field_of_view(text: &str) -> Result<f64, String> {
    match text.trim().parse() {
        Ok(degrees) => Ok(degrees),
        Err(_) => Screen::parse(text).map(|screen| screen.fov_deg),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|v| (0.0..=3600.0).contains(v));
    value.ok_or_else(|| "write seconds, from 0 to 3600".into())
}

impl GazeArgs {
    /// Whether a gaze is given.
    pub fn is_given(&self) -> bool {
        self.gaze.is_some() || self.gaze_cycle.is_some() || self.gaze_stream.is_some()
    }

    /// Where somebody looks in each of the views.
    ///
    /// # Errors
    /// Exit code 2 for a gaze or a screen that cannot be, 3 for a stream that cannot be read or has
    /// a gap.
    pub fn of_views(&self, cameras: &[Camera]) -> Result<Vec<ScreenGaze>, Failure> {
        let screen = Screen { pooling_rate: self.pooling_rate, ..self.screen };
        screen.check().or_exit(Exit::Usage, "--screen, --pooling-rate")?;
        let gazes: Vec<[f32; 2]> = match (&self.gaze_stream, self.gaze_cycle) {
            (Some(path), _) => self.streamed(path, cameras)?,
            (None, Some(n)) => (0..cameras.len()).map(|i| GAZE_CYCLE[i % usize::from(n)]).collect(),
            (None, None) => {
                let (x, y) = self.gaze.unwrap_or((0.5, 0.5));
                // Before it is rounded: just outside is outside.
                let size = cameras.first().map_or([1, 1], |c| [c.width, c.height]);
                let map = powergs_frame::fovea::EccentricityMap::on(screen, [x, y], size);
                map.or_exit(Exit::Usage, "--gaze")?;
                vec![[x as f32, y as f32]; cameras.len()]
            }
        };
        Ok(gazes.into_iter().map(|gaze| ScreenGaze { point: gaze, screen }).collect())
    }

    fn streamed(&self, path: &PathBuf, cameras: &[Camera]) -> Result<Vec<[f32; 2]>, Failure> {
        let shown = path.display();
        let text = std::fs::read_to_string(path).or_exit(Exit::BadInput, &shown)?;
        let stream = GazeStream::parse(&text).or_exit(Exit::BadInput, &shown)?;
        let of_pair = |camera: &Camera| match () {
            () if camera.name.ends_with("_left") => Some(Eye::Left),
            () if camera.name.ends_with("_right") => Some(Eye::Right),
            () => None,
        };
        let is_stereo =
            cameras.len().is_multiple_of(2) && cameras.iter().all(|c| of_pair(c).is_some());
        let own = match self.eye {
            EyeArg::Left => Eye::Left,
            EyeArg::Right => Eye::Right,
        };
        let at = |(i, camera): (usize, &Camera)| {
            let (moment, eye) = match of_pair(camera).filter(|_| is_stereo) {
                Some(eye) => (i / 2, eye),
                None => (i, own),
            };
            let time = stream.samples()[0].time_s + moment as f64 / self.gaze_rate;
            let gaze = stream.at(time, eye, self.gaze_gap);
            gaze.or_exit(Exit::BadInput, format_args!("{shown}: view {i}"))
        };
        cameras.iter().enumerate().map(at).collect()
    }
}

/// The regions that no view shows, 0 for R1: images that are too small for all four.
pub fn missing(cameras: &[Camera], gazes: &[ScreenGaze]) -> Vec<u8> {
    let mut missing: Vec<u8> = (0..4).collect();
    for (camera, gaze) in cameras.iter().zip(gazes) {
        if missing.is_empty() {
            break;
        }
        if let Ok(map) = gaze.eccentricity_map([camera.width, camera.height]) {
            let own = map.missing_regions();
            missing.retain(|region| own.contains(region));
        }
    }
    missing
}

/// Says which levels no view shows.
pub fn note_missing(context: &Context, cameras: &[Camera], gazes: &[ScreenGaze]) {
    let missing = missing(cameras, gazes);
    if !missing.is_empty() && !context.global.quiet {
        let names: Vec<_> = missing.iter().map(|&r| REGIONS[usize::from(r)]).collect();
        out::complain(format_args!(
            "note: no pixel is in {}: the images are too small for these levels; larger ones, a \
             wider --screen or a larger --pooling-rate have them",
            names.join(", ")
        ));
    }
}

/// Says where somebody looks, if nobody said.
pub fn note_default(context: &Context, gaze: &GazeArgs) {
    if !gaze.is_given() && !context.global.quiet {
        out::complain(
            "note: the model is foveated and no gaze is given: the middle of the image; --gaze, \
             --gaze-cycle or --gaze-stream choose another",
        );
    }
}

/// A gaze without levels to choose from.
///
/// # Errors
/// Always: exit code 2.
pub fn refuse_plain(name: impl std::fmt::Display) -> Result<(), Failure> {
    let what = format!(
        "{name}: a gaze needs a foveated model (.fov): make one of its four levels with \
         `powergs-sim scene compose`, or leave --gaze out"
    );
    Err(Failure::new(Exit::Usage, what))
}
