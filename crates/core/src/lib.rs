//! The simulator: a frame binned for a machine, *when* things happen on it, *how often*, and what
//! it *costs*.

pub mod flow;
pub mod kernel;
pub mod machine;
pub mod run;
pub mod sim;
pub mod stage;
pub mod workload;
