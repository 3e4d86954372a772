//! The second view of a pair, as far as a machine makes it of the first one.
//!
//! The eyes of a pair look along parallel axes, so that a splat has the same depth and the same row
//! in both, and in the second one lies further to the left by its disparity. What blends anywhere
//! in a sub-tile of the first eye is handed on to the sub-tiles of the second one under it, shifted
//! by that; the lists of the second eye are these splats and no others. What lies beside the image
//! of the first eye was sorted for both and is handed on unseen.

use rayon::prelude::*;

use crate::workload::lanes::LaneMap;
use crate::workload::{FrameWorkload, Geometry, STORAGE_BLOCK, StoragePrefix, TileList};
use powergs_frame::splat::pixel::PixelAlpha;
use powergs_frame::splat::{ALPHA_MIN, Splat};

/// No rank.
const NONE: u32 = u32::MAX;

/// What is known of the first view of a pair.
#[derive(Debug)]
pub struct FirstView {
    geometry: Geometry,
    /// Pixels of the image.
    size: [u32; 2],
    tiles_x: u32,
    /// Rank by scene index, [`NONE`] where it is not visible.
    rank_of: Vec<u32>,
    /// Centres, by rank.
    means: Vec<[f32; 2]>,
    /// Where the entries of each rank begin in `entries`.
    starts: Vec<usize>,
    /// Tiles in which a splat blends, ascending.
    entries: Vec<u32>,
    /// The sub-tiles of each in which it does.
    bits: Vec<u8>,
}

/// What a second view that is made of the first one has of its own lists.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StereoSummary {
    /// (Splat, tile) pairs that the first view handed on.
    pub handed_on: u64,
    /// Entries that the lists of the second view would have.
    pub entries: u64,
    /// Those that they have.
    pub kept: u64,
    /// Blends of the second view.
    pub blends: u64,
    /// Those that it loses, because their splats were not handed on.
    pub lost_blends: u64,
    /// Pixels of the second view.
    pub pixels: u64,
    /// Those whose colour may be another one by a step of eight bits or more: the weights of what
    /// is lost add up to 1/255.
    pub changed_pixels: u64,
    /// The same for what is lost because its disparity is beyond the largest.
    pub cut_off_pixels: u64,
    /// The largest disparity of a splat that was handed on, pixels.
    pub largest_disparity: f32,
}

impl StereoSummary {
    /// Adds a part of a view, or another pair.
    pub fn add(&mut self, other: &StereoSummary) {
        self.handed_on += other.handed_on;
        self.entries += other.entries;
        self.kept += other.kept;
        self.blends += other.blends;
        self.lost_blends += other.lost_blends;
        self.pixels += other.pixels;
        self.changed_pixels += other.changed_pixels;
        self.cut_off_pixels += other.cut_off_pixels;
        self.largest_disparity = self.largest_disparity.max(other.largest_disparity);
    }
}

/// Why a second view cannot be made of the first one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoSecond {
    /// The views of the pair are not of the same geometry and size.
    Different,
    /// A splat is in another row, by so many pixels.
    Rows(f32),
}

/// The largest distance of rows that rounding explains, pixels.
const ROWS: f32 = 0.5;

impl FirstView {
    /// Everything that is handed on; with `blended`, where its splats blend.
    pub fn new(workload: &FrameWorkload, blended: bool) -> FirstView {
        let most = workload.index.iter().max().map_or(0, |&index| index as usize + 1);
        let mut rank_of = vec![NONE; most];
        for (rank, &index) in (0..).zip(&workload.index) {
            rank_of[index as usize] = rank;
        }
        let mut first = FirstView {
            geometry: workload.geometry,
            size: [workload.width, workload.height],
            tiles_x: workload.tiles_x,
            rank_of,
            means: Vec::new(),
            starts: Vec::new(),
            entries: Vec::new(),
            bits: Vec::new(),
        };
        if let (true, Some(pixels)) = (blended, &workload.pixels) {
            first.means = pixels.splats.iter().map(|splat| splat.mean).collect();
            first.find_blends(workload);
        }
        first
    }

