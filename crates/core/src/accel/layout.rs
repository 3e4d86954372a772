//! DRAM layout of a frame, and the address ranges that a request touches (A35).
//!
//! Regions follow each other, each beginning at a multiple of 1 MiB: positions, geometry and
//! colours of the scene in storage order (one array of whole records with `ccu.fetch =
//! "everything"`), projected splats in the order of the CCUs, tile lists back to back, features in
//! storage order at `record.feature-pitch`, keys that do not fit the sorting buffers (one MiB a
//! core), and the image, tile by tile. Foveated frames have two more in front of the keys: the
//! colours of levels 2 to 4, three records a Gaussian, and the features of second levels in storage
//! order.

use super::machine::Fetch;
use super::resolved::ResolvedUnits;
use super::traffic::ChunkLoad;
use crate::dram::AddressRange;
use crate::workload::FrameWorkload;

/// Regions begin at multiples of this.
const REGION: u64 = 1 << 20;

/// The addresses that a request touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AccessPattern {
    /// Contiguous bytes.
    Run(AddressRange),
    /// Two ranges: the projected splats and the list entries that a CCU writes.
    Two(AddressRange, AddressRange),
    /// Records of the survivors of a batch, evenly among its records.
    Survivors {
        /// Record of the first one in the batch.
        first: u64,
        /// Records of the batch.
        records: u64,
        /// Survivors among them.
        survivors: u64,
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
}

/// Addresses of the regions of a frame.
#[derive(Debug, Clone)]
pub struct Layout {
    fetch: Fetch,
    /// Position, geometry, colour: bytes read, and distance of records.
    scene: [(u64, u64, u64); 3],
    projected: (u64, u64),
    lists: (u64, u64),
    features: (u64, u64, u64),
    /// Colours of further levels and features of second ones, in foveated frames.
    levels: [(u64, u64); 2],
    spill: u64,
    pixels: (u64, u64),
    /// First byte behind all regions.
    end: u64,
}

impl Layout {
    /// The layout of `workload` on a machine with these units.
    pub fn new(workload: &FrameWorkload, units: &ResolvedUnits) -> Layout {
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
            Fetch::GeometryFirst | Fetch::LazyColour => {
                [(r.position.0, r.position.0), (geometry, geometry), (r.colour.0, r.colour_pitch.0)]
            }
        };
        let scene =
            sizes.map(|(bytes, pitch)| (region(c.points.saturating_mul(pitch)), bytes, pitch));
        let entries = workload.list.len() as u64;
        let mut layout = Layout {
            end: 0,
            fetch: units.ccu.spec.fetch,
            scene,
            projected: (region(c.intersecting_points * r.projected.0), r.projected.0),
            lists: (region(entries.max(c.tile_pairs) * r.list_entry.0), r.list_entry.0),
            features: {
                let start = region(c.intersecting_points * r.feature_pitch.0);
                (start, r.feature.0, r.feature_pitch.0)
            },
            // Plain frames have none, and nothing moves.
            levels: match &workload.fovea {
                None => [(0, 0); 2],
                Some(_) => [
                    (region(3 * c.points.saturating_mul(fovea.record.0)), fovea.record.0),
                    (region(c.intersecting_points * fovea.feature.0), fovea.feature.0),
                ],
            },
            spill: region(u64::from(units.vru.spec.cores) * REGION),
            pixels: (region(0), u64::from(workload.geometry.tile).pow(2) * r.pixel.0),
        };
        layout.end = layout.pixels.0 + workload.tiles.len() as u64 * layout.pixels.1;
        layout
    }

    /// First byte behind all regions of the frame.
    pub(super) fn end(&self) -> u64 {
        self.end
    }

    /// The first read of a batch: `bytes` from the scene record with index `first`.
    pub fn first_read(&self, first: u64, bytes: u64) -> AccessPattern {
        let (base, _, pitch) = self.scene[0];
        AccessPattern::Run(AddressRange { address: base + first * pitch, bytes })
    }

    /// The results that a CCU writes for a batch: `splats` projected splats from index
    /// `first_splat`, and `pairs` list entries from index `first_pair`.
    pub fn results(
        &self,
        first_splat: u64,
        splats: u64,
        first_pair: u64,
        pairs: u64,
    ) -> AccessPattern {
        let at = |(base, size): (u64, u64), first: u64, n: u64| AddressRange {
            address: base + first * size,
            bytes: n * size,
        };
        AccessPattern::Two(
            at(self.projected, first_splat, splats),
            at(self.lists, first_pair, pairs),
        )
    }

    /// `bytes` of the lists, from the list entry with index `start`.
    pub fn list(&self, start: u32, bytes: u64) -> AccessPattern {
        AccessPattern::Run(AddressRange {
            address: self.lists.0 + u64::from(start) * self.lists.1,
            bytes,
        })
    }

    /// `bytes` of the spill region of `core`, for keys that its sorting buffer does not hold.
    pub fn spill(&self, core: u32, bytes: u64) -> AccessPattern {
        AccessPattern::Run(AddressRange { address: self.spill + u64::from(core) * REGION, bytes })
    }

    /// The first `bytes` of the pixels of `tile` (row-major index) in the image.
    pub fn pixels(&self, tile: u32, bytes: u64) -> AccessPattern {
        AccessPattern::Run(AddressRange {
            address: self.pixels.0 + u64::from(tile) * self.pixels.1,
            bytes,
        })
    }

    /// The next address range of a request of which `cursor` ranges are done.
    pub fn piece(
        &self,
        span: &AccessPattern,
        cursor: &mut u64,
        workload: &FrameWorkload,
    ) -> Option<AddressRange> {
        loop {
            let step = *cursor;
            *cursor += 1;
            let piece = match *span {
                AccessPattern::Run(piece) => part(piece, step)?,
                AccessPattern::Two(a, b) => *[a, b].get(step as usize)?,
                AccessPattern::Survivors { first, records, survivors } => {
                    self.survivor(first, records, survivors, step)?
                }
                AccessPattern::Chunk { start, entries, load } => {
                    self.record(start, entries, load, step, workload)?
                }
            };
            if piece.bytes > 0 {
                return Some(piece);
            }
        }
    }

    fn survivor(
        &self,
        first: u64,
        records: u64,
        survivors: u64,
        step: u64,
    ) -> Option<AddressRange> {
        let both = self.fetch == Fetch::GeometryFirst;
        let (index, part) = if both { (step / 2, step % 2) } else { (step, 0) };
        if index >= survivors {
            return None;
        }
        let record = first + index * records / survivors;
        let (base, bytes, pitch) = self.scene[1 + part as usize];
        Some(AddressRange { address: base + record * pitch, bytes })
    }

    fn record(
        &self,
        start: u64,
        entries: u64,
        load: ChunkLoad,
        step: u64,
        workload: &FrameWorkload,
    ) -> Option<AddressRange> {
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

/// The `step`-th MiB of a piece.
fn part(piece: AddressRange, step: u64) -> Option<AddressRange> {
    let done = step * REGION;
    let bytes = piece.bytes.checked_sub(done)?.min(REGION);
    (bytes > 0).then_some(AddressRange { address: piece.address + done, bytes })
}
