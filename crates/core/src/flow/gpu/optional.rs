//! Parts that a GPU may not have.

use super::{AttachedSpec, TrainSpec};
use crate::machine::Optional;

pub(super) const OPTIONAL: [Optional; 2] = [TRAINS, ATTACHED];

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
    switch: "train.sum",
    keys: &[
        "train.update",
        "train.loss",
        "train.loss-bytes",
        "train.state",
        "train.gradient",
        "train.record",
        "train.atomics",
        "train.zeroed",
        "train.chain",
        "train.accesses",
        "train.step",
        "train.densify",
    ],
    with: &["train.sum=pixel", "train.atomics=0.05"],
    is_there: |m| m.of_type::<TrainSpec>().trains(),
};
