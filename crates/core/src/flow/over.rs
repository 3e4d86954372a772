//! Filters over dataflows: what becomes of a frame before a machine takes it, whatever its
//! dataflow: which pixels are rendered at all, lists of frames before, the second eye.
//!
//! A filter takes a frame that was prepared for a machine, and what was kept of frames before, and
//! makes another one of it, with what moves for that. Turned off it makes none.

pub mod kept_order;
pub mod pixels;
pub mod second_eye;
