//! One foveated frame in a single pass: tiles have levels, and near the next one blend two.
//!
//! The scene is projected, sorted and listed once. A tile's list holds the splats whose highest
//! level is not below the tile's; its pixels are blended with the colours and opacities of that
//! level, and where it blends, of the next one too, in the same pass into a second accumulator
//! (`powergs.md` §6.4 in the corrected form of §10). A pixel that sees one level only takes no part
//! in the other. The picture equals that of every level rendered whole, mixed pixel by pixel.

mod paints;
mod pair;
mod row;

use rayon::prelude::*;

use self::paints::LevelPaints;
use self::row::{FoveatedRowTarget, Shared, Work, render_row};
use super::blend::{BlendCounted, BlendRecord, ImageOnly};
use super::forward::{Detail, Options, preview};
use super::row::{Fetched, TileCount, count_fetches};
use powergs_base::picture::Picture;
use powergs_frame::fovea::{GazeError, ScreenGaze, TileLevels};
use powergs_frame::splat::runs::{Levels, Runs, Touch};
use powergs_frame::splat::{Counters, FoveaCounters, Splat, TileGrid};
use powergs_frame::trace::{Fovea, Frame, FrameFacts, PixelColumns};
use powergs_scene::{Camera, Foveated, ShDegree};

/// Counts of one tile.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FoveatedTile {
    /// List, loads and first level; evaluations are those until both levels have stopped.
    pub count: TileCount,
    /// Entries while both levels were open, summed over its pixels (`T_extra_alpha`).
    pub extra_alpha: u64,
    /// Entries blended for the second level, without terminating ones (`T_used2`).
    pub blends_2: u64,
}

/// A rendered foveated frame.
#[derive(Debug, Clone)]
pub struct FoveatedFrame {
    /// The image, over the background, not clamped.
    pub picture: Picture,
    /// Visible splats in depth order; only those that some tile could show for [`Detail::Image`].
    /// The opacity is the largest of the levels that it has.
    pub splats: Vec<Splat>,
    /// Highest level of every splat, by rank.
    pub highest: Vec<u8>,
    /// One bit per Gaussian: passed the cull.
    pub survivor_bits: Vec<u8>,
    /// Degree of the scene's spherical harmonics.
    pub sh_degree: ShDegree,
    /// Whether the scene is an anti-aliased model.
    pub antialiased: bool,
    /// Frame totals; only `points` and `survivors` for [`Detail::Image`].
    pub counters: Counters,
    /// Counters of foveated frames.
    pub fovea: FoveaCounters,
    /// Tests and accepted tiles per splat, by rank; empty for [`Detail::Image`].
    pub touches: Vec<Touch>,
    /// Tiles that fetched each splat, by rank.
    pub fetches: Vec<u32>,
    /// Per-pixel columns of the first level.
    pub pixels: PixelColumns,
    /// Per-pixel columns of the second level: stop rank, entries while both are open, blended.
    pub second: [Vec<u32>; 3],
    /// Tiles, row-major.
    pub tiles: Vec<FoveatedTile>,
    /// The gaze and the screen.
    pub gaze: ScreenGaze,
}

/// Renders one view of a foveated model. [`Detail::Dominance`] and [`Detail::Hits`] count
/// as [`Detail::Counters`].
///
/// # Errors
/// [`GazeError`]: a gaze outside the picture, or an impossible screen.
pub fn render_foveated(
    model: &Foveated,
    camera: &Camera,
    gaze: &ScreenGaze,
    options: &Options,
) -> Result<FoveatedFrame, GazeError> {
    let map = gaze.eccentricity_map([camera.width, camera.height])?;
    let grid = TileGrid::new(camera.width, camera.height, options.tile);
    let levels = TileLevels::new(&map, grid);
    Ok(match options.detail {
        Detail::Image => render_as(model, camera, *gaze, &levels, options, ImageOnly),
        Detail::Counters | Detail::Dominance | Detail::Hits => {
            render_as(model, camera, *gaze, &levels, options, BlendCounted)
        }
    })
}

fn render_as<R: BlendRecord>(
    model: &Foveated,
    camera: &Camera,
    gaze: ScreenGaze,
    levels: &TileLevels,
    options: &Options,
    record: R,
) -> FoveatedFrame {
    let filter = levels.filter();
    let paints = LevelPaints::new(model, camera, &filter, options.level, !R::COUNT);
    let (grid, test) = (levels.grid, options.test);
    let runs = if R::COUNT {
        let by_level = Levels { filter: &filter, highest: &paints.highest };
        Runs::foveated(&paints.splats, grid, test, by_level)
    } else {
        Runs::new(&paints.splats, grid, test)
    };
    let shared = Shared {
        runs: &runs,
        paints: &paints,
        levels,
        filter: &filter,
        background: options.background,
        chunk: options.chunk,
        level: options.level,
    };
    let mut frame = FoveatedFrame::sized::<R>(camera, gaze, grid);
    let mut fetched = vec![Fetched::ALL; if R::COUNT { grid.len() } else { 0 }];
    targets(&mut frame, &mut fetched, grid).into_par_iter().enumerate().for_each_init(
        Work::default,
        |work, (ty, mut out)| {
            render_row(&shared, ty as u32, record, work, &mut out);
        },
    );
    if R::COUNT {
        count_fetches(&runs, &fetched, options.level, |ty| shared.keep(ty), &mut frame.fetches);
        frame.touches = runs.touches;
    }
    frame.survivor_bits = paints.survivor_bits;
    frame.sh_degree = model.base.degree();
    frame.antialiased = model.base.antialiased;
    (frame.splats, frame.highest) = (paints.splats, paints.highest);
    (frame.counters, frame.fovea) = totals(model, &frame);
    frame
}

