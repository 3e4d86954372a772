//! Costs of a machine that do not depend on a frame: prices, and the peak power of each block.

use crate::machine::DramModel;
use crate::machine::{Machine, MemoryOwner};
use crate::stage::{self, EnergyTable};
use powergs_dram::{CommandPrices, Device};
use powergs_energy::hardware::{Does, Unpriced};
use powergs_energy::table::PriceError;
use powergs_energy::{Built, DramCosts, Prices};

/// The prices of `table` on `machine`. DRAM prices are those of its device, by the byte where the
/// DRAM model counts no commands.
///
/// # Errors
/// A machine that the table has no price for.
pub fn prices(table: &EnergyTable, machine: &Machine) -> Result<Prices, PriceError> {
    let inventory = machine.inventory();
    let [idle_leakage, channels, phy_channels, standby_share] = untimed(machine);
    let device = machine.device.as_deref().map(|device| match machine.dram.model {
        DramModel::Bandwidth => {
            device_costs(device).uncounted(device.organisation.burst, table.dram.row_hits())
        }
        DramModel::Calibrated | DramModel::Banked => device_costs(device),
    });
    table.prices(&Built {
        inventory: &inventory,
        idle_leakage,
        gated: machine.gating.units,
        numbers: machine.flow().numbers(machine),
        device,
        channels,
        phy_channels,
        standby_share,
        clock: machine.clock,
    })
}

/// What of a machine moves prices and may leave its timing as it is: the share of its leakage that
/// a unit without work keeps, memory channels, those with a PHY on the chip, and the share of the
/// memory's standby that is its own.
pub fn untimed(machine: &Machine) -> [f64; 4] {
    let gating = &machine.gating;
    let channels = machine.flow().channels(machine);
    let leakage = if gating.units { gating.residual } else { 1.0 };
    let [phy, standby] = match machine.dram.owner {
        MemoryOwner::Chip => [channels, 1.0],
        MemoryOwner::Shared => [0.0, machine.dram.standby_share.unwrap_or(1.0)],
    };
    [leakage, channels, phy, standby]
}

/// The prices of a DRAM device: one per byte, or one per command.
pub fn device_costs(device: &Device) -> DramCosts {
    let energy = &device.energy;
    if let Some(flat) = &energy.flat {
        let pj = flat.energy.0 * energy.scale;
        return DramCosts::Bytes { read_pj: pj, write_pj: pj, background_w: 0.0, refresh_w: 0.0 };
    }
    DramCosts::Commands(CommandPrices::of(device).expect("checked: flat or actions"))
}

/// Power of every block of the chip when each does all that it can in every cycle, leakage
/// included: a bound. Units, then buffers; DRAM is another chip.
pub fn peak_w(machine: &Machine, prices: &Prices) -> Vec<(&'static str, f64)> {
    let hardware = stage::hardware();
    let pj = |wanted: &dyn Fn(Does) -> bool| {
        hardware.action(wanted).map_or(0.0, |action| prices.of(action).0)
    };
    let inventory = machine.inventory();
    let watts = machine.clock.0 * 1e-12;
    let mut blocks = Vec::new();
    for ((id, unit), leakage) in hardware.units().zip(&prices.unit_leakage_w) {
        let mut per_cycle = pj(&|does| does == Does::Clock(id));
        // Of what one action may be made into, a unit does one kind at a time.
        let mut made = 0.0_f64;
        for (key, times) in stage::stage(id).a_cycle(machine) {
            let work = |does| matches!(does, Does::Work(_, work) if work.key == key);
            let is_made = hardware.action(work).is_some_and(|action| {
                matches!(hardware.does(action), Does::Work(_, work)
                    if matches!(work.unpriced, Unpriced::MadeOf(_)))
            });
            match is_made {
                true => made = made.max(pj(&work) * times),
                false => per_cycle += pj(&work) * times,
            }
        }
        let units = f64::from(inventory.units[id.index()]);
        blocks.push((unit.key, (per_cycle + made) * units * watts + leakage));
    }
    for ((id, buffer), memory) in hardware.buffers().zip(&inventory.memories) {
        let read = pj(&|does| does == Does::SramRead(id));
        let write = pj(&|does| does == Does::SramWrite(id));
        let per_byte = if memory.two_ports { read + write } else { read.max(write) };
        let bytes = memory.word.0 as f64 * f64::from(memory.banks);
        let leakage = prices.sram_leakage_w[id.index()];
        blocks.push((buffer.name, per_byte * bytes * watts + leakage));
    }
    blocks
}
