//! Where pixels come from (`pixels.impl`; A141, A142, A143): not all of a frame need be rendered.
//!
//! - **Warped.** One frame in `period` is rendered whole. Of the others every pixel that was shown
//!   is moved to where its depth says that it is now, nearest first. A tile of which more than
//!   `holes` is missing is rendered anew; what is missing of the others is filled in from its
//!   neighbours, and is not moved on into the next frame.
//! - **Cached.** A pixel that has blended its first `ids` Gaussians looks them up in the cache of
//!   its region. Where they are known its colour is, and it stops there; else it goes on, and is
//!   remembered.
//! - **Sampled.** One pixel in `stride` x `stride` is rendered.
//!
//! The depth of a pixel, and its first Gaussians, are found by blending its list: nothing of it is
//! in a trace. Depth is where less than half of the light behind reaches the eye.

mod cache;
mod table;
mod warp;

use crate::flow::History;
use crate::kernel::blocks::{BlockStream, MovedBlock};
use crate::machine::Machine;
use crate::stage::{
    Bias, DRAM_READ, DRAM_WRITE, Measured, StageDecl, StatDecl, buffer, buffer_id, counted, omit,
    part, share, sram_read, sram_write, stage_id, work, work_id,
};
use crate::workload::blend::TileBlend;
use crate::workload::{FrameWorkload, STORAGE_BLOCK, TileList};
use powergs_base::quantity::Bytes;
use powergs_energy::action::{ActionCounts, ActionId, BufferId, Memory, Phase, StageId};
use powergs_frame::scene::Eye;
use powergs_frame::splat::Ellipse;
use rayon::prelude::*;

use crate::kernel::stream::{reads, writes};
use cache::{KnownTile, RadianceCaches};
pub use table::{PixelFilter, PixelSource, PixelsSpec, SamplePattern};
pub(in crate::flow) use table::{check, goes_over, leave_out};
pub use warp::{Shown, ShownPixel, Warp};

/// What the unit declares.
pub const PIXELS: StageDecl = StageDecl {
    units: Some(|m| u32::from(m.of_type::<PixelsSpec>().source.has_unit())),
    works: &[
        work("warp-pixel", 24, "One pixel of the frame before moved to its place in this one.")
            .a_cycle(rate)
            .priced_as("alpha"),
        work("look-up", 0, "The first Gaussians of a pixel compared with those of a set.")
            .comparing(|m| m.of_type::<PixelsSpec>().ways)
            .a_cycle(rate)
            .priced_as("pivot-key"),
    ],
    buffers: &[buffer("known_pixels", "pixels.buffer", |m| {
        let spec = m.of_type::<PixelsSpec>();
        match spec.source.has_unit() {
            true => spec.buffer.shared(1),
            false => Memory { bank: Bytes(0), banks: 0, ..spec.buffer.shared(1) },
        }
    })
    .full()],
    streams: &[
        reads("known-in", "pixels that are known", &[], ["lists", "records"]),
        writes(
            "known-out",
            "pixels that were not rendered, and what is known of them",
            ["pixels", "results"],
        ),
    ],
    parts: &[part("rate", "Pixels a cycle: `pixels.per-cycle`.", rate)],
    stats: &[&RENDERED, &WARPED, &FILLED, &LOOKED_UP, &KNOWN_SHARE],
    also_waits: &["features"],
    omits: &[
        omit("a depth for each pixel, which rendering units find", Bias::Optimistic, "A141")
            .by("pixels.impl = \"warped\"", |m| is(m, PixelSource::Warped)),
        omit("regions whose cache is not there when their first tile is", Bias::Optimistic, "A142")
            .by("pixels.impl = \"cached\"", |m| is(m, PixelSource::Cached)),
    ],
    behind: &["A141", "A142"],
    optional: table::OPTIONAL,
    check: Some(table::check),
    ..StageDecl::new(
        "pxu",
        "pixel reuse unit (PXU)",
        Phase::Rendering,
        "Pixels that are not rendered: moved from the frame before, or found in a cache by the \
         first Gaussians that they blend. Keys: `pixels`.",
    )
};

