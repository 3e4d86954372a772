//! A frame, cut into regions: which Gaussians meet each of them, and what one costs in lanes.
//!
//! A Gaussian meets a region if its footprint does: the pixels of its bounding square of 3 sigma,
//! or, with `region.cut = "exact"`, those of its rows in which α may reach 1/255, within that
//! square. Its pixels in the region go to the lanes in steps: together (`box`), or row by row
//! (`rows`, `exact`), which leaves lanes empty at the end of each row. A step takes a cycle, or as
//! long as the banks need for the pixels that are in it.

use rayon::prelude::*;

use super::{Cut, Resident};
use crate::flow::{Work, WorkKey, WorkKind};
use crate::workload::demand::{self, Unbinnable};
use crate::workload::{FrameDetail, FrameWorkload, Geometry, bin_for};
use powergs_base::budget::Budget;
use powergs_frame::scene::ShDegree;
use powergs_frame::splat::{Counters, Ellipse, Splat};
use powergs_frame::trace::{Frame, NEVER};

/// Records of a block of [`ResidentFrame::storage`].
pub const STORAGE_BLOCK: u64 = 32;

/// Tiles in which the depths of pixels are found, which no machine has: any would do.
const DEPTH_TILES: Geometry = Geometry::REFERENCE;
const DEPTHS: FrameDetail = FrameDetail { pixels: true, whole: false };

/// What decides how a frame is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RegionShape {
    /// Width of a region, pixels; 0 for that of the image.
    pub width: u32,
    /// Height of a region, pixels; 0 for that of the image.
    pub height: u32,
    /// Which pixels of a Gaussian go to the lanes, and how.
    pub cut: Cut,
    /// Pixels of a step.
    pub lanes: u32,
    /// Words that a pixel takes through the banks in a step; 0 where a full step takes a cycle.
    pub words: u32,
    /// Banks: words in a cycle.
    pub banks: u32,
    /// Whether the depths of its pixels are needed: its Gaussians in lists of tiles.
    pub depths: bool,
}

impl RegionShape {
    /// That of a machine.
    pub fn new(m: &Resident) -> RegionShape {
        let (words, banks) = (m.pixel_words(), m.stores.pixels.banks.max(1));
        // Machines whose banks never hold a step up share their work.
        let is_free = u64::from(m.raster.lanes) * u64::from(words) <= u64::from(banks);
        RegionShape {
            width: m.region.width,
            height: m.region.height,
            cut: m.region.cut,
            lanes: m.raster.lanes,
            words: if is_free { 0 } else { words },
            banks: if is_free { 1 } else { banks },
            depths: m.pixel_filter().is_some(),
        }
    }

    /// Who shares work of this shape.
    pub fn key(&self) -> WorkKey {
        let RegionShape { width, height, cut, lanes, words, banks, depths } = *self;
        let numbers = vec![width, height, cut as u32, lanes, words, banks, u32::from(depths)];
        WorkKey { kind: &Regions, numbers }
    }

    /// Cycles in which the lanes take some pixels, which fill one step after the other. A lane
    /// without a pixel makes no access.
    pub fn cycles(&self, pixels: u32) -> u32 {
        let step = |pixels: u32| {
            let words = u64::from(pixels) * u64::from(self.words);
            (words.div_ceil(self.banks.into()) as u32).max(1)
        };
        let (full, last) = (pixels / self.lanes, pixels % self.lanes);
        full * step(self.lanes) + if last > 0 { step(last) } else { 0 }
    }

    /// The shape of the numbers of a key.
    ///
    /// # Panics
    /// On those of another kind of work.
    pub fn of(numbers: &[u32]) -> RegionShape {
        let [width, height, cut, lanes, words, banks, depths] = *numbers else {
            panic!("a key of lists of regions has seven numbers: {numbers:?}")
        };
        let cut = Cut::ALL.into_iter().find(|known| *known as u32 == cut);
        let cut = cut.expect("a key of a shape");
        RegionShape { width, height, cut, lanes, words, banks, depths: depths > 0 }
    }

