//! The presets: what each looks like, from where it is seen, and which published statistics it
//! aims at.

use glam::DVec3;

use super::super::camera::Camera;

/// A kind of scene.
#[derive(Debug)]
pub struct Preset {
    /// Name on the command line.
    pub name: &'static str,
    /// One line for `synth --list`.
    pub summary: &'static str,
    /// Gaussians unless asked otherwise.
    pub points: usize,
    /// Image size of its views, pixels.
    pub size: (u32, u32),
    /// Published statistics that it aims at.
    pub targets: &'static [Target],
    /// Where its views are.
    pub(super) rig: Rig,
    /// What is in it.
    pub(super) scenery: Scenery,
}

impl Preset {
    /// The preset of this name.
    pub fn named(name: &str) -> Option<&'static Preset> {
        PRESETS.iter().find(|preset| preset.name == name)
    }
}

/// A statistic of a scene and its frames, averaged over views where it is one of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Statistic {
    /// Gaussians in the scene.
    Points,
    /// Share of Gaussians with an opacity below 0.35.
    LowOpacity,
    /// Share of Gaussians whose longest axis is at least three times the shortest.
    Spiky,
    /// Share of Gaussians in front of the near plane.
    Survivors,
    /// Splats with at least one tile of 16x16, whole count.
    Visible,
    /// Tiles of 16x16 per visible splat, OBB test.
    TilesPerSplat,
    /// Mean list length of the 16x16 tiles that have a list, OBB test.
    ListMean,
    /// Median list length of the tiles that have a list.
    ListMedian,
    /// 99th percentile of the list lengths.
    ListP99,
    /// Longest list.
    ListMax,
    /// Share of α evaluations that contribute (α at least 1/255), lists of bounding squares.
    ContributingAabb,
    /// The same, OBB test.
    ContributingObb,
    /// List entries times pixels, over α evaluations until pixels stop.
    TerminationSaving,
    /// Pairs with 8x8 tiles at 1920x1080 per Gaussian of the scene, bounding squares.
    PairsAabb,
    /// The same with the exact ellipse.
    PairsExact,
}

impl Statistic {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Statistic::Points => "points",
            Statistic::LowOpacity => "low_opacity_frac",
            Statistic::Spiky => "spiky_frac",
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
            Statistic::PairsAabb => "pairs_8x8_aabb_per_point",
            Statistic::PairsExact => "pairs_8x8_exact_per_point",
        }
    }
}

/// A published value, as a range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Of what.
    pub statistic: Statistic,
    /// Smallest value that was published for such scenes.
    pub low: f64,
    /// Largest.
    pub high: f64,
    /// Who published it.
    pub source: &'static str,
}

/// What is in a preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scenery {
    /// A digger before black.
    Toy,
    /// A room.
    Room,
    /// A truck on a yard.
    Street,
    /// A lawn with trees to the horizon.
    Garden,
    /// A digger on a table.
    Demo,
}

/// Views on rings around a target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rig {
    /// Number of views.
    pub views: usize,
    /// The point at the centre of all views, world units.
    pub target: DVec3,
    /// Horizontal distances of the nearest and the farthest ring, world units.
    pub radius: (f64, f64),
    /// Heights of the lowest and the highest ring, world units.
    pub height: (f64, f64),
    /// Times that the views go around.
    pub turns: f64,
    /// Vertical field of view, degrees.
    pub vertical_fov: f64,
}

impl Rig {
    /// The views, along one spiral: neighbours are close, so that they make a path.
    pub(crate) fn cameras(&self, size: (u32, u32)) -> Vec<Camera> {
        let last = (self.views - 1).max(1) as f64;
        (0..self.views)
            .map(|idx| {
                let t = idx as f64 / last;
                let mix = |(low, high): (f64, f64)| low + (high - low) * t;
                let angle = std::f64::consts::TAU * self.turns * t;
                let (sin, cos) = angle.sin_cos();
                let flat = DVec3::new(cos, sin, 0.0) * mix(self.radius);
                let centre = flat + DVec3::Z * mix(self.height);
                let fov = self.vertical_fov.to_radians();
                Camera::looking_at(centre, self.target, DVec3::Z, fov, size)
            })
            .collect()
    }
}

const fn target(statistic: Statistic, low: f64, high: f64, source: &'static str) -> Target {
    Target { statistic, low, high, source }
}

const OPACITY: Target = target(Statistic::LowOpacity, 0.60, 0.70, "FlashGS 2408.07967: 65.1 %");
const SPIKY: Target = target(Statistic::Spiky, 0.52, 0.62, "FLICKER 2603.01158: 57 %");
const TILES: Target = target(Statistic::TilesPerSplat, 1.5, 7.6, "SwiftGS: at most 7.61");
const CONTRIBUTING: Target =
    target(Statistic::ContributingAabb, 0.076, 0.137, "GBU 2503.23625: 7.6 to 13.7 %");
