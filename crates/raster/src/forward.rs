//! One frame: project, sort by depth, list, blend.

use std::sync::atomic::AtomicU64;

use fearless_simd::Level;
use rayon::prelude::*;

use super::blend::{BlendCounted, BlendRecord, Dominance, ImageOnly, OPEN, Tallied, WEIGHT_STEP};
use super::prepare::Prepared;
use super::row::{
    Fetched, KeepEverything, RowTarget, Shared, TileCount, Work, count_fetches, render_row,
};
use powergs_base::picture::Picture;
use powergs_frame::splat::project::inside_frustum;
use powergs_frame::splat::runs::Touch;
use powergs_frame::splat::{Counters, Intersection, Splat, TileGrid};
use powergs_frame::trace::{Frame, FrameFacts, PixelColumns, Preview};
use powergs_scene::{Camera, Gaussians, ShDegree};

/// How to render.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Tile side, pixels (16 in the reference).
    pub tile: u32,
    /// Splat-against-tile test (OBB in the reference).
    pub test: Intersection,
    /// List entries fetched together (256 in the reference).
    pub chunk: u32,
    /// Background colour, sRGB.
    pub background: [f32; 3],
    /// What is recorded besides the image.
    pub detail: Detail,
    /// Instruction set; the best of this processor by default.
    pub level: Level,
}

impl Options {
    /// The reference tiling of traces over a black background: 16x16 tiles, OBB lists, chunks of
    /// 256.
    pub fn reference(detail: Detail) -> Options {
        Options {
            tile: 16,
            test: Intersection::Obb,
            chunk: 256,
            background: [0.0; 3],
            detail,
            level: Level::new(),
        }
    }
}

/// What is recorded besides the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Nothing.
    Image,
    /// The counters of a trace.
    Counters,
    /// The counters of a trace, what every pixel iterated, and per splat what pruning needs.
    Dominance,
    /// Per splat the pixels that it is blended into, and no other counter.
    Hits,
}

/// A rendered frame.
#[derive(Debug, Clone, Default)]
pub struct Rendered {
    /// The image, over the background, not clamped.
    pub picture: Picture,
    /// Visible splats in depth order (position is the rank).
    pub splats: Vec<Splat>,
    /// One bit per Gaussian: passed the cull.
    pub survivor_bits: Vec<u8>,
    /// Degree of the scene's spherical harmonics.
    pub sh_degree: ShDegree,
    /// Whether the scene is an anti-aliased model.
    pub antialiased: bool,
    /// Frame totals; only `points` and `survivors` for [`Detail::Image`].
    pub counters: Counters,
    /// Tests and accepted tiles per splat, by rank.
    pub touches: Vec<Touch>,
    /// Tiles that fetched each splat (`intersect_count`), by rank.
    pub fetches: Vec<u32>,
    /// Pixels in which each splat is the heaviest (`dominance_count`), by rank.
    pub dominance: Vec<u32>,
    /// Pixels that each splat was blended into, by rank, without those that stop at it; only for
    /// [`Detail::Hits`].
    pub hits: Vec<u32>,
    /// The sum over all pixels of the weight with which each splat is blended, by rank; only for
    /// [`Detail::Dominance`].
    pub weights: Vec<f64>,
    /// Per-pixel columns of a trace.
    pub pixels: PixelColumns,
    /// Entries iterated by each pixel (`T_bf_term`), row-major; only for [`Detail::Dominance`].
    pub iterated: Vec<u32>,
    /// Tiles, row-major.
    pub tiles: Vec<TileCount>,
}

/// Renders one view. Cannot fail: scene and camera are checked where they are read.
pub fn render(scene: &Gaussians, camera: &Camera, options: &Options) -> Rendered {
    let mut canvas = Canvas::new();
    canvas.render(scene, camera, options);
    canvas.rendered
}

/// Renders views one after another, each in the memory of the one before: fresh memory costs up to
/// a fifth of a frame. What is rendered does not depend on the frames before.
#[derive(Debug, Default)]
pub struct Canvas {
    prepared: Prepared,
    tally: Vec<AtomicU64>,
    heaviest: Vec<u32>,
    /// By tile.
    fetched: Vec<Fetched>,
    rendered: Rendered,
}

