//! The picture that the rendering units of `rtl/` draw: the lists of the rasteriser, blended bit
//! for bit as `powergs_datapath` does.
//!
//! Splats are projected and coloured in f32; their features are then rounded to the number format,
//! means relative to each tile. Lists have the order of the keys by which the hardware sorts:
//! depths in a number format of their own, ties by index in the scene.

use rayon::prelude::*;

use powergs_base::picture::Picture;
use powergs_datapath::{NumberFormat, Pixel, Record, TILE, Vrc};
use powergs_frame::splat::runs::Runs;
use powergs_frame::splat::{Splat, TileGrid};
use powergs_raster::{Options, front_to_back};
use powergs_scene::{Camera, Gaussians};

/// Renders one view with the datapath of a core. Lists are sorted by depths in the format `keys`,
/// or by those in f32. Of the options only the test, the background and the instruction set matter:
/// tiles are those of the core.
pub fn render_datapath(
    scene: &Gaussians,
    camera: &Camera,
    options: &Options,
    vrc: &Vrc,
    keys: Option<NumberFormat>,
) -> Picture {
    let (splats, colours) = ordered(scene, camera, options, keys);
    let grid = TileGrid::new(camera.width, camera.height, TILE);
    let runs = Runs::new(&splats, grid, options.test);
    let mut picture = Picture {
        width: camera.width,
        height: camera.height,
        pixels: vec![[0.0; 3]; camera.width as usize * camera.height as usize],
    };
    let frame = Frame { vrc, runs: &runs, splats: &splats, colours: &colours };
    let lines = (camera.width * TILE) as usize;
    picture.pixels.par_chunks_mut(lines).enumerate().for_each(|(ty, pixels)| {
        frame.render_row(ty as u32, options.background, pixels);
    });
    picture
}

/// The splats of a view and their colours, front to back by the keys of the hardware.
pub(super) fn ordered(
    scene: &Gaussians,
    camera: &Camera,
    options: &Options,
    keys: Option<NumberFormat>,
) -> (Vec<Splat>, Vec<[f32; 3]>) {
    let key = |depth: f32| keys.map_or(depth, |keys| keys.to_f32(keys.from_f32(depth)));
    front_to_back(scene, camera, options.level, key)
}

/// What all rows of tiles share.
struct Frame<'a> {
    vrc: &'a Vrc,
    runs: &'a Runs,
    splats: &'a [Splat],
    colours: &'a [[f32; 3]],
}

impl Frame<'_> {
    /// Renders row `ty` of tiles into its lines of the picture.
    fn render_row(&self, ty: u32, background: [f32; 3], pixels: &mut [[f32; 3]]) {
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); self.runs.grid.nx as usize];
        for run in self.runs.row(ty) {
            for list in &mut lists[usize::from(run.x0)..usize::from(run.x1)] {
                list.push(run.rank);
            }
        }
        for (tx, list) in lists.iter().enumerate() {
            self.render_tile([tx as u32, ty], list, background, pixels);
        }
    }

    fn render_tile(
        &self,
        [tx, ty]: [u32; 2],
        list: &[u32],
        background: [f32; 3],
        out: &mut [[f32; 3]],
    ) {
        let place = self.runs.grid.pixels(tx, ty);
        let middle = [place.0, place.1].map(|first| f64::from(first) + 0.5 * f64::from(TILE - 1));
        let entries = list.iter().filter_map(|&rank| {
            let Splat { mean, cov, opacity, .. } = self.splats[rank as usize];
            let mean = [0, 1].map(|i| f64::from(mean[i]) - middle[i]);
            let splat = self.vrc.record(mean, cov, opacity, self.colours[rank as usize])?;
            Some(TileEntry { splat, subtiles: ALL })
        });
        let lines = self.runs.grid.width as usize;
        draw_tile(self.vrc, (place, lines), entries, background, out);
    }
}

/// An entry of a tile's list.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileEntry {
    /// The splat relative to the tile.
    pub splat: Record,
    /// Sub-tiles that it is for, a bit each, row by row.
    pub subtiles: u32,
}

/// All four sub-tiles.
const ALL: u32 = 0xf;

/// Blends the entries of a tile, front to back, into `out`: the lines of the picture that its row
/// of tiles has, of `length` pixels each. The tile is first and end pixel of columns and rows.
pub(super) fn draw_tile(
    vrc: &Vrc,
    ((x0, y0, x1, y1), length): ((u32, u32, u32, u32), usize),
    entries: impl Iterator<Item = TileEntry>,
    background: [f32; 3],
    out: &mut [[f32; 3]],
) {
    let format = vrc.format();
    let (width, height) = (x1 - x0, y1 - y0);
    let mut pixels = vec![Pixel::open(format, true); (width * height) as usize];
    let mut live = pixels.len();
    for TileEntry { splat, subtiles } in entries {
        let reach = vrc.reach(&splat);
        for y in 0..height {
            for x in 0..width {
                let subtile = 2 * (2 * y / TILE) + 2 * x / TILE;
                let pixel = &mut pixels[(y * width + x) as usize];
                if pixel.live && subtiles >> subtile & 1 == 1 && !reach.misses(x, y) {
                    vrc.blend(pixel, &splat, x, y);
                    live -= usize::from(!pixel.live);
                }
            }
        }
        if live == 0 {
            break;
        }
    }
    for (i, pixel) in (0..).zip(&pixels) {
        let line = (i / width) as usize * length;
        let behind = format.to_f32(pixel.transmittance);
        let colour = [0, 1, 2].map(|c| format.to_f32(pixel.colour[c]) + behind * background[c]);
        out[line + (x0 + i % width) as usize] = colour;
    }
}
