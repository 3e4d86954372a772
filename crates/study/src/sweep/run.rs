//! Runs sweeps: every design of a space on every trace, resumable and in parts.
//!
//! A [`SweepRequest`] or a sweep built in memory ([`Sweep`]) is opened as an [`OpenedSweep`].
//! [`Plan`] lists its designs: grouped by what they need of a frame, so that it is prepared once,
//! and by machine, so that designs that differ in prices only are timed once. [`work()`] simulates
//! what is not known yet and appends each result to a journal of the
//! [`Store`](powergs_core::run::Store). [`results`] makes the table from the journals, in the order
//! of the space.
//!
//! A part of a sweep ([`Shard`]) is simulated like the whole and has a journal of its own. All
//! journals of a store are read, so merging parts only takes making the table.

mod columns;
pub mod confirm;
pub mod estimate;
pub mod finish;
pub mod folder;
mod hand_out;
mod noted;
pub mod opened;
mod own;
pub mod parts;
mod plan;
mod records;
mod request;
pub mod results;
mod running;
pub mod search;
mod shared;
pub mod state;
mod traces;
mod watch;
mod work;

pub(crate) use columns::{column_hint, settings_columns};
pub use folder::{Existing, Shard, SweepFolder};
pub use hand_out::{HandOut, HandedDesign, HandedRow, HandedTrace, HandedWords};
pub use opened::{Designs, OpenedSweep};
pub use own::Sweep;
pub use plan::{Cause, Plan};
pub use records::Records;
pub use request::{StandIn, SweepRequest};
pub use results::{Results, Tally};
pub use shared::SharedResults;
pub use state::State;
pub use traces::{SweepTrace, trace_files};
pub use watch::SweepWatch;
pub use work::{ResultSink, work};
