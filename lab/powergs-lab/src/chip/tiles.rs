//! A view as the core of `rtl/` gets it, and the same for the cycle model: lists of the culling and
//! conversion unit, records, pivots, and what the datapath makes of every tile.

use rayon::prelude::*;
use serde::Deserialize;

use super::design::{Design, SPILL};
use crate::FrontEnd;
use powergs_base::picture::Picture;
use powergs_core::workload::{
    FrameDetail, FrameWorkload, Geometry, Pixels, StoragePrefix, TileList, TileWork,
};
use powergs_datapath::ccu::Converted;
use powergs_datapath::ccu::tiles::{Pair, Walk};
use powergs_datapath::{Entry, NumberFormat, Pixel, Record, TILE, TileRun, Vrc, Vru};
use powergs_scene::{Camera, Gaussians};

/// Bytes of a record in memory.
pub const RECORD: usize = 32;

/// Means of a request.
const MEANS: u32 = 7;
/// Bytes of an entry of a list.
const ENTRY: u64 = 6;
/// Most bytes of a request.
const REQUEST: u64 = 64;
/// Bytes of a line of a list.
const LINE: u64 = 32;
/// Bytes of the pixels of a tile.
pub const TILE_BYTES: u64 = 2048;

/// Pixels of a tile.
const PIXELS: usize = (TILE * TILE) as usize;

/// A splat that is seen.
#[derive(Debug, Clone)]
struct Seen {
    converted: Converted,
    walk: Walk,
    colour: [u16; 3],
    pairs: Vec<Pair>,
    /// What it is called in lists, and where its record is.
    number: u32,
}

/// An entry of a list: depth, number of the splat, its pair.
#[derive(Debug, Clone, Copy)]
struct Listed {
    depth: u16,
    slot: u32,
    number: u32,
    pair: Pair,
}

/// A tile and what becomes of it.
#[derive(Debug, Clone)]
pub struct ChipTile {
    /// Column and row.
    pub place: [u32; 2],
    /// Columns and rows of its pixels that are in the image.
    pub size: [u32; 2],
    /// Its list, front to back.
    entries: Vec<Listed>,
    /// What the rendering unit makes of it.
    run: TileRun,
}

/// What of a view is wanted.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// Entries of a sub-tile's queue.
    pub queue: usize,
    /// Only about so many tiles: whole ones, spread over those that have a list.
    pub most: Option<usize>,
    /// From the one at this position on.
    pub offset: usize,
    /// Converters that make the lists; 0: the lists are there.
    pub units: u32,
}

/// A view.
#[derive(Debug, Clone)]
pub struct ChipFrame {
    /// Columns and rows of tiles of the image.
    pub grid: [u32; 2],
    /// Its tiles, row by row, or some of them.
    pub tiles: Vec<ChipTile>,
    /// Whether these are all.
    pub is_whole: bool,
    /// Columns and rows of pixels of the image.
    pub size: [u32; 2],
    /// What a front reads.
    pub scene: SceneNumbers,
    seen: Vec<Seen>,
    /// Indices in the scene of `seen`.
    indices: Vec<u32>,
}

/// A scene and a view of it as a front reads them; nothing for cores alone.
#[derive(Debug, Clone, Default)]
pub struct SceneNumbers {
    /// How many Gaussians.
    pub gaussians: u32,
    /// Degree of their colours.
    pub degree: u32,
    /// The view.
    pub settings: [u32; 18],
    /// Means of 9 bytes, shapes of 24, coefficients of 96.
    pub numbers: Vec<u8>,
    /// For every Gaussian: whether it is kept, candidate tiles of its box tests.
    tested: Vec<(bool, u64)>,
}

impl SceneNumbers {
    fn new(front: &FrontEnd, count: usize) -> SceneNumbers {
        let settings = &front.settings;
        let of = |i: usize| {
            let gaussian = front.gaussian(i);
            let kept = front.unit.cull(settings, &gaussian.mean).kept;
            let walk = front.unit.splat(settings, &gaussian).map(|(_, walk)| walk.candidates());
            (gaussian, front.coefficients(i), (kept, walk.unwrap_or(0)))
        };
        let all: Vec<_> = (0..count).into_par_iter().map(of).collect();
        let wide = |numbers: &[u32]| -> Vec<u8> {
            numbers.iter().flat_map(|number| number.to_le_bytes()[..3].to_vec()).collect()
        };
        let mut numbers: Vec<u8> = all.iter().flat_map(|one| wide(&one.0.mean)).collect();
        numbers.extend(all.iter().flat_map(|one| wide(&one.0.shape)));
        numbers.extend(all.iter().flat_map(|one| one.1.map(u16::to_le_bytes)).flatten());
        SceneNumbers {
            gaussians: count as u32,
            degree: front.degree,
            settings: settings.numbers,
            numbers,
            tested: all.iter().map(|one| one.2).collect(),
        }
    }
}