const ALL_PIXELS: StatDecl = counted("pixels.all", "");
/// Pixels that are rendered.
pub const RENDERED_PIXELS: StatDecl = counted("pixels.rendered", "");
const TAKEN_PIXELS: StatDecl = counted("pixels.warped", "");
const FILLED_PIXELS: StatDecl = counted("pixels.filled", "");
const LOOKUPS: StatDecl = counted("pixels.looked_up", "");
const HITS: StatDecl = counted("pixels.known", "");

/// Share of the pixels that are rendered.
pub const RENDERED: StatDecl = share(
    "pixels.rendered_frac",
    &RENDERED_PIXELS,
    &[&ALL_PIXELS],
    "Share of the pixels that are rendered, 0 to 1, where not all are.",
);
/// Share of them that are moved from the frame before.
pub const WARPED: StatDecl = share(
    "pixels.warped_frac",
    &TAKEN_PIXELS,
    &[&ALL_PIXELS],
    "Share of the pixels that are moved from the frame before, 0 to 1.",
);
/// Share of them that are filled in from their neighbours.
pub const FILLED: StatDecl = share(
    "pixels.filled_frac",
    &FILLED_PIXELS,
    &[&ALL_PIXELS],
    "Share of the pixels that are filled in from their neighbours, 0 to 1.",
);
const LOOKED_UP: StatDecl = share(
    "pixels.looked_up_frac",
    &LOOKUPS,
    &[&ALL_PIXELS],
    "Share of the pixels that look up the first Gaussians that they blend, 0 to 1.",
);
/// Share of those that look up their first Gaussians whose colour is known by them.
pub const KNOWN_SHARE: StatDecl = share(
    "pixels.known_frac",
    &HITS,
    &[&LOOKUPS],
    "Share of these whose colour is known by them, 0 to 1.",
);

/// Where the pixels of a frame come from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PixelSummary {
    /// Pixels of the image.
    pub pixels: u64,
    /// Those that are rendered.
    pub rendered: u64,
    /// Those that are moved from the frame before.
    pub taken: u64,
    /// Those that are filled in from their neighbours.
    pub filled: u64,
    /// Pixels that look up their first Gaussians.
    pub lookups: u64,
    /// Those whose colour is known by them.
    pub hits: u64,
}

impl PixelSummary {
    /// As it is reported.
    pub fn measured(&self) -> Measured {
        let mut all = self.moved();
        all.extend(Measured::of(&[(&LOOKUPS, self.lookups), (&HITS, self.hits)]));
        all
    }

    /// The same of machines without a cache of colours.
    pub fn moved(&self) -> Measured {
        let PixelSummary { pixels, rendered, taken, filled, .. } = *self;
        Measured::of(&[
            (&ALL_PIXELS, pixels),
            (&RENDERED_PIXELS, rendered),
            (&TAKEN_PIXELS, taken),
            (&FILLED_PIXELS, filled),
        ])
    }
}

fn rate(m: &Machine) -> f64 {
    f64::from(m.of_type::<PixelsSpec>().per_cycle)
}

fn is(m: &Machine, source: PixelSource) -> bool {
    m.of_type::<PixelsSpec>().source == source
}

/// The unit.
pub const PXU: StageId = stage_id("pxu");
const WARP: ActionId = work_id("warp-pixel");
const LOOK_UP: ActionId = work_id("look-up");
/// What is known of pixels.
const KNOWN: BufferId = buffer_id("known_pixels");

/// Bytes of a counter of the missing pixels of a tile.
pub const COUNTER: u64 = 2;

/// Bytes of a tag of the cache.
pub const TAG: u64 = 4;

/// Where a pixel of a picture comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelOrigin {
    /// It is rendered.
    Rendered,
    /// It is this one of the frame before, row by row.
    Moved(u32),
    /// It is filled in from its neighbours.
    Filled,
    /// It has the colour of this pixel of this frame.
    Known {
        /// Frames before it.
        frame: u32,
        /// The pixel, row by row.
        pixel: u32,
    },
}

/// A frame of which not all pixels are rendered.
#[derive(Debug)]
pub struct SomePixels {
    /// The frame with what is rendered of it; `None` where that is all.
    pub made: Option<Box<FrameWorkload>>,
    /// What the unit does.
    pub blocks: Vec<MovedBlock>,
    /// Where its pixels come from.
    pub summary: PixelSummary,
    /// The same one by one, row by row; empty where nobody wants to know it.
    pub origins: Vec<PixelOrigin>,
    actions: ActionCounts,
}

