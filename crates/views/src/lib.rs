//! Where rendering and simulating meet: frames that are rendered as a run asks for them
//! ([`RenderedViews`]), and what a scene and its frames measure ([`statistics`]).

mod rendered;
pub mod statistics;

pub use rendered::{RenderedViews, rendered};
