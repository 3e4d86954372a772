//! Transition times, from inputs and clock through the gates.
//!
//! As static timing analysers do it: an edge of an output takes the longest transition that any arc
//! to it gives, for the transition of the input edge that it follows and the load at the output.
//! Wires have no resistance here, so a pin sees what its driver makes.

use crate::liberty::library::{Arc, Output, Sense};

/// Transition times of a net, ns.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slew {
    /// Of rising edges.
    pub rise: f64,
    /// Of falling edges.
    pub fall: f64,
}

impl Slew {
    /// Both edges alike.
    pub fn both(time: f64) -> Slew {
        Slew { rise: time, fall: time }
    }
}

/// Transition times of `output` with a load in fF; `input` gives those of the cell's inputs.
pub fn of_output(output: &Output, load: f64, input: impl Fn(usize) -> Slew) -> Slew {
    let mut out = Slew::default();
    for arc in &output.arcs {
        let (rise, fall) = of_arc(arc, load, input(arc.from));
        out.rise = out.rise.max(rise);
        out.fall = out.fall.max(fall);
    }
    out
}

fn of_arc(arc: &Arc, load: f64, from: Slew) -> (f64, f64) {
    let (before_rise, before_fall): (&[f64], &[f64]) = match arc.sense {
        Sense::Positive => (&[from.rise], &[from.fall]),
        Sense::Negative => (&[from.fall], &[from.rise]),
        Sense::Either => (&[from.rise, from.fall], &[from.rise, from.fall]),
        Sense::Rising => (&[from.rise], &[from.rise]),
    };
    let longest = |table: &Option<crate::liberty::table::Table>, slews: &[f64]| {
        let table = table.as_ref();
        table.map_or(0.0, |table| slews.iter().map(|s| table.at(*s, load)).fold(0.0, f64::max))
    };
    (longest(&arc.rise, before_rise), longest(&arc.fall, before_fall))
}