/// A tile as it is rendered: its list, and what was seen on the way.
struct SeenTile {
    list: TileList,
    /// Its pixels.
    pixels: Vec<ShownPixel>,
}

impl SomePixels {
    /// What a frame renders. With `one_by_one` the origins of pixels are there.
    pub fn of(
        filter: PixelFilter<'_>,
        workload: &FrameWorkload,
        eye: Option<Eye>,
        history: &mut History,
        one_by_one: bool,
    ) -> SomePixels {
        let frame = SourceFrame { filter, workload, eye, one_by_one };
        match filter.spec.source {
            PixelSource::All => frame.whole(),
            PixelSource::Warped => frame.warped(history),
            PixelSource::Cached => frame.cached(history),
            PixelSource::Sampled => frame.sampled(history),
        }
    }

    /// Charges what the unit does.
    pub(in crate::flow) fn charge(&self, actions: &mut ActionCounts) {
        actions.add(&self.actions);
        charge_blocks(&self.blocks, actions);
    }
}

/// Regions of a frame, of which those are rendered of which too much is missing.
#[derive(Debug)]
pub struct SomeRegions {
    /// Whether each is rendered, row by row; `None` where all are.
    pub wanted: Option<Vec<bool>>,
    /// What the unit does.
    pub blocks: Vec<MovedBlock>,
    /// Where its pixels come from.
    pub summary: PixelSummary,
}

impl SomeRegions {
    /// What a frame renders whose pixels may be warped: `workload` has it in tiles, `side` is the
    /// width and height of a region.
    pub fn of(
        filter: PixelFilter<'_>,
        workload: &FrameWorkload,
        side: [u32; 2],
        eye: Option<Eye>,
        history: &mut History,
    ) -> SomeRegions {
        let PixelFilter { spec, pixel } = filter;
        let (width, height) = (workload.width, workload.height);
        let pixels = u64::from(width) * u64::from(height);
        let mut summary = PixelSummary { pixels, rendered: pixels, ..PixelSummary::default() };
        let tiles = || (0..workload.tiles.len()).into_par_iter();
        let before = history.take::<Shown>(eye).filter(|shown| shown.goes_on(workload, spec));
        let Some(before) = before else {
            let seen = tiles().map(|tile| seen(workload, tile).pixels);
            history.keep(eye, Shown::new(workload, seen.collect(), None));
            return SomeRegions { wanted: None, blocks: Vec::new(), summary };
        };
        let warp = before.warp(workload.camera.as_ref().expect("a frame has a camera"));
        let [columns, rows] = [width.div_ceil(side[0]), height.div_ceil(side[1])];
        let area = |region: u32| {
            let [x, y] = [region % columns * side[0], region / columns * side[1]];
            (x, y, (x + side[0]).min(width), (y + side[1]).min(height))
        };
        let size = |(x0, y0, x1, y1): (u32, u32, u32, u32)| u64::from(x1 - x0) * u64::from(y1 - y0);
        let missing: Vec<u32> =
            (0..columns * rows).into_par_iter().map(|region| warp.missing(area(region))).collect();
        let anew = |(region, missing): (u32, &u32)| {
            f64::from(*missing) > size(area(region)) as f64 * spec.holes
        };
        let wanted: Vec<bool> = (0..).zip(&missing).map(anew).collect();
        let is_wanted = |x: u32, y: u32| wanted[(y / side[1] * columns + x / side[0]) as usize];
        let kept = pixel.0 + spec.depth.0;
        let mut blocks = Vec::with_capacity(wanted.len());
        summary.rendered = 0;
        for ((region, &missing), &anew) in (0..).zip(&missing).zip(&wanted) {
            let own = size(area(region));
            // A region that is rendered anew is written by the engines.
            let written = if anew { 0 } else { own * kept };
            blocks.push(MovedBlock { items: own, read: own * kept, write: written });
            match anew {
                true => summary.rendered += own,
                false => {
                    summary.taken += own - u64::from(missing);
                    summary.filled += u64::from(missing);
                }
            }
        }
        let shown = tiles().map(|tile| {
            let (x0, y0, x1, y1) = workload.pixels_of(tile);
            let places = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
            let mut pixels = warp.shown((x0, y0, x1, y1));
            if places.clone().any(|(x, y)| is_wanted(x, y)) {
                let own = seen(workload, tile).pixels;
                for ((pixel, own), (x, y)) in pixels.iter_mut().zip(own).zip(places) {
                    *pixel = if is_wanted(x, y) { own } else { *pixel };
                }
            }
            pixels
        });
        history.keep(eye, Shown::new(workload, shown.collect(), Some(&before)));
        SomeRegions { wanted: Some(wanted), blocks, summary }
    }

