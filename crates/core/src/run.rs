//! Runs things: frames from anywhere through any number of machines.
//!
//! A [`System`] is a machine with everything that a simulation and a price need. [`Frames`] are
//! read from a trace file, kept in memory or rendered as they are asked for. A [`Session`] takes
//! frames through systems: each frame is binned once per geometry and measured once per cache,
//! sort key and order reuse; machines that differ in prices only are timed once. Whoever calls
//! says through a [`Watch`] when to stop, and hears how far the work is.
//!
//! This layer opens files. It neither prints nor parses arguments.

pub mod change;
pub mod error;
pub mod files;
pub mod frames;
pub mod identity;
pub mod input;
pub mod observed;
pub mod paper;
pub mod session;
pub mod store;
pub mod system;
mod trace_file;
pub mod watch;
pub mod window;

pub use change::Change;
pub use error::RunError;
pub use files::{ConfigText, FileKind};
pub use frames::{Frames, MemoryFrames, Pending};
pub use input::Input;
pub use observed::FrameOn;
pub use paper::PaperModel;
pub use session::{Folded, FrameView, Session, Subject};
pub use store::{FileStore, MemoryStore, Store};
pub use system::{System, SystemSpec};
pub use trace_file::TraceFile;
pub use watch::Watch;
pub use window::Window;
