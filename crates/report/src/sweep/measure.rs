//! Columns of results for people: what they are called, and their values with a unit.

use crate::format::{prefix_of, rounded, significant};
use powergs_study::sweep::{self, key::Key, unit::Unit};

/// How the values of a column are shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// What it is: `energy per frame`, or the column's name where nobody knows better.
    pub words: String,
    /// The unit of shown values, empty for bare numbers.
    unit: &'static str,
    /// From the column's unit to the shown one.
    scale: f64,
    /// Whether the unit takes prefixes.
    prefixed: bool,
    /// How files write values of a key.
    written: Option<sweep::measure::Measure>,
}

/// Beginnings of columns with what they are called.
const NAMES: [(&str, &str); 13] = [
    ("energy_pj", "energy per frame"),
    ("frame_time_ms", "frame time"),
    ("fps", "frame rate"),
    ("area_mm2", "area"),
    ("power_full_rate_w", "power at full rate"),
    ("power_w", "power at the display rate"),
    ("display_power_w", "display power"),
    ("rendering_plus_display_w", "rendering and display power"),
    ("edp_pj_s", "energy-delay product"),
    ("dram_bytes", "DRAM bytes per frame"),
    ("dram_read_bytes", "DRAM bytes read"),
    ("dram_write_bytes", "DRAM bytes written"),
    ("deadline_missed_frac", "frames over the deadline"),
];

/// How numbers of a unit are shown: unit, factor, whether it takes prefixes.
fn shown(unit: Unit) -> (&'static str, f64, bool) {
    match unit {
        Unit::PicojouleSeconds => ("Js", 1e-12, true),
        Unit::Picojoules => ("J", 1e-12, true),
        Unit::Milliseconds => ("s", 1e-3, true),
        Unit::SquareMillimetres => ("mm²", 1.0, false),
        Unit::Watts => ("W", 1.0, true),
        Unit::GigabytesPerSecond => ("B/s", 1e9, true),
        Unit::Bytes => ("B", 1.0, true),
        Unit::Fraction => ("%", 100.0, false),
        Unit::Cycles => ("cycles", 1.0, false),
        Unit::FramesPerSecond => ("FPS", 1.0, false),
        // No column of ours has them.
        Unit::Megahertz
        | Unit::Hertz
        | Unit::Nanoseconds
        | Unit::Microseconds
        | Unit::Seconds
        | Unit::Nanojoules
        | Unit::Microjoules
        | Unit::Millijoules
        | Unit::Milliwatts
        | Unit::Nanometres => ("", 1.0, false),
    }
}

/// How differences of values of a key are shown: those of expressions, which count in SI units.
fn base(measure: sweep::measure::Measure) -> (&'static str, f64, bool) {
    use sweep::measure::Measure::*;
    match measure {
        Size => ("B", 1.0, true),
        Bandwidth => ("B/s", 1.0, true),
        Frequency => ("Hz", 1.0, true),
        Time => ("s", 1.0, true),
        Energy => ("J", 1.0, true),
        EnergyPerByte => ("J/B", 1.0, true),
        Power => ("W", 1.0, true),
        Voltage => ("V", 1.0, true),
        Area => ("mm²", 1.0, false),
        Node => ("nm", 1.0, false),
    }
}

impl Measure {
    /// How the column `name` is shown.
    pub fn of(name: &str) -> Measure {
        let (first, rest) = name.split_once('.').unwrap_or((name, ""));
        let key = name.strip_suffix(".si").unwrap_or(name);
        let written = Key::of(key).and_then(Key::measure);
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-.:[]".contains(c);
        let unit = Unit::of_column(name).filter(|_| name.chars().all(is_plain));
        let (unit, scale, prefixed) = match (unit, written) {
            (_, Some(measure)) => base(measure),
            (Some(unit), None) => shown(unit),
            // Plain numbers, and expressions: their unit is what they are made of.
            (None, None) => ("", 1.0, false),
        };
        let known = NAMES.into_iter().find(|n| n.0 == first).map(|n| n.1);
        let words = match (known, rest) {
            (None, _) => key.to_owned(),
            (Some(words), "" | "mean") => words.to_owned(),
            (Some(words), "max") => format!("maximum {words}"),
            (Some(words), "min") => format!("minimum {words}"),
            (Some(words), "p50") => format!("median {words}"),
            (Some(words), rest) => format!("{words}, {rest}"),
        };
        Measure { words, unit, scale, prefixed, written }
    }

    /// What it is in a few words: `power` for the power at the display rate.
    pub fn short(&self) -> String {
        self.words.replace(" at the display rate", "")
    }

    /// A value with its unit: `1.23 mJ`.
    pub fn text(&self, value: f64) -> String {
        self.in_unit_of(value, value)
    }

    /// By how much `value` changes, with a sign, in the unit that `value` is shown in: `-0.501 mW`
    /// of 182 mW.
    pub fn difference(&self, change: f64, value: f64) -> String {
        let sign = if change > 0.0 { "+" } else { "" };
        let largest = if value.is_finite() { value.abs().max(change.abs()) } else { change };
        format!("{sign}{}", self.in_unit_of(change, largest))
    }

    fn in_unit_of(&self, value: f64, shown: f64) -> String {
        if !value.is_finite() {
            return "-".into();
        }
        if let Some(Ok(text)) = self.written.map(|measure| measure.write(value)) {
            return rounded(&text);
        }
        let (factor, prefix) =
            if self.prefixed { prefix_of(shown * self.scale) } else { (1.0, "") };
        let x = value * self.scale / factor;
        format!("{} {prefix}{}", significant(x), self.unit).trim_end().to_owned()
    }

    /// For an axis up to `largest`: the factor for values, and the name with the unit.
    pub fn axis(&self, largest: f64) -> (f64, String) {
        let (factor, prefix) =
            if self.prefixed { prefix_of(largest * self.scale) } else { (1.0, "") };
        let unit = format!("{prefix}{}", self.unit);
        let name =
            if unit.is_empty() { self.words.clone() } else { format!("{}, {unit}", self.words) };
        (self.scale / factor, name)
    }
}