    /// Charges what the unit does.
    pub(in crate::flow) fn charge(&self, actions: &mut ActionCounts) {
        if self.wanted.is_some() {
            charge_moved(self.summary.pixels, actions);
        }
        charge_blocks(&self.blocks, actions);
    }
}

/// Charges the unit with moving pixels.
fn charge_moved(pixels: u64, actions: &mut ActionCounts) {
    actions.charge(Phase::Rendering, WARP, pixels);
    actions.charge(Phase::Rendering, sram_read(KNOWN), pixels * COUNTER);
    actions.charge(Phase::Rendering, sram_write(KNOWN), pixels * COUNTER);
}

fn charge_blocks(blocks: &[MovedBlock], actions: &mut ActionCounts) {
    let [read, write] = BlockStream::bytes(blocks);
    actions.charge(Phase::Rendering, DRAM_READ, read);
    actions.charge(Phase::Rendering, DRAM_WRITE, write);
}

/// A frame, and who shows it.
#[derive(Clone, Copy)]
struct SourceFrame<'a> {
    filter: PixelFilter<'a>,
    workload: &'a FrameWorkload,
    eye: Option<Eye>,
    one_by_one: bool,
}

impl SourceFrame<'_> {
    /// All of it is rendered.
    fn whole(&self) -> SomePixels {
        let pixels = u64::from(self.workload.width) * u64::from(self.workload.height);
        let origins = if self.one_by_one { pixels } else { 0 };
        SomePixels {
            made: None,
            blocks: Vec::new(),
            summary: PixelSummary { pixels, rendered: pixels, ..PixelSummary::default() },
            origins: vec![PixelOrigin::Rendered; origins as usize],
            actions: ActionCounts::default(),
        }
    }

    fn warped(&self, history: &mut History) -> SomePixels {
        let SourceFrame { workload, eye, .. } = *self;
        let PixelFilter { spec, pixel } = self.filter;
        let tiles = workload.tiles.len();
        let before = history.take::<Shown>(eye).filter(|shown| shown.goes_on(workload, spec));
        // A whole frame needs the depths of its pixels only, so that the next one can move them.
        let Some(before) = before else {
            let seen = (0..tiles).into_par_iter().map(|tile| seen(workload, tile).pixels);
            history.keep(eye, Shown::new(workload, seen.collect(), None));
            return self.whole();
        };
        let camera = workload.camera.as_ref().expect("a frame has a camera");
        let warp = before.warp(camera);
        let parts: Vec<(Option<SeenTile>, u32)> = (0..tiles)
            .into_par_iter()
            .map(|tile| {
                let missing = warp.missing(workload.pixels_of(tile));
                let most = f64::from(workload.tiles[tile].pixels) * spec.holes;
                let anew = f64::from(missing) > most;
                (anew.then(|| seen(workload, tile)), missing)
            })
            .collect();
        let mut found = self.whole();
        let whole = pixel.0 + spec.depth.0;
        let (mut shown, mut lists) = (Vec::with_capacity(tiles), Vec::with_capacity(tiles));
        found.summary.rendered = 0;
        for (tile, (anew, missing)) in parts.into_iter().enumerate() {
            let pixels = workload.tiles[tile].pixels;
            // A tile that is rendered anew is written by the rendering units.
            let written = if anew.is_some() { 0 } else { u64::from(pixels) * whole };
            found.blocks.push(MovedBlock {
                items: pixels.into(),
                read: u64::from(pixels) * whole,
                write: written,
            });
            match anew {
                Some(tile) => {
                    found.summary.rendered += u64::from(pixels);
                    shown.push(tile.pixels);
                    lists.push(tile.list);
                }
                None => {
                    if self.one_by_one {
                        self.moved(tile, &warp, &mut found.origins);
                    }
                    found.summary.taken += u64::from(pixels - missing);
                    found.summary.filled += u64::from(missing);
                    shown.push(warp.shown(workload.pixels_of(tile)));
                    lists.push(none(workload, tile));
                }
            }
        }
        history.keep(eye, Shown::new(workload, shown, Some(&before)));
        found.made = Some(Box::new(workload.with_some_lists(lists)));
        charge_moved(found.summary.pixels, &mut found.actions);
        found
    }

    /// Says of each pixel of a tile which one it was.
    fn moved(&self, tile: usize, warp: &Warp<'_>, origins: &mut [PixelOrigin]) {
        let area = self.workload.pixels_of(tile);
        for (place, from) in self.places(tile).zip(warp.pixels(area)) {
            origins[place] = from.map_or(PixelOrigin::Filled, PixelOrigin::Moved);
        }
    }

    /// The places of the pixels of a tile in the image, row by row.
    fn places(&self, tile: usize) -> impl Iterator<Item = usize> + use<> {
        let (x0, y0, x1, y1) = self.workload.pixels_of(tile);
        let width = self.workload.width;
        (y0..y1).flat_map(move |y| (x0..x1).map(move |x| (y * width + x) as usize))
    }

    fn cached(&self, history: &mut History) -> SomePixels {
        let (SourceFrame { workload, eye, .. }, spec) = (*self, self.filter.spec);
        let caches = history.take::<RadianceCaches>(eye);
        let caches = caches.filter(|caches| caches.fits(workload, spec));
        let mut caches = caches.unwrap_or_else(|| RadianceCaches::new(workload, spec));
        let held = caches.entries();
        let looked = caches.frame(workload, spec);
        let mut found = self.whole();
        let mut lists: Vec<TileList> =
            (0..workload.tiles.len()).map(|_| Default::default()).collect();
        for ((region, held), kept) in looked.into_iter().zip(held).zip(caches.entries()) {
            found.summary.lookups += region.lookups;
            found.summary.hits += region.hits;
            let bytes = |entries: u64| entries * spec.entry.0;
            found.blocks.push(MovedBlock {
                items: region.lookups,
                read: bytes(held),
                write: bytes(kept),
            });
            let misses = region.lookups - region.hits;
            let tags = region.lookups * u64::from(spec.ways) * TAG;
            let read = bytes(region.hits + kept) + tags;
            found.actions.charge(Phase::Rendering, LOOK_UP, region.lookups);
            found.actions.charge(Phase::Rendering, sram_read(KNOWN), read);
            found.actions.charge(Phase::Rendering, sram_write(KNOWN), bytes(misses + held));
            for KnownTile { tile, list, known } in region.tiles {
                if self.one_by_one {
                    for (place, known) in self.places(tile).zip(known) {
                        let known = known.map(|[frame, pixel]| PixelOrigin::Known { frame, pixel });
                        found.origins[place] = known.unwrap_or(PixelOrigin::Rendered);
                    }
                }
                lists[tile] = list;
            }
        }
        history.keep(eye, caches);
        let mut made = workload.with_lists(lists);
        // Preprocessing is that of the whole frame: pixels that stop early change only what tiles
        // load.
        made.counters = powergs_frame::splat::Counters {
            fetched_points: made.counters.fetched_points,
            tile_loads: made.tiles.iter().map(|tile| u64::from(tile.loaded)).sum(),
            alpha_evaluations: made.tiles.iter().map(|tile| tile.alpha_evaluations).sum(),
            blends: made.tiles.iter().map(|tile| tile.blends).sum(),
            ..workload.counters
        };
        made.storage.clone_from(&workload.storage);
        found.made = Some(Box::new(made));
        found
    }

    fn sampled(&self, history: &mut History) -> SomePixels {
        let (SourceFrame { workload, eye, .. }, spec) = (*self, self.filter.spec);
        let FrameCount(frame) = history.take(eye).unwrap_or_default();
        history.keep(eye, FrameCount(frame + 1));
        let mut found = self.whole();
        // With a period of 0 no frame is whole (A143).
        if spec.period > 0 && frame % spec.period == 0 {
            return found;
        }
        let tiles: Vec<(TileList, Vec<u32>)> = (0..workload.tiles.len())
            .into_par_iter()
            .map(|tile| sampled_tile(spec, workload, tile, frame))
            .collect();
        let (lists, tests): (Vec<TileList>, Vec<Vec<u32>>) = tiles.into_iter().unzip();
        let finished = lists.iter().filter_map(|list| list.finished);
        found.summary.rendered = finished.map(u64::from).sum();
        let mut made = workload.with_some_lists(lists);
        if spec.filter {
            filtered(&mut made, workload, &tests);
        }
        found.made = Some(Box::new(made));
        found
    }
}

