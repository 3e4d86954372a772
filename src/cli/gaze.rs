//! Where the viewer looks: the flags of commands that show foveated models.

use std::path::{Path, PathBuf};

use super::filter::pair;
use super::{Context, Exit, Failure, OrExit, out};
use powergs_frame::fovea::{GazeStream, REGIONS, Screen, ScreenGaze, ScreenRule, ScreenWidth};
use powergs_frame::scene::Eye;
use powergs_scene::Camera;
use powergs_scene::gaze::{GazeSource, ViewGazeError, gazes, missing_regions};

/// Where the viewer looks in each view, and on which screen.
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
    /// The virtual screen: camera, as wide as the camera of each view sees; its width in degrees;
    /// or powergs (90, as published), wide-100, wide-110
    #[arg(long, value_name = "DEGREES|NAME", default_value = "camera")]
    #[arg(value_parser = ScreenWidth::parse, allow_hyphen_values = true)]
    pub screen: ScreenWidth,
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

/// The field of view of a picture, degrees. No file of a picture says it: without `given` that of
/// the published screen is taken, which is said.
pub fn of_picture(given: Option<f64>, context: &Context) -> f64 {
    given.unwrap_or_else(|| {
        let published = Screen::PUBLISHED.fov_deg;
        if !context.global.quiet {
            out::complain(format_args!(
                "note: the picture is taken as {published} degrees wide; --fov gives what its \
                 camera saw"
            ));
        }
        published
    })
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

    /// On which screen each view is shown.
    fn rule(&self) -> ScreenRule {
        ScreenRule { width: self.screen, pooling_rate: self.pooling_rate }
    }

    /// Where the viewer looks in each of the views.
    ///
    /// # Errors
    /// Exit code 2 for a gaze or a screen that cannot be, 3 for a stream that cannot be read or has
    /// a gap.
    pub fn of_views(&self, cameras: &[Camera]) -> Result<Vec<ScreenGaze>, Failure> {
        let file = self.gaze_stream.as_ref().map(|path| path.display().to_string());
        let file = file.unwrap_or_default();
        let stream = self.gaze_stream.as_deref().map(stream).transpose()?;
        let source = match (&stream, self.gaze_cycle) {
            (Some(stream), _) => GazeSource::Stream {
                stream,
                rate: self.gaze_rate,
                gap_s: self.gaze_gap,
                eye: match self.eye {
                    EyeArg::Left => Eye::Left,
                    EyeArg::Right => Eye::Right,
                },
            },
            (None, Some(n)) => GazeSource::Cycle(usize::from(n)),
            (None, None) => GazeSource::Point(self.gaze.unwrap_or((0.5, 0.5)).into()),
        };
        gazes(source, self.rule(), cameras).map_err(|error| {
            let (exit, place) = match &error {
                ViewGazeError::Screen(_) => (Exit::Usage, "--screen, --pooling-rate"),
                ViewGazeError::Point(_) => (Exit::Usage, "--gaze"),
                ViewGazeError::Stream { .. } => (Exit::BadInput, file.as_str()),
            };
            Failure::new(exit, format!("{place}: {error}"))
        })
    }
}

/// The samples in a file.
fn stream(path: &Path) -> Result<GazeStream, Failure> {
    let shown = path.display();
    let text = std::fs::read_to_string(path).or_exit(Exit::BadInput, &shown)?;
    GazeStream::parse(&text).or_exit(Exit::BadInput, &shown)
}

/// Says what is particular about how a foveated model is shown: no flag says where the viewer
/// looks, the screen is not as wide as the cameras see, no view shows some level.
pub fn note(context: &Context, gaze: &GazeArgs, cameras: &[Camera], gazes: &[ScreenGaze]) {
    note_default(context, gaze);
    note_width(context, gaze.rule(), cameras);
    let missing = missing_regions(cameras, gazes);
    let names: Vec<_> = missing.iter().map(|&r| REGIONS[usize::from(r)]).collect();
    note_missing(context, &names);
}

/// Says that the screen is not as wide as the cameras see.
pub fn note_width(context: &Context, rule: ScreenRule, cameras: &[Camera]) {
    let Some(camera) = rule.most_unlike(cameras).filter(|_| !context.global.quiet) else { return };
    out::complain(format_args!(
        "note: the screen is {:.1} degrees wide, but the camera of view {} sees {:.1}: levels are \
         those of its picture stretched to the screen; --screen camera takes what each camera sees",
        rule.of(camera).fov_deg,
        camera.name,
        camera.horizontal_fov().to_degrees()
    ));
}

/// Says which levels no view shows, by the names of their regions.
pub fn note_missing(context: &Context, missing: &[&str]) {
    if !missing.is_empty() && !context.global.quiet {
        out::complain(format_args!(
            "note: no pixel is in {}: the images are too small or too narrow for these levels; \
             more pixels, a wider field of view or a larger --pooling-rate have them",
            missing.join(", ")
        ));
    }
}

/// Says where the viewer looks, if no flag does.
fn note_default(context: &Context, gaze: &GazeArgs) {
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
