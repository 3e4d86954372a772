//! `--demo`: the generated scene, its views, and the flags that it sets.

use super::super::replay::ModelArg;
use super::super::{Failure, demo_scene};
use super::OptimizeArgs;
use powergs_frame::fovea::{Screen, ScreenRule, ScreenWidth};
use powergs_scene::Camera;

/// Every how many-th of its 96 views.
const EVERY: usize = 3;
/// Image size, pixels.
const IMAGE: (u32, u32) = (200, 200);
/// Display power of the dense model over its rendering power; published scenes have 0.38 to 2.66.
const RATIO: f64 = 2.0;

/// What is said before the demonstration.
pub const NOTE: &str = "note: a scene this small costs milliwatts to render, which the standing \
                        power of a whole machine would hide: --demo counts with the paper model \
                        (--oracle paper) and scales the panel to match (--display-ratio 2)";

/// The views.
pub fn views(size: Option<(u32, u32)>) -> Result<Vec<Camera>, Failure> {
    demo_scene::views(EVERY, size.unwrap_or(IMAGE))
}

/// Pooling rate of the demonstration: its small images show the regions that images of 1,237
/// pixels show at the published rate.
const POOLING_RATE: f64 = 0.31;

/// What decides the virtual screen of each view. The demonstration shows its images on the
/// published one.
pub fn screens(args: &OptimizeArgs) -> ScreenRule {
    let (width, pooling_rate) = match args.demo {
        true => (ScreenWidth::Degrees(Screen::PUBLISHED.fov_deg), POOLING_RATE),
        false => (ScreenWidth::OfCamera, Screen::PUBLISHED.pooling_rate),
    };
    ScreenRule {
        width: args.fovea.screen.unwrap_or(width),
        pooling_rate: args.fovea.pooling_rate.unwrap_or(pooling_rate),
    }
}

/// What counts power.
pub fn oracle(args: &OptimizeArgs) -> ModelArg {
    args.power.oracle.unwrap_or(if args.demo { ModelArg::Paper } else { ModelArg::Cycle })
}

/// The ratio that the panel is scaled to; `None` leaves it as it is.
pub fn display_ratio(args: &OptimizeArgs) -> Option<f64> {
    args.power.display_ratio.or(args.demo.then_some(RATIO))
}
