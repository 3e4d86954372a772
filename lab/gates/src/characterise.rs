//! Prices of what a unit does, from real work that is run through its netlist.
//!
//! 64 circuits run side by side, each on work of its own, with pauses of random length in front of
//! the input. After every window of cycles the energy of all toggles is noted beside what was done
//! in it: cycles, rows, keys, exchanges. Prices are the least-squares fit of one to the other on
//! three quarters of the lists; on the last quarter, prices times counts are compared with what was
//! measured. No price is negative: where the lists do not tell an action from others that come with
//! it, a fit may make one cheap and the other dear; then the one below zero is left out, its energy
//! is in the others, and it is named.
//!
//! The clock and the idle circuit are the price of a cycle; leakage is apart. Registers that a
//! clock gate serves cost their clock where something is done, and not in that price: so it is
//! that of an idle unit. What it would be without gates is stated beside it.

pub mod bsu;
pub mod ccu;
mod lanes;
pub mod qsu;
pub mod vrc;
pub mod vru;

use thiserror::Error;

use crate::energy;
use crate::netlist::Netlist;
use crate::simulator::Simulator;

/// Cycles of a window, for units that are done with something after a few.
const WINDOW: u64 = 16;
/// Windows below which prices are not fitted: four for each price.
const MIN_WINDOWS: usize = 16;
/// Windows of other lists below which prices are not tried.
const MIN_HELD_OUT: usize = 4;

/// Why there are no prices.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum CharacteriseError {
    /// Not enough work.
    #[error("{windows} windows of work are too few to fit prices to; give more or longer lists")]
    TooLittle {
        /// Windows with work.
        windows: usize,
    },
    /// Actions that always come together.
    #[error("the lists do not tell {action} from the other actions; give other frames")]
    Alike {
        /// The action.
        action: &'static str,
    },
    /// Energies that leave no action a price.
    #[error(
        "no action has a price of zero or more: the energies of the netlist are below zero; look \
         at the power tables of its library"
    )]
    BelowZero,
    /// A netlist of another unit, or of another version of it.
    #[error("the netlist has no port {port}: it is not of this unit")]
    Port {
        /// The port.
        port: String,
    },
    /// A netlist of a unit with other parameters.
    #[error(
        "port {port} of the netlist has {bits} bits in place of {expected}; map the unit with the \
         parameters of rtl/"
    )]
    Width {
        /// The port.
        port: String,
        /// Its bits.
        bits: usize,
        /// What they must be.
        expected: String,
    },
    /// A netlist that computes something else.
    #[error("the netlist does not do what the unit does: {what}; map this version of rtl/")]
    Differs {
        /// What was seen.
        what: &'static str,
    },
    /// A netlist that takes nothing.
    #[error("the netlist has taken nothing for {cycles} cycles; map this version of rtl/")]
    Stuck {
        /// Cycles.
        cycles: u64,
    },
}

impl CharacteriseError {
    /// Whether it is the netlist that is wrong, and not the work.
    pub fn is_of_netlist(&self) -> bool {
        match self {
            CharacteriseError::TooLittle { .. } | CharacteriseError::Alike { .. } => false,
            CharacteriseError::BelowZero
            | CharacteriseError::Port { .. }
            | CharacteriseError::Width { .. }
            | CharacteriseError::Differs { .. }
            | CharacteriseError::Stuck { .. } => true,
        }
    }
}

/// That the gates do what the model does.
///
/// # Errors
/// Says `what` they do in its place.
fn must(holds: bool, what: &'static str) -> Result<(), CharacteriseError> {
    if holds { Ok(()) } else { Err(CharacteriseError::Differs { what }) }
}

/// What the gates must have been given before.
///
/// # Errors
/// Says `what` they do in its place.
fn due<T>(value: Option<T>, what: &'static str) -> Result<T, CharacteriseError> {
    value.ok_or(CharacteriseError::Differs { what })
}

/// What was done, and what it cost, in windows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Measured {
    /// Names of the actions.
    actions: &'static [&'static str],
    /// Counts of each action, and energy in fJ, of each window.
    windows: Vec<(Vec<f64>, f64)>,
    /// Energy of the clock in all of them, fJ: as it is, and with all clock gates open.
    clock: [f64; 2],
}

/// The price of an action.
#[derive(Debug, Clone, PartialEq)]
pub struct Price {
    /// What is done.
    pub action: &'static str,
    /// Energy, pJ.
    pub pj: f64,
    /// Standard error of the fit, pJ: few windows leave much of it.
    pub error_pj: f64,
    /// How often it was done where prices were fitted.
    pub count: f64,
}

