//! A scene as the culling and conversion unit of `rtl/` takes it, and the picture of the whole
//! hardware.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::picture::{TileEntry, draw_tile};
use powergs_base::picture::Picture;
use powergs_datapath::ccu::tiles::{Pair, Walk};
use powergs_datapath::ccu::{Ccu, Converted, Gaussian, Settings, camera as settings};
use powergs_datapath::vectors::CcuWork;
use powergs_datapath::{NumberFormat, Record, TILE, Vrc, WideFormat};
use powergs_frame::scene::ShDegree;
use powergs_frame::splat::TileGrid;
use powergs_frame::splat::project::{View, compensations};
use powergs_raster::Options;
use powergs_scene::{Camera, Gaussians};

/// Gaussians of a scene for a culling and conversion unit, in one view.
#[derive(Debug, Clone)]
pub struct FrontEnd<'a> {
    scene: &'a Gaussians,
    view: View,
    /// The unit.
    pub unit: Ccu,
    /// The view.
    pub settings: Settings,
    /// Degree of the colours, 0 to 3.
    pub degree: u32,
}

impl<'a> FrontEnd<'a> {
    /// The unit of `rtl/` that hands over numbers of `narrow`, with its view; `None` where the
    /// format has less than four bits of exponent.
    pub fn new(scene: &'a Gaussians, camera: &Camera, narrow: NumberFormat) -> Option<Self> {
        let wide = WideFormat::new(8, 15).expect("24 bits");
        let rows = [0, 1, 2].map(|row| camera.world_to_camera.row(row).to_array());
        let settings = settings(
            wide,
            camera.centre.to_array(),
            rows,
            [camera.fx, camera.fy],
            [camera.cx, camera.cy],
            [camera.width, camera.height],
        );
        let degree = u32::from(scene.sh_degree.min(3));
        let view = View::new(camera);
        Some(FrontEnd { scene, view, unit: Ccu::new(wide, narrow)?, settings, degree })
    }

    /// Gaussian `i` in the numbers of the unit. The unit has nothing that compensates opacities for
    /// its low-pass: those of an anti-aliased model come compensated.
    pub fn gaussian(&self, i: usize) -> Gaussian {
        let number = |value: f64| self.unit.wide().from_f64(value);
        let turn = self.scene.rotations[i].map(f64::from);
        let length = turn.iter().map(|q| q * q).sum::<f64>().sqrt() / std::f64::consts::SQRT_2;
        let scales = self.scene.log_scales[i].map(|s| f64::from(s).exp());
        let opacity =
            self.compensation(i) / (1.0 + (-f64::from(self.scene.logit_opacities[i])).exp());
        let [s0, s1, s2] = scales.map(number);
        let [w, x, y, z] = turn.map(|q| number(q / length));
        let shape = [s0, s1, s2, w, x, y, z, number(opacity)];
        Gaussian { mean: self.scene.means[i].map(|m| number(f64::from(m))), shape }
    }

    fn compensation(&self, i: usize) -> f64 {
        if !self.scene.antialiased {
            return 1.0;
        }
        let index = [i as u32];
        let factors = dispatch!(Level::new(), simd =>
            compensations(simd, self.scene, &self.view, &index));
        f64::from(factors[0])
    }

    /// Coefficients of the colour of Gaussian `i`, with the factors of their functions; those
    /// beyond the scene's degree are 0.
    pub fn coefficients(&self, i: usize) -> [u16; 48] {
        let kept = (self.scene.sh_degree as usize + 1).pow(2);
        let narrow = self.unit.narrow();
        let mut coefficients = [0; 48];
        for k in 0..kept.min(16) {
            for channel in 0..3 {
                let of = self.scene.sh[(3 * i + channel) * kept + k] * ShDegree::FACTORS[k];
                let half = if k == 0 { 0.5 } else { 0.0 };
                coefficients[3 * k + channel] = narrow.from_f32(of + half);
            }
        }
        coefficients
    }

    /// Gaussian `i` with its coefficients.
    pub fn work(&self, i: usize) -> CcuWork {
        CcuWork { gaussian: self.gaussian(i), coefficients: self.coefficients(i) }
    }

    /// What becomes of Gaussian `i`: what leaves for it, its tiles, its colour; `None` where
    /// nothing of it is seen.
    pub(crate) fn converted(&self, i: usize) -> Option<(Converted, Walk, [u16; 3])> {
        let (splat, walk) = self.unit.splat(&self.settings, &self.gaussian(i))?;
        let colour = self.unit.colour(self.degree, &splat.direction, &self.coefficients(i));
        Some((splat, walk, colour))
    }

    /// The pairs of Gaussian `i`: tile and what its list gets.
    fn pairs(&self, i: usize) -> Vec<(u32, Placed)> {
        let Some((splat, walk, colour)) = self.converted(i) else { return Vec::new() };
        let pair = |pair: Pair| {
            let record =
                Record { mean: pair.local, root: splat.root, opacity: splat.opacity, colour };
            let entry = TileEntry { splat: record, subtiles: pair.subtiles };
            let tile = pair.tile[1] * self.settings.tiles[0] + pair.tile[0];
            (tile, Placed { depth: splat.depth, index: i as u32, entry })
        };
        walk.pairs(self.unit.narrow()).into_iter().map(pair).collect()
    }
}

/// An entry with what it is sorted by.
struct Placed {
    depth: u16,
    index: u32,
    entry: TileEntry,
}

/// Renders one view as the hardware of `rtl/` does, from the Gaussian to the pixel: culling,
/// projection, box tests of tiles and sub-tiles, colours, depths as sort keys and blending, all in
/// the number formats of the units. Ties of depths are decided by the index in the scene. `None`
/// where the format has less than four bits of exponent. Of the options only the background
/// matters.
pub fn render_hardware(
    scene: &Gaussians,
    camera: &Camera,
    options: &Options,
    vrc: &Vrc,
) -> Option<Picture> {
    let front = FrontEnd::new(scene, camera, vrc.format())?;
    let grid = TileGrid::new(camera.width, camera.height, TILE);
    let pairs: Vec<Vec<(u32, Placed)>> =
        (0..scene.len()).into_par_iter().map(|i| front.pairs(i)).collect();
    let mut lists: Vec<Vec<Placed>> = Vec::new();
    lists.resize_with((grid.nx * grid.ny) as usize, Vec::new);
    for (tile, placed) in pairs.into_iter().flatten() {
        lists[tile as usize].push(placed);
    }
    let mut picture = Picture {
        width: camera.width,
        height: camera.height,
        pixels: vec![[0.0; 3]; camera.width as usize * camera.height as usize],
    };
    let lines = (camera.width * TILE) as usize;
    let rows = lists.par_chunks_mut(grid.nx as usize).enumerate();
    picture.pixels.par_chunks_mut(lines).zip(rows).for_each(|(pixels, (ty, lists))| {
        for (tx, list) in (0..).zip(lists) {
            // Depths are not negative, so their bits have their order.
            list.sort_unstable_by_key(|placed| (placed.depth, placed.index));
            let entries = list.iter().map(|placed| placed.entry);
            let place = (grid.pixels(tx, ty as u32), camera.width as usize);
            draw_tile(vrc, place, entries, options.background, pixels);
        }
    });
    Some(picture)
}
