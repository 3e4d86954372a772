//! Costs of a machine that do not depend on a frame: prices, and the peak power of each block.

use crate::accel::Machine;
use crate::accel::bsu::network;
use crate::accel::machine::{DramModel, Fetch};
use powergs_dram::{CommandPrices, Device};
use powergs_energy::action::{Action, Buffer, UnitKind};
use powergs_energy::table::PriceError;
use powergs_energy::{Area, Built, DramCosts, EnergyTable, Prices};

/// The prices of `table` on `machine`. DRAM prices are those of its device where the DRAM model
/// counts commands.
///
/// # Errors
/// A machine that the table has no price for.
pub fn prices(table: &EnergyTable, machine: &Machine) -> Result<Prices, PriceError> {
    let inventory = machine.inventory();
    let [idle_leakage, channels] = untimed(machine);
    let device = machine.device.as_deref().filter(|_| machine.dram.model != DramModel::Bandwidth);
    table.prices(&Built {
        inventory: &inventory,
        idle_leakage,
        gated: machine.gating.units,
        numbers: machine.record.numbers,
        device: device.map(device_costs),
        channels,
        clock: machine.clock,
    })
}

/// What of a machine moves prices and may leave its timing as it is: the share of its leakage that
/// a unit without work keeps, and memory channels.
pub fn untimed(machine: &Machine) -> [f64; 2] {
    let gating = &machine.gating;
    let channels = f64::from(machine.dram.channels);
    [if gating.units { gating.residual } else { 1.0 }, channels]
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
/// included: a bound. Names as in [`Area::blocks`], colour units in the rendering units; DRAM is
/// another chip.
pub fn peak_w(machine: &Machine, prices: &Prices) -> Vec<(&'static str, f64)> {
    let pj = |actions: &[Action]| actions.iter().map(|&a| prices.of(a).0).sum::<f64>();
    let (ccu, gsu) = (&machine.ccu, &machine.gsu);
    let gaussian = [Action::Cull, Action::Project, Action::ObbPrepare];
    let colour = pj(&[Action::ShColour]);
    let in_ccu = if ccu.fetch == Fetch::LazyColour { 0.0 } else { colour };
    let per_cycle = [
        (pj(&gaussian) + in_ccu) * ccu.gaussians_per_cycle()
            + pj(&[Action::ObbTest]) * f64::from(ccu.intersection_units),
        pj(&[Action::PivotKey]) * f64::from(gsu.keys_per_cycle),
        pj(&[Action::CompareExchange]) * network(gsu.bsu_width) as f64
            + pj(&[Action::SortedRow]).max(pj(&[Action::MergedRow])),
        pj(&[Action::Alpha, Action::Blend]),
    ];
    let inventory = machine.inventory();
    let watts = machine.clock.0 * 1e-12;
    let mut blocks = Vec::new();
    for (i, name) in Area::UNITS.into_iter().enumerate() {
        let clock = pj(&[Action::Clock(UnitKind::ALL[i])]);
        let mut dynamic = (per_cycle[i] + clock) * f64::from(inventory.units[i]);
        if name == UnitKind::Vru.name() {
            let one = f64::from(ccu.operations.sh_colour.max(1));
            dynamic += colour * inventory.colour_operations / one;
        }
        blocks.push((name, dynamic * watts + prices.unit_leakage_w[i]));
    }
    for (buffer, memory) in Buffer::ALL.into_iter().zip(&inventory.memories) {
        let (read, write) = (pj(&[Action::SramRead(buffer)]), pj(&[Action::SramWrite(buffer)]));
        let per_byte = if memory.two_ports { read + write } else { read.max(write) };
        let bytes = memory.word.0 as f64 * f64::from(memory.banks);
        let leakage = prices.sram_leakage_w[buffer as usize];
        blocks.push((buffer.name(), per_byte * bytes * watts + leakage));
    }
    blocks
}