/// Prices of a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Characterised {
    /// Prices of its actions.
    pub prices: Vec<Price>,
    /// Actions whose energy is in the prices of the others.
    pub left_out: Vec<&'static str>,
    /// Leakage, mW.
    pub leakage_mw: f64,
    /// Windows that prices were fitted to.
    pub windows: usize,
    /// Root of the mean square of what is left in a window, as a share of the mean window.
    pub spread: f64,
    /// Prices times counts over what was measured, less 1, on lists that were not fitted.
    pub held_out: f64,
    /// Energy a lane-cycle on those lists, pJ.
    pub held_out_pj_per_cycle: f64,
    /// What of it the clock takes: its nets, pins and gates.
    pub clock_pj_per_cycle: f64,
    /// What the clock would take in any cycle if all clock gates were open.
    pub clock_ungated_pj_per_cycle: f64,
    /// What a report without vectors would say of a cycle ([`energy::vectorless`]).
    pub vectorless_pj_per_cycle: f64,
}

/// Notes what windows cost.
pub(crate) struct Meter<'n> {
    netlist: &'n Netlist,
    actions: &'static [&'static str],
    window: u64,
    counts: Vec<f64>,
    windows: Vec<(Vec<f64>, f64)>,
    clock: [f64; 2],
}

impl<'n> Meter<'n> {
    /// The first of `actions` is a cycle.
    pub(crate) fn new(
        netlist: &'n Netlist,
        actions: &'static [&'static str],
        window: u64,
    ) -> Meter<'n> {
        Meter {
            netlist,
            actions,
            window,
            counts: vec![0.0; actions.len()],
            windows: Vec::new(),
            clock: [0.0; 2],
        }
    }

    /// So much more of an action, by its place.
    pub(crate) fn count(&mut self, action: usize, amount: u64) {
        self.counts[action] += amount as f64;
    }

    /// Behind each cycle of the simulator: closes the window when it is full.
    pub(crate) fn cycle(&mut self, simulator: &mut Simulator) {
        self.count(0, 64);
        if simulator.cycles() < self.window {
            return;
        }
        let energy = energy::of(self.netlist, &simulator.toggles());
        self.clock[0] += energy.clock();
        self.clock[1] += energy.clock_ungated;
        let counts = std::mem::replace(&mut self.counts, vec![0.0; self.actions.len()]);
        self.windows.push((counts, energy.total()));
        simulator.count_anew();
    }

    pub(crate) fn measured(self) -> Measured {
        Measured { actions: self.actions, windows: self.windows, clock: self.clock }
    }
}

/// Fits prices to `fitted` and looks how they do on `held_out`.
fn characterise(
    netlist: &Netlist,
    fitted: &Measured,
    held_out: &Measured,
) -> Result<Characterised, CharacteriseError> {
    let windows = fitted.windows.len();
    if windows < MIN_WINDOWS || held_out.windows.len() < MIN_HELD_OUT {
        return Err(CharacteriseError::TooLittle { windows });
    }
    let (prices, inverse, left_out) = fit_above_zero(fitted)?;
    let predicted = |counts: &[f64]| counts.iter().zip(&prices).map(|(n, fj)| n * fj).sum::<f64>();
    let left = fitted.windows.iter().map(|(counts, fj)| (fj - predicted(counts)).powi(2));
    let left: f64 = left.sum();
    let mean = fitted.windows.iter().map(|(_, fj)| fj).sum::<f64>() / windows as f64;
    let spread = (left / windows as f64).sqrt() / mean;
    let free = windows - (prices.len() - left_out.len());
    let expected: f64 = held_out.windows.iter().map(|(counts, _)| predicted(counts)).sum();
    let measured: f64 = held_out.windows.iter().map(|(_, fj)| fj).sum();
    let cycles: f64 = held_out.windows.iter().map(|(counts, _)| counts[0]).sum();
    let count = |action: usize| fitted.windows.iter().map(|(counts, _)| counts[action]).sum();
    let price = |(action, fj): (usize, &f64)| Price {
        action: fitted.actions[action],
        pj: fj * 1e-3,
        error_pj: (inverse[action] * left / free as f64).sqrt() * 1e-3,
        count: count(action),
    };
    let kept = prices.iter().enumerate().filter(|(action, _)| !left_out.contains(action));
    let (vectorless, of_cycles) = energy::vectorless(netlist);
    Ok(Characterised {
        prices: kept.map(price).collect(),
        left_out: left_out.iter().map(|action| fitted.actions[*action]).collect(),
        leakage_mw: netlist.leakage() * 1e-6,
        windows,
        spread,
        held_out: expected / measured - 1.0,
        held_out_pj_per_cycle: measured / cycles * 1e-3,
        clock_pj_per_cycle: held_out.clock[0] / cycles * 1e-3,
        clock_ungated_pj_per_cycle: held_out.clock[1] / cycles * 1e-3,
        vectorless_pj_per_cycle: vectorless.total() / of_cycles * 1e-3,
    })
}

