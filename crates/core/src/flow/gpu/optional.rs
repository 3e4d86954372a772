//! Parts that a GPU may not have.

use super::TrainSpec;
use crate::machine::Optional;

pub(super) const OPTIONAL: [Optional; 1] = [Optional {
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
    ],
    with: &["train.sum=pixel", "train.atomics=0.05"],
    is_there: |m| m.of_type::<TrainSpec>().trains(),
}];