    /// Width and height of a region of an image.
    pub fn region(&self, width: u32, height: u32) -> [u32; 2] {
        let of = |own: u32, image: u32| if own == 0 { image.max(1) } else { own };
        [of(self.width, width), of(self.height, height)]
    }
}

/// A Gaussian in the list of a region.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RegionEntry {
    /// Its depth rank.
    pub rank: u32,
    /// Cycles of the lanes.
    pub cycles: u32,
    /// Pixels of it in the region.
    pub pixels: u32,
    /// Those of them that have not stopped before.
    pub live: u32,
    /// Rows of them whose ends must be found; 0 where the ends are those of a square.
    pub rows: u32,
}

/// A region of the image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Region {
    /// Its first entry in [`ResidentFrame::entries`].
    pub start: u32,
    /// Its entries.
    pub entries: u32,
    /// Entries until its last pixel has stopped: all where one never does.
    pub saturated: u32,
    /// Its pixels.
    pub pixels: u32,
    /// Blends of its pixels.
    pub blends: u64,
}

/// Counts of the first records of the scene.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RecordCounts {
    /// In front of the near plane.
    pub survivors: u64,
    /// With a region.
    pub splats: u64,
    /// Entries of lists.
    pub entries: u64,
    /// Rows that are looked at for the regions of those with one.
    pub rows: u64,
}

/// A frame, cut into regions.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidentFrame {
    /// How.
    pub shape: RegionShape,
    /// Degree of the scene's spherical harmonics.
    pub sh_degree: ShDegree,
    /// Whether it is foveated, which no machine of this dataflow shows.
    pub is_foveated: bool,
    /// Frame totals; a pair is an entry of a region.
    pub counters: Counters,
    /// Regions, row by row.
    pub regions: Vec<Region>,
    /// Entries of all regions, region by region, each in depth order.
    pub entries: Vec<RegionEntry>,
    /// By rank: the position among splats with a region, in storage order; `u32::MAX` without one.
    pub slot: Vec<u32>,
    /// By slot: the index in the scene.
    pub index: Vec<u32>,
    /// Counts of the first `(i + 1) STORAGE_BLOCK` records, the last entry for all.
    pub storage: Vec<RecordCounts>,
    /// The same Gaussians in lists of tiles, where depths of pixels are needed.
    pub tiles: Option<Box<FrameWorkload>>,
}

/// The pixels of a splat: columns and rows, half open.
#[derive(Debug, Clone, Copy)]
struct Footprint {
    columns: [u32; 2],
    rows: [u32; 2],
    ellipse: Option<Ellipse>,
}

impl Footprint {
    /// Of a splat in an image; `None` where it has no pixel.
    fn new(splat: &Splat, width: u32, height: u32, cut: Cut) -> Option<Footprint> {
        let conic = splat.conic()?;
        let radius = splat.radius();
        let ellipse = match cut {
            Cut::Box | Cut::Rows => None,
            Cut::Exact => Some(Ellipse::new(splat, conic)?),
        };
        let within = |mean: f32, most: u32| {
            let low = f64::from(mean - radius).ceil().max(0.0);
            let high = (f64::from(mean + radius).floor() + 1.0).min(f64::from(most));
            (low < high).then_some([low as u32, high as u32])
        };
        let columns = within(splat.mean[0], width)?;
        let rows = within(splat.mean[1], height)?;
        Some(Footprint { columns, rows, ellipse })
    }

    /// The columns of a row that lie in `from..to`.
    fn row(&self, y: u32, from: u32, to: u32) -> Option<[u32; 2]> {
        let (mut first, mut end) = (self.columns[0].max(from), self.columns[1].min(to));
        if let Some(ellipse) = &self.ellipse {
            let y = i64::from(y);
            let (low, high) = ellipse.columns(y, y + 1)?;
            first = i64::from(first).max(low).min(i64::from(to)) as u32;
            end = i64::from(end).min(high).max(0) as u32;
        }
        (first < end).then_some([first, end])
    }
}

