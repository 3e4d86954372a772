//! Pictures of lists in an order of one's own: what a machine shows whose order is not exact.

use fearless_simd::Level;
use rayon::prelude::*;

use super::front_to_back;
use powergs_base::picture::Picture;
use powergs_frame::splat::pixel::{PixelAlpha, spans};
use powergs_frame::splat::{Splat, TRANSMITTANCE_MIN, TileGrid};
use powergs_scene::{Camera, Gaussians};

/// How the entries of a list make a colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ListBlending {
    /// One over the next, nearest first, until hardly any light is left.
    Over,
    /// In any order: a mean of the colours by α and by depth to the power of minus so much, as
    /// opaque as all of them together. Nothing stops.
    Weighted(f32),
}

/// The splats of a view and their colours, by depth rank.
#[derive(Debug)]
pub struct PaintedView {
    splats: Vec<Splat>,
    colours: Vec<[f32; 3]>,
    size: [u32; 2],
}

impl PaintedView {
    /// What a camera sees of a scene.
    pub fn new(scene: &Gaussians, camera: &Camera, level: Level) -> PaintedView {
        let (splats, colours) = front_to_back(scene, camera, level, |depth| depth);
        PaintedView { splats, colours, size: [camera.width, camera.height] }
    }

    /// The splats, by depth rank: those of a trace frame of the view.
    pub fn splats(&self) -> &[Splat] {
        &self.splats
    }

    /// The picture of the lists of tiles of `tile` pixels, row-major: depth ranks in the order in
    /// which they are blended.
    ///
    /// # Panics
    /// When there is not a list for each tile, or a rank is of no splat.
    pub fn blend(
        &self,
        tile: u32,
        lists: &[Vec<u32>],
        blending: ListBlending,
        background: [f32; 3],
    ) -> Picture {
        let [width, height] = self.size;
        let grid = TileGrid::new(width, height, tile);
        assert_eq!(lists.len(), grid.len(), "a list for each tile");
        let mut pixels = vec![background; width as usize * height as usize];
        let rows = pixels.par_chunks_mut((width * tile) as usize).enumerate();
        rows.for_each(|(ty, row)| {
            for tx in 0..grid.nx {
                let area = grid.pixels(tx, ty as u32);
                let list = &lists[grid.index(tx, ty as u32)];
                let colours = self.tile(list, area, blending, background);
                let (x0, y0, x1, y1) = area;
                for (y, colours) in (0..y1 - y0).zip(colours.chunks_exact((x1 - x0) as usize)) {
                    let start = (y * width + x0) as usize;
                    row[start..start + colours.len()].copy_from_slice(colours);
                }
            }
        });
        Picture { width, height, pixels }
    }

    fn tile(
        &self,
        list: &[u32],
        area: (u32, u32, u32, u32),
        blending: ListBlending,
        background: [f32; 3],
    ) -> Vec<[f32; 3]> {
        let (x0, y0, x1, y1) = area;
        let mut pixels = vec![OpenPixel::default(); ((x1 - x0) * (y1 - y0)) as usize];
        for &rank in list {
            let splat = &self.splats[rank as usize];
            let (alpha, colour) = (PixelAlpha::of(splat), self.colours[rank as usize]);
            let weight = match blending {
                ListBlending::Over => 1.0,
                ListBlending::Weighted(power) => f64::from(splat.depth).powf(-f64::from(power)),
            };
            for (y, span) in spans(splat, area) {
                let Some([first, end]) = span else { continue };
                let row = &mut pixels[((y - y0) * (x1 - x0)) as usize..];
                for x in first..end {
                    let pixel = &mut row[(x - x0) as usize];
                    match blending {
                        ListBlending::Over => pixel.over(alpha.at(x, y), colour),
                        ListBlending::Weighted(_) => pixel.weigh(alpha.at(x, y), weight, colour),
                    }
                }
            }
        }
        pixels.into_iter().map(|pixel| pixel.colour(blending, background)).collect()
    }
}

/// What a pixel has seen so far.
#[derive(Debug, Clone, Copy)]
struct OpenPixel {
    /// Weights of great powers leave single precision.
    sum: [f64; 3],
    weight: f64,
    transmittance: f32,
    is_done: bool,
}

impl Default for OpenPixel {
    fn default() -> OpenPixel {
        OpenPixel { sum: [0.0; 3], weight: 0.0, transmittance: 1.0, is_done: false }
    }
}

impl OpenPixel {
    fn add(&mut self, weight: f64, colour: [f32; 3]) {
        self.sum.iter_mut().zip(colour).for_each(|(sum, c)| *sum += weight * f64::from(c));
    }

    fn over(&mut self, alpha: f32, colour: [f32; 3]) {
        if alpha == 0.0 || self.is_done {
            return;
        }
        let rest = self.transmittance * (1.0 - alpha);
        // As in the reference, the splat that would go below the limit is not blended itself.
        if rest < TRANSMITTANCE_MIN {
            self.is_done = true;
            return;
        }
        self.add(f64::from(self.transmittance * alpha), colour);
        self.transmittance = rest;
    }

    fn weigh(&mut self, alpha: f32, weight: f64, colour: [f32; 3]) {
        let own = f64::from(alpha) * weight;
        self.add(own, colour);
        self.weight += own;
        self.transmittance *= 1.0 - alpha;
    }

    fn colour(&self, blending: ListBlending, background: [f32; 3]) -> [f32; 3] {
        let scale = match blending {
            ListBlending::Over => 1.0,
            ListBlending::Weighted(_) if self.weight > 0.0 => {
                f64::from(1.0 - self.transmittance) / self.weight
            }
            ListBlending::Weighted(_) => 0.0,
        };
        std::array::from_fn(|c| (scale * self.sum[c]) as f32 + self.transmittance * background[c])
    }
}
