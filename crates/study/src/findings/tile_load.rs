//! The tile lists of one frame, kept for the heatmap.

use powergs_core::workload::FrameWorkload;

/// A picture, 8-bit sRGB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Row-major, 3 bytes a pixel.
    pub rgb: Vec<u8>,
}

/// List lengths of all tiles of one frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileLoad {
    /// Position of the frame in the trace.
    pub frame: usize,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
    /// Tile side, pixels.
    pub tile: u32,
    /// Tiles per row.
    pub tiles_x: u32,
    /// List length of each tile, row-major.
    pub entries: Vec<u32>,
    /// A small picture of the frame, where the trace carries one.
    pub picture: Option<Picture>,
}

impl TileLoad {
    /// The lists of `workload`.
    pub fn of(frame: usize, workload: &FrameWorkload, picture: Option<Picture>) -> Self {
        Self {
            frame,
            width: workload.width,
            height: workload.height,
            tile: workload.geometry.tile,
            tiles_x: workload.tiles_x,
            entries: workload.tiles.iter().map(|t| t.entries).collect(),
            picture,
        }
    }
}
