//! Charts from hand-made values.

mod charts;
mod regressions;
mod scale;