impl Canvas {
    /// A canvas without a view.
    pub fn new() -> Canvas {
        Canvas::default()
    }

    /// Renders one view, as [`render`] does.
    pub fn render(&mut self, scene: &Gaussians, camera: &Camera, options: &Options) -> &Rendered {
        match options.detail {
            Detail::Image => self.render_as(scene, camera, options, ImageOnly),
            Detail::Counters => self.render_as(scene, camera, options, BlendCounted),
            Detail::Dominance => self.render_as(scene, camera, options, Dominance),
            Detail::Hits => self.render_as(scene, camera, options, Tallied),
        }
        &self.rendered
    }

    /// The trace frame of one view, as [`Rendered::into_frame`]; what a frame does not have stays
    /// for the next view. The options must have the reference tiling and count.
    pub fn frame(&mut self, scene: &Gaussians, camera: &Camera, options: &Options) -> Frame {
        self.render(scene, camera, options);
        let frame = self.rendered.take_frame(camera, options.background);
        Frame { frustum_bits: Some(inside_frustum(scene, camera)), ..frame }
    }

    fn render_as<R: BlendRecord>(
        &mut self,
        scene: &Gaussians,
        camera: &Camera,
        options: &Options,
        record: R,
    ) {
        let Canvas { prepared, tally, heaviest, fetched, rendered } = self;
        // What the view before left behind is memory for this one.
        rendered.trade(prepared);
        let grid = TileGrid::new(camera.width, camera.height, options.tile);
        prepared.prepare(scene, camera, grid, options.test, options.level);
        let Prepared { paints, runs, .. } = &*prepared;
        tally.clear();
        if R::PIXELS || R::WEIGHTS {
            tally.resize_with(paints.len(), AtomicU64::default);
        }
        let shared = Shared {
            runs,
            paints,
            background: options.background,
            chunk: options.chunk,
            tally,
            level: options.level,
        };
        rendered.resize::<R>(camera, grid);
        // Values of the view before may stay: rows write all that is read.
        heaviest.resize(if R::DOMINANCE { rendered.picture.pixels.len() } else { 0 }, OPEN);
        fetched.resize(if R::COUNT { grid.len() } else { 0 }, Fetched::ALL);
        targets(rendered, heaviest, fetched, grid)
            .into_par_iter()
            .enumerate()
            .for_each_init(Work::default, |work, (ty, mut out)| {
                render_row(&shared, ty as u32, record, work, &mut out)
            });
        rendered.fetches.clear();
        if R::COUNT {
            count_fetches(runs, fetched, options.level, |_| KeepEverything, &mut rendered.fetches);
        }
        rendered.dominance.clear();
        if R::DOMINANCE {
            rendered.dominance.resize(paints.len(), 0);
            for rank in heaviest.iter().filter(|&&rank| rank != OPEN) {
                rendered.dominance[*rank as usize] += 1;
            }
        }
        rendered.hits.clear();
        rendered.weights.clear();
        let tally = tally.iter_mut().map(|n| *n.get_mut());
        if R::PIXELS {
            rendered.hits.extend(tally.map(|n| u32::try_from(n).unwrap_or(u32::MAX)));
        } else {
            rendered.weights.extend(tally.map(|n| n as f64 * f64::from(WEIGHT_STEP)));
        }
        rendered.sh_degree = scene.degree();
        rendered.antialiased = scene.antialiased;
        // Back before the totals, which are counted from what was prepared.
        rendered.trade(prepared);
        rendered.counters = totals(scene, rendered);
    }
}

