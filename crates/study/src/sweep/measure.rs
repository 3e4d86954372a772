//! The measures that have a unit in a text, as numbers in SI units and back.
//!
//! Expressions count in bytes, hertz, seconds, joules, watts, volts, bytes per second and joules
//! per byte; areas stay in mm² and technology nodes in nanometres, as reports have them.

use powergs_base::quantity::{
    Bytes, BytesPerSecond, Hertz, Nanometres, Nanoseconds, Picojoules, PicojoulesPerByte, Quantity,
    SquareMillimetres, Volts, Watts,
};

/// What a number with a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Measure {
    /// Bytes.
    Size,
    /// Bytes per second.
    Bandwidth,
    /// Hertz.
    Frequency,
    /// Seconds.
    Time,
    /// Joules.
    Energy,
    /// Joules per byte.
    EnergyPerByte,
    /// Watts.
    Power,
    /// Square millimetres.
    Area,
    /// Nanometres.
    Node,
    /// Volts.
    Voltage,
}

/// The largest number of bytes that a number holds exactly.
const BYTES_MAX: f64 = (1u64 << 53) as f64;

impl Measure {
    /// All measures.
    pub const ALL: [Measure; 10] = [
        Measure::Size,
        Measure::Bandwidth,
        Measure::Frequency,
        Measure::Time,
        Measure::Energy,
        Measure::EnergyPerByte,
        Measure::Power,
        Measure::Area,
        Measure::Node,
        Measure::Voltage,
    ];

    /// With its article: `a bandwidth`.
    pub const fn name(self) -> &'static str {
        match self {
            Measure::Size => Bytes::KIND,
            Measure::Bandwidth => BytesPerSecond::KIND,
            Measure::Frequency => Hertz::KIND,
            Measure::Time => Nanoseconds::KIND,
            Measure::Energy => Picojoules::KIND,
            Measure::EnergyPerByte => PicojoulesPerByte::KIND,
            Measure::Power => Watts::KIND,
            Measure::Area => SquareMillimetres::KIND,
            Measure::Node => Nanometres::KIND,
            Measure::Voltage => Volts::KIND,
        }
    }

    /// The names of the units that are understood, comma-separated.
    pub fn unit_names(self) -> String {
        match self {
            Measure::Size => Bytes::unit_names(),
            Measure::Bandwidth => BytesPerSecond::unit_names(),
            Measure::Frequency => Hertz::unit_names(),
            Measure::Time => Nanoseconds::unit_names(),
            Measure::Energy => Picojoules::unit_names(),
            Measure::EnergyPerByte => PicojoulesPerByte::unit_names(),
            Measure::Power => Watts::unit_names(),
            Measure::Area => SquareMillimetres::unit_names(),
            Measure::Node => Nanometres::unit_names(),
            Measure::Voltage => Volts::unit_names(),
        }
    }

    /// Units of this measure in files per unit of this measure in expressions: 1e9 ns in a second.
    const fn per_base(self) -> f64 {
        match self {
            Measure::Time => 1e9,
            Measure::Energy | Measure::EnergyPerByte => 1e12,
            Measure::Size
            | Measure::Bandwidth
            | Measure::Frequency
            | Measure::Power
            | Measure::Area
            | Measure::Node
            | Measure::Voltage => 1.0,
        }
    }

    /// The number in a text with its unit.
    ///
    /// # Errors
    /// Why the text is no such measure, and what to write.
    pub fn read(self, text: &str) -> Result<f64, String> {
        fn of<Q: Quantity>(text: &str, number: impl Fn(Q) -> f64) -> Result<f64, String> {
            text.parse::<Q>().map(number).map_err(|e| e.to_string())
        }
        let read = match self {
            Measure::Size => of::<Bytes>(text, |q| q.0 as f64),
            Measure::Bandwidth => of::<BytesPerSecond>(text, |q| q.0),
            Measure::Frequency => of::<Hertz>(text, |q| q.0),
            Measure::Time => of::<Nanoseconds>(text, |q| q.0),
            Measure::Energy => of::<Picojoules>(text, |q| q.0),
            Measure::EnergyPerByte => of::<PicojoulesPerByte>(text, |q| q.0),
            Measure::Power => of::<Watts>(text, |q| q.0),
            Measure::Area => of::<SquareMillimetres>(text, |q| q.0),
            Measure::Node => of::<Nanometres>(text, |q| q.0),
            Measure::Voltage => of::<Volts>(text, |q| q.0),
        };
        read.map(|number| number / self.per_base())
    }

    /// A number as a text with its unit, to twelve digits.
    ///
    /// # Errors
    /// Why no such measure has this value: a negative one, or a part of a byte.
    pub fn write(self, number: f64) -> Result<String, String> {
        if !number.is_finite() || number < 0.0 {
            return Err(format!("{} cannot be {number}", self.name()));
        }
        let scaled = twelve_digits(number * self.per_base());
        Ok(match self {
            Measure::Size if scaled.fract() != 0.0 || scaled > BYTES_MAX => {
                return Err(format!("{scaled} B is not a whole number of bytes"));
            }
            Measure::Size => Bytes(scaled as u64).to_string(),
            Measure::Bandwidth => BytesPerSecond(scaled).to_string(),
            Measure::Frequency => Hertz(scaled).to_string(),
            Measure::Time => Nanoseconds(scaled).to_string(),
            Measure::Energy => Picojoules(scaled).to_string(),
            Measure::EnergyPerByte => PicojoulesPerByte(scaled).to_string(),
            Measure::Power => Watts(scaled).to_string(),
            Measure::Area => SquareMillimetres(scaled).to_string(),
            Measure::Node => Nanometres(scaled).to_string(),
            Measure::Voltage => Volts(scaled).to_string(),
        })
    }

    /// The measure that a unit belongs to: `KiB` is one of a size.
    pub fn with_unit(unit: &str) -> Option<Measure> {
        Measure::ALL.into_iter().find(|m| m.unit_names().split(", ").any(|name| name == unit))
    }
}

/// A product of decimal numbers as people would write it.
pub(crate) fn twelve_digits(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}
