//! What a frame is: displays, gaze, trace files.

mod display;
mod fovea;
mod trace;
