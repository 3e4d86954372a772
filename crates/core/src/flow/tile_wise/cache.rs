//! Feature cache: what it declares. Its hits are measured outside of time
//! ([`workload::cache`](crate::workload::cache)).

use super::CacheSpec;
use crate::stage::{Measured, StageDecl, StatDecl, buffer, buffer_id, counted, part, share};
use crate::workload::cache::CacheReplay;
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