impl ChipFrame {
    /// The view of `camera`.
    pub fn new(scene: &Gaussians, camera: &Camera, asked: &Asked) -> ChipFrame {
        let Asked { queue, most, offset, units } = *asked;
        let is_chip = units > 0;
        let format = NumberFormat::FP16;
        let front = FrontEnd::new(scene, camera, format).expect("FP16 has enough exponent");
        let unit = Vru { vrc: Vrc::new(format).expect("so have pixels"), split: true, queue };
        let found: Vec<(u32, Seen)> = (0..scene.len())
            .into_par_iter()
            .filter_map(|i| {
                let (converted, walk, colour) = front.converted(i)?;
                let pairs = walk.pairs(format);
                let seen = Seen { converted, walk, colour, pairs, number: 0 };
                (is_chip || !seen.pairs.is_empty()).then_some((i as u32, seen))
            })
            .collect();
        let mut found = found;
        number(&mut found, units.max(1));
        let (indices, seen): (Vec<u32>, Vec<Seen>) = found.into_iter().unzip();
        let size = [camera.width, camera.height];
        let grid = size.map(|length| length.div_ceil(TILE));
        let mut lists: Vec<Vec<Listed>> = Vec::new();
        lists.resize_with((grid[0] * grid[1]) as usize, Vec::new);
        for (slot, splat) in (0..).zip(&seen) {
            for &pair in &splat.pairs {
                let tile = (pair.tile[1] * grid[0] + pair.tile[0]) as usize;
                let (depth, number) = (splat.converted.depth, splat.number);
                lists[tile].push(Listed { depth, slot, number, pair });
            }
        }
        let places = lists.into_iter().zip(0u32..);
        let places = places.map(|(list, i)| (list, [i % grid[0], i / grid[0]]));
        let inside = |place: [u32; 2]| [0, 1].map(|i| (size[i] - place[i] * TILE).min(TILE));
        let mut taken: Vec<(Vec<Listed>, [u32; 2])> = places.collect();
        let all = taken.len();
        if let Some(most) = most.filter(|&most| most < all) {
            taken.retain(|(list, place)| !list.is_empty() && inside(*place) == [TILE; 2]);
            let step = taken.len().div_ceil(most.max(1)).max(1);
            taken = taken.into_iter().skip(offset % step).step_by(step).collect();
        }
        let tiles: Vec<ChipTile> = taken
            .into_par_iter()
            .map(|(mut entries, place)| {
                // Depths are not negative, so their bits have their order.
                entries.sort_unstable_by_key(|listed| (listed.depth, listed.slot));
                let given: Vec<Entry> = entries.iter().map(|listed| entry(&seen, listed)).collect();
                let size = inside(place);
                ChipTile { place, size, run: unit.tile(&given, size), entries }
            })
            .collect();
        let scene = match is_chip {
            true => SceneNumbers::new(&front, scene.len()),
            false => SceneNumbers::default(),
        };
        ChipFrame { grid, is_whole: tiles.len() == all, tiles, size, scene, seen, indices }
    }

    /// Entries of the longest list.
    pub fn longest(&self) -> usize {
        self.tiles.iter().map(|tile| tile.entries.len()).max().unwrap_or(0)
    }

    /// Entries of all lists.
    pub fn entries(&self) -> usize {
        self.tiles.iter().map(|tile| tile.entries.len()).sum()
    }

    /// Entries that are needed of all lists.
    pub fn needed(&self) -> usize {
        self.tiles.iter().map(ChipTile::needed).sum()
    }

