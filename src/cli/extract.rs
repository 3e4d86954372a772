//! `extract`: a scene and its views become a trace.
//!
//! Frames are rendered one after another, each on all threads, and written as they come: memory
//! does not grow with the length of the trace. While one frame is compressed the next is rendered.

use std::path::PathBuf;

use serde_json::json;

use super::background::Background;
use super::camera_file::CameraArgs;
use super::progress::Progress;
use super::{Context, Exit, Failure, OrExit, out, scene_file};
use crate::raster::{Detail, Options, render};
use crate::scene::camera::orbit::SceneBounds;

/// Shown under `extract --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim extract scene.ply --cameras cameras.json -o scene.bin
  powergs-sim extract scene.ply --cameras cameras.json --size 1920x1080 --every 8 -o hd.bin
  powergs-sim extract scene.spz --orbit 90 --size 800x800 -o orbit.bin
  powergs-sim extract scene.ply --cameras cameras.json --path-frames 1350 -o path.bin

Then: powergs-sim replay scene.bin";

/// The arguments of `extract`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The model: PLY, compressed PLY, .splat, .spz, .sog, or a folder with a meta.json
    pub scene: PathBuf,
    /// Level of detail of a streamed scene (lod-meta.json)
    #[arg(long, value_name = "N")]
    pub lod: Option<u32>,
    /// The views.
    #[command(flatten)]
    pub cameras: CameraArgs,
    /// Background: black, white, or r,g,b from 0 to 1
    #[arg(long, default_value = "black")]
    pub background: Background,
    /// The trace file
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
}