/// Pixels of a region that have not stopped, one bit each.
struct Live<'a> {
    words: usize,
    bits: Vec<u64>,
    /// Where pixels stop, in order: rank, column, row.
    stops: std::iter::Peekable<std::slice::Iter<'a, (u32, u32, u32)>>,
}

impl<'a> Live<'a> {
    fn new(width: u32, height: u32, stops: &'a [(u32, u32, u32)]) -> Live<'a> {
        let words = width.div_ceil(u64::BITS) as usize;
        Live {
            words,
            bits: vec![u64::MAX; words * height as usize],
            stops: stops.iter().peekable(),
        }
    }

    /// Takes out the pixels that have stopped before a splat.
    fn advance(&mut self, rank: u32) {
        // The splat at which a pixel stops is still evaluated for it.
        while let Some((_, x, y)) = self.stops.next_if(|(stop, ..)| *stop < rank) {
            let word = *y as usize * self.words + (x / u64::BITS) as usize;
            self.bits[word] &= !(1 << (x % u64::BITS));
        }
    }

    /// The live ones of some columns of a row.
    fn count(&self, y: u32, [from, to]: [u32; 2]) -> u32 {
        let row = &self.bits[y as usize * self.words..][..self.words];
        let below = |x: u32, word: usize| match x.saturating_sub(word as u32 * u64::BITS) {
            0 => 0,
            n if n >= u64::BITS => u64::MAX,
            n => (1 << n) - 1,
        };
        let words = (from / u64::BITS) as usize..to.div_ceil(u64::BITS) as usize;
        words.map(|w| (row[w] & below(to, w) & !below(from, w)).count_ones()).sum()
    }
}

/// What the regions of one row have.
struct RowOfRegions {
    regions: Vec<Region>,
    entries: Vec<RegionEntry>,
}

impl ResidentFrame {
    /// Cuts a frame.
    pub fn new(frame: &Frame, shape: RegionShape) -> ResidentFrame {
        let camera = &frame.facts.camera;
        let [width, height] = [camera.width, camera.height];
        let feet: Vec<Option<Footprint>> = (frame.splats.par_iter())
            .map(|splat| Footprint::new(splat, width, height, shape.cut))
            .collect();
        let rows = height.div_ceil(shape.region(width, height)[1]);
        let rows: Vec<RowOfRegions> =
            (0..rows).into_par_iter().map(|row| row_of_regions(frame, shape, &feet, row)).collect();
        let mut regions = Vec::with_capacity(rows.iter().map(|row| row.regions.len()).sum());
        let mut entries = Vec::with_capacity(rows.iter().map(|row| row.entries.len()).sum());
        for row in rows {
            let start = entries.len() as u32;
            regions.extend(row.regions.into_iter().map(|r| Region { start: r.start + start, ..r }));
            entries.extend(row.entries);
        }
        let mut of_splat = vec![0_u32; frame.splats.len()];
        entries.iter().for_each(|entry: &RegionEntry| of_splat[entry.rank as usize] += 1);
        let (slot, index) = slots(frame, &of_splat);
        // Where there is one region, nobody asks which ones a Gaussian meets.
        let looks = shape.cut == Cut::Exact && regions.len() > 1;
        let rows = |rank: usize| match (&feet[rank], looks) {
            (Some(foot), true) => u64::from(foot.rows[1] - foot.rows[0]),
            _ => 0,
        };
        let storage = storage(frame, &of_splat, rows);
        let counters = Counters {
            points: frame.facts.points,
            survivors: frame.facts.survivors,
            tile_pairs: entries.len() as u64,
            intersecting_points: index.len() as u64,
            fetched_points: index.len() as u64,
            tile_loads: entries.len() as u64,
            alpha_evaluations: entries.iter().map(|entry| u64::from(entry.live)).sum(),
            blends: regions.iter().map(|region| region.blends).sum(),
            ..Counters::default()
        };
        let sh_degree = frame.facts.colour_degree();
        let is_foveated = frame.fovea.is_some();
        ResidentFrame {
            shape,
            sh_degree,
            is_foveated,
            counters,
            regions,
            entries,
            slot,
            index,
            storage,
            tiles: shape.depths.then(|| Box::new(bin_for(frame, DEPTH_TILES, DEPTHS))),
        }
    }