/// Frames that were seen.
#[derive(Default)]
struct FrameCount(u32);

/// A tile that is not rendered.
fn none(workload: &FrameWorkload, tile: usize) -> TileList {
    let pixels = workload.tiles[tile].pixels as usize;
    TileList { iterated: vec![0; pixels], finished: Some(0), ..TileList::default() }
}

/// The list of a tile with its bitmaps, as it is.
fn own_list(workload: &FrameWorkload, tile: usize) -> TileList {
    let (work, bytes) = (&workload.tiles[tile], workload.geometry.bitmap_bytes());
    let first = work.list_start as usize * bytes;
    TileList {
        ranks: workload.list_of(work).to_vec(),
        bitmaps: workload.bitmaps[first..first + work.entries as usize * bytes].to_vec(),
        ..TileList::default()
    }
}

/// Blends a tile: where its pixels stop, and how deep they see.
fn seen(workload: &FrameWorkload, tile: usize) -> SeenTile {
    let mut list = own_list(workload, tile);
    let mut pixels = TileBlend::new(workload, tile, list.ranks.len() as u32);
    let mut depth = vec![f32::INFINITY; pixels.iterated.len()];
    for (at, &rank) in (0..).zip(&list.ranks) {
        let own = workload.depth[rank as usize];
        pixels.blend_and(at, rank, |pixel, rest| {
            // The first Gaussian that leaves less than half of the light is the depth (A141).
            if rest < HALF && depth[pixel] == f32::INFINITY {
                depth[pixel] = own;
            }
        });
    }
    list.stopped = pixels.stopped();
    (list.iterated, list.blends) = (pixels.iterated, pixels.blends);
    SeenTile { list, pixels: depth.into_iter().map(ShownPixel::rendered).collect() }
}