    /// The same for the cycle model. Tiles that are some of a view lie side by side.
    pub fn workload(&self, geometry: Geometry) -> FrameWorkload {
        let mut order: Vec<u32> = (0..self.seen.len() as u32).collect();
        let depth = |slot: u32| self.seen[slot as usize].converted.depth;
        order.sort_unstable_by_key(|&slot| (depth(slot), slot));
        let mut rank = vec![0u32; order.len()];
        (0..).zip(&order).for_each(|(at, &slot)| rank[slot as usize] = at);
        let (size, tiles) = match self.is_whole {
            true => (self.size, self.grid),
            false => ([self.tiles.len() as u32 * TILE, TILE], [self.tiles.len() as u32, 1]),
        };
        let lists: Vec<TileList> = self.tiles.iter().map(|tile| tile.list(&rank)).collect();
        let pixels = size[0] as usize * size[1] as usize;
        let own = |tile: &ChipTile| TileWork {
            pixels: tile.size[0] * tile.size[1],
            ..TileWork::default()
        };
        let made = FrameWorkload {
            width: size[0],
            height: size[1],
            tiles_x: tiles[0],
            tiles_y: tiles[1],
            tiles: self.tiles.iter().map(own).collect(),
            index: order.iter().map(|&slot| self.indices[slot as usize]).collect(),
            depth: order.iter().map(|&slot| NumberFormat::FP16.to_f32(depth(slot))).collect(),
            slot: order,
            detail: FrameDetail { pixels: true, whole: false },
            pixels: Some(Pixels { splats: Vec::new(), iterated: vec![0; pixels] }),
            ..FrameWorkload::empty(geometry)
        };
        let mut made = made.with_lists(lists);
        self.count(&mut made);
        FrameWorkload { detail: FrameDetail::default(), pixels: None, ..made }
    }

    /// What the front of the chip does, as the cycle model counts it.
    fn count(&self, made: &mut FrameWorkload) {
        let tested = &self.scene.tested;
        let mut blocks = vec![StoragePrefix::default(); tested.len().div_ceil(32)];
        for (i, (kept, candidates)) in tested.iter().enumerate() {
            let own = &mut blocks[i / 32];
            own.survivors += u32::from(*kept);
            // A single candidate is taken as it is.
            if *candidates > 1 {
                own.prepared += 1;
                own.tests += *candidates as u32;
            }
        }
        for (index, seen) in self.indices.iter().zip(&self.seen) {
            if let Some(own) = blocks.get_mut(*index as usize / 32) {
                own.splats += 1;
                own.pairs += seen.pairs.len() as u32;
            }
        }
        let mut sum = StoragePrefix::default();
        for own in &mut blocks {
            sum.survivors += own.survivors;
            sum.prepared += own.prepared;
            sum.tests += own.tests;
            sum.splats += own.splats;
            sum.pairs += own.pairs;
            *own = sum;
        }
        made.counters.points = tested.len() as u64;
        made.counters.survivors = sum.survivors.into();
        made.counters.tile_pairs = sum.pairs.into();
        made.counters.intersecting_points = sum.splats.into();
        made.counters.obb_tests = sum.tests.into();
        made.counters.obb_prepared = sum.prepared.into();
        made.storage = blocks;
    }

    /// Lists in storage order, one behind the other: addresses and bytes.
    pub fn lists(&self) -> (Vec<u32>, Vec<u8>) {
        let (mut addresses, mut bytes) = (Vec::new(), Vec::new());
        for tile in &self.tiles {
            addresses.push(bytes.len() as u32);
            let mut stored = tile.entries.clone();
            stored.sort_unstable_by_key(|listed| listed.slot);
            for listed in stored {
                bytes.extend(&key(&listed).to_le_bytes()[..5]);
                bytes.push(listed.pair.subtiles as u8);
            }
        }
        (addresses, bytes)
    }

    /// Records of all splats that are seen.
    pub fn records(&self) -> Vec<u8> {
        self.seen.iter().flat_map(Seen::record).collect()
    }

    /// The pivots of each list, in the order of its splits; `None` where a list needs a third
    /// split, which the core has not.
    pub fn pivots(&self, chunk: usize, rule: Pivots) -> Option<Vec<Vec<u64>>> {
        let of = |tile: &ChipTile| {
            let mut keys: Vec<u64> = tile.entries.iter().map(key).collect();
            // As they arrive: in storage order.
            keys.sort_unstable_by_key(|key| key & 0xff_ffff);
            let mut all = Vec::new();
            split(&keys, chunk, rule, 2, &mut all).then_some(all)
        };
        self.tiles.iter().map(of).collect()
    }