    /// The same with some of its regions only. The front finds out which regions a Gaussian meets
    /// before it knows which of them are rendered.
    pub fn with_some(&self, wanted: &[bool]) -> ResidentFrame {
        let mut made = ResidentFrame { tiles: None, ..self.clone() };
        (made.regions, made.entries) = (Vec::new(), Vec::new());
        for (region, _) in self.regions.iter().zip(wanted).filter(|(_, wanted)| **wanted) {
            made.regions.push(Region { start: made.entries.len() as u32, ..*region });
            made.entries.extend(self.of(region));
        }
        let mut of_splat = vec![0_u32; self.slot.len()];
        made.entries.iter().for_each(|entry| of_splat[entry.rank as usize] += 1);
        // Slots are in the order of storage, and stay so.
        let mut own = vec![RecordCounts::default(); self.storage.len()];
        let mut ranks: Vec<u32> = (0..self.slot.len() as u32).collect();
        ranks.retain(|&rank| of_splat[rank as usize] > 0);
        ranks.sort_unstable_by_key(|&rank| self.slot[rank as usize]);
        made.slot.fill(u32::MAX);
        made.index.clear();
        for (slot, &rank) in (0..).zip(&ranks) {
            let index = self.index[self.slot[rank as usize] as usize];
            made.slot[rank as usize] = slot;
            made.index.push(index);
            let block = &mut own[(u64::from(index) / STORAGE_BLOCK) as usize];
            block.splats += 1;
            block.entries += u64::from(of_splat[rank as usize]);
        }
        let mut sum = RecordCounts::default();
        for (counts, own) in made.storage.iter_mut().zip(own) {
            (sum.splats, sum.entries) = (sum.splats + own.splats, sum.entries + own.entries);
            (counts.splats, counts.entries) = (sum.splats, sum.entries);
        }
        let (entries, splats) = (made.entries.len() as u64, made.index.len() as u64);
        made.counters = Counters {
            tile_pairs: entries,
            intersecting_points: splats,
            fetched_points: splats,
            tile_loads: entries,
            alpha_evaluations: made.entries.iter().map(|entry| u64::from(entry.live)).sum(),
            blends: made.regions.iter().map(|region| region.blends).sum(),
            ..self.counters
        };
        made
    }

    /// The entries of a region.
    pub fn of(&self, region: &Region) -> &[RegionEntry] {
        &self.entries[region.start as usize..][..region.entries as usize]
    }

