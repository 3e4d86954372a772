//! What other masters of a memory ask for, and whether they get it.

use powergs_core::machine::MASTERS;
use powergs_core::sim::statistics::Key;

/// What a master may miss of what it asks for before it is said to starve.
const STARVED: f64 = 0.02;

/// What each of the other masters asks for, 10⁹ bytes per second, in the order of [`MASTERS`]; 0
/// where there is none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MastersAsked(pub [f64; MASTERS.len()]);

/// What a master asks for and gets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MasterGets {
    /// `second`, `third` or `fourth`.
    pub name: &'static str,
    /// 10⁹ bytes per second that it gets.
    pub gets: f64,
    /// 10⁹ bytes per second that it asks for.
    pub asks: f64,
}

impl MastersAsked {
    /// What each gets, by the means of a run.
    pub fn gets(self, mean: impl Fn(Key) -> Option<f64>) -> Vec<MasterGets> {
        let asked =
            MASTERS.into_iter().zip(self.0).enumerate().filter(|(_, (_, asks))| *asks > 0.0);
        let gets = asked.filter_map(|(place, (name, asks))| {
            // Of a third and a fourth one that get nothing, statistics say nothing.
            let gets =
                mean(Key::MasterRate(place)).or_else(|| mean(Key::MasterRate(0)).and(Some(0.0)));
            Some(MasterGets { name, gets: gets?, asks })
        });
        gets.collect()
    }
}

impl MasterGets {
    /// Whether it gets less than it asks for.
    pub fn is_starved(&self) -> bool {
        self.gets < self.asks * (1.0 - STARVED)
    }
}
