//! Axes that suit the values of a column.

use super::measure::Measure;
use powergs_chart::Scale;

/// Above this ratio of the largest to the smallest value a scale is logarithmic.
const DECADES: f64 = 20.0;

/// An axis in shown units.
#[derive(Debug, Clone)]
pub struct Axis {
    /// The axis; its title is `area, mm²`.
    pub axis: powergs_chart::Axis,
    /// From the unit of the column to the shown one.
    pub factor: f64,
}

impl Axis {
    /// For the finite ones of `values` of the column `name`.
    pub fn of(name: &str, values: impl Iterator<Item = f64>) -> Axis {
        let ends = powergs_chart::ends(values);
        let (low, high) = if ends.0 <= ends.1 { ends } else { (0.0, 1.0) };
        let (factor, name) = Measure::of(name).axis(low.abs().max(high.abs()));
        let (low, high) = (low * factor, high * factor);
        if low > 0.0 && high > DECADES * low {
            let axis = powergs_chart::Axis::new(name, Scale::logarithmic(low, high));
            return Axis { axis, factor };
        }
        let scale = if low >= 0.0 && low < 0.4 * high {
            Scale::from_zero(high * 1.02)
        } else {
            let pad = if high > low { 0.03 * (high - low) } else { 0.1 * high.abs().max(1e-9) };
            Scale::rounded(low - pad, high + pad)
        };
        Axis { axis: powergs_chart::Axis::new(name, scale), factor }
    }
}
