//! Charts from hand-made values.

mod charts;
mod scale;
