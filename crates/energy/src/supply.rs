//! Clock and supply voltage: the least voltage at which a clock is reached, and what it does to
//! energy and leakage.
//!
//! The clock that gates reach at a voltage V follows the alpha-power law, `f = k (V - Vt)^a / V`,
//! with an effective threshold Vt and an exponent a of the node (A65). k is that of the energy
//! table: its units reach the clock that their prices are for at the voltage that they are for. So
//! at that clock all factors are exactly 1. Energy goes with V², leakage power with
//! `V exp((V - nominal) / slope)` (A66). Below the lowest voltage of a node the voltage stays, and
//! a clock that needs more than the highest one is refused (A67).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use powergs_base::quantity::{Hertz, Volts};

/// How fast the gates of a node are at a voltage.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Curve {
    /// Effective threshold.
    pub threshold: Volts,
    /// Exponent of the overdrive.
    #[schemars(range(min = 1.0, max = 3.0), extend("x-unit" = "exponent"))]
    pub exponent: f64,
    /// Voltage that makes the leakage current e times as large.
    pub leakage_slope: Volts,
    /// Lowest voltage.
    pub lowest: Volts,
    /// Highest voltage.
    pub highest: Volts,
}

/// The supply of a machine: its voltage, and factors on prices at the nominal clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Supply {
    /// Supply voltage, volts.
    pub voltage: f64,
    /// On the energy of actions and buffer accesses.
    pub energy: f64,
    /// On the leakage power of units and buffers.
    pub leakage: f64,
    /// The highest clock, hertz: the one at the highest voltage.
    pub highest_clock: f64,
}

/// Steps of the bisection: more than a double has bits.
const STEPS: usize = 64;

impl Curve {
    /// What is wrong with it, in one line.
    pub fn problem(&self) -> Option<String> {
        let (vt, low, high) = (self.threshold.0, self.lowest.0, self.highest.0);
        if vt >= low || low > high {
            return Some(format!(
                "`threshold` = {vt} V, `lowest` = {low} V and `highest` = {high} V must ascend"
            ));
        }
        (!(1.0..=3.0).contains(&self.exponent))
            .then(|| format!("`exponent` = {} must be from 1 to 3", self.exponent))
    }

    /// The clock at a voltage above the threshold, up to a factor.
    fn speed(&self, volts: f64) -> f64 {
        (volts - self.threshold.0).powf(self.exponent) / volts
    }

    /// The clock of a voltage, hertz, of gates that reach `clock` at `voltage`.
    pub fn clock_at(&self, volts: f64, clock: Hertz, voltage: Volts) -> f64 {
        clock.0 * self.speed(volts) / self.speed(voltage.0)
    }

    /// The supply at `wanted`, of gates that reach `clock` at `voltage`; `None` where no voltage
    /// is high enough.
    pub fn supply(&self, wanted: Hertz, clock: Hertz, voltage: Volts) -> Option<Supply> {
        let highest_clock = self.clock_at(self.highest.0, clock, voltage);
        let volts = if wanted == clock { voltage.0 } else { self.least(wanted, clock, voltage)? };
        let ratio = volts / voltage.0;
        let leakage = ratio * ((volts - voltage.0) / self.leakage_slope.0).exp();
        Some(Supply { voltage: volts, energy: ratio * ratio, leakage, highest_clock })
    }

    /// The least voltage that reaches `wanted`. The clock grows with the voltage: the exponent is
    /// at least 1.
    fn least(&self, wanted: Hertz, clock: Hertz, voltage: Volts) -> Option<f64> {
        let reaches = |volts: f64| self.clock_at(volts, clock, voltage) >= wanted.0;
        let (mut low, mut high) = (self.lowest.0, self.highest.0);
        if reaches(low) {
            return Some(low);
        }
        if !reaches(high) {
            return None;
        }
        for _ in 0..STEPS {
            let middle = (low + high) / 2.0;
            *(if reaches(middle) { &mut high } else { &mut low }) = middle;
        }
        Some(high)
    }
}
