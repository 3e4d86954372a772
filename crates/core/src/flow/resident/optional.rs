//! Parts that a machine may not have.

use super::{ComposeSpec, Cut, RegionSpec, TailSpec};
use crate::flow::steps::TRAINING;
use crate::machine::Optional;

/// All of them.
pub(super) const OPTIONAL: [Optional; 4] = [
    Optional {
        what: "a search for the ends of rows",
        switch: "region.cut",
        keys: &["raster.row-cycles", "front.row"],
        with: &["region.cut=exact"],
        is_there: |m| m.of_type::<RegionSpec>().cut == Cut::Exact,
    },
    Optional {
        what: "tail units",
        switch: "tail.share",
        keys: &["tail", "stores.tail"],
        with: &[
            "tail.share=0.25",
            "region.slices=1",
            "stores.pixels.capacity=256 KiB",
            r#"stores.tail={ capacity = "32 KiB", word = "64 B", banks = 1, ports = "1rw" }"#,
        ],
        is_there: |m| m.of_type::<TailSpec>().share > 0.0,
    },
    Optional {
        what: "composing units",
        switch: "compose.lanes",
        keys: &["compose"],
        with: &["compose.lanes=16", "region.slices=2"],
        is_there: |m| m.of_type::<ComposeSpec>().lanes > 0,
    },
    TRAINING,
];
