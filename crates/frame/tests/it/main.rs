//! What a frame is: displays, gaze, runs of tiles, trace files.

mod display;
mod fovea;
mod order;
mod regressions;
mod runs;
mod trace;