    fn find_blends(&mut self, workload: &FrameWorkload) {
        let (geometry, bytes) = (&workload.geometry, workload.geometry.bitmap_bytes());
        // Ranks, and bitmaps one behind the other.
        let tiles: Vec<(Vec<u32>, Vec<u8>)> = (0..workload.tiles.len())
            .into_par_iter()
            .map(|tile| {
                let lanes = LaneMap::new(workload, tile);
                let work = &workload.tiles[tile];
                let (mut ranks, mut all) = (Vec::new(), Vec::new());
                let mut bits = vec![0u8; bytes];
                for (at, &rank) in (0..work.loaded).zip(workload.list_of(work)) {
                    bits.fill(0);
                    lanes.blends(at, |x, y| set(&mut bits, lanes.subtile(geometry, x, y)));
                    if bits.iter().any(|&bits| bits != 0) {
                        ranks.push(rank);
                        all.extend(&bits);
                    }
                }
                (ranks, all)
            })
            .collect();
        let mut starts = vec![0usize; workload.index.len() + 1];
        for &rank in tiles.iter().flat_map(|(ranks, _)| ranks) {
            starts[rank as usize + 1] += 1;
        }
        for rank in 0..workload.index.len() {
            starts[rank + 1] += starts[rank];
        }
        let (mut next, entries) = (starts.clone(), starts.last().copied().unwrap_or(0));
        self.entries = vec![0; entries];
        self.bits = vec![0; entries * bytes];
        // Tiles ascend, so that `blends` can search for one among those of a splat.
        for (tile, (ranks, all)) in (0..).zip(tiles) {
            for (&rank, bits) in ranks.iter().zip(all.chunks_exact(bytes)) {
                let place = &mut next[rank as usize];
                self.entries[*place] = tile;
                self.bits[*place * bytes..][..bytes].copy_from_slice(bits);
                *place += 1;
            }
        }
        self.starts = starts;
    }

    /// (Splat, tile) pairs that are handed on.
    pub fn handed_on(&self) -> u64 {
        self.entries.len() as u64
    }

    fn rank(&self, index: u32) -> Option<u32> {
        self.rank_of.get(index as usize).copied().filter(|&rank| rank != NONE)
    }

    /// Whether a splat blends in a sub-tile, given by column and row in the image.
    fn blends(&self, rank: u32, column: i64, row: u32) -> bool {
        let side = self.geometry.subtiles_per_side();
        // What lies outside of the first eye's image was sorted for both, and is handed on unseen
        // (A132).
        let Ok(column) = u32::try_from(column) else { return true };
        if column >= self.size[0].div_ceil(self.geometry.subtile) {
            return true;
        }
        let tile = row / side * self.tiles_x + column / side;
        let first = self.starts[rank as usize];
        let entries = &self.entries[first..self.starts[rank as usize + 1]];
        let Ok(at) = entries.binary_search(&tile) else { return false };
        let bytes = self.geometry.bitmap_bytes();
        let bits = &self.bits[(first + at) * bytes..][..bytes];
        has(bits, (row % side * side + column % side) as usize)
    }
}

fn set(bits: &mut [u8], subtile: usize) {
    bits[subtile / 8] |= 1 << (subtile % 8);
}

fn has(bits: &[u8], subtile: usize) -> bool {
    bits[subtile / 8] >> (subtile % 8) & 1 == 1
}

