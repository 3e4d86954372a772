//! The presets: what each looks like, from where it is seen, and which published statistics it
//! aims at. They are files: `arch-configs/synth/*.toml`, or a user's own.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use glam::DVec3;
use powergs_base::config::embedded::SYNTH;
use powergs_base::config::{self, ConfigError, layer};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::camera::Camera;

/// A kind of scene, as in `arch-configs/synth/*.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Preset {
    /// Name on the command line and in reports.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// Gaussians unless asked otherwise.
    #[schemars(extend("minimum" = 1, "maximum" = 100_000_000, "x-unit" = "Gaussians"))]
    pub points: usize,
    /// What is in it.
    pub scenery: Scenery,
    /// Share of the Gaussians in what the views look at, the rest being around it: what a view sees
    /// of the scene. Without it that of the scenery.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0, "maximum" = 1, "x-unit" = "share"))]
    pub focus: Option<f64>,
    /// Factor on the size of every Gaussian: larger ones cover more tiles.
    #[schemars(extend("minimum" = 0.01, "maximum" = 100, "x-unit" = "factor"))]
    pub scale: f64,
    /// Factor on the logarithms of the ratios of axes: 1 is as trained, 0 makes balls.
    #[serde(default = "one")]
    #[schemars(extend("minimum" = 0, "maximum" = 4, "x-unit" = "factor"))]
    pub elongation: f64,
    /// The pictures of its views.
    pub image: Image,
    /// Where its views are.
    pub rig: Rig,
    /// Published statistics that it aims at.
    #[serde(default)]
    pub targets: BTreeMap<Statistic, Target>,
}

impl Preset {
    /// The preset of this name that comes with the program.
    pub fn named(name: &str) -> Option<&'static Preset> {
        presets().iter().find(|preset| preset.name == name)
    }

    /// Reads and checks a preset.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line.
    pub fn parse(text: &str) -> Result<Preset, ConfigError> {
        let text = &layer::on_embedded(text, SYNTH)?;
        let config = config::parse::<Preset>(text, &[])?;
        let mut problems = Vec::new();
        for (statistic, target) in &config.value.targets {
            if target.low > target.high {
                let key = format!("targets.{}.low", statistic.name());
                problems
                    .push(config.problem(&key, "is above `high`: no value would be near".into()));
            }
        }
        config.checked(problems)
    }

    /// Width and height of its views, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.image.width, self.image.height)
    }
}

fn one() -> f64 {
    1.0
}

/// The presets that come with the program, in the order of `synth --list`.
///
/// # Panics
/// Never: tests read all of them.
pub fn presets() -> &'static [Preset] {
    static PRESETS: LazyLock<Vec<Preset>> = LazyLock::new(|| {
        let parse = |file: &config::Embedded| {
            Preset::parse(file.text).unwrap_or_else(|e| panic!("{}: {e}", file.name))
        };
        SYNTH.iter().map(parse).collect()
    });
    &PRESETS
}

/// Size of the pictures of a preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Image {
    /// Width of a picture.
    #[schemars(extend("minimum" = 1, "maximum" = 16384, "x-unit" = "pixels"))]
    pub width: u32,
    /// Height of a picture.
    #[schemars(extend("minimum" = 1, "maximum" = 16384, "x-unit" = "pixels"))]
    pub height: u32,
}

/// A statistic of a scene and its frames, averaged over views where it is one of frames.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize, JsonSchema,
)]
pub enum Statistic {
    /// Gaussians in the scene.
    #[serde(rename = "points")]
    Points,
    /// Share of Gaussians with an opacity below 0.35.
    #[serde(rename = "low_opacity_frac")]
    LowOpacity,
    /// Share of Gaussians whose longest axis is at least three times the shortest.
    #[serde(rename = "spiky_frac")]
    Spiky,
    /// Median of the longest axis over the shortest.
    #[serde(rename = "axis_ratio_median")]
    AxisRatio,
    /// Median distance of Gaussians that follow each other in memory, over that of any two: 1 where
    /// an address says nothing about a place.
    #[serde(rename = "neighbour_distance")]
    NeighbourDistance,
    /// Share of Gaussians in front of the near plane.
    #[serde(rename = "survivors_frac")]
    Survivors,
    /// Splats with at least one tile of 16x16, whole count.
    #[serde(rename = "visible_splats")]
    Visible,
    /// Tiles of 16x16 per visible splat, OBB test.
    #[serde(rename = "tiles_per_splat")]
    TilesPerSplat,
    /// Mean list length of the 16x16 tiles that have a list, OBB test.
    #[serde(rename = "list_mean")]
    ListMean,
    /// Median list length of the tiles that have a list.
    #[serde(rename = "list_median")]
    ListMedian,
    /// 99th percentile of the list lengths.
    #[serde(rename = "list_p99")]
    ListP99,
    /// Longest list.
    #[serde(rename = "list_max")]
    ListMax,
    /// Share of α evaluations that contribute (α at least 1/255), lists of bounding squares.
    #[serde(rename = "contributing_aabb_frac")]
    ContributingAabb,
    /// The same, OBB test.
    #[serde(rename = "contributing_obb_frac")]
    ContributingObb,
    /// List entries times pixels, over α evaluations until pixels stop.
    #[serde(rename = "termination_saving")]
    TerminationSaving,
    /// Pairs with 16x16 tiles of bounding squares over those of oriented boxes.
    #[serde(rename = "squares_per_box")]
    SquaresPerBox,
    /// Pairs of bounding squares with 64x64 tiles over those with 16x16.
    #[serde(rename = "squares_64_per_16")]
    Squares64Per16,
    /// Pairs with 8x8 tiles at 1920x1080 per Gaussian of the scene, bounding squares.
    #[serde(rename = "pairs_8x8_aabb_per_point")]
    PairsAabb,
    /// The same with the exact ellipse.
    #[serde(rename = "pairs_8x8_exact_per_point")]
    PairsExact,
}

