//! Words that people bring from elsewhere, with what they are called here.

use super::{Term, term};

pub(super) const WORDS: &[Term] = &[
    term(
        &["GPU"],
        "",
        "A machine with `dataflow = \"gpu\"`: kernels one after the other (docs/model-gpu.md). \
         `arch list` has those that come with the program, e.g. `orin-nx`.",
    ),
    term(
        &["frame latency", "motion to photon", "MTP"],
        "ms",
        "`frame_latency_ms`: from the first read of a frame to its last write. `frame_interval_ms` \
         is from one frame to the next. Tracking of the head and the scan of the panel are not in \
         either.",
    ),
    term(
        &["SLAM", "mapping and tracking"],
        "",
        "Steps of tracking (`training.update = \"pose\"`, e.g. `splatonic`) and of mapping (all or \
         visible Gaussians). A frame of SLAM is a number of each: replay both, and `compare` says \
         what a step takes; there is no schedule of both in one run.",
    ),
    term(
        &["tracking", "pose"],
        "",
        "A step that finds the pose of a camera: `training.update = \"pose\"`, with gradients and \
         without an update of Gaussians.",
    ),
    term(
        &["backward", "reverse pass", "backpropagation"],
        "",
        "Gradients of a step of training (`[training]`): in `compare` the parts of a step are \
         forward, loss, reverse, chain rule and update.",
    ),
    term(
        &["Adam", "optimizer step", "optimiser step"],
        "",
        "The update of a step of training: `training.step` operations a parameter, with moments of \
         `training.widths.moment` bytes. In the program's own training: `train --help`.",
    ),
    term(
        &["warp"],
        "",
        "Of a GPU: 32 threads that run together. Of pictures: pixels of the frame \
         before, moved to the new view (`pixels.impl = \"warped\"`).",
    ),
    term(
        &["densification", "clone and split"],
        "",
        "Gaussians that are cloned, split and removed while a model is trained: `train` does it, \
         machines that train pay for it by `training.densify`.",
    ),
    term(
        &["battery", "battery life", "temperature"],
        "",
        "Not modelled: `power_w.total` is the mean at the display rate. Hours are the watt-hours \
         of a battery over all that the device draws.",
    ),
    term(
        &["starved", "STARVED", "STARVES"],
        "",
        "Another master of the memory gets less than it asks for: more requests under way \
         (`dram.second-master.in-flight`), `priority` or a `guaranteed` rate give it more.",
    ),
    term(
        &["COLMAP", "camera file"],
        "",
        "Cameras and points of a reconstruction: `camera convert` reads its text and binary files \
         (docs/cameras.md), `train` its points.",
    ),
];
