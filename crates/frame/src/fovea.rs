//! Foveation: the gaze, the size of the eye's pooling regions around it, and the level of a model
//! that each tile shows. `docs/foveation.md` has the formulas.
//!
//! [`ScreenRule`] says on which screen each view is shown, [`EccentricityMap`] gives eccentricity,
//! pooling size and level at every point of a screen, [`TileLevels`] the levels of the tiles of a
//! grid and how neighbouring levels are blended, [`GazeStream`] the gaze over time.

mod eccentricity;
mod screen;
pub mod stream;
pub mod tiles;

pub use eccentricity::{EccentricityMap, POOLINGS};
pub use screen::{ScreenRule, ScreenWidth};
pub use stream::{GazeSample, GazeStream, StreamError};
pub use tiles::{TileLevel, TileLevels};

/// Levels of a foveated model, and regions of a screen: R1 to R4.
pub const LEVELS: usize = 4;

/// Names of the regions, in order.
pub const REGIONS: [&str; LEVELS] = ["R1", "R2", "R3", "R4"];

/// An impossible gaze or screen.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum GazeError {
    /// The gaze is not on the picture.
    #[error("gaze {x},{y}: give two numbers from 0 to 1, from the left and from the top")]
    Gaze {
        /// From the left.
        x: f64,
        /// From the top.
        y: f64,
    },
    /// The field of view is no angle of a flat screen.
    #[error("field of view {degrees}: give the horizontal one, above 0 and below 180 degrees")]
    FieldOfView {
        /// The angle.
        degrees: f64,
    },
    /// A pooling rate outside the range of eyes.
    #[error("pooling rate {rate}: give one from 0.001 to 10 per radian; published: 0.05")]
    PoolingRate {
        /// The rate.
        rate: f64,
    },
}

/// The virtual screen of one eye: flat, straight ahead, seen from the axis through its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    /// Horizontal field of view, degrees, between 0 and 180.
    pub fov_deg: f64,
    /// Pooling angle per squared eccentricity, 1/rad. Small pictures reach all levels with a larger
    /// one.
    pub pooling_rate: f64,
}

impl Screen {
    /// The screen of the publication: 90 degrees, pooling rate 0.05 (`powergs`).
    pub const PUBLISHED: Screen = Screen { fov_deg: 90.0, pooling_rate: 0.05 };

    /// Screens with names: the published one, and those of wider headsets, per eye.
    pub(crate) const PRESETS: [(&'static str, Screen); 3] = [
        ("powergs", Screen::PUBLISHED),
        ("wide-100", Screen { fov_deg: 100.0, ..Screen::PUBLISHED }),
        ("wide-110", Screen { fov_deg: 110.0, ..Screen::PUBLISHED }),
    ];

    /// The preset with this name, or a screen with this field of view in degrees.
    ///
    /// # Errors
    /// A word that is neither, or an angle that no flat screen has.
    pub fn parse(text: &str) -> Result<Screen, String> {
        let text = text.trim();
        if let Some((_, screen)) = Screen::PRESETS.iter().find(|(name, _)| *name == text) {
            return Ok(*screen);
        }
        let Ok(fov_deg) = text.parse() else {
            let names = Screen::PRESETS.map(|(name, _)| name).join(", ");
            return Err(format!("give degrees, or one of {names}"));
        };
        let screen = Screen { fov_deg, ..Screen::PUBLISHED };
        screen.check().map_err(|e| e.to_string())?;
        Ok(screen)
    }

    /// Checks field of view and pooling rate.
    ///
    /// # Errors
    /// An angle that is not between 0 and 180 degrees, a rate that is not from 0.001 to 10, or NaN.
    pub fn check(&self) -> Result<(), GazeError> {
        if !(self.fov_deg > 0.0 && self.fov_deg < 180.0) {
            return Err(GazeError::FieldOfView { degrees: self.fov_deg });
        }
        if !(0.001..=10.0).contains(&self.pooling_rate) {
            return Err(GazeError::PoolingRate { rate: self.pooling_rate });
        }
        Ok(())
    }
}

/// A gaze on a screen, as traces keep it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenGaze {
    /// Gaze, shares of width and height from the upper left corner.
    pub point: [f32; 2],
    /// The screen.
    pub screen: Screen,
}

impl ScreenGaze {
    /// The eccentricity map of a picture of `size` pixels, width and height.
    ///
    /// # Errors
    /// [`GazeError`]: a gaze outside the picture, or an impossible screen.
    pub fn eccentricity_map(&self, size: [u32; 2]) -> Result<EccentricityMap, GazeError> {
        // The same numbers whether they come from a trace or not.
        EccentricityMap::on(self.screen, self.point.map(f64::from), size)
    }
}

/// The nine gazes at which foveated frames are measured: {1/4, 1/2, 3/4}², from left to right, each
/// from top to bottom. View i has gaze i modulo 9 (`powergs`).
pub const GAZE_CYCLE: [[f32; 2]; 9] = [
    [0.25, 0.25],
    [0.25, 0.5],
    [0.25, 0.75],
    [0.5, 0.25],
    [0.5, 0.5],
    [0.5, 0.75],
    [0.75, 0.25],
    [0.75, 0.5],
    [0.75, 0.75],
];
