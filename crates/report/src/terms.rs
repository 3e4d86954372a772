//! The words of reports: heads of columns, names of rows, abbreviations. What is a statistic or a
//! key of a file has its definition there; everything else that a page or a table prints is here,
//! and `explain` knows it.

mod codesign;
mod compared;
mod cycles;
mod optimizer;
mod pictures;
mod power;
mod sensitivity;
mod shared;
mod sweeps;
mod tables;
mod units;
mod words;

use codesign::CODESIGN;
use compared::COMPARED;
use cycles::CYCLES;
use optimizer::OPTIMIZER;
use pictures::{INPUTS, PICTURES};
use power::POWER;
use sensitivity::SENSITIVITY;
use shared::MORE;
use sweeps::SWEEPS;
use tables::TABLES;
use units::UNITS;
use words::WORDS;

/// A word with its meaning.
#[derive(Debug, Clone, Copy)]
pub struct Term {
    /// How reports write it, the usual way first.
    pub names: &'static [&'static str],
    /// Unit; empty where it has none.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

const fn term(names: &'static [&'static str], unit: &'static str, meaning: &'static str) -> Term {
    Term { names, unit, meaning }
}

/// All words.
pub fn terms() -> impl Iterator<Item = &'static Term> {
    [
        UNITS,
        CYCLES,
        POWER,
        TABLES,
        COMPARED,
        SWEEPS,
        SENSITIVITY,
        MORE,
        OPTIMIZER,
        CODESIGN,
        PICTURES,
        INPUTS,
        WORDS,
    ]
    .into_iter()
    .flatten()
}
