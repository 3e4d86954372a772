//! Costs of the regions of a foveated frame.

use crate::flow::{Foveal, RegionWork};
use crate::stage::{DRAM_READ, DRAM_WRITE, hardware};
use powergs_energy::Prices;
use powergs_energy::action::{ActionId, Phase};

use super::timed::Timed;

/// One region of a foveated frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RegionReport {
    /// Tiles.
    pub tiles: u64,
    /// List entries that they load.
    pub entries: u64,
    /// Cycles for which the rendering units of a core work on them.
    pub cycles: u64,
    /// Energy of their sorting and rendering, picojoules.
    pub energy_pj: f64,
}

/// Prices the regions of a frame. Where DRAM commands are priced, a stage's are shared by bytes.
pub(super) fn priced(timed: &Timed, prices: &Prices) -> Option<Foveal<RegionReport>> {
    let fovea = timed.outcome.fovea.as_ref()?;
    let bytes = |work: &RegionWork, stage| {
        let count = |action| work.actions.count(stage, action);
        count(DRAM_READ) + count(DRAM_WRITE)
    };
    let of = |work: &RegionWork| {
        let priced = |action: ActionId| work.actions.total(action) as f64 * prices.of(action).0;
        let mut energy_pj: f64 = hardware().actions().map(|(action, _)| priced(action)).sum();
        if let Some(commands) = &timed.outcome.timing.dram.commands {
            for (stage, made) in Phase::WORK.into_iter().zip(&commands.stages) {
                let all = &timed.outcome.actions;
                let all = all.count(stage, DRAM_READ) + all.count(stage, DRAM_WRITE);
                let share = bytes(work, stage) as f64 / all.max(1) as f64;
                energy_pj += prices.commands(made).0 * share;
            }
        }
        let RegionWork { tiles, entries, cycles, .. } = *work;
        RegionReport { tiles, entries, cycles, energy_pj }
    };
    Some(Foveal { summary: fovea.summary, regions: fovea.regions.each_ref().map(of) })
}
