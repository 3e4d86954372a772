//! Scales that suit the values of a column.

use super::measure::Measure;
use crate::plot::Scale;

/// Above this ratio of the largest to the smallest value a scale is logarithmic.
const DECADES: f64 = 20.0;

/// A scale in shown units with its name.
#[derive(Debug, Clone)]
pub struct Axis {
    /// The scale, for values in the shown unit.
    pub scale: Scale,
    /// From the unit of the column to the shown one.
    factor: f64,
    /// `area, mm²`; says if it is logarithmic, `(log)`.
    pub name: String,
}

impl Axis {
    /// For the finite ones of `values` of the column `name`, on the page range `page`.
    pub fn of(name: &str, values: impl Iterator<Item = f64>, page: (f64, f64)) -> Axis {
        let ends = values
            .filter(|x| x.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |e, x| (e.0.min(x), e.1.max(x)));
        let (low, high) = if ends.0 <= ends.1 { ends } else { (0.0, 1.0) };
        let (factor, name) = Measure::of(name).axis(low.abs().max(high.abs()));
        let (low, high) = (low * factor, high * factor);
        if low > 0.0 && high > DECADES * low {
            let name = format!("{name} (log)");
            return Axis { scale: Scale::logarithmic(low, high, page), factor, name };
        }
        let scale = if low >= 0.0 && low < 0.4 * high {
            Scale::from_zero(high * 1.02, page)
        } else {
            let pad = if high > low { 0.06 * (high - low) } else { 0.1 * high.abs().max(1e-9) };
            Scale::exact(low - pad, high + pad, page)
        };
        Axis { scale, factor, name }
    }

    /// The page coordinate of a value in the unit of the column.
    pub fn at(&self, value: f64) -> f64 {
        self.scale.at(value * self.factor)
    }
}
