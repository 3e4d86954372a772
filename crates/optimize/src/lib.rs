//! The PowerGS optimiser: the fewest watts at a given quality.
//!
//! A dense model is pruned to several ratios ρ; each pruned model is fine-tuned with a display
//! term whose weight λ a controller moves until the quality sits just above the target. Display
//! power, as it would be without quality to spare, and rendering power of these models are fitted
//! as functions of ρ, the sum has one minimum, and the dense model is pruned and fine-tuned to that
//! ρ (`powergs`, sections 4 and 5).
//!
//! ```text
//! dense model --prune(rho)--> tune: forward, loss, backward, Adam --> model on the target
//!                               '-- lambda::Controller <-- quality on the gate views
//! samples (rho, D, R) --fit--> rho* --realise--> final model;   oracle: watts of any candidate
//! ```
//!
//! A [`request::Request`] is opened as a [`campaign::Campaign`] and run in a
//! [`Store`](powergs_core::run::Store), a folder or memory. It is a list of jobs ([`plan`]), each
//! of which can be stopped after any iteration ([`watch::CampaignWatch`]) and goes on from a
//! [`checkpoint`] bit for bit. Nothing here prints, parses arguments or asks for the time.

#![warn(clippy::missing_errors_doc)]

pub mod adam;
mod between;
pub mod campaign;
pub mod checkpoint;
pub mod conclusion;
pub mod counted;
pub mod estimate;
pub mod fit;
pub mod foveated;
pub mod history;
pub mod invalid;
pub mod job;
pub mod judged;
pub mod lambda;
pub mod next_quality;
pub mod oracle;
pub mod outcome;
pub mod photos;
pub mod pictures;
pub mod plan;
pub mod pooled;
pub mod prune;
pub mod ratio_study;
pub mod record;
pub mod references;
pub mod renderer;
pub mod request;
pub mod results;
pub mod role;
pub mod schedule;
pub mod settings;
pub mod setup;
pub mod slack;
pub mod target;
pub mod times;
pub mod train;
pub mod tune;
pub mod views;
pub mod watch;
