//! Where a viewer looks in each of some views.

use powergs_frame::fovea::{
    EccentricityMap, GAZE_CYCLE, GazeError, GazeStream, Screen, ScreenGaze, ScreenRule, StreamError,
};
use powergs_frame::scene::{Camera, Eye, are_pairs};

/// Where the gazes of views come from.
#[derive(Debug, Clone, Copy)]
pub enum GazeSource<'a> {
    /// The same point in all views: shares of width and height, from the upper left corner.
    Point([f64; 2]),
    /// The first so many of the nine points at 1/4, 1/2 and 3/4 of both sides, one view after the
    /// other; 1 to 9.
    Cycle(usize),
    /// What an eye tracker saw while the views were shown.
    Stream {
        /// Its samples.
        stream: &'a GazeStream,
        /// Views a second.
        rate: f64,
        /// The longest time for which a sample holds, seconds.
        gap_s: f64,
        /// Which eye. The views of a pair have their own, both at one time.
        eye: Eye,
    },
}

/// A gaze that cannot be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ViewGazeError {
    /// The screen.
    #[error("{0}")]
    Screen(GazeError),
    /// The point.
    #[error("{0}")]
    Point(GazeError),
    /// The stream knows no gaze in a view.
    #[error("view {view}: {error}")]
    Stream {
        /// The view, from 0.
        view: usize,
        /// Why.
        error: StreamError,
    },
}

/// The gaze in each of the views, on the screen that `rule` gives it.
///
/// # Errors
/// [`ViewGazeError`]: a screen or a point that cannot be, a gap in the stream.
pub fn gazes(
    source: GazeSource<'_>,
    rule: ScreenRule,
    cameras: &[Camera],
) -> Result<Vec<ScreenGaze>, ViewGazeError> {
    rule.check().map_err(ViewGazeError::Screen)?;
    let points: Vec<[f32; 2]> = match source {
        GazeSource::Point(point) => {
            // Before it is rounded: just outside is outside, on whatever screen.
            EccentricityMap::on(Screen::PUBLISHED, point, [1, 1]).map_err(ViewGazeError::Point)?;
            vec![point.map(|share| share as f32); cameras.len()]
        }
        GazeSource::Cycle(n) => (0..cameras.len()).map(|i| GAZE_CYCLE[i % n]).collect(),
        GazeSource::Stream { stream, rate, gap_s, eye } => {
            let is_stereo = are_pairs(cameras);
            let at = |(view, camera): (usize, &Camera)| {
                let (moment, eye) = match camera.eye.filter(|_| is_stereo) {
                    Some(eye) => (view / 2, eye),
                    None => (view, eye),
                };
                let time_s = stream.samples()[0].time_s + moment as f64 / rate;
                let gaze = stream.at(time_s, eye, gap_s);
                gaze.map_err(|error| ViewGazeError::Stream { view, error })
            };
            cameras.iter().enumerate().map(at).collect::<Result<_, _>>()?
        }
    };
    let on = |(point, camera)| ScreenGaze { point, screen: rule.of(camera) };
    Ok(points.into_iter().zip(cameras).map(on).collect())
}

/// The regions that no view shows, 0 for R1: the images are too small for all four.
pub fn missing_regions(cameras: &[Camera], gazes: &[ScreenGaze]) -> Vec<u8> {
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
