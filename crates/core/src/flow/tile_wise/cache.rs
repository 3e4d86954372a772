//! Feature cache: what it declares. Its hits are measured outside of time
//! ([`workload::cache`](crate::workload::cache)).

use super::CacheSpec;
use crate::stage::{StageDecl, buffer, buffer_id, part};
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
    ..StageDecl::new(
        "cache",
        "feature cache",
        Phase::Rendering,
        "Feature cache: keeps feature records that another tile may need again. Keys: \
         `cache`.",
    )
};

/// Bits of the tag of a cached record.
const TAG_BITS: f64 = 24.0;

/// Feature records that another tile may need again.
pub const RECORDS: BufferId = buffer_id("cache");
