//! Pixels of one frame moved to where they are in the next one.

use std::sync::atomic::{AtomicU64, Ordering};

use super::PixelsSpec;
use crate::workload::FrameWorkload;
use glam::{DMat3, DVec3};
use powergs_frame::scene::Camera;
use rayon::prelude::*;

/// A pixel that was shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShownPixel {
    /// Depth: infinite where nothing is, not a number where it was filled in.
    pub depth: f32,
    /// Where in the pixel what it shows lies, in parts of 256: without it every move would round
    /// anew.
    pub place: [u8; 2],
}

impl ShownPixel {
    /// One that was rendered.
    pub const fn rendered(depth: f32) -> ShownPixel {
        ShownPixel { depth, place: [128; 2] }
    }

    /// One that was filled in.
    const FILLED: ShownPixel = ShownPixel::rendered(f32::NAN);
}

/// The pixels that were shown of a frame.
#[derive(Debug, Clone)]
pub struct Shown {
    camera: Camera,
    /// Row by row.
    pixels: Vec<ShownPixel>,
    /// Frames since one was rendered whole.
    age: u32,
}

/// No pixel.
const NONE: u64 = u64::MAX;

/// What is not in front of this is behind the eye.
const NEAR: f64 = 1e-6;

impl Shown {
    /// Of a frame, with the pixels of its tiles; `before` is that from which some were taken.
    pub fn new(
        workload: &FrameWorkload,
        tiles: Vec<Vec<ShownPixel>>,
        before: Option<&Shown>,
    ) -> Shown {
        let width = workload.width as usize;
        let mut pixels = vec![ShownPixel::FILLED; width * workload.height as usize];
        for (tile, own) in tiles.iter().enumerate() {
            let (x0, y0, x1, _) = workload.pixels_of(tile);
            for (y, row) in (y0 as usize..).zip(own.chunks_exact(((x1 - x0) as usize).max(1))) {
                let start = y * width + x0 as usize;
                pixels[start..start + row.len()].copy_from_slice(row);
            }
        }
        let camera = workload.camera.clone().expect("a frame has a camera");
        Shown { camera, pixels, age: before.map_or(0, |before| before.age + 1) }
    }

    /// Whether a frame takes pixels of this one: it is of the same size, and not the one of its
    /// period that is rendered whole.
    pub fn goes_on(&self, workload: &FrameWorkload, spec: &PixelsSpec) -> bool {
        let size = [self.camera.width, self.camera.height];
        size == [workload.width, workload.height] && self.age + 1 < spec.period
    }

    /// Moves its pixels to where another camera sees them. Of those that come to the same place the
    /// nearest stays, and of equally near ones the first.
    pub fn warp<'a>(&'a self, to: &'a Camera) -> Warp<'a> {
        let from = &self.camera;
        let (width, new_width) = (from.width as usize, to.width as usize);
        let new: Vec<AtomicU64> =
            (0..new_width * to.height as usize).map(|_| AtomicU64::new(NONE)).collect();
        let mut warp = Warp {
            shown: self,
            to,
            turned: to.world_to_camera * from.world_to_camera.transpose(),
            moved: to.world_to_camera * (from.centre - to.centre),
            from: Vec::new(),
        };
        self.pixels.par_chunks(width.max(1)).enumerate().for_each(|(y, row)| {
            for source in y * width..y * width + row.len() {
                let Some(([x, y], depth)) = warp.moved(source) else { continue };
                let inside = (0.0..f64::from(to.width)).contains(&x)
                    && (0.0..f64::from(to.height)).contains(&y);
                if inside {
                    // Bits of positive numbers are in their order.
                    let key = u64::from(depth.to_bits()) << 32 | source as u64;
                    new[y as usize * new_width + x as usize].fetch_min(key, Ordering::Relaxed);
                }
            }
        });
        warp.from = new.into_iter().map(AtomicU64::into_inner).collect();
        warp
    }
}

/// Where the pixels of a frame come from.
#[derive(Debug)]
pub struct Warp<'a> {
    shown: &'a Shown,
    to: &'a Camera,
    turned: DMat3,
    moved: DVec3,
    /// Depth in the upper half, the pixel in the lower one.
    from: Vec<u64>,
}

impl Warp<'_> {
    /// Where a pixel comes to, from the edge of the image on, and how deep it is then; `None` for
    /// one that was filled in, and behind the eye.
    fn moved(&self, source: usize) -> Option<([f64; 2], f32)> {
        let (from, to) = (&self.shown.camera, self.to);
        let ShownPixel { depth, place } = self.shown.pixels[source];
        if depth.is_nan() {
            return None;
        }
        let width = from.width as usize;
        let [x, y] = [source % width, source / width].map(|n| n as f64);
        let [dx, dy] = place.map(|part| f64::from(part) / 256.0);
        let ray = DVec3::new((x + dx - from.cx) / from.fx, (y + dy - from.cy) / from.fy, 1.0);
        // What is infinitely far turns and does not move.
        let place = match depth.is_finite() {
            true => self.turned * (ray * f64::from(depth)) + self.moved,
            false => self.turned * ray,
        };
        let new = [to.fx * place.x / place.z + to.cx, to.fy * place.y / place.z + to.cy];
        let depth = if depth.is_finite() { place.z as f32 } else { f32::INFINITY };
        (place.z > NEAR).then_some((new, depth))
    }

    /// The pixels of an area, `(x0, y0, x1, y1)`, half open, row by row: which one of the frame
    /// before comes there; `None` where none does.
    pub fn pixels(
        &self,
        (x0, y0, x1, y1): (u32, u32, u32, u32),
    ) -> impl Iterator<Item = Option<u32>> + '_ {
        let places = (y0..y1).flat_map(move |y| (x0..x1).map(move |x| (y, x)));
        places.map(|(y, x)| {
            let key = self.from[y as usize * self.to.width as usize + x as usize];
            (key != NONE).then_some(key as u32)
        })
    }

    /// How many pixels of an area none comes to.
    pub fn missing(&self, area: (u32, u32, u32, u32)) -> u32 {
        self.pixels(area).filter(Option::is_none).count() as u32
    }

    /// The pixels of an area as they are shown.
    pub fn shown(&self, area: (u32, u32, u32, u32)) -> Vec<ShownPixel> {
        let shown = |pixel: Option<u32>| {
            let Some(([x, y], depth)) = pixel.and_then(|pixel| self.moved(pixel as usize)) else {
                return ShownPixel::FILLED;
            };
            ShownPixel { depth, place: [x, y].map(|n| (n.fract() * 256.0) as u8) }
        };
        self.pixels(area).map(shown).collect()
    }
}