/// What of the light behind reaches the eye where a pixel is, in depth.
const HALF: f32 = 0.5;

/// Says of a frame how many pixels each splat was tested at before it came into lists; the tests
/// are those of the entries of the tiles of `workload`, in the order of their lists.
fn filtered(made: &mut FrameWorkload, workload: &FrameWorkload, tests: &[Vec<u32>]) {
    let mut blocks = vec![0u32; made.storage.len()];
    let mut all = 0u64;
    for (work, tests) in workload.tiles.iter().zip(tests) {
        for (&rank, &tests) in workload.list_of(work).iter().zip(tests) {
            all += u64::from(tests);
            let block = workload.index[rank as usize] as usize / STORAGE_BLOCK as usize;
            if let Some(own) = blocks.get_mut(block) {
                *own += tests;
            }
        }
    }
    // Prefix sums, because batches take differences of them.
    let mut sum = 0u32;
    for (prefix, own) in made.storage.iter_mut().zip(blocks) {
        sum = sum.saturating_add(own);
        (prefix.tests, prefix.prepared) = (sum, 0);
    }
    (made.counters.obb_tests, made.counters.obb_prepared) = (all, 0);
}

/// A tile of which some pixels are rendered, and at how many each entry of its list is tested.
fn sampled_tile(
    spec: &PixelsSpec,
    workload: &FrameWorkload,
    tile: usize,
    frame: u32,
) -> (TileList, Vec<u32>) {
    let mut list = own_list(workload, tile);
    let (x0, y0, x1, y1) = workload.pixels_of(tile);
    let mut pixels = TileBlend::new(workload, tile, list.ranks.len() as u32);
    let mut blended = vec![0u32; pixels.iterated.len()];
    for (at, &rank) in (0..).zip(&list.ranks) {
        pixels.blend_and(at, rank, |pixel, _| blended[pixel] += 1);
    }
    let places = (y0..y1).flat_map(|y| (x0..x1).map(move |x| [x, y]));
    let mut finished = 0;
    for (i, place) in places.enumerate() {
        let unseen = spec.pattern == SamplePattern::Unseen && pixels.transmittance[i] > HALF;
        if unseen || is_sampled(spec, place, frame) {
            finished += 1;
            list.blends += u64::from(blended[i]);
            list.stopped += u32::from(pixels.has_stopped[i]);
        } else {
            // It wants nothing of the list, so that sub-tiles go on for the wanted pixels alone.
            pixels.iterated[i] = 0;
        }
    }
    if finished == 0 {
        return (none(workload, tile), vec![0; list.ranks.len()]);
    }
    (list.iterated, list.finished) = (pixels.iterated, Some(finished));
    if spec.filter { filtered_list(workload, tile, list) } else { (list, Vec::new()) }
}

