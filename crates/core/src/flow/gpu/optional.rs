//! Parts that a GPU may not have.

use super::{AttachedSpec, RopSpec, TrainSpec};
use crate::machine::Optional;

pub(super) const OPTIONAL: [Optional; 3] = [TRAINS, ATTACHED, ROPS];

const ATTACHED: Optional = Optional {
    what: "an attached unit",
    switch: "attached.impl",
    keys: &["attached.lanes", "attached.clock", "attached.overlap", "attached.cache"],
    with: &[
        "energy=orin-nx-gbu",
        "attached.impl=rows",
        "attached.lanes=1",
        "attached.overlap=none",
    ],
    is_there: |m| m.of_type::<AttachedSpec>().is_there(),
};

const TRAINS: Optional = Optional {
    what: "kernels that train",
    switch: "training.sum",
    // The first as that of other dataflows: what both have is said of theirs.
    keys: &[
        "training.state",
        "training.update",
        "training.loss",
        "training.loss-bytes",
        "training.gradient",
        "training.record",
        "training.atomics",
        "training.zeroed",
        "training.chain",
        "training.widths",
        "training.step",
        "training.densify",
    ],
    with: &["training.sum=pixel", "training.atomics=0.05"],
    is_there: |m| m.of_type::<TrainSpec>().trains(),
};

const ROPS: Optional = Optional {
    what: "raster operations that blend",
    switch: "rops.impl",
    keys: &[
        "rops.quads-per-cycle",
        "rops.found-per-cycle",
        "rops.stop",
        "rops.merge",
        "rops.bins",
        "rops.bin-quads",
        "rops.groups",
        "rops.group-side",
        "rops.group-gaussians",
        "rops.corner",
        "rops.shade",
        "rops.pair",
    ],
    with: &[
        "energy=agx-orin-rops",
        "pairs.test=obb",
        "rops.impl=boxes",
        "rops.merge=true",
        "rops.groups=4",
        "rops.bins=4",
        "rops.shade=2000",
        "rops.pair=500",
    ],
    is_there: |m| m.of_type::<RopSpec>().is_there(),
};
