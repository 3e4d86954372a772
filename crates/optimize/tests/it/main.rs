//! The optimiser: rules, numbers, runs.

mod adam;
mod campaign;
mod checkpoint;
mod disk;
mod estimate;
mod fit;
mod gains;
mod lambda;
mod levels;
mod oracle;
mod photos;
mod priced;
mod promise;
mod prune;
mod record;
mod regressions;
mod renderer;
mod result;
mod role;
mod scenes;
mod schedule;
mod search;
mod slack;
mod train;
mod tune;
mod views;
