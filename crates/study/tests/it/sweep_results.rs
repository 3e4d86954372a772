//! What a sweep keeps and what its table says.

mod engine;
mod metric;
mod table;

use powergs_study::sweep::outcome::{Outcome, means, place};

/// An outcome of frames with these times, milliseconds; energy is ten times that, power a tenth.
pub fn outcome(times: &[f64]) -> Outcome {
    let mut values = vec![Some(1.0); means().len()];
    let mean = |f: &dyn Fn(f64) -> f64| {
        Some(times.iter().map(|&t| f(t)).sum::<f64>() / times.len() as f64)
    };
    values[place("frame_time_ms").unwrap()] = mean(&|t| t);
    values[place("energy_pj.total").unwrap()] = mean(&|t| 10.0 * t);
    values[place("power_w.total").unwrap()] = mean(&|t| 0.1 * t);
    Outcome { samples: times.iter().map(|&t| [t, 10.0 * t, 0.1 * t]).collect(), means: values }
}
