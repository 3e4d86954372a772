//! Feature cache: what it declares. Its hits are measured outside of time
//! ([`workload::cache`](crate::workload::cache)).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::machine::Optional;
use crate::stage::{Measured, StageDecl, StatDecl, buffer, buffer_id, counted, part, share};
use crate::workload::cache::{CacheReplay, Eviction, Victims};
use powergs_base::quantity::Bytes;
use powergs_energy::action::{BufferId, Memory, Phase};

/// What a feature cache declares. A cache compares the tags of its ways, with the distances that it
/// evicts by (A102).
pub const CACHE: StageDecl = StageDecl {
    buffers: &[buffer("cache", "cache", |m| Memory {
        bank: Bytes(
            m.of_type::<CacheSpec>().capacity.0 / u64::from(m.of_type::<CacheSpec>().banks).max(1),
        ),
        banks: if m.of_type::<CacheSpec>().capacity.0 == 0 {
            0
        } else {
            m.of_type::<CacheSpec>().banks
        },
        word: m.of_type::<CacheSpec>().word,
        two_ports: false,
    })
    .full()
    .growing()],
    parts: &[part("ways", "Ways: tags that are read and compared at a time.", |m| {
        let tag = TAG_BITS + f64::from(m.of_type::<CacheSpec>().carried_bits());
        f64::from(m.of_type::<CacheSpec>().ways) * tag / TAG_BITS
    })],
    stats: &[&HITS, &MISSES, &HIT_SHARE],
    optional: OPTIONAL,
    ..StageDecl::new(
        "cache",
        "feature cache",
        Phase::Rendering,
        "Feature cache: keeps feature records that another tile may need again. Keys: \
         `cache`.",
    )
};

const HITS: StatDecl =
    counted("cache.hits", "Feature records that were found in the feature cache.");
const MISSES: StatDecl = counted("cache.misses", "Feature records that had to be read from DRAM.");
const HIT_SHARE: StatDecl = share(
    "cache.hit_frac",
    &HITS,
    &[&HITS, &MISSES],
    "Share of the feature records that were found in the feature cache, 0 to 1.",
);

/// What is reported of the hits in a frame.
pub fn measured(replay: &CacheReplay) -> Measured {
    Measured::of(&[(&HITS, replay.hit_loads), (&MISSES, replay.loads - replay.hit_loads)])
}

/// Bits of the tag of a cached record.
const TAG_BITS: f64 = 24.0;

/// Feature records that another tile may need again.
pub const RECORDS: BufferId = buffer_id("cache");

/// The `[cache]` table: a set-associative cache of feature records, least recently used first out.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct CacheSpec {
    /// Size; without it, or with 0 B, there is none.
    pub capacity: Bytes,
    /// Records of a set.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "ways"))]
    pub ways: u32,
    /// Which record of a set leaves for a new one.
    pub eviction: Eviction,
    /// Bits of the distance to the next tile of a splat, in every list entry and every tag, with
    /// `eviction = "reuse-distance"`.
    #[schemars(range(min = 1, max = 32), extend("x-unit" = "bits"))]
    pub distance_bits: u32,
    /// Bytes of one access of one bank.
    pub word: Bytes,
    /// Banks.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "banks"))]
    pub banks: u32,
}

impl Default for CacheSpec {
    /// None; what one has where the file says only its size (A96, A102).
    fn default() -> CacheSpec {
        CacheSpec {
            capacity: Bytes(0),
            ways: 4,
            eviction: Eviction::Lru,
            distance_bits: 8,
            word: Bytes(32),
            banks: 4,
        }
    }
}

impl CacheSpec {
    /// Whether the machine has one.
    pub fn is_there(&self) -> bool {
        self.capacity.0 > 0 && self.ways > 0
    }

    /// Bits of a distance in list entries and tags; 0 where nothing is evicted by it.
    pub(crate) fn carried_bits(&self) -> u32 {
        match self.eviction {
            Eviction::ReuseDistance if self.is_there() => self.distance_bits,
            Eviction::ReuseDistance | Eviction::Lru => 0,
        }
    }

    /// How it evicts.
    pub(crate) fn victims(&self) -> Victims {
        match self.eviction {
            Eviction::Lru => Victims::Lru,
            Eviction::ReuseDistance => Victims::Furthest { bits: self.distance_bits },
        }
    }
}

/// Parts and choices that it may be without.
pub(super) const OPTIONAL: &[Optional] = &[
    Optional {
        what: "a feature cache",
        switch: "cache.capacity",
        keys: &["cache"],
        with: &["cache.capacity=32 KiB"],
        is_there: |m| m.of_type::<CacheSpec>().is_there(),
    },
    Optional {
        what: "eviction by reuse distance",
        switch: "cache.eviction",
        keys: &["cache.distance-bits"],
        with: &["cache.capacity=32 KiB", "cache.eviction=reuse-distance"],
        is_there: |m| m.of_type::<CacheSpec>().eviction == Eviction::ReuseDistance,
    },
];