/// The second view, with lists of what the first one handed on, whose disparity is at most `reach`
/// pixels.
///
/// # Errors
/// [`NoSecond`]: views that are no pair.
pub fn derived(
    first: &FirstView,
    second: &FrameWorkload,
    reach: f32,
) -> Result<(FrameWorkload, StereoSummary), NoSecond> {
    check(first, second)?;
    let pixels = second.pixels.as_ref().ok_or(NoSecond::Different)?;
    // Disparity, by rank; none of splats that the first view does not show at all.
    let shift = |(splat, &index): (&Splat, &u32)| {
        let rank = first.rank(index)?;
        let mean = first.means[rank as usize];
        Some((rank, mean[0] - splat.mean[0], (mean[1] - splat.mean[1]).abs()))
    };
    let shifts: Vec<Option<(u32, f32, f32)>> =
        pixels.splats.par_iter().zip(&second.index).map(shift).collect();
    let is_seen = |rank: u32| first.starts[rank as usize + 1] > first.starts[rank as usize];
    // Only splats that are handed on must lie in the same row of both eyes.
    let rows = shifts.iter().flatten().filter(|s| is_seen(s.0)).map(|s| s.2);
    if let Some(rows) = rows.fold(None, |most: Option<f32>, r| Some(most.map_or(r, |m| m.max(r))))
        && rows > ROWS
    {
        return Err(NoSecond::Rows(rows));
    }
    let tiles = (0..second.tiles.len()).into_par_iter();
    let maker = SecondTile { first, second, shifts: &shifts, reach };
    let (lists, own): (Vec<TileList>, Vec<StereoSummary>) =
        tiles.map(|tile| maker.tile(tile)).unzip();
    let mut summary = StereoSummary { handed_on: first.handed_on(), ..StereoSummary::default() };
    own.iter().for_each(|own| summary.add(own));
    // Nothing is fetched of the second eye: its features come on chip.
    let mut made = second.with_lists(lists);
    made.counters.fetched_points = 0;
    made.chunks.iter_mut().for_each(|chunk| chunk.first_loads = 0);
    made.tiles.iter_mut().for_each(|tile| tile.complete_after = 0);
    Ok((made, summary))
}

fn check(first: &FirstView, second: &FrameWorkload) -> Result<(), NoSecond> {
    let same = first.geometry == second.geometry && first.size == [second.width, second.height];
    if same { Ok(()) } else { Err(NoSecond::Different) }
}

/// What a pixel has seen so far.
#[derive(Debug, Clone)]
struct PixelWeights {
    /// Light that is left.
    transmittance: f32,
    /// Weights of what is lost: no colour moves by more.
    lost: f32,
    /// Those of what lies beyond the largest disparity.
    cut_off: f32,
}

impl Default for PixelWeights {
    fn default() -> PixelWeights {
        PixelWeights { transmittance: 1.0, lost: 0.0, cut_off: 0.0 }
    }
}

impl PixelWeights {
    fn blend(&mut self, alpha: f32, is_lost: bool, is_cut_off: bool) {
        let weight = self.transmittance * alpha;
        self.transmittance -= weight;
        self.lost += if is_lost { weight } else { 0.0 };
        self.cut_off += if is_cut_off { weight } else { 0.0 };
    }
}

struct SecondTile<'a> {
    first: &'a FirstView,
    second: &'a FrameWorkload,
    shifts: &'a [Option<(u32, f32, f32)>],
    reach: f32,
}