/// A list with those entries that reach a pixel that is rendered, and at how many of them each is
/// tested: those in its bounding square.
fn filtered_list(workload: &FrameWorkload, tile: usize, list: TileList) -> (TileList, Vec<u32>) {
    let splats = &workload.pixels.as_ref().expect("binned with its pixels").splats;
    let (x0, y0, x1, _) = workload.pixels_of(tile);
    let bytes = workload.geometry.bitmap_bytes();
    let width = (x1 - x0) as usize;
    let place = |i: usize| [x0 + (i % width) as u32, y0 + (i / width) as u32];
    let rendered: Vec<usize> = (0..list.iterated.len()).filter(|&i| list.iterated[i] > 0).collect();
    let mut kept = TileList { iterated: vec![0; list.iterated.len()], ..TileList::default() };
    let mut tests = Vec::with_capacity(list.ranks.len());
    for (at, &rank) in (0_u32..).zip(&list.ranks) {
        let splat = &splats[rank as usize];
        let (radius, ellipse) = (f64::from(splat.radius()), Ellipse::of(splat));
        let is_near = |i: usize| {
            let near = |n: u32, mean: f32| (f64::from(n) - f64::from(mean)).abs() <= radius;
            let [x, y] = place(i);
            near(x, splat.mean[0]) && near(y, splat.mean[1])
        };
        let reaches = |i: usize| {
            let [x, y] = place(i).map(i64::from);
            ellipse.as_ref().is_some_and(|ellipse| ellipse.reaches(x, y))
        };
        tests.push(rendered.iter().filter(|&&i| is_near(i)).count() as u32);
        if !rendered.iter().any(|&i| reaches(i)) {
            continue;
        }
        let start = at as usize * bytes;
        kept.ranks.push(rank);
        kept.bitmaps.extend(&list.bitmaps[start..start + bytes]);
        // A pixel has gone through what it went through before, as far as it is still there.
        let until = kept.ranks.len() as u32;
        rendered.iter().filter(|&&i| list.iterated[i] > at).for_each(|&i| kept.iterated[i] = until);
    }
    let TileList { finished, blends, stopped, .. } = list;
    (TileList { finished, blends, stopped, ..kept }, tests)
}

/// Whether a pixel is that of its cell.
pub fn is_sampled(spec: &PixelsSpec, [x, y]: [u32; 2], frame: u32) -> bool {
    let n = spec.stride.max(1);
    let of_cell = match spec.pattern {
        SamplePattern::Grid => [n / 2; 2],
        SamplePattern::Random | SamplePattern::Unseen => {
            let cell = [x / n, y / n, frame].map(u64::from);
            let drawn = cell.into_iter().fold(0, |seed, n| mixed(seed ^ n));
            [drawn as u32 % n, (drawn >> 32) as u32 % n]
        }
    };
    [x % n, y % n] == of_cell
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
pub(super) fn mixed(n: u64) -> u64 {
    let n = n.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let n = (n ^ (n >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let n = (n ^ (n >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    n ^ (n >> 31)
}
