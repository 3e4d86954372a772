//! A set-associative cache of feature records, replayed over the chunk loads of a frame.
//!
//! Rule: chunks are loaded tile by tile in a given order, entry by entry. The record of a splat has
//! the number of its slot ([`FrameWorkload::slot`]) and belongs into set `slot mod sets`: slots are
//! given without gaps, so neighbours in storage lie in neighbouring sets. All cores share the cache
//! (A74).
//!
//! A record that is missing replaces one of its set. With [`Eviction::Lru`] it is the one that was
//! used longest ago. With [`Eviction::ReuseDistance`] it is the one whose next tile is furthest: a
//! unit that writes a splat into the lists of its tiles knows which of them comes next in the order
//! of tiles, and a list entry carries the distance to it, in tiles (A102). A splat without a
//! further tile, and one whose next tile has gone by, is of no use; the record that is missing is
//! not kept if all others are needed earlier.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FrameWorkload;
use powergs_base::quantity::Bytes;

/// Which record of a set leaves for a new one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Eviction {
    /// The one that was used longest ago.
    Lru,
    /// The one that is needed again last, by a distance in tiles that each list entry carries.
    ReuseDistance,
}

/// How a cache evicts: the policy with the bits of a distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Victims {
    /// By age.
    Lru,
    /// By distances of so many bits; longer ones count as no further use.
    Furthest {
        /// Bits of a distance in tiles, 1 to 32.
        bits: u32,
    },
}

/// Size and shape of a cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CacheShape {
    /// Sets (at least 1).
    pub sets: u32,
    /// Records of a set; 0 for no cache.
    pub ways: u32,
}

impl CacheShape {
    /// The cache of `capacity` that holds records of `pitch` bytes each in sets of `ways`. What is
    /// left after whole sets is not used; a cache of less than one set is one smaller set.
    pub fn new(capacity: Bytes, pitch: Bytes, ways: u32) -> CacheShape {
        let records = u32::try_from(capacity.0 / pitch.0.max(1)).unwrap_or(u32::MAX);
        CacheShape { sets: (records / ways.max(1)).max(1), ways: records.min(ways) }
    }
}

/// Hits and misses of a frame.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CacheReplay {
    /// Hits of each chunk, in the order of [`FrameWorkload::chunks`].
    pub hits: Vec<u32>,
    /// Entries that were looked up.
    pub loads: u64,
    /// Of these, found.
    pub hit_loads: u64,
    /// Of these, looked up for the first time in the frame: no cache has them.
    pub first_loads: u64,
}

/// Replays the chunk loads of `workload`, its tiles in `order` (row-major indices, each once).
pub fn replay(
    workload: &FrameWorkload,
    shape: CacheShape,
    victims: Victims,
    order: &[u32],
) -> CacheReplay {
    assert_eq!(order.len(), workload.tiles.len(), "every tile is loaded once");
    let records = workload.counters.intersecting_points as usize;
    match victims {
        Victims::Lru => {
            let mut cache = Cache::new(shape, records);
            loads(workload, order, |_, rank, _| cache.load(workload.slot[rank as usize]))
        }
        Victims::Furthest { bits } => {
            let next = next_tiles(workload, order, bits);
            let mut cache = Foreseeing::new(shape, records);
            loads(workload, order, |now, rank, entry| {
                cache.load(now, workload.slot[rank as usize], next[entry])
            })
        }
    }
}

/// For every list entry the position in `order` of the next tile of its splat; [`NONE`] where there
/// is none, or it is further than `bits` can say.
fn next_tiles(workload: &FrameWorkload, order: &[u32], bits: u32) -> Vec<u32> {
    let most = u32::MAX.checked_shr(32 - bits.min(32)).unwrap_or(0);
    let entries = workload.tiles.iter().map(|tile| tile.entries as usize).sum();
    let mut next = vec![NONE; entries];
    let mut known = vec![NONE; workload.slot.len()];
    for (now, &index) in order.iter().enumerate().rev() {
        let (now, tile) = (now as u32, &workload.tiles[index as usize]);
        let own = &mut next[tile.list_start as usize..];
        for (next, &rank) in own.iter_mut().zip(workload.list_of(tile)) {
            let later = std::mem::replace(&mut known[rank as usize], now);
            // The largest number says that there is no further tile.
            if later != NONE && later - now < most {
                *next = later;
            }
        }
    }
    next
}

/// Looks up every chunk load: `load` gets the position of the tile, the splat and its list entry.
fn loads(
    workload: &FrameWorkload,
    order: &[u32],
    mut load: impl FnMut(u32, u32, usize) -> Lookup,
) -> CacheReplay {
    let mut replay = CacheReplay { hits: vec![0; workload.chunks.len()], ..CacheReplay::default() };
    for (now, &index) in order.iter().enumerate() {
        let tile = &workload.tiles[index as usize];
        let mut list = workload.list_of(tile);
        let mut entry = tile.list_start as usize;
        for chunk in tile.chunk_start..tile.chunk_start + tile.chunks {
            let entries = workload.chunks[chunk as usize].entries;
            let (own, rest) = list.split_at(entries as usize);
            list = rest;
            for &rank in own {
                match load(now as u32, rank, entry) {
                    Lookup::Hit => replay.hits[chunk as usize] += 1,
                    Lookup::First => replay.first_loads += 1,
                    Lookup::Evicted => {}
                }
                entry += 1;
            }
            replay.loads += u64::from(entries);
            replay.hit_loads += u64::from(replay.hits[chunk as usize]);
        }
    }
    replay
}

/// The result of the lookup of a record.
enum Lookup {
    Hit,
    /// It was never loaded.
    First,
    /// It has been there.
    Evicted,
}