impl SecondTile<'_> {
    /// A tile, and what it has of its own list.
    fn tile(&self, tile: usize) -> (TileList, StereoSummary) {
        let (w, g) = (self.second, self.second.geometry);
        let (bytes, work) = (g.bitmap_bytes(), &w.tiles[tile]);
        let lanes = LaneMap::new(w, tile);
        let list = w.list_of(work);
        let bitmaps = &w.bitmaps[work.list_start as usize * bytes..][..list.len() * bytes];
        let mut part = TileList::default();
        let mut summary = StereoSummary {
            entries: work.entries.into(),
            pixels: work.pixels.into(),
            ..StereoSummary::default()
        };
        // Entries that are kept in front of each list position.
        let mut before = Vec::with_capacity(list.len() + 1);
        let mut weights = vec![PixelWeights::default(); work.pixels as usize];
        let mut bits = vec![0u8; bytes];
        for ((at, &rank), own) in (0u32..).zip(list).zip(bitmaps.chunks_exact(bytes)) {
            before.push(part.ranks.len() as u32);
            let shift = self.shifts[rank as usize];
            let is_cut_off = shift.is_some_and(|(_, shift, _)| shift.abs() > self.reach);
            bits.fill(0);
            match shift {
                None => bits.copy_from_slice(own),
                Some(_) if is_cut_off => {}
                Some((first, shift, _)) => {
                    let subtiles = (0..g.subtiles() as usize).filter(|&s| has(own, s));
                    subtiles
                        .filter(|&s| self.is_handed_on(first, shift, tile, s))
                        .for_each(|s| set(&mut bits, s));
                    if bits.iter().any(|&bits| bits != 0) {
                        summary.largest_disparity = summary.largest_disparity.max(shift.abs());
                    }
                }
            }
            if at < work.loaded {
                let (x0, y0, x1, _) = lanes.area;
                let alpha = PixelAlpha::of(lanes.splat(at));
                lanes.blends(at, |x, y| {
                    let is_lost = !has(&bits, lanes.subtile(&g, x, y));
                    summary.blends += 1;
                    summary.lost_blends += u64::from(is_lost);
                    let pixel = &mut weights[((y - y0) * (x1 - x0) + x - x0) as usize];
                    pixel.blend(alpha.at(x, y), is_lost, is_lost && is_cut_off);
                });
            }
            if bits.iter().any(|&bits| bits != 0) {
                part.ranks.push(rank);
                part.bitmaps.extend(&bits);
            }
        }
        before.push(part.ranks.len() as u32);
        // Stops are positions in the frame's own list; in the shorter one, what is kept in front of
        // them.
        let stops = lanes.all_stops();
        part.iterated = stops.map(|stop| before[(stop as usize).min(list.len())]).collect();
        part.blends = work.blends.saturating_sub(summary.lost_blends);
        summary.kept = part.ranks.len() as u64;
        let changed = |lost: fn(&PixelWeights) -> f32| {
            weights.iter().filter(|pixel| f64::from(lost(pixel)) >= ALPHA_MIN).count() as u64
        };
        summary.changed_pixels = changed(|pixel| pixel.lost);
        summary.cut_off_pixels = changed(|pixel| pixel.cut_off);
        (part, summary)
    }

    /// Whether a splat comes to a sub-tile: it blends in one of those under it in the first view.
    fn is_handed_on(&self, rank: u32, shift: f32, tile: usize, subtile: usize) -> bool {
        let g = self.second.geometry;
        let (side, n) = (g.subtiles_per_side(), i64::from(g.subtile));
        let (x0, y0, ..) = self.second.pixels_of(tile);
        let row = y0 / g.subtile + subtile as u32 / side;
        let x = i64::from(x0) + i64::from(subtile as u32 % side) * n;
        let columns = [x, x + n - 1].map(|x| (x as f64 + f64::from(shift)).round() as i64);
        // Columns are negative to the left of the image, where a plain division would round up.
        let [first, last] = columns.map(|x| x.div_euclid(n));
        (first..=last).any(|column| self.first.blends(rank, column, row))
    }
}

/// The second view where both are converted together: what the first one has converted is not read
/// and converted again. Its records, whose centres are others, and its lists are written, and these
/// are sorted, as before.
///
/// # Errors
/// [`NoSecond`]: views that are no pair.
pub fn shared(first: &FirstView, second: &FrameWorkload) -> Result<FrameWorkload, NoSecond> {
    check(first, second)?;
    let mut made = second.clone();
    let mut pairs = vec![0u32; second.index.len()];
    second.list.iter().for_each(|&rank| pairs[rank as usize] += 1);
    let splats = second.counters.intersecting_points;
    let mut storage = vec![StoragePrefix::default(); splats.div_ceil(STORAGE_BLOCK) as usize];
    let mut extras = 0;
    let with_tile = (0..second.slot.len()).filter(|&rank| second.slot[rank] != u32::MAX);
    for rank in with_tile {
        let own = &mut storage[second.slot[rank] as usize / STORAGE_BLOCK as usize];
        let is_extra = first.rank(second.index[rank]).is_none();
        own.survivors += u32::from(is_extra);
        own.prepared += u32::from(is_extra);
        own.splats += 1;
        own.pairs += pairs[rank];
        extras += u64::from(is_extra);
    }
    let mut sum = StoragePrefix::default();
    // Box tests are spread as pairs are.
    let (tests, all) = (second.counters.obb_tests, second.counters.tile_pairs.max(1));
    for own in &mut storage {
        sum.survivors += own.survivors;
        sum.prepared += own.prepared;
        sum.splats += own.splats;
        sum.pairs += own.pairs;
        sum.tests = (u128::from(tests) * u128::from(sum.pairs) / u128::from(all)) as u32;
        *own = sum;
    }
    made.storage = storage;
    made.index.iter_mut().zip(&second.slot).for_each(|(index, &slot)| {
        *index = if slot == u32::MAX { *index } else { slot };
    });
    let c = &mut made.counters;
    (c.points, c.survivors, c.obb_prepared) = (splats, extras, extras);
    Ok(made)
}
