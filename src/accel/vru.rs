//! Volume Rendering Unit (VRU): blends the depth-sorted Gaussians of one tile, sub-tile by
//! sub-tile.
//!
//! Timing rule: a core has `units_per_core` units that hold `pixels_per_unit` pixels each and
//! rotate them through one pipeline, one pixel a cycle, so that the recurrence of transmittance
//! never stalls it. All units of a core work on the same (Gaussian, sub-tile) pair, which takes
//! `ceil(subtile² / (units pixels)) pixels` cycles: 4 for 8x8 pixels on 16 units of 2x2. With
//! sub-tile skipping only pairs whose bitmap bit is set are executed, and none after the last pixel
//! of a sub-tile has stopped. An entry takes at least one cycle to leave the feature buffer (A26).
//!
//! The last chunk of a tile also drains the pipeline, `latency` cycles, and finishes the pixels,
//! one a cycle in each unit; the next tile enters after that (A27). A tile without chunks only
//! finishes its pixels.
//!
//! Source: `gscore`, `nerarch-sim` (64 units of 2x2 pixels, 192 cycles).

use super::machine::{Fetch, VruSpec};
use super::unit::Unit;
use crate::action::{Action, ActionCounts, Buffer, Stage};
use crate::workload::{ChunkWork, TileWork};

/// A chunk, and the tile that ends with it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Render {
    /// The chunk; without entries for a tile that has none.
    pub chunk: ChunkWork,
    /// The tile, with its last chunk.
    pub last: Option<TileWork>,
}

/// The rendering units of one core.
#[derive(Debug, Clone)]
pub struct Vru {
    /// The `[vru]` table.
    pub spec: VruSpec,
    /// Side of a sub-tile, pixels.
    pub subtile: u32,
    /// Bytes of an entry in the feature buffer.
    pub feature: u64,
    /// Bytes of a finished pixel.
    pub pixel: u64,
    /// When colour is fetched.
    pub fetch: Fetch,
}

impl Vru {
    fn subtile_pixels(&self) -> u64 {
        u64::from(self.subtile).pow(2)
    }

    /// Cycles of one (Gaussian, sub-tile) pair.
    pub fn pair_cycles(&self) -> u64 {
        let rotated = u64::from(self.spec.pixels_per_unit);
        self.subtile_pixels().div_ceil(u64::from(self.spec.units_per_core) * rotated) * rotated
    }

    /// (Gaussian, sub-tile) pairs that a chunk executes.
    pub fn pairs(&self, chunk: &ChunkWork) -> u64 {
        u64::from(match self.spec.subtile_skipping {
            true => chunk.skipping.subtile_pairs,
            false => chunk.unskipped.subtile_pairs,
        })
    }

    /// Bytes that a tile leaves in the pixel buffer.
    pub fn pixel_bytes(&self, tile: &TileWork) -> u64 {
        u64::from(tile.pixels) * self.pixel
    }
}

impl Unit for Vru {
    type Work = Render;
    const NAME: &'static str = "vru";

    fn cycles(&self, work: &Render) -> u64 {
        let entries = u64::from(work.chunk.entries);
        let blend = (self.pairs(&work.chunk) * self.pair_cycles()).max(entries);
        let finish = work.last.map_or(0, |tile| {
            let drain = if tile.chunks > 0 { u64::from(self.spec.latency) } else { 0 };
            drain + u64::from(tile.pixels).div_ceil(u64::from(self.spec.units_per_core))
        });
        (blend + finish).max(1)
    }

    fn charge(&self, work: &Render, actions: &mut ActionCounts) {
        let stage = Stage::Rendering;
        let alphas = self.pairs(&work.chunk) * self.subtile_pixels();
        actions.charge(stage, Action::Alpha, alphas);
        if self.fetch == Fetch::LazyColour {
            actions.charge(stage, Action::ShColour, u64::from(work.chunk.first_loads));
        }
        let features = u64::from(work.chunk.entries) * self.feature;
        actions.charge(stage, Action::SramWrite(Buffer::Feature), features);
        actions.charge(stage, Action::SramRead(Buffer::Feature), features);
        if let Some(tile) = &work.last {
            actions.charge(stage, Action::Blend, tile.blends);
            actions.charge(stage, Action::PixelFinish, u64::from(tile.pixels));
            let pixels = self.pixel_bytes(tile);
            actions.charge(stage, Action::SramWrite(Buffer::PixelOut), pixels);
            actions.charge(stage, Action::SramRead(Buffer::PixelOut), pixels);
        }
    }
}
