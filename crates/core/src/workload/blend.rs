//! The pixels of a tile while a list is blended, one by one: for frames that go through other lists
//! than their own, and for what is asked of pixels (where they stop, how deep they see).

use super::FrameWorkload;
use powergs_frame::splat::pixel::{PixelAlpha, spans};
use powergs_frame::splat::{Splat, TRANSMITTANCE_MIN};

/// The pixels of a tile, row by row.
pub struct TileBlend<'a> {
    splats: &'a [Splat],
    area: (u32, u32, u32, u32),
    /// Whether nothing stops.
    whole: bool,
    /// What of the light behind reaches each pixel.
    pub transmittance: Vec<f32>,
    /// List position from which on each pixel needs nothing.
    pub iterated: Vec<u32>,
    /// Entries that were blended, those that stop a pixel included.
    pub blends: u64,
    /// Whether an entry has stopped each pixel.
    pub has_stopped: Vec<bool>,
}

impl<'a> TileBlend<'a> {
    /// The pixels of a tile in front of a list of so many entries.
    ///
    /// # Panics
    /// When the frame was not binned for [`FrameDetail::pixels`](super::FrameDetail).
    pub fn new(workload: &'a FrameWorkload, tile: usize, entries: u32) -> TileBlend<'a> {
        let area = workload.pixels_of(tile);
        let pixels = (area.2 - area.0) as usize * (area.3 - area.1) as usize;
        TileBlend {
            splats: &workload.pixels.as_ref().expect("binned for pixels").splats,
            area,
            whole: workload.detail.whole,
            transmittance: vec![1.0; pixels],
            iterated: vec![entries; pixels],
            blends: 0,
            has_stopped: vec![false; pixels],
        }
    }

    /// Pixels that an entry has stopped.
    pub fn stopped(&self) -> u32 {
        self.has_stopped.iter().filter(|stopped| **stopped).count() as u32
    }

    /// Blends the splat `rank`, as the rasteriser does: the entry that would leave too little light
    /// stops a pixel, and is not blended.
    pub fn blend(&mut self, at: u32, rank: u32) {
        self.blend_and(at, rank, |_, _| {});
    }

    /// As [`TileBlend::blend`], and calls `seen` with each pixel that blends and what is left of
    /// the light behind.
    pub fn blend_and(&mut self, at: u32, rank: u32, mut seen: impl FnMut(usize, f32)) {
        let splat = &self.splats[rank as usize];
        let (alpha, (x0, y0, x1, _)) = (PixelAlpha::of(splat), self.area);
        for (y, span) in spans(splat, self.area) {
            let Some([first, end]) = span else { continue };
            let row = ((y - y0) * (x1 - x0)) as usize;
            for x in first..end {
                let pixel = row + (x - x0) as usize;
                let alpha = if self.iterated[pixel] > at { alpha.at(x, y) } else { 0.0 };
                if alpha == 0.0 {
                    continue;
                }
                self.blends += 1;
                let rest = self.transmittance[pixel] * (1.0 - alpha);
                if rest < TRANSMITTANCE_MIN && !self.whole {
                    self.iterated[pixel] = at + 1;
                    self.has_stopped[pixel] = true;
                } else {
                    self.transmittance[pixel] = rest;
                }
                seen(pixel, rest);
            }
        }
    }
}