    /// Counts of the first records of the scene: whole blocks, or all.
    pub fn up_to(&self, records: u64) -> RecordCounts {
        // Batches are multiples of a block, so that only the last one may end inside of a block.
        let blocks = records.div_ceil(STORAGE_BLOCK).min(self.storage.len() as u64) as usize;
        blocks.checked_sub(1).map_or(RecordCounts::default(), |last| self.storage[last])
    }
}

/// Entries of a frame by bounding squares, and the memory that cutting it takes, bytes.
fn demand(frame: &Frame, shape: RegionShape) -> (u64, u64) {
    let camera = &frame.facts.camera;
    let [width, height] = shape.region(camera.width, camera.height);
    let entries = |splat: &Splat| {
        let foot = Footprint::new(splat, camera.width, camera.height, Cut::Box);
        foot.map_or(0, |foot| {
            let of = |[from, to]: [u32; 2], side: u32| u64::from((to - 1) / side - from / side + 1);
            of(foot.columns, width) * of(foot.rows, height)
        })
    };
    let pairs: u64 = frame.splats.par_iter().map(entries).sum();
    let splats = frame.splats.len() as u64;
    // For a moment entries are there twice: row by row, and all together.
    let each = 2 * size_of::<RegionEntry>() as u64;
    let splat = size_of::<Option<Footprint>>() as u64 + 16;
    let pixels = u64::from(camera.width) * u64::from(camera.height) * 16;
    let blocks = frame.facts.points.div_ceil(STORAGE_BLOCK) * size_of::<RecordCounts>() as u64;
    let bytes = (pairs.saturating_mul(each))
        .saturating_add(splats.saturating_mul(splat))
        .saturating_add(pixels.saturating_add(blocks));
    (pairs, bytes)
}

/// The regions of a row, in parallel to others.
fn row_of_regions(
    frame: &Frame,
    shape: RegionShape,
    feet: &[Option<Footprint>],
    row: u32,
) -> RowOfRegions {
    let camera = &frame.facts.camera;
    let [width, height] = shape.region(camera.width, camera.height);
    let [top, bottom] = [row * height, ((row + 1) * height).min(camera.height)];
    let columns = camera.width.div_ceil(width);
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); columns as usize];
    for (rank, foot) in feet.iter().enumerate() {
        let Some(foot) = foot.filter(|foot| foot.rows[0] < bottom && foot.rows[1] > top) else {
            continue;
        };
        let touched = foot.columns[0] / width..(foot.columns[1] - 1) / width + 1;
        touched.for_each(|column| lists[column as usize].push(rank as u32));
    }
    let mut all = RowOfRegions { regions: Vec::new(), entries: Vec::new() };
    for (column, list) in (0..columns).zip(lists) {
        let [left, right] = [column * width, ((column + 1) * width).min(camera.width)];
        let pixels = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
        let at = |x: u32, y: u32| y as usize * camera.width as usize + x as usize;
        let mut stops: Vec<(u32, u32, u32)> = Vec::new();
        let mut blends = 0;
        for (x, y) in pixels {
            let stop = frame.pixels.stop_rank[at(x, y)];
            blends += u64::from(frame.pixels.blended[at(x, y)]);
            if stop != NEVER {
                stops.push((stop, x - left, y - top));
            }
        }
        stops.sort_unstable();
        let area = (right - left) * (bottom - top);
        // A region becomes opaque only if every one of its pixels stops.
        let last = stops.last().filter(|_| stops.len() == area as usize).map(|stop| stop.0);
        let mut live = Live::new(right - left, bottom - top, &stops);
        let mut region =
            Region { start: all.entries.len() as u32, pixels: area, blends, ..Region::default() };
        for rank in list {
            let foot = feet[rank as usize].as_ref().expect("it has pixels");
            live.advance(rank);
            let mut entry = RegionEntry { rank, cycles: 0, pixels: 0, live: 0, rows: 0 };
            for y in foot.rows[0].max(top)..foot.rows[1].min(bottom) {
                let Some([from, to]) = foot.row(y, left, right) else { continue };
                entry.pixels += to - from;
                entry.cycles += shape.cycles(to - from);
                entry.rows += u32::from(shape.cut == Cut::Exact);
                entry.live += live.count(y - top, [from - left, to - left]);
            }
            if entry.pixels == 0 {
                continue;
            }
            // A box is cut into steps as a whole, without empty lanes at the ends of its rows
            // (A121).
            if shape.cut == Cut::Box {
                entry.cycles = shape.cycles(entry.pixels);
            }
            all.entries.push(entry);
            region.entries += 1;
            if last.is_none_or(|last| rank <= last) {
                region.saturated = region.entries;
            }
        }
        all.regions.push(region);
    }
    all
}

