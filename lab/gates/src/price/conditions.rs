//! What is not said by the circuit or the library: the conditions that a unit was mapped under.

use serde_json::Value;

use crate::yosys::JsonError;

/// What is not said by the circuit or the library.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// What the library is called.
    pub library: String,
    /// Clock period that the circuit was mapped for, ns.
    pub period_ns: f64,
    /// Critical path by static timing analysis, ns; 0 if it was not analysed.
    pub critical_path_ns: f64,
    /// Transition time of the ideal clock, ns.
    pub clock_transition_ns: f64,
    /// Transition time at inputs, ns.
    pub input_transition_ns: f64,
    /// Load of each output, fF.
    pub load_ff: f64,
}

impl Conditions {
    /// Reads the `report.json` that `rtl/synth/synthesise.py` writes beside a netlist.
    ///
    /// # Errors
    /// When it is no JSON object, or a number is missing, negative or not finite.
    pub fn parse(file: &str, text: &str) -> Result<Conditions, JsonError> {
        let refuse = |reason: String| JsonError { file: file.to_owned(), reason };
        let report: Value = serde_json::from_str(text)
            .map_err(|error| refuse(format!("no JSON ({error}); the file may be truncated")))?;
        let number = |name: &str| {
            let number = report.get(name).and_then(Value::as_f64);
            number.filter(|number| number.is_finite() && *number >= 0.0)
        };
        let needed = |name: &str| {
            let missing = || format!("no number `{name}`; it is what synthesise.py writes");
            number(name).ok_or_else(|| refuse(missing()))
        };
        Ok(Conditions {
            library: report.get("library").and_then(Value::as_str).unwrap_or("").to_owned(),
            period_ns: needed("period_ns")?,
            critical_path_ns: number("critical_path_ns").unwrap_or(0.0),
            clock_transition_ns: needed("clock_transition_ns")?,
            input_transition_ns: needed("input_transition_ns")?,
            load_ff: needed("load_ff")?,
        })
    }
}