    /// Behind the largest number of a splat.
    pub fn numbers(&self) -> u32 {
        self.seen.last().map_or(0, |seen| seen.number + 1)
    }

    /// Where lists, records, pixels and what is spilled are in the memory of a bench, and its end.
    /// Reads of a request may go beyond what they are for.
    pub fn layout(&self, design: &Design) -> [u64; 5] {
        let tiles = u64::from(self.grid[0]) * u64::from(self.grid[1]);
        let listed = match self.scene.gaussians {
            0 => (self.entries() as u64 * ENTRY + REQUEST).next_multiple_of(LINE),
            _ => tiles << design.region,
        };
        let lists = (self.scene.numbers.len() as u64 + REQUEST).next_multiple_of(LINE);
        let records = lists + listed;
        let pixels = records + u64::from(self.numbers()) * RECORD as u64;
        let spill = pixels + tiles * TILE_BYTES + REQUEST;
        [lists, records, pixels, spill, spill + u64::from(design.cores) * SPILL]
    }

    /// The picture that was written, before black; tiles that were not asked for are black.
    pub fn picture(&self, written: &[u8]) -> Picture {
        let [width, height] = self.size;
        let mut pixels = vec![[0.0; 3]; (width * height) as usize];
        for tile in &self.tiles {
            let at = (tile.place[1] * self.grid[0] + tile.place[0]) as usize * PIXELS * 8;
            for ((_, _, [x, y]), found) in places().zip(written[at..].chunks_exact(8)) {
                let [x, y] = [tile.place[0] * TILE + x, tile.place[1] * TILE + y];
                if x < width && y < height {
                    let channel = |i: usize| u16::from_le_bytes([found[2 * i], found[2 * i + 1]]);
                    let colour = [0, 1, 2].map(|i| NumberFormat::FP16.to_f32(channel(i)));
                    pixels[(y * width + x) as usize] = colour;
                }
            }
        }
        Picture { width, height, pixels }
    }

    /// Which tiles differ in any pixel from what the core wrote: their positions.
    pub fn wrong(&self, written: &[u8]) -> Vec<usize> {
        let is_wrong = |tile: &ChipTile| {
            let at = (tile.place[1] * self.grid[0] + tile.place[0]) as usize * PIXELS * 8;
            tile.pixels().zip(written[at..].chunks_exact(8)).any(|(pixel, found)| {
                let Some(pixel) = pixel else { return false };
                let [r, g, b] = pixel.colour;
                let own = [r, g, b, pixel.transmittance].map(u16::to_le_bytes);
                own.as_flattened() != found
            })
        };
        (0..self.tiles.len()).filter(|&tile| is_wrong(&self.tiles[tile])).collect()
    }
}

impl ChipTile {
    /// Entries of its list.
    pub fn listed(&self) -> usize {
        self.entries.len()
    }

    /// Entries up to the one behind which nothing is needed.
    fn needed(&self) -> usize {
        self.ends().into_iter().max().unwrap_or(0) as usize
    }

    /// List positions from which on nothing of a sub-tile is needed.
    fn ends(&self) -> [u32; 4] {
        self.run.ends.map(|end| end.unwrap_or(self.entries.len()) as u32)
    }

    fn list(&self, rank: &[u32]) -> TileList {
        let ends = self.ends();
        let [columns, rows] = self.size;
        let pixels =
            (0..rows).flat_map(|y| (0..columns).map(move |x| (2 * (y / 8) + x / 8) as usize));
        TileList {
            ranks: self.entries.iter().map(|listed| rank[listed.slot as usize]).collect(),
            bitmaps: self.entries.iter().map(|listed| listed.pair.subtiles as u8).collect(),
            iterated: pixels.map(|subtile| ends[subtile]).collect(),
            ..TileList::default()
        }
    }

    /// Its pixels in the order in which a core writes them; `None` outside of the image.
    fn pixels(&self) -> impl Iterator<Item = Option<&Pixel>> {
        places().map(|(unit, i, [x, y])| {
            let is_inside = x < self.size[0] && y < self.size[1];
            is_inside.then(|| &self.run.pixels[(16 * unit + i) as usize])
        })
    }
}