/// Prices, their diagonal of the inverse, and the actions that are left out.
type Fit = (Vec<f64>, Vec<f64>, Vec<usize>);

/// Least squares without negative prices, and the actions that are left out: those that never
/// happen, and one at a time that with the most energy below zero.
fn fit_above_zero(measured: &Measured) -> Result<Fit, CharacteriseError> {
    let never = |action: &usize| measured.windows.iter().all(|(counts, _)| counts[*action] == 0.0);
    let (mut left_out, mut kept): (Vec<usize>, Vec<usize>) =
        (0..measured.actions.len()).partition(never);
    loop {
        if kept.is_empty() {
            return Err(CharacteriseError::BelowZero);
        }
        let fitted = fit(measured, &kept)?;
        let energy = |place: &usize| {
            let counts = measured.windows.iter().map(|(counts, _)| counts[kept[*place]]);
            fitted[*place].0 * counts.sum::<f64>()
        };
        let below = (0..kept.len()).filter(|place| fitted[*place].0 < 0.0);
        let Some(worst) = below.min_by(|a, b| energy(a).total_cmp(&energy(b))) else {
            let mut prices = vec![0.0; measured.actions.len()];
            let mut inverse = prices.clone();
            for (&action, of) in kept.iter().zip(fitted) {
                (prices[action], inverse[action]) = of;
            }
            return Ok((prices, inverse, left_out));
        };
        left_out.push(kept.remove(worst));
    }
}

/// Least squares by the normal equations; columns are scaled to a mean of 1 first. Each price with
/// its place on the diagonal of the inverse: its variance, where that of a window is 1.
fn fit(measured: &Measured, kept: &[usize]) -> Result<Vec<(f64, f64)>, CharacteriseError> {
    let n = kept.len();
    let of = |counts: &[f64]| -> Vec<f64> { kept.iter().map(|action| counts[*action]).collect() };
    let mut scale = vec![0.0; n];
    for (counts, _) in &measured.windows {
        of(counts).iter().zip(&mut scale).for_each(|(count, sum)| *sum += count);
    }
    scale.iter_mut().for_each(|sum| *sum /= measured.windows.len() as f64);
    let alike = |place: usize| CharacteriseError::Alike { action: measured.actions[kept[place]] };
    // The equations, their right side, and the identity that becomes the inverse.
    let mut rows = vec![vec![0.0; 2 * n + 1]; n];
    (0..n).for_each(|i| rows[i][n + 1 + i] = 1.0);
    for (counts, fj) in &measured.windows {
        let x: Vec<f64> = of(counts).iter().zip(&scale).map(|(count, mean)| count / mean).collect();
        for i in 0..n {
            (0..n).for_each(|j| rows[i][j] += x[i] * x[j]);
            rows[i][n] += x[i] * fj;
        }
    }
    let whole = rows[0][0];
    for i in 0..n {
        let largest = (i..n).max_by(|a, b| rows[*a][i].abs().total_cmp(&rows[*b][i].abs()));
        rows.swap(i, largest.expect("a row is left"));
        if rows[i][i].abs() < 1e-9 * whole {
            return Err(alike(i));
        }
        let pivot = rows[i].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(j, _)| *j != i) {
            let factor = row[i] / pivot[i];
            row.iter_mut().zip(&pivot).for_each(|(value, above)| *value -= factor * above);
        }
    }
    let price = |i: usize| {
        let row = &rows[i];
        (row[n] / row[i] / scale[i], row[n + 1 + i] / row[i] / scale[i].powi(2))
    };
    Ok((0..n).map(price).collect())
}

/// Every fourth list is held out.
fn divided<T: Clone>(lists: &[T]) -> [Vec<T>; 2] {
    let part = |held_out: bool| {
        let of = lists.iter().enumerate().filter(|(i, _)| (i % 4 == 3) == held_out);
        of.map(|(_, list)| list.clone()).collect()
    };
    [part(false), part(true)]
}
