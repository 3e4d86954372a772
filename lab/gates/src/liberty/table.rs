//! Tables of a library over slew and load: linear between points, and beyond the last ones.

/// What an axis of a table is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Transition time at the input, ns.
    Slew,
    /// Capacitance at the output, fF.
    Load,
}

/// A table of one value (no axes) or over one or two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Axes with their points in ascending order; the last one runs fastest.
    pub axes: Vec<(Axis, Vec<f64>)>,
    /// One value for each combination of points.
    pub values: Vec<f64>,
}

impl Table {
    /// The value at a slew in ns and a load in fF.
    pub fn at(&self, slew: f64, load: f64) -> f64 {
        let place = |(axis, points): &(Axis, Vec<f64>)| {
            let x = if *axis == Axis::Slew { slew } else { load };
            locate(points, x)
        };
        match self.axes.as_slice() {
            [first, second] => {
                let ((i, s), (j, t)) = (place(first), place(second));
                let (rows, columns) = (first.1.len(), second.1.len());
                let value = |i: usize, j: usize| {
                    self.values[i.min(rows - 1) * columns + j.min(columns - 1)]
                };
                let near = value(i, j) * (1.0 - t) + value(i, j + 1) * t;
                let far = value(i + 1, j) * (1.0 - t) + value(i + 1, j + 1) * t;
                near * (1.0 - s) + far * s
            }
            [only] => {
                let (i, s) = place(only);
                let next = self.values[(i + 1).min(self.values.len() - 1)];
                self.values[i] * (1.0 - s) + next * s
            }
            _ => self.values[0],
        }
    }
}

/// The point before `x` and the way to the next one; beyond the last points the way leaves 0 to 1.
fn locate(points: &[f64], x: f64) -> (usize, f64) {
    if points.len() < 2 {
        return (0, 0.0);
    }
    let i = points.partition_point(|&point| point <= x).saturating_sub(1).min(points.len() - 2);
    (i, (x - points[i]) / (points[i + 1] - points[i]))
}