/// No record.
const NONE: u32 = u32::MAX;

/// State of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Unseen,
    Resident,
    Gone,
}

/// A record in the list of its set, which is in order of use.
#[derive(Debug, Clone, Copy)]
struct CacheNode {
    newer: u32,
    older: u32,
    state: State,
}

#[derive(Debug, Clone, Copy)]
struct Set {
    newest: u32,
    oldest: u32,
    records: u32,
}

/// Sets are linked lists through one array of all records: a load costs the same for any number of
/// ways.
struct Cache {
    shape: CacheShape,
    nodes: Vec<CacheNode>,
    sets: Vec<Set>,
}

impl Cache {
    /// An empty cache for records `0..records`; sets that no record belongs into are not kept.
    fn new(shape: CacheShape, records: usize) -> Cache {
        let sets = (shape.sets as usize).min(records.max(1));
        let set = Set { newest: NONE, oldest: NONE, records: 0 };
        let node = CacheNode { newer: NONE, older: NONE, state: State::Unseen };
        Cache { shape, nodes: vec![node; records], sets: vec![set; sets] }
    }

    fn load(&mut self, record: u32) -> Lookup {
        let set = record % self.shape.sets;
        let state = self.nodes[record as usize].state;
        if state == State::Resident {
            if self.sets[set as usize].newest != record {
                self.remove(set, record);
                self.push(set, record);
            }
            return Lookup::Hit;
        }
        if self.shape.ways > 0 {
            let own = self.sets[set as usize];
            if own.records == self.shape.ways {
                self.remove(set, own.oldest);
                self.nodes[own.oldest as usize].state = State::Gone;
            }
            self.push(set, record);
        }
        self.nodes[record as usize].state =
            if self.shape.ways > 0 { State::Resident } else { State::Gone };
        if state == State::Unseen { Lookup::First } else { Lookup::Evicted }
    }

    fn push(&mut self, set: u32, record: u32) {
        let own = &mut self.sets[set as usize];
        let before = std::mem::replace(&mut own.newest, record);
        own.records += 1;
        match before {
            NONE => own.oldest = record,
            before => self.nodes[before as usize].newer = record,
        }
        let node = &mut self.nodes[record as usize];
        (node.newer, node.older) = (NONE, before);
    }

    fn remove(&mut self, set: u32, record: u32) {
        let CacheNode { newer, older, .. } = self.nodes[record as usize];
        let own = &mut self.sets[set as usize];
        own.records -= 1;
        match newer {
            NONE => own.newest = older,
            newer => self.nodes[newer as usize].older = older,
        }
        match older {
            NONE => self.sets[set as usize].oldest = newer,
            older => self.nodes[older as usize].newer = newer,
        }
    }
}

/// A cache that knows when records are needed again.
struct Foreseeing {
    shape: CacheShape,
    seen: Vec<bool>,
    /// Records of each set, with the position of their next tile.
    sets: Vec<Vec<(u32, u32)>>,
}

impl Foreseeing {
    /// An empty cache for records `0..records`; sets that no record belongs into are not kept.
    fn new(shape: CacheShape, records: usize) -> Foreseeing {
        let sets = (shape.sets as usize).min(records.max(1));
        Foreseeing { shape, seen: vec![false; records], sets: vec![Vec::new(); sets] }
    }

    /// Looks up a record in the tile at position `now`; it is needed again at `next`.
    fn load(&mut self, now: u32, record: u32, next: u32) -> Lookup {
        let set = &mut self.sets[(record % self.shape.sets) as usize];
        if let Some(own) = set.iter_mut().find(|(known, _)| *known == record) {
            own.1 = next;
            return Lookup::Hit;
        }
        let lookup = match std::mem::replace(&mut self.seen[record as usize], true) {
            false => Lookup::First,
            true => Lookup::Evicted,
        };
        if set.len() < self.shape.ways as usize {
            set.push((record, next));
            return lookup;
        }
        // What was due in a tile that has gone by stopped there before it was loaded.
        let due = |next: u32| if next < now { NONE } else { next };
        let last = set.iter_mut().max_by_key(|(known, next)| (due(*next), *known));
        if let Some(last) = last.filter(|last| due(last.1) > next) {
            *last = (record, next);
        }
        lookup
    }
}

/// A cache of sums: what is added to one that is not there is fetched, and another leaves.
pub(crate) struct SumCache {
    cache: Cache,
}

/// What is added to a sum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Added {
    /// Whether nothing was added to it before.
    pub is_first: bool,
    /// Whether it was not there.
    pub is_fetched: bool,
    /// Which one left: the one that was added to longest ago, or itself where nothing is kept.
    pub leaves: Option<u32>,
}

impl SumCache {
    /// An empty cache for sums `0..records`.
    pub(crate) fn new(shape: CacheShape, records: usize) -> SumCache {
        SumCache { cache: Cache::new(shape, records) }
    }

    /// Adds to a sum.
    pub(crate) fn add(&mut self, record: u32) -> Added {
        let CacheShape { sets, ways } = self.cache.shape;
        let set = self.cache.sets[(record % sets) as usize];
        let is_full = set.records == ways;
        let lookup = self.cache.load(record);
        let is_fetched = !matches!(lookup, Lookup::Hit);
        let victim = if ways == 0 { record } else { set.oldest };
        Added {
            is_first: matches!(lookup, Lookup::First),
            is_fetched,
            leaves: (is_fetched && is_full).then_some(victim),
        }
    }

    /// Sums that are there.
    pub(crate) fn held(&self) -> u64 {
        self.cache.sets.iter().map(|set| u64::from(set.records)).sum()
    }
}
