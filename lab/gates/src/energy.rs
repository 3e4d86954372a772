//! What counted toggles cost.

use crate::netlist::{Behaviour, Netlist};
use crate::simulator::Toggles;

/// Energy of all lanes together, fJ, by where it goes; leakage apart.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Charging of nets: pins, wires, loads of outputs. Nets of input ports are in `inputs`.
    pub nets: f64,
    /// The same of nets that input ports drive, which is paid outside of the unit.
    pub inputs: f64,
    /// Internal energy of gates.
    pub gates: f64,
    /// Internal energy of flip-flops when their inputs or outputs toggle.
    pub flip_flops: f64,
    /// Internal energy of flip-flops at the edges of the clock.
    pub clock_pins: f64,
    /// Internal energy of clock gates: clock, enables, outputs.
    pub clock_gates: f64,
    /// Charging of the clock net, which is ideal: pins and wire, no buffers.
    pub clock_net: f64,
    /// Charging of the nets behind clock gates: pins and wire.
    pub gated_nets: f64,
    /// What [`clock`](Energy::clock) would be if all clock gates were open in every cycle.
    pub clock_ungated: f64,
}

impl Energy {
    /// Everything that the unit draws while it is clocked, input nets left out, fJ.
    pub fn total(&self) -> f64 {
        self.nets + self.internal() + self.clock_net + self.gated_nets
    }

    /// The same if every clock pin saw every cycle: all clock gates open, fJ.
    pub fn total_ungated(&self) -> f64 {
        self.without_clock() + self.clock_ungated
    }

    /// What of the total the clock costs: its nets and pins, and its gates, fJ.
    pub fn clock(&self) -> f64 {
        self.clock_pins + self.clock_gates + self.clock_net + self.gated_nets
    }

    /// Internal energy of all cells, fJ.
    pub fn internal(&self) -> f64 {
        self.gates + self.flip_flops + self.clock_pins + self.clock_gates
    }

    /// The total without [`clock`](Energy::clock), fJ.
    pub fn without_clock(&self) -> f64 {
        self.nets + self.gates + self.flip_flops
    }
}

/// Toggles of every net a cycle in a power that is reported without vectors.
pub const VECTORLESS_TOGGLES: f64 = 0.1;
/// Share of the cycles in which clock gates are open there.
pub const VECTORLESS_OPEN: f64 = 0.5;

/// The energy of a million cycles of one lane without any vectors, as synthesis reports state it by
/// default: [`VECTORLESS_TOGGLES`] at every net, [`VECTORLESS_OPEN`] of the clock.
pub fn vectorless(netlist: &Netlist) -> (Energy, f64) {
    const CYCLES: u64 = 1_000_000;
    let each = |share: f64| (CYCLES as f64 * share).round() as u64;
    let mut toggles = Toggles {
        lane_cycles: CYCLES,
        rises: vec![each(0.5 * VECTORLESS_TOGGLES); netlist.nets()],
        falls: vec![each(0.5 * VECTORLESS_TOGGLES); netlist.nets()],
    };
    for cell in 0..netlist.parts().cells.len() {
        if let Behaviour::ClockGate(_) = netlist.kind(cell).behaviour {
            let net = netlist.pins(cell).1[0].net as usize;
            toggles.rises[net] = each(VECTORLESS_OPEN);
            toggles.falls[net] = each(VECTORLESS_OPEN);
        }
    }
    (of(netlist, &toggles), CYCLES as f64)
}

/// The energy of `toggles` in `netlist`. Leakage is [`Netlist::leakage`] times the time.
///
/// # Panics
/// When the toggles are not those of this netlist.
pub fn of(netlist: &Netlist, toggles: &Toggles) -> Energy {
    assert_eq!(toggles.rises.len(), netlist.nets(), "toggles of another netlist");
    let parts = netlist.parts();
    let half_square = 0.5 * parts.about.voltage * parts.about.voltage;
    let cycles = toggles.lane_cycles as f64;
    let both = |net: usize| (toggles.rises[net] + toggles.falls[net]) as f64;
    let charging = |net: usize| half_square * f64::from(parts.capacitance[net]) * both(net);
    let inputs = 2 + crate::netlist::input_bits(&parts.ports);
    let clock_energy = |net: u32| 2.0 * half_square * f64::from(parts.capacitance[net as usize]);
    let mut energy = Energy {
        nets: (inputs..netlist.nets()).map(charging).sum(),
        inputs: (2..inputs).filter(|net| *net != parts.clock as usize).map(charging).sum(),
        ..Energy::default()
    };
    for cell in 0..parts.cells.len() {
        let (ins, outs) = netlist.pins(cell);
        let pins = ins.iter().chain(outs).map(|pin| {
            let (net, rise, fall) = (pin.net as usize, pin.rise_fj, pin.fall_fj);
            toggles.rises[net] as f64 * f64::from(rise)
                + toggles.falls[net] as f64 * f64::from(fall)
        });
        let pins: f64 = pins.sum();
        match &netlist.kind(cell).behaviour {
            Behaviour::Gate(_) => energy.gates += pins,
            Behaviour::FlipFlop(kind) => {
                energy.flip_flops += pins;
                let changes = outs.first().map_or(0.0, |pin| both(pin.net as usize));
                let clocked = match parts.clocks[cell] {
                    clock if clock == parts.clock => cycles,
                    gated => toggles.rises[gated as usize] as f64,
                };
                let more = (kind.change_fj - kind.idle_fj) * changes;
                energy.clock_pins += kind.idle_fj * clocked + more;
                energy.clock_ungated += kind.idle_fj * cycles + more;
            }
            Behaviour::ClockGate(kind) => {
                let net = outs[0].net;
                let open = toggles.rises[net as usize] as f64;
                energy.clock_gates += pins + kind.closed_fj * (cycles - open);
                energy.gated_nets += clock_energy(net) * open;
                // It is in the sum of all nets.
                energy.nets -= charging(net as usize);
                let both_edges = f64::from(outs[0].rise_fj) + f64::from(outs[0].fall_fj);
                energy.clock_ungated += (both_edges + clock_energy(net)) * cycles;
            }
        }
    }
    if parts.clock != 0 {
        energy.clock_net = clock_energy(parts.clock) * cycles;
        energy.clock_ungated += energy.clock_net;
    }
    energy
}