/// The lines of each row of tiles. Columns that are not recorded stay empty.
fn targets<'a>(
    rendered: &'a mut Rendered,
    heaviest: &'a mut [u32],
    fetched: &'a mut [Fetched],
    grid: TileGrid,
) -> Vec<RowTarget<'a>> {
    let lines = (grid.width * grid.tile) as usize;
    let mut stop_rank = rendered.pixels.stop_rank.chunks_mut(lines);
    let mut blended = rendered.pixels.blended.chunks_mut(lines);
    let mut iterated = rendered.iterated.chunks_mut(lines);
    let mut heaviest = heaviest.chunks_mut(lines);
    let mut fetched = fetched.chunks_mut(grid.nx as usize);
    let pixels = rendered.picture.pixels.chunks_mut(lines);
    pixels
        .zip(rendered.tiles.chunks_mut(grid.nx as usize))
        .map(|(pixels, tiles)| RowTarget {
            pixels,
            tiles,
            stop_rank: stop_rank.next().unwrap_or_default(),
            blended: blended.next().unwrap_or_default(),
            iterated: iterated.next().unwrap_or_default(),
            heaviest: heaviest.next().unwrap_or_default(),
            fetched: fetched.next().unwrap_or_default(),
        })
        .collect()
}

fn totals(scene: &Gaussians, rendered: &Rendered) -> Counters {
    let mut counters = Counters {
        points: scene.len() as u64,
        survivors: rendered.survivor_bits.iter().map(|b| u64::from(b.count_ones())).sum(),
        fetched_points: rendered.fetches.iter().filter(|&&n| n > 0).count() as u64,
        ..Counters::default()
    };
    for touch in &rendered.touches {
        counters.touch(touch);
    }
    for tile in &rendered.tiles {
        counters.tile_loads += u64::from(tile.loaded);
        counters.alpha_evaluations += tile.alpha_evaluations;
        counters.blends += tile.blends;
    }
    counters
}

/// Longer side of the picture that a trace carries for reports, pixels.
const PREVIEW_SIDE: u32 = 480;

impl Rendered {
    /// Makes room for a view; what is recorded of every pixel and tile is written later.
    fn resize<R: BlendRecord>(&mut self, camera: &Camera, grid: TileGrid) {
        let n = camera.width as usize * camera.height as usize;
        (self.picture.width, self.picture.height) = (camera.width, camera.height);
        self.picture.pixels.resize(n, [0.0; 3]);
        let counts = if R::COUNT { n } else { 0 };
        self.pixels.stop_rank.resize(counts, 0);
        self.pixels.blended.resize(counts, 0);
        self.iterated.resize(if R::DOMINANCE { n } else { 0 }, 0);
        self.tiles.resize(grid.len(), TileCount::default());
    }

    /// Gives what a view is prepared in for what was prepared.
    fn trade(&mut self, prepared: &mut Prepared) {
        std::mem::swap(&mut self.splats, &mut prepared.splats);
        std::mem::swap(&mut self.survivor_bits, &mut prepared.survivor_bits);
        std::mem::swap(&mut self.touches, &mut prepared.runs.touches);
    }

    /// The trace frame of this rendering. Must have been rendered with the reference tiling and
    /// counters.
    pub fn into_frame(mut self, camera: &Camera, background: [f32; 3]) -> Frame {
        self.take_frame(camera, background)
    }

    fn take_frame(&mut self, camera: &Camera, background: [f32; 3]) -> Frame {
        assert!(!self.pixels.stop_rank.is_empty(), "a trace frame needs Detail::Counters");
        Frame {
            facts: FrameFacts {
                camera: camera.clone(),
                points: self.counters.points,
                survivors: self.counters.survivors,
                sh_degree: Some(self.sh_degree),
                antialiased: self.antialiased,
                background,
                mean_linear_rgb: Some(self.picture.mean_linear_rgb()),
            },
            splats: std::mem::take(&mut self.splats),
            survivor_bits: Some(std::mem::take(&mut self.survivor_bits)),
            frustum_bits: None,
            pixels: std::mem::take(&mut self.pixels),
            fovea: None,
            preview: Some(preview(&self.picture)),
        }
    }
}

/// The picture that a trace carries.
pub(super) fn preview(picture: &Picture) -> Preview {
    let small = picture.shrunk(PREVIEW_SIDE);
    Preview { width: small.width, height: small.height, rgb: small.to_rgb8() }
}
