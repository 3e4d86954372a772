//! The rasteriser: images and counters from a scene and a camera.
//!
//! The model is that of INRIA's and PowerGS's tile rasteriser (`powergs.md` §1) with the corrected
//! oriented-box test. Lists hold every accepted splat.
//! Images, counters and traces do not depend on the number of threads. Between processors with and
//! without fused multiply-add the last bit of a pixel may differ.
//!
//! [`train`] is the differentiable form: the same picture, and the gradients of a loss.

mod blend;
mod forward;
pub mod foveated;
pub mod lists;
mod prepare;
pub mod regions;
mod row;
mod sight;
pub mod train;

pub use forward::{Canvas, Detail, Options, Rendered, render};
pub use foveated::{FoveatedFrame, render_foveated};
pub use prepare::front_to_back;
pub use sight::{NearCut, most_in_sight, near_cut};