impl Statistic {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Statistic::Points => "points",
            Statistic::LowOpacity => "low_opacity_frac",
            Statistic::Spiky => "spiky_frac",
            Statistic::AxisRatio => "axis_ratio_median",
            Statistic::NeighbourDistance => "neighbour_distance",
            Statistic::Survivors => "survivors_frac",
            Statistic::Visible => "visible_splats",
            Statistic::TilesPerSplat => "tiles_per_splat",
            Statistic::ListMean => "list_mean",
            Statistic::ListMedian => "list_median",
            Statistic::ListP99 => "list_p99",
            Statistic::ListMax => "list_max",
            Statistic::ContributingAabb => "contributing_aabb_frac",
            Statistic::ContributingObb => "contributing_obb_frac",
            Statistic::TerminationSaving => "termination_saving",
            Statistic::SquaresPerBox => "squares_per_box",
            Statistic::Squares64Per16 => "squares_64_per_16",
            Statistic::PairsAabb => "pairs_8x8_aabb_per_point",
            Statistic::PairsExact => "pairs_8x8_exact_per_point",
        }
    }
}

/// A published value, as a range.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Smallest value that was published for such scenes.
    #[schemars(extend("minimum" = 0, "maximum" = 1e12, "x-unit" = "as the statistic"))]
    pub low: f64,
    /// Largest.
    #[schemars(extend("minimum" = 0, "maximum" = 1e12, "x-unit" = "as the statistic"))]
    pub high: f64,
    /// Who published it, and what.
    pub publication: String,
}

/// What is in a preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scenery {
    /// A digger before black.
    Toy,
    /// A room.
    Room,
    /// A truck on a yard.
    Street,
    /// A lawn with trees to the horizon.
    Garden,
    /// Blocks of houses along streets, from the air.
    City,
    /// A digger on a table.
    Demo,
}

/// Views on rings around a target.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Rig {
    /// Number of views; every eighth is held out.
    #[schemars(extend("minimum" = 1, "maximum" = 100_000, "x-unit" = "views"))]
    pub views: usize,
    /// The point at the centre of all views.
    pub target: Point,
    /// Horizontal distances of the first and the last view from the target's axis.
    pub radius: Radii,
    /// Heights of the first and the last view.
    pub height: Heights,
    /// Times that the views go around.
    #[schemars(extend("minimum" = 0, "maximum" = 1000, "x-unit" = "turns"))]
    pub turns: f64,
    /// Vertical field of view.
    #[schemars(extend("minimum" = 1, "maximum" = 170, "x-unit" = "degrees"))]
    pub vertical_fov: f64,
}

/// A point of a scene; z is up.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// To the right.
    #[schemars(extend("minimum" = -1e4, "maximum" = 1e4, "x-unit" = "world units"))]
    pub x: f64,
    /// To the back.
    #[schemars(extend("minimum" = -1e4, "maximum" = 1e4, "x-unit" = "world units"))]
    pub y: f64,
    /// Upwards.
    #[schemars(extend("minimum" = -1e4, "maximum" = 1e4, "x-unit" = "world units"))]
    pub z: f64,
}

/// Horizontal distances.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Radii {
    /// Of the first view.
    #[schemars(extend("minimum" = 1e-3, "maximum" = 1e4, "x-unit" = "world units"))]
    pub from: f64,
    /// Of the last view.
    #[schemars(extend("minimum" = 1e-3, "maximum" = 1e4, "x-unit" = "world units"))]
    pub to: f64,
}

/// Heights.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Heights {
    /// Of the first view.
    #[schemars(extend("minimum" = -1e4, "maximum" = 1e4, "x-unit" = "world units"))]
    pub from: f64,
    /// Of the last view.
    #[schemars(extend("minimum" = -1e4, "maximum" = 1e4, "x-unit" = "world units"))]
    pub to: f64,
}

impl Rig {
    /// The views, along one spiral: neighbours are close, so that they make a path.
    pub(crate) fn cameras(&self, size: (u32, u32)) -> Vec<Camera> {
        let target = DVec3::new(self.target.x, self.target.y, self.target.z);
        let last = (self.views - 1).max(1) as f64;
        (0..self.views)
            .map(|idx| {
                let t = idx as f64 / last;
                let mix = |low: f64, high: f64| low + (high - low) * t;
                let angle = std::f64::consts::TAU * self.turns * t;
                let (sin, cos) = angle.sin_cos();
                let flat = DVec3::new(cos, sin, 0.0) * mix(self.radius.from, self.radius.to);
                let centre = flat + DVec3::Z * mix(self.height.from, self.height.to);
                let fov = self.vertical_fov.to_radians();
                Camera::looking_at(centre, target, DVec3::Z, fov, size)
            })
            .collect()
    }
}