/// The lines of each row of tiles. Columns that are not recorded stay empty.
fn targets<'a>(
    frame: &'a mut FoveatedFrame,
    fetched: &'a mut [Fetched],
    grid: TileGrid,
) -> Vec<FoveatedRowTarget<'a>> {
    let lines = (grid.width * grid.tile) as usize;
    let mut stop_rank = frame.pixels.stop_rank.chunks_mut(lines);
    let mut blended = frame.pixels.blended.chunks_mut(lines);
    let [stop_rank_2, extra_alpha, blended_2] = &mut frame.second;
    let mut second = [stop_rank_2, extra_alpha, blended_2].map(|column| column.chunks_mut(lines));
    let mut fetched = fetched.chunks_mut(grid.nx as usize);
    let rows = frame.picture.pixels.chunks_mut(lines);
    rows.zip(frame.tiles.chunks_mut(grid.nx as usize))
        .map(|(pixels, tiles)| FoveatedRowTarget {
            pixels,
            tiles,
            fetched: fetched.next().unwrap_or_default(),
            stop_rank: stop_rank.next().unwrap_or_default(),
            blended: blended.next().unwrap_or_default(),
            second: second.each_mut().map(|column| column.next().unwrap_or_default()),
        })
        .collect()
}

fn totals(model: &Foveated, frame: &FoveatedFrame) -> (Counters, FoveaCounters) {
    let mut counters = Counters {
        points: model.len() as u64,
        survivors: frame.survivor_bits.iter().map(|b| u64::from(b.count_ones())).sum(),
        fetched_points: frame.fetches.iter().filter(|&&n| n > 0).count() as u64,
        ..Counters::default()
    };
    let mut fovea = FoveaCounters::default();
    for touch in &frame.touches {
        counters.touch(touch);
        fovea.touch(touch);
    }
    for (touch, _) in frame.touches.iter().zip(&frame.fetches).filter(|(_, n)| **n > 0) {
        fovea.fetch(touch);
    }
    for tile in &frame.tiles {
        counters.tile_loads += u64::from(tile.count.loaded);
        counters.alpha_evaluations += tile.count.alpha_evaluations;
        counters.blends += tile.count.blends;
        fovea.extra_alpha += tile.extra_alpha;
        fovea.blends_2 += tile.blends_2;
    }
    (counters, fovea)
}

impl FoveatedFrame {
    fn sized<R: BlendRecord>(camera: &Camera, gaze: ScreenGaze, grid: TileGrid) -> FoveatedFrame {
        let n = camera.width as usize * camera.height as usize;
        let column = || vec![0; if R::COUNT { n } else { 0 }];
        let (width, height) = (camera.width, camera.height);
        FoveatedFrame {
            picture: Picture { width, height, pixels: vec![[0.0; 3]; n] },
            splats: Vec::new(),
            highest: Vec::new(),
            survivor_bits: Vec::new(),
            sh_degree: ShDegree::ZERO,
            antialiased: false,
            counters: Counters::default(),
            fovea: FoveaCounters::default(),
            touches: Vec::new(),
            fetches: Vec::new(),
            pixels: PixelColumns { stop_rank: column(), blended: column() },
            second: [column(), column(), column()],
            tiles: vec![FoveatedTile::default(); grid.len()],
            gaze,
        }
    }

    /// The trace frame of this rendering. Must have been rendered with the reference tiling and
    /// counters.
    pub fn into_frame(self, camera: &Camera, background: [f32; 3]) -> Frame {
        assert!(!self.pixels.stop_rank.is_empty(), "a trace frame needs Detail::Counters");
        let [stop_rank_2, extra_alpha, blended_2] = self.second;
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
            preview: Some(preview(&self.picture)),
            splats: self.splats,
            survivor_bits: Some(self.survivor_bits),
            frustum_bits: None,
            pixels: self.pixels,
            fovea: Some(Fovea {
                gaze: self.gaze.point,
                screen: self.gaze.screen,
                highest_level: self.highest,
                stop_rank_2,
                extra_alpha,
                blended_2,
            }),
        }
    }
}