const SAVING: Target =
    target(Statistic::TerminationSaving, 1.2, 2.52, "VR-Pipe: 2.52; PEER: 16 to 32 % of lists");

/// All presets, in the order of `synth --list`.
pub static PRESETS: [Preset; 5] = [
    Preset {
        name: "demo",
        summary: "a toy on a table, tiny: for tests and the committed trace",
        points: 20_000,
        size: (320, 240),
        targets: &[OPACITY, SPIKY, SAVING],
        rig: Rig {
            views: 24,
            target: DVec3::new(0.0, 0.0, 0.2),
            radius: (2.3, 2.1),
            height: (0.9, 1.6),
            turns: 1.0,
            vertical_fov: 42.0,
        },
        scenery: Scenery::Demo,
    },
    Preset {
        name: "lego",
        summary: "a toy before black, as the Lego scene of the Blender set",
        points: 340_000,
        size: (800, 800),
        targets: &[
            target(Statistic::Points, 330_000.0, 358_000.0, "VR-Pipe: 358 K; NeRArch-Sim: 334 K"),
            OPACITY,
            SPIKY,
            TILES,
            CONTRIBUTING,
            SAVING,
        ],
        rig: Rig {
            views: 96,
            target: DVec3::new(0.0, 0.0, 0.25),
            radius: (2.9, 1.9),
            height: (0.9, 2.5),
            turns: 3.0,
            vertical_fov: 39.6,
        },
        scenery: Scenery::Toy,
    },
    Preset {
        name: "indoor",
        summary: "a room with a laden table, as counter, room and bonsai",
        points: 1_400_000,
        size: (1559, 1039),
        targets: &[
            target(Statistic::Points, 1.19e6, 1.55e6, "gsplat eval: 1.19 to 1.55 M"),
            OPACITY,
            SPIKY,
            TILES,
            target(Statistic::ListMean, 463.0, 635.0, "GSCore re-implementation (low confidence)"),
            CONTRIBUTING,
            SAVING,
            target(Statistic::PairsAabb, 5.3, 8.9, "HiGS 2606.00352, table 1"),
            target(Statistic::PairsExact, 3.4, 5.4, "HiGS 2606.00352, table 1"),
        ],
        rig: Rig {
            views: 96,
            target: DVec3::new(0.0, 0.0, 0.85),
            radius: (1.6, 1.42),
            height: (1.2, 1.75),
            turns: 3.0,
            vertical_fov: 42.0,
        },
        scenery: Scenery::Room,
    },
    Preset {
        name: "outdoor-bounded",
        summary: "a truck on a yard, as Train and Truck of Tanks & Temples",
        points: 1_800_000,
        size: (980, 545),
        targets: &[
            target(Statistic::Points, 1.03e6, 2.54e6, "VR-Pipe: Train 1.03 M, Truck 2.54 M"),
            OPACITY,
            SPIKY,
            target(Statistic::Visible, 0.3e6, 0.9e6, "VR-Pipe: at most 900 K in the frustum"),
            TILES,
            CONTRIBUTING,
            SAVING,
        ],
        rig: Rig {
            views: 96,
            target: DVec3::new(0.0, 0.0, 1.0),
            radius: (5.6, 6.4),
            height: (1.5, 2.4),
            turns: 2.0,
            vertical_fov: 50.0,
        },
        scenery: Scenery::Street,
    },
    Preset {
        name: "outdoor-unbounded",
        summary: "a garden to the horizon, as bicycle, garden and stump (1.4 GB)",
        points: 5_700_000,
        size: (1237, 822),
        targets: &[
            target(Statistic::Points, 4.82e6, 6.06e6, "gsplat eval: 4.82 to 6.06 M"),
            OPACITY,
            SPIKY,
            TILES,
            target(Statistic::ListMean, 1000.0, 1400.0, "GSCore re-implementation: garden 1400"),
            target(Statistic::ListMax, 2000.0, 2500.0, "MetaSapiens 2407.00435, gsplat: 2485"),
            CONTRIBUTING,
            SAVING,
            target(Statistic::PairsAabb, 1.7, 2.1, "HiGS 2606.00352, table 1"),
            target(Statistic::PairsExact, 1.1, 1.4, "HiGS 2606.00352, table 1"),
        ],
        rig: Rig {
            views: 96,
            target: DVec3::new(0.0, 0.0, 0.7),
            radius: (2.8, 2.4),
            height: (1.3, 1.8),
            turns: 2.0,
            vertical_fov: 39.0,
        },
        scenery: Scenery::Garden,
    },
];
