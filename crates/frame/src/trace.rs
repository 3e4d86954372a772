//! Traces: what a frame is, independent of any machine.
//!
//! A trace frame holds every projected splat in depth order, and per pixel the depth rank at which
//! blending stopped. From these the work of any tiling can be counted without evaluating one
//! exponential. The file format is specified in `docs/trace-format.md`.
//!
//! [`Writer`] streams frames to any `Write`; [`Reader`] reads any frame of a complete file;
//! [`verify`] reads a possibly damaged one from front to back. A [`Frame`] that was read has passed
//! [`Frame::check`]; one that is written must pass it.

mod block;
mod check;
pub mod codec;
mod column;
mod content;
mod encoded;
mod error;
mod head;
mod reader;
mod scan;
mod source;
mod transform;
mod verify;
mod writer;

pub use column::{COLUMNS, Column, ColumnGroup, Per, Presence};
pub use encoded::{ColumnInfo, EncodedFrame, FrameInfo};
pub use error::{FrameFault, TraceError};
pub use head::{FrameHead, TraceHeader};
pub use reader::Reader;
pub use scan::{Item, Scan};
pub use transform::Transform;
pub use verify::{Damage, VerifyReport, verify, visit_intact};
pub use writer::Writer;

use crate::fovea::{Screen, ScreenGaze};
use crate::scene::{Camera, ShDegree};
use crate::splat::Splat;
use xxhash_rust::xxh3::Xxh3;

/// The stop rank of a pixel that never stopped.
pub const NEVER: u32 = u32::MAX;
/// The version of the file format that is written: major, minor. Files of this major version and
/// older ones are read.
pub const VERSION: (u16, u16) = (2, 2);
/// The largest width or height of a frame, pixels.
pub const SIDE_MAX: u32 = 65_536;
/// The most Gaussians in a scene: indices are 32-bit, and the last value is kept free.
pub const POINTS_MAX: u64 = u32::MAX as u64;
/// The highest level of a splat in a foveated frame: there are four levels.
pub const LEVEL_MAX: u8 = 3;

/// Facts of one frame that are known before its splats.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameFacts {
    /// Pose, intrinsics and resolution.
    pub camera: Camera,
    /// Gaussians in the scene.
    pub points: u64,
    /// Gaussians that passed the near-plane cull (visible or not).
    pub survivors: u64,
    /// Degree of the scene's spherical harmonics, which decides the bytes and the operations of a
    /// colour. `None` where the writer did not know it, and in every file of format 1: such frames
    /// count as degree 3 ([`FrameFacts::colour_degree`]).
    pub sh_degree: Option<ShDegree>,
    /// Whether the model is anti-aliased: opacities of splats are then compensated for the low-pass
    /// of the view. Files before this was known say no.
    pub antialiased: bool,
    /// Background colour, sRGB as rendered.
    pub background: [f32; 3],
    /// Mean linear R, G, B of the displayed image, where it was rendered: the input of display
    /// power.
    pub mean_linear_rgb: Option<[f64; 3]>,
}

/// Per-pixel columns, row-major, `width * height` entries each.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PixelColumns {
    /// Depth rank (position in [`Frame::splats`]) of the splat at which blending stopped, the
    /// terminating one; [`NEVER`] if it did not. Measured with 16x16 tiles and OBB lists.
    pub stop_rank: Vec<u32>,
    /// Splats with α ≥ 1/255 up to the stop, the terminating one included.
    pub blended: Vec<u32>,
}

/// Additional columns of a foveated frame (`spec` §1.4).
#[derive(Debug, Clone, PartialEq)]
pub struct Fovea {
    /// Gaze, fraction of width and height.
    pub gaze: [f32; 2],
    /// The virtual screen that the gaze is on.
    pub screen: Screen,
    /// Highest level of every splat, by rank: 0 for those of level 1 alone.
    pub highest_level: Vec<u8>,
    /// Stop rank of the second blended level of every pixel, or [`NEVER`]. Rank 0, at which nothing
    /// can stop, says here and in [`PixelColumns::stop_rank`] that the pixel does not show that
    /// level.
    pub stop_rank_2: Vec<u32>,
    /// Entries while both blended levels are unfinished, per pixel (`T_extra_alpha`).
    pub extra_alpha: Vec<u32>,
    /// Entries blended for the second level, per pixel (`T_used2`).
    pub blended_2: Vec<u32>,
}

impl Fovea {
    /// The gaze and the screen.
    pub fn screen_gaze(&self) -> ScreenGaze {
        ScreenGaze { point: self.gaze, screen: self.screen }
    }
}

impl Frame {
    /// What the frame goes by in files about it: a hash of everything that decides what a machine
    /// has to do. Compression, preview and name do not count.
    pub fn id(&self) -> u64 {
        let mut hash = Xxh3::new();
        let (facts, camera) = (&self.facts, &self.facts.camera);
        let degree = facts.colour_degree().get();
        hash.update(bytemuck::bytes_of(&[camera.width, camera.height, u32::from(degree)]));
        hash.update(bytemuck::bytes_of(&[facts.points, facts.survivors, self.splats.len() as u64]));
        for splat in &self.splats {
            let Splat { index, depth, mean, cov, opacity } = *splat;
            let [x, y] = mean;
            let [a, b, d] = cov;
            hash.update(bytemuck::bytes_of(&[depth, x, y, a, b, d, opacity].map(f32::to_le_bytes)));
            hash.update(&index.to_le_bytes());
        }
        let words = |hash: &mut Xxh3, all: &[u32]| {
            all.iter().for_each(|word| hash.update(&word.to_le_bytes()));
        };
        words(&mut hash, &self.pixels.stop_rank);
        words(&mut hash, &self.pixels.blended);
        if let Some(fovea) = &self.fovea {
            hash.update(&fovea.highest_level);
            words(&mut hash, &fovea.stop_rank_2);
        }
        if let Some(bits) = &self.frustum_bits {
            hash.update(bits);
        }
        hash.digest()
    }
}

/// A small picture of the frame, for reports.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// 8-bit sRGB, row-major, 3 bytes a pixel.
    pub rgb: Vec<u8>,
}

/// One frame of a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Facts known before the splats.
    pub facts: FrameFacts,
    /// Splats whose bounding square touches the image (rounded up to 64-pixel tiles), in ascending
    /// (depth bits, index): position is the *rank*.
    pub splats: Vec<Splat>,
    /// One bit per scene point, least significant first: passed the near-plane cull. Lets a machine
    /// model know the addresses of geometry-first fetches.
    pub survivor_bits: Option<Vec<u8>>,
    /// One bit per scene point: its centre is inside the frustum with a margin
    /// ([`inside_frustum`](crate::splat::project::inside_frustum)), for machines that cull by it.
    pub frustum_bits: Option<Vec<u8>>,
    /// Per-pixel columns.
    pub pixels: PixelColumns,
    /// Foveated columns.
    pub fovea: Option<Fovea>,
    /// A small picture of the frame.
    pub preview: Option<Preview>,
}
