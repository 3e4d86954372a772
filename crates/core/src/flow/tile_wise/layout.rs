//! DRAM layout of a frame, and the address ranges that a request touches (A35).
//!
//! Regions follow each other, each beginning at a multiple of 1 MiB: positions, geometry and
//! colours of the scene in storage order (one array of whole records with `ccu.fetch =
//! "everything"`), bounds of clusters where there are any, projected splats in the order of the
//! CCUs, tile lists back to back, features in storage order at `record.feature-pitch`, keys that
//! do not fit the sorting buffers (one MiB a core), what is known of pixels where not all are
//! rendered, what a step of training reads and writes, sums of gradients, and the image, tile by
//! tile. Foveated frames
//! have two more in front of the keys: the colours of levels 2 to 4, three records a Gaussian, and
//! the features of second levels in storage order. Where the CCUs write the feature records there
//! is no region of projected splats. Where lists are made with pointers (A90), the pointers have a
//! region behind the lists.

use crate::kernel;
use crate::kernel::blocks::BlockStream;
use std::ops::Range;

use crate::flow::steps::StepPart;
use crate::flow::tile_wise::FrameContext;
use crate::flow::tile_wise::batch::{Batch, Pass};
use crate::flow::tile_wise::gradients::GradientWork;
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::schedule::{Job, Plan};
use crate::flow::tile_wise::traffic::ChunkLoad;
use crate::flow::tile_wise::{FeatureSource, Fetch};
use crate::workload::FrameWorkload;
use crate::workload::binning::{ListWrites, Moved};
use powergs_dram::AddressRange;

/// Regions begin at multiples of this.
const REGION: u64 = 1 << 20;

/// The addresses that a request touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AccessPattern {
    /// Contiguous bytes.
    Run(AddressRange),
    /// What a CCU writes of a batch.
    Results {
        /// Place of its first splat.
        first_splat: u64,
        /// Splats.
        splats: u64,
        /// Its list entries, back to back.
        entries: AddressRange,
        /// What of its entries and of the pointers is written instead.
        lists: Moves,
    },
    /// What is read before list entries are written.
    Back(Moves),
    /// The lists of tiles one after the other, or that of a sort group.
    Lists {
        /// First position in [`Plan::tiles`], and the one behind the last.
        tiles: (u32, u32),
        /// The sort group.
        group: Option<u32>,
        /// Bytes.
        bytes: u64,
    },
    /// Records of some Gaussians of a batch, evenly among its records.
    Some {
        /// Record of the first one in the batch.
        first: u64,
        /// Records of the batch.
        records: u64,
        /// Gaussians among them.
        taken: u64,
        /// Arrays of [`Layout`] that are read.
        arrays: Arrays,
    },
    /// Depths of entries of a list, in their feature records.
    Depths {
        /// First entry in [`FrameWorkload::list`].
        start: u64,
        /// Entries of the list.
        entries: u64,
        /// Those that are read, evenly among them.
        taken: u64,
    },
    /// Features and colours of entries of a list.
    Chunk {
        /// First entry in [`FrameWorkload::list`].
        start: u64,
        /// Entries.
        entries: u64,
        /// How many of their records are read. Evenly spaced entries stand for them: which entries
        /// hit the cache or were loaded before is not known here.
        load: ChunkLoad,
    },
    /// What a gradient unit reads or writes of a tile.
    Gradients {
        /// Contiguous bytes.
        run: AddressRange,
        /// First entry in [`FrameWorkload::list`], and how many have their features read.
        list: (u64, u64),
        /// Whether sums are read (0) or written (1).
        way: usize,
        /// The first of them in what is moved in the frame, and the one behind the last.
        sums: (u32, u32),
    },
}

/// Moves between lists and chip.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Moves {
    /// Of the pass that counts.
    counts: bool,
    first: u64,
    end: u64,
}

/// What of a record is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrays {
    /// Its geometry.
    Geometry,
    /// Its colour.
    Colour,
    /// Both.
    Both,
}

