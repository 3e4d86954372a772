//! Prices of clock gates, whose state is known in every cycle.
//!
//! The enable changes behind a rising edge of the clock, as everything does whose delay is left
//! out; the latch follows at the falling edge, where the output falls if the gate was open. What is
//! different there because the enable is another one already is in the price of its edge. So four
//! kinds of cycles have their exact price: closed, opening, open, closing.

use super::{energy, input_prices};
use crate::liberty::library::{Cell, ClockGate, Power};
use crate::slew::Slew;

/// A state of a gate, between edges.
#[derive(Debug, Clone, Copy)]
struct State {
    /// Enabling input, and whether it is 1; the others are 0.
    enable: (usize, bool),
    /// The clock, and what comes out.
    clock: bool,
    output: bool,
}

/// The groups that hold in a state: of each supply those with a condition that is true, or if there
/// are none those without a condition.
fn holding<'p>(cell: &Cell, powers: &'p [Power], state: State) -> Vec<&'p Power> {
    let gate = cell.clock_gate.as_ref().expect("a clock gate");
    let pin = |pin: usize| {
        let value = match pin.checked_sub(cell.inputs.len()) {
            Some(_) => state.output,
            None if pin == gate.clock => state.clock,
            None => state.enable == (pin, true),
        };
        0u64.wrapping_sub(u64::from(value))
    };
    let is_true = |power: &&Power| power.when.as_ref().is_some_and(|w| w.evaluate(pin) & 1 == 1);
    let has = |supply: &str| powers.iter().any(|power| power.supply == supply && is_true(&power));
    let counts = |power: &&Power| is_true(power) || power.when.is_none() && !has(&power.supply);
    powers.iter().filter(counts).collect()
}

/// An enabling input, and the state in which it is 0 or 1.
fn state(gate: &ClockGate, input: Option<usize>, clock: bool, output: bool) -> State {
    // Any place that is none of an input's: all are 0.
    State { enable: (input.unwrap_or(gate.clock), input.is_some()), clock, output }
}

/// Both edges of the clock pin in a cycle in which the gate is closed, fJ.
pub fn closed(cell: &Cell, clock_slew: f64) -> f64 {
    let gate = cell.clock_gate.as_ref().expect("a clock gate");
    let powers = &cell.inputs[gate.clock].powers;
    let groups = holding(cell, powers, state(gate, None, false, false));
    let both = |power: &&Power| {
        energy(&power.rise, clock_slew, 0.0) + energy(&power.fall, clock_slew, 0.0)
    };
    groups.iter().map(both).sum()
}

/// Rising and falling edges of the data inputs, then of the output, which stand for its cycle.
pub fn of_pins(
    cell: &Cell,
    gate: &ClockGate,
    clock_slew: f64,
    load: f64,
    input_slew: impl Fn(usize) -> Slew,
) -> Vec<(f64, f64)> {
    let sum =
        |groups: Vec<&Power>, of: &dyn Fn(&Power) -> f64| groups.into_iter().map(of).sum::<f64>();
    let clock_falls = |input, output| {
        let (powers, load) = match output {
            true => (&cell.outputs[0].powers, load),
            false => (&cell.inputs[gate.clock].powers, 0.0),
        };
        let groups = holding(cell, powers, state(gate, input, true, output));
        sum(groups, &|power| energy(&power.fall, clock_slew, load))
    };
    let output_rises = |input| {
        let groups = holding(cell, &cell.outputs[0].powers, state(gate, input, true, true));
        sum(groups, &|power| energy(&power.rise, clock_slew, load))
    };
    let enables = |pin: usize| gate.enable.depends_on(pin, cell.inputs.len());
    let mut prices = Vec::new();
    for pin in (0..cell.inputs.len()).filter(|pin| *pin != gate.clock) {
        let powers = &cell.inputs[pin].powers;
        if !enables(pin) {
            prices.push(input_prices(powers, &vec![1.0; powers.len()], input_slew(pin)));
            continue;
        }
        let (on, slew) = (Some(pin), input_slew(pin));
        let rises = holding(cell, powers, state(gate, None, true, false));
        let falls = holding(cell, powers, state(gate, on, true, true));
        let opening = clock_falls(on, false) - clock_falls(None, false);
        let closing = clock_falls(None, true) - clock_falls(on, true);
        prices.push((
            opening + sum(rises, &|power| energy(&power.rise, slew.rise, 0.0)),
            closing + sum(falls, &|power| energy(&power.fall, slew.fall, 0.0)),
        ));
    }
    let on = (0..cell.inputs.len()).find(|pin| *pin != gate.clock && enables(*pin));
    prices.push((output_rises(on), clock_falls(on, true)));
    prices
}
