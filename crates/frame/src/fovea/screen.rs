//! Which screen each view is shown on: one as wide as its camera sees, or one that is given.

use super::{GazeError, Screen};
use crate::scene::Camera;

/// A screen is as wide as its camera sees up to this share of the angle.
const TOLERANCE: f64 = 0.03;
/// The widest screen of a camera, degrees: a flat one of 180 has no end.
const WIDEST: f64 = 179.9;

/// How wide the screen of a view is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScreenWidth {
    /// As wide as the camera of the view sees: the picture fills the screen without stretching.
    OfCamera,
    /// The same for all views, degrees.
    Degrees(f64),
}

impl ScreenWidth {
    /// `camera`, or what [`Screen::parse`] takes: the name of a screen, or degrees.
    ///
    /// # Errors
    /// Another word, or an angle that no flat screen has.
    pub fn parse(text: &str) -> Result<ScreenWidth, String> {
        if text.trim() == "camera" {
            return Ok(ScreenWidth::OfCamera);
        }
        match Screen::parse(text) {
            Ok(screen) => Ok(ScreenWidth::Degrees(screen.fov_deg)),
            Err(why) => Err(format!("{why}; `camera` is as wide as the camera sees")),
        }
    }
}

/// What decides the screen of each view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenRule {
    /// How wide it is.
    pub width: ScreenWidth,
    /// Pooling angle per squared eccentricity, 1/rad.
    pub pooling_rate: f64,
}

impl From<Screen> for ScreenRule {
    /// One screen for all views.
    fn from(screen: Screen) -> ScreenRule {
        let width = ScreenWidth::Degrees(screen.fov_deg);
        ScreenRule { width, pooling_rate: screen.pooling_rate }
    }
}

impl ScreenRule {
    /// The screen of the view of `camera`; one that can be if the rule can.
    pub fn of(&self, camera: &Camera) -> Screen {
        let fov_deg = match self.width {
            ScreenWidth::OfCamera => camera.horizontal_fov().to_degrees().min(WIDEST),
            ScreenWidth::Degrees(degrees) => degrees,
        };
        Screen { fov_deg, pooling_rate: self.pooling_rate }
    }

    /// Checks what is known without a camera.
    ///
    /// # Errors
    /// As [`Screen::check`].
    pub fn check(&self) -> Result<(), GazeError> {
        let fov_deg = match self.width {
            ScreenWidth::OfCamera => Screen::PUBLISHED.fov_deg,
            ScreenWidth::Degrees(degrees) => degrees,
        };
        Screen { fov_deg, pooling_rate: self.pooling_rate }.check()
    }

    /// The camera whose field of view differs most from its screen, the first of equals; `None`
    /// where all screens are as wide as their cameras see, to 3 per cent of the angle.
    pub fn most_unlike<'a>(&self, cameras: &'a [Camera]) -> Option<&'a Camera> {
        let unlike = |camera: &Camera| {
            (self.of(camera).fov_deg / camera.horizontal_fov().to_degrees() - 1.0).abs()
        };
        let most = cameras.iter().rev().max_by(|a, b| unlike(a).total_cmp(&unlike(b)))?;
        (unlike(most) > TOLERANCE).then_some(most)
    }
}