/// Addresses of the regions of a frame.
#[derive(Debug, Clone)]
pub struct Layout<'a> {
    workload: &'a FrameWorkload,
    fetch: Fetch,
    /// Position, geometry, colour: bytes read, and distance of records.
    scene: [(u64, u64, u64); 3],
    /// Bounds of clusters: base, bytes.
    clusters: (u64, u64),
    /// Base, bytes, pitch.
    projected: (u64, u64, u64),
    /// Features of second levels, where a CCU writes them.
    seconds: (u64, u64),
    lists: (u64, u64),
    /// How lists are made, and where their pointers lie.
    made: Option<(&'a ListWrites, u64)>,
    /// [`Plan::tiles`].
    tiles: &'a [u32],
    features: (u64, u64, u64),
    /// Bytes of a depth.
    depth: u64,
    /// Colours of further levels and features of second ones, in foveated frames.
    levels: [(u64, u64); 2],
    spill: u64,
    /// What each unit that acts first reads and writes.
    first: Vec<[u64; 2]>,
    /// Pixels that are known.
    known: u64,
    pixels: (u64, u64),
    /// What each part of a step of training reads and writes.
    steps: [[u64; 2]; StepPart::ALL.len()],
    /// Which sums are moved, where they lie, and their bytes.
    sums: Option<(&'a [Vec<u32>; 2], u64, u64)>,
    /// First byte behind the arrays of the scene.
    scene_end: u64,
    /// First byte behind all regions.
    end: u64,
}

impl<'a> Layout<'a> {
    /// The layout of `workload` on a machine with these units, in a frame context.
    pub fn new(
        workload: &'a FrameWorkload,
        units: &ResolvedUnits,
        plan: &'a Plan,
        context: &FrameContext<'a>,
    ) -> Layout<'a> {
        let gradients = GradientWork::new(workload, units, context);
        let gradients = gradients.as_ref();
        let (r, c) = (&units.ccu.record, &workload.counters);
        let mut end = 0u64;
        let mut region = |bytes: u64| {
            let start = end;
            end = (start + bytes).next_multiple_of(REGION);
            start
        };
        let fovea = &units.vru.fovea;
        let geometry = r.geometry.0 + units.ccu.level_bytes;
        let all = r.position.0 + geometry + r.colour.0;
        let sizes = match units.ccu.spec.fetch {
            Fetch::Everything => [(all, all), (0, 0), (0, 0)],
            Fetch::GeometryFirst | Fetch::VisibleColour | Fetch::LazyColour => {
                let levels = units.ccu.level_colour_bytes;
                let colour = (r.colour.0 + levels, r.colour_pitch.0 + levels);
                [(r.position.0, r.position.0), (geometry, geometry), colour]
            }
        };
        let scene =
            sizes.map(|(bytes, pitch)| (region(c.points.saturating_mul(pitch)), bytes, pitch));
        let (size, bytes) = (u64::from(units.ccu.spec.clusters), units.ccu.spec.cluster.0);
        let clusters = if size == 0 { 0 } else { c.points.div_ceil(size) };
        let clusters = (region(clusters * bytes), bytes);
        let entries = workload.list.len() as u64;
        let mut layout = Layout {
            workload,
            end: 0,
            tiles: &plan.tiles,
            scene_end: region(0),
            fetch: units.ccu.spec.fetch,
            scene,
            clusters,
            seconds: (0, 0),
            projected: match r.feature_source {
                FeatureSource::Ccu => (0, 0, 0),
                FeatureSource::Nobody => {
                    (region(c.intersecting_points * r.projected.0), r.projected.0, r.projected.0)
                }
            },
            lists: match context.lists {
                Some(lists) => (region(lists.sizes()[0]), units.ccu.entry),
                None => (region(entries.max(c.tile_pairs) * units.ccu.entry), units.ccu.entry),
            },
            made: context.lists.map(|lists| (lists, region(lists.sizes()[1]))),
            features: {
                let start = region(c.intersecting_points * r.feature_pitch.0);
                (start, r.feature.0, r.feature_pitch.0)
            },
            depth: units.qsu.depth,
            // Plain frames have none, and nothing moves.
            levels: match &workload.fovea {
                None => [(0, 0); 2],
                Some(_) => [
                    (region(3 * c.points.saturating_mul(fovea.record.0)), fovea.record.0),
                    (region(c.intersecting_points * fovea.feature.0), fovea.feature.0),
                ],
            },
            spill: region(u64::from(units.vru.spec.cores) * REGION),
            first: context.first.iter().map(|unit| unit.bytes().map(&mut region)).collect(),
            known: region(context.pixels.map_or(0, |some| BlockStream::bytes(&some.blocks)[0])),
            steps: StepPart::ALL.map(|part| {
                let bytes = gradients.map_or([0; 2], |work| work.bytes(part));
                // Cores take tiles in turn, and one may take more than its share.
                bytes.map(|bytes| region(2 * bytes))
            }),
            sums: gradients.map(|work| {
                let all = c.intersecting_points * work.record();
                (work.moved(), region(all), work.record())
            }),
            pixels: (region(0), u64::from(workload.geometry.tile).pow(2) * units.vru.pixel),
        };
        // CCUs write the feature records themselves, so that splats need no region of their own.
        if r.feature_source == FeatureSource::Ccu {
            layout.projected = (layout.features.0, r.projected.0, r.feature_pitch.0);
            layout.seconds = layout.levels[1];
        }
        layout.end = layout.pixels.0 + workload.tiles.len() as u64 * layout.pixels.1;
        layout
    }

    /// What was there before the frame: the arrays of the scene, and the colours of further levels.
    pub fn uploaded(&self) -> [Range<u64>; 2] {
        let levels = self.levels[0];
        let behind = if levels.1 == 0 { levels.0 } else { self.levels[1].0 };
        [0..self.scene_end, levels.0..behind]
    }

    /// A read of a batch, 0 to 2, of `bytes`: the records in order, the survivors, the splats.
    pub fn batch_read(&self, batch: &Batch, read: usize, bytes: u64) -> AccessPattern {
        let Batch { first, records, survivors, splats, .. } = *batch;
        let (base, _, pitch) = self.scene[0];
        let arrays =
            if self.fetch == Fetch::GeometryFirst { Arrays::Both } else { Arrays::Geometry };
        if batch.pass == Pass::Scatter {
            let entries = AddressRange { address: 0, bytes: 0 };
            let (first_splat, lists) = (batch.first_splat, Moves::default());
            return AccessPattern::Results { first_splat, splats, entries, lists };
        }
        match read {
            0 if batch.clusters > 0 => {
                let (base, pitch) = self.clusters;
                AccessPattern::Run(AddressRange { address: base + first * pitch, bytes })
            }
            0 => AccessPattern::Run(AddressRange { address: base + first * pitch, bytes }),
            1 => AccessPattern::Some { first, records, taken: survivors, arrays },
            _ => AccessPattern::Some { first, records, taken: splats, arrays: Arrays::Colour },
        }
    }

    /// The results that a CCU writes for a batch: projected splats, and list entries. Where splats
    /// are feature records, each lies in its own place.
    pub fn results(&self, batch: &Batch) -> AccessPattern {
        let (base, size) = self.lists;
        let pairs = if self.made.is_some() { 0 } else { batch.pairs };
        let entries = AddressRange { address: base + batch.first_pair * size, bytes: pairs * size };
        let splats = if batch.pass == Pass::Scatter { 0 } else { batch.splats };
        let lists = moves(batch);
        AccessPattern::Results { first_splat: batch.first_splat, splats, entries, lists }
    }

    /// What a CCU reads for a batch before it writes its results.
    pub fn read_back(&self, batch: &Batch) -> AccessPattern {
        AccessPattern::Back(moves(batch))
    }

    /// The first `bytes` of the list of a job.
    pub fn list(&self, job: &Job, bytes: u64) -> AccessPattern {
        match self.made {
            Some(_) => {
                let tiles = (job.tiles.start, job.tiles.end);
                AccessPattern::Lists { tiles, group: job.group, bytes }
            }
            None => AccessPattern::Run(AddressRange {
                address: self.lists.0 + u64::from(job.list_start) * self.lists.1,
                bytes,
            }),
        }
    }

    /// The depths that are read for a job.
    pub fn depths(&self, job: &Job) -> AccessPattern {
        let tiles = &self.tiles[job.tiles.start as usize..job.tiles.end as usize];
        let of = |&tile: &u32| u64::from(self.workload.tiles[tile as usize].entries);
        // Of a group, the first of its tiles that has as many stands for all of it.
        let most = tiles.iter().map(of).max().unwrap_or(0);
        let first = tiles.iter().find(|&tile| of(tile) == most);
        let start = first.map_or(0, |&tile| self.workload.tiles[tile as usize].list_start);
        AccessPattern::Depths { start: start.into(), entries: most, taken: job.depths }
    }

    /// `bytes` of the spill region of `core`, for keys that its sorting buffer does not hold.
    pub fn spill(&self, core: u32, bytes: u64) -> AccessPattern {
        AccessPattern::Run(AddressRange { address: self.spill + u64::from(core) * REGION, bytes })
    }

    /// Where what each unit that acts first reads and writes begins.
    pub fn first(&self) -> &[[u64; 2]] {
        &self.first
    }

    /// Where pixels that are known lie, and where they come to.
    pub fn known(&self) -> [u64; 2] {
        [self.known, self.pixels.0]
    }

    /// [`Plan::tiles`].
    pub fn tiles(&self) -> &'a [u32] {
        self.tiles
    }

    /// Where what a part of a step reads and writes begins.
    pub fn step(&self, part: StepPart) -> [u64; 2] {
        self.steps[part as usize]
    }

    /// The first `bytes` of the pixels of `tile` (row-major index) in the image.
    pub fn pixels(&self, tile: u32, bytes: u64) -> AccessPattern {
        AccessPattern::Run(AddressRange {
            address: self.pixels.0 + u64::from(tile) * self.pixels.1,
            bytes,
        })
    }

    /// The next address range of a request of which `cursor` ranges are done.
    pub fn piece(&self, span: &AccessPattern, cursor: &mut u64) -> Option<AddressRange> {
        if let AccessPattern::Lists { tiles, group, bytes } = *span {
            // The cursor counts bytes.
            let piece = self.of_lists(tiles, group, *cursor, bytes)?;
            *cursor += piece.bytes;
            return Some(piece);
        }
        loop {
            let step = *cursor;
            *cursor += 1;
            let piece = match *span {
                AccessPattern::Run(piece) => part(piece, step)?,
                AccessPattern::Results { first_splat, splats, entries, lists } => {
                    self.result(first_splat, splats, entries, &lists, step)?
                }
                AccessPattern::Back(lists) => self.moved(&lists, step, 0)?,
                AccessPattern::Lists { .. } => return None,
                AccessPattern::Some { first, records, taken, arrays } => {
                    self.of_record((first, records), taken, arrays, step)?
                }
                AccessPattern::Depths { start, entries, taken } => {
                    let at =
                        (step < taken && entries > 0).then(|| start + step * entries / taken)?;
                    let slot = self.workload.slot[self.workload.list[at as usize] as usize];
                    let address = self.features.0 + u64::from(slot) * self.features.2;
                    AddressRange { address, bytes: self.depth }
                }
                AccessPattern::Chunk { start, entries, load } => {
                    self.record(start, entries, load, step)?
                }
                AccessPattern::Gradients { run, list, way, sums } => {
                    self.of_gradients(run, list, (way, sums), step)?
                }
            };
            if piece.bytes > 0 {
                return Some(piece);
            }
        }
    }

    /// Splats back to back are one piece; feature records have gaps between them.
    fn result(
        &self,
        first: u64,
        splats: u64,
        entries: AddressRange,
        lists: &Moves,
        step: u64,
    ) -> Option<AddressRange> {
        let (base, bytes, pitch) = self.projected;
        let (pieces, size) = if bytes == pitch { (1, splats * bytes) } else { (splats, bytes) };
        if step < pieces {
            return Some(AddressRange { address: base + (first + step) * pitch, bytes: size });
        }
        match step - pieces {
            0 => Some(entries),
            1 => {
                let (base, bytes) = self.seconds;
                Some(AddressRange { address: base + first * bytes, bytes: splats * bytes })
            }
            step => self.moved(lists, step - 2, 1),
        }
    }

    /// The contiguous bytes from byte `at` of lists one after the other, of which `bytes` are read.
    fn of_lists(
        &self,
        tiles: (u32, u32),
        group: Option<u32>,
        mut at: u64,
        bytes: u64,
    ) -> Option<AddressRange> {
        let workload = self.workload;
        let (lists, _) = self.made?;
        let mut left = bytes.checked_sub(at).filter(|&left| left > 0)?.min(REGION);
        let mut list = group.unwrap_or(0);
        if group.is_none() {
            let tiles = &self.tiles[tiles.0 as usize..tiles.1 as usize];
            list = *tiles.iter().find(|&&tile| {
                let entries = workload.tiles[tile as usize].entries;
                let own = lists.shape().list_bytes(u64::from(entries));
                let is_here = at < own;
                (at, left) = if is_here { (at, left.min(own - at)) } else { (at - own, left) };
                is_here
            })?;
        }
        // A list with pointers lies in blocks, and what is contiguous ends with a block (A90).
        let (place, bytes) = lists.run(list, at, left);
        Some(AddressRange { address: self.lists.0 + place, bytes })
    }

    /// What the `step`-th move reads (`way` 0) or writes (1), which may be nothing.
    fn moved(&self, moves: &Moves, step: u64, way: usize) -> Option<AddressRange> {
        let (lists, pointers) = self.made?;
        let at = moves.first + step;
        if at >= moves.end {
            return None;
        }
        let own = lists.moved(moves.counts, at);
        let base = if own.what == Moved::Entries { self.lists.0 } else { pointers };
        let bytes = lists.bytes_of(own)[way];
        Some(AddressRange { address: base + lists.place_of(own), bytes })
    }

    /// What is read of the records from `first` of which `taken` are taken.
    fn of_record(
        &self,
        (first, records): (u64, u64),
        taken: u64,
        arrays: Arrays,
        step: u64,
    ) -> Option<AddressRange> {
        let (index, array) = match arrays {
            Arrays::Geometry => (step, 1),
            Arrays::Colour => (step, 2),
            Arrays::Both => (step / 2, 1 + step % 2),
        };
        if index >= taken {
            return None;
        }
        let record = first + index * records / taken;
        let (base, bytes, pitch) = self.scene[array as usize];
        Some(AddressRange { address: base + record * pitch, bytes })
    }

    /// Bytes in a row, features of entries of a list, then sums.
    fn of_gradients(
        &self,
        run: AddressRange,
        (start, features): (u64, u64),
        (way, (first, end)): (usize, (u32, u32)),
        step: u64,
    ) -> Option<AddressRange> {
        let parts = run.bytes.div_ceil(REGION);
        if step < parts {
            return part(run, step);
        }
        let step = step - parts;
        if step < features {
            let load = ChunkLoad { features, ..ChunkLoad::default() };
            return self.record(start, features, load, step);
        }
        let (moved, base, bytes) = self.sums?;
        let at = u64::from(first) + step - features;
        let slot = (at < u64::from(end)).then(|| moved[way][at as usize])?;
        Some(AddressRange { address: base + u64::from(slot) * bytes, bytes })
    }

    fn record(&self, start: u64, entries: u64, load: ChunkLoad, step: u64) -> Option<AddressRange> {
        let workload = self.workload;
        let rank =
            |nth: u64, of: u64| workload.list[(start + nth * entries / of) as usize] as usize;
        if step < load.features {
            let (base, bytes, pitch) = self.features;
            let slot = u64::from(workload.slot[rank(step, load.features)]);
            return Some(AddressRange { address: base + slot * pitch, bytes });
        }
        let step = step - load.features;
        if step < load.colours {
            let (base, bytes, pitch) = self.scene[2];
            let index = u64::from(workload.index[rank(step, load.colours)]);
            return Some(AddressRange { address: base + index * pitch, bytes });
        }
        let step = step - load.colours;
        if step < load.levels {
            // The three further levels of a Gaussian lie together.
            let (base, bytes) = self.levels[0];
            let (nth, level) = (step * entries / load.levels, step % 3);
            let index = u64::from(workload.index[rank(nth, entries)]);
            return Some(AddressRange { address: base + (3 * index + level) * bytes, bytes });
        }
        let step = step - load.levels;
        if step >= load.seconds {
            return None;
        }
        let (base, bytes) = self.levels[1];
        let slot = u64::from(workload.slot[rank(step, load.seconds)]);
        Some(AddressRange { address: base + slot * bytes, bytes })
    }
}

impl kernel::memory::Layout for Layout<'_> {
    type Pattern = AccessPattern;

    fn piece(&self, pattern: &AccessPattern, cursor: &mut u64) -> Option<AddressRange> {
        Layout::piece(self, pattern, cursor)
    }

    fn end(&self) -> u64 {
        self.end
    }
}

/// The moves of a batch.
fn moves(batch: &Batch) -> Moves {
    batch.lists.map_or(Moves::default(), |part| Moves {
        counts: batch.pass == Pass::Count,
        first: part.first,
        end: part.first + part.moves,
    })
}

/// The `step`-th MiB of a piece.
fn part(piece: AddressRange, step: u64) -> Option<AddressRange> {
    let done = step * REGION;
    let bytes = piece.bytes.checked_sub(done)?.min(REGION);
    (bytes > 0).then_some(AddressRange { address: piece.address + done, bytes })
}