/// The pixels of a tile as a core writes them, eight of a row at a time, two of each unit: unit,
/// pixel of it, column and row.
fn places() -> impl Iterator<Item = (u32, u32, [u32; 2])> {
    (0..32).flat_map(|turn| {
        (0..8).map(move |at| {
            let (i, column, row) = (turn / 4 * 2 + at % 2, at / 2, turn % 4);
            let subtile = row / 2 * 2 + column / 2;
            let unit = 4 * subtile + row % 2 * 2 + column % 2;
            (unit, i, [4 * column + i % 4, 4 * row + i / 4])
        })
    })
}

impl Seen {
    /// Mean (two of 24 bits), a, b, c as whole numbers (three of 19), a, b, c, opacity, red, green,
    /// blue.
    fn record(&self) -> [u8; RECORD] {
        let (mean, root) = self.walk.form();
        let part = |value: i64, bits: u32| u128::from(value as u64 & ((1 << bits) - 1));
        let mut low = part(mean[0], 24) | part(mean[1], 24) << 24;
        for (i, root) in (0..).zip(root) {
            low |= part(root, 19) << (48 + 19 * i);
        }
        let mut record = [0; RECORD];
        record[..14].copy_from_slice(&low.to_le_bytes()[..14]);
        let Converted { root, opacity, .. } = self.converted;
        let narrow = root.into_iter().chain([opacity]).chain(self.colour);
        for (at, number) in record[14..].chunks_exact_mut(2).zip(narrow) {
            at.copy_from_slice(&number.to_le_bytes());
        }
        record
    }
}

/// Numbers splats as `units` converters do, each of which has every so manyth run of means of a
/// request, and counts what it sees in steps of `units`; sorts them by number.
fn number(found: &mut [(u32, Seen)], units: u32) {
    let mut next: Vec<u32> = (0..units).collect();
    for (index, seen) in found.iter_mut() {
        let own = &mut next[(*index / MEANS % units) as usize];
        seen.number = *own;
        *own += units;
    }
    found.sort_unstable_by_key(|(_, seen)| seen.number);
}

fn entry(seen: &[Seen], listed: &Listed) -> Entry {
    let splat = &seen[listed.slot as usize];
    let Converted { root, opacity, .. } = splat.converted;
    let splat = Record { mean: listed.pair.local, root, opacity, colour: splat.colour };
    Entry { splat, bitmap: listed.pair.subtiles as u8 }
}

/// What a list is sorted by: the number below the depth.
fn key(listed: &Listed) -> u64 {
    u64::from(listed.depth) << 24 | u64::from(listed.number)
}

/// Where pivots come from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pivots {
    #[default]
    /// They cut a list into whole chunks, as the cycle model has it (A23)
    Exact,
    /// They are quantiles of 64 keys of the list, for parts a quarter shorter than a chunk (A73)
    Sampled,
}

/// Parts of a split.
const PARTS: usize = 8;
/// Keys of a sample.
const SAMPLE: usize = 64;

/// Adds the pivots of a list, and of its parts that are longer than a chunk, front to back; returns
/// whether `levels` of splits are enough.
fn split(keys: &[u64], chunk: usize, rule: Pivots, levels: u32, all: &mut Vec<u64>) -> bool {
    if keys.len() <= chunk {
        return true;
    }
    if levels == 0 {
        return false;
    }
    let pivots: Vec<u64> = match rule {
        Pivots::Exact => {
            let mut sorted = keys.to_vec();
            sorted.sort_unstable();
            let part = if keys.len() <= PARTS * chunk { chunk } else { PARTS * chunk };
            (1..PARTS).map(|k| sorted.get(k * part).copied().unwrap_or(NEVER)).collect()
        }
        Pivots::Sampled => {
            let step = keys.len().div_ceil(SAMPLE);
            let mut sample: Vec<u64> = keys.iter().step_by(step).copied().collect();
            sample.sort_unstable();
            let parts = (4 * keys.len()).div_ceil(3 * chunk).min(PARTS);
            let quantile = |k: usize| sample[k * sample.len() / parts];
            (1..PARTS).map(|k| if k < parts { quantile(k) } else { NEVER }).collect()
        }
    };
    all.extend(&pivots);
    let mut parts: Vec<Vec<u64>> = vec![Vec::new(); PARTS];
    for &key in keys {
        parts[pivots.partition_point(|&pivot| pivot <= key)].push(key);
    }
    parts.iter().all(|part| split(part, chunk, rule, levels - 1, all))
}

/// A pivot that no key reaches.
const NEVER: u64 = (1 << 40) - 1;