/// Where feature records lie: by rank the slot, by slot the index.
fn slots(frame: &Frame, of_splat: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut order: Vec<(u32, u32)> = (frame.splats.iter().zip(0..).zip(of_splat))
        .filter(|(_, entries)| **entries > 0)
        .map(|((splat, rank), _)| (splat.index, rank))
        .collect();
    order.sort_unstable();
    let mut slot = vec![u32::MAX; frame.splats.len()];
    for (place, (_, rank)) in (0..).zip(&order) {
        slot[*rank as usize] = place;
    }
    (slot, order.into_iter().map(|(index, _)| index).collect())
}

/// Counts by blocks of records. Where a trace does not say which records survive, they are spread
/// evenly.
fn storage(frame: &Frame, of_splat: &[u32], rows: impl Fn(usize) -> u64) -> Vec<RecordCounts> {
    let points = frame.facts.points;
    let blocks = points.div_ceil(STORAGE_BLOCK) as usize;
    let mut all = vec![RecordCounts::default(); blocks];
    for (rank, (splat, entries)) in frame.splats.iter().zip(of_splat).enumerate() {
        if *entries == 0 {
            continue;
        }
        let block = &mut all[(u64::from(splat.index) / STORAGE_BLOCK) as usize];
        block.splats += 1;
        block.entries += u64::from(*entries);
        block.rows += rows(rank);
    }
    if let Some(bits) = &frame.survivor_bits {
        for (block, bytes) in all.iter_mut().zip(bits.chunks(STORAGE_BLOCK as usize / 8)) {
            block.survivors = bytes.iter().map(|byte| u64::from(byte.count_ones())).sum();
        }
    }
    let mut sum = RecordCounts::default();
    for (block, end) in all.iter_mut().zip(1..) {
        sum.splats += block.splats;
        sum.entries += block.entries;
        sum.rows += block.rows;
        sum.survivors = match frame.survivor_bits {
            Some(_) => sum.survivors + block.survivors,
            None => {
                let records = (end * STORAGE_BLOCK).min(points);
                let even = u128::from(frame.facts.survivors) * u128::from(records);
                // No fewer than are seen.
                ((even / u128::from(points.max(1))) as u64).max(sum.splats)
            }
        };
        *block = sum;
    }
    all
}

/// Lists of regions.
pub struct Regions;

impl WorkKind for Regions {
    fn name(&self) -> &'static str {
        "lists of regions"
    }

    fn demand(&self, frame: &Frame, numbers: &[u32], budget: Budget) -> Result<u64, Unbinnable> {
        let shape = RegionShape::of(numbers);
        let (pairs, mut bytes) = demand(frame, shape);
        if shape.depths {
            bytes += demand::demand(frame, DEPTH_TILES, DEPTHS, budget)?;
        }
        budget.check(bytes).map_err(|over| Unbinnable::Memory { pairs, over })?;
        if pairs > u64::from(u32::MAX) { Err(Unbinnable::Pairs(pairs)) } else { Ok(bytes) }
    }

    fn prepare(&self, frame: &Frame, numbers: &[u32]) -> Box<dyn Work> {
        Box::new(ResidentFrame::new(frame, RegionShape::of(numbers)))
    }
}

impl Work for ResidentFrame {
    fn key(&self) -> WorkKey {
        self.shape.key()
    }

    fn counters(&self) -> &Counters {
        &self.counters
    }

    fn sh_degree(&self) -> ShDegree {
        self.sh_degree
    }

    fn tiles(&self) -> usize {
        self.regions.len()
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.regions)
            + size_of_val(&*self.entries)
            + size_of_val(&*self.slot)
            + size_of_val(&*self.index)
            + size_of_val(&*self.storage)
            + self.tiles.as_ref().map_or(0, |tiles| tiles.bytes())
    }
}
