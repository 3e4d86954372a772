//! A set-associative cache of feature records, replayed over the chunk loads of a frame.
//!
//! Rule: chunks are loaded tile by tile in a given order, entry by entry. The record of a splat has
//! the number of its slot ([`FrameWorkload::slot`]) and belongs into set `slot mod sets`: slots are
//! given without gaps, so neighbours in storage lie in neighbouring sets. A record that is missing
//! replaces the one of its set that was used longest ago. All cores share the cache (A74).

use super::FrameWorkload;
use powergs_base::quantity::Bytes;

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
pub fn replay(workload: &FrameWorkload, shape: CacheShape, order: &[u32]) -> CacheReplay {
    assert_eq!(order.len(), workload.tiles.len(), "every tile is loaded once");
    let mut cache = Cache::new(shape, workload.counters.intersecting_points as usize);
    let mut replay = CacheReplay { hits: vec![0; workload.chunks.len()], ..CacheReplay::default() };
    for &index in order {
        let tile = &workload.tiles[index as usize];
        let mut list = workload.list_of(tile);
        for chunk in tile.chunk_start..tile.chunk_start + tile.chunks {
            let entries = workload.chunks[chunk as usize].entries;
            let (own, rest) = list.split_at(entries as usize);
            list = rest;
            for &rank in own {
                match cache.load(workload.slot[rank as usize]) {
                    Lookup::Hit => replay.hits[chunk as usize] += 1,
                    Lookup::First => replay.first_loads += 1,
                    Lookup::Evicted => {}
                }
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
struct Node {
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
    nodes: Vec<Node>,
    sets: Vec<Set>,
}

impl Cache {
    /// An empty cache for records `0..records`; sets that no record belongs into are not kept.
    fn new(shape: CacheShape, records: usize) -> Cache {
        let sets = (shape.sets as usize).min(records.max(1));
        let set = Set { newest: NONE, oldest: NONE, records: 0 };
        let node = Node { newer: NONE, older: NONE, state: State::Unseen };
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
        let Node { newer, older, .. } = self.nodes[record as usize];
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
