//! Quantities as text: `"51.2 GB/s"` to a number in the base unit and back, without rounding on
//! the way.
//!
//! Decimal prefixes only move the decimal point and binary ones multiply by a power of two, so the
//! result is the `f64` nearest to what was written, and printing it and reading it back gives the
//! same bits.

use std::fmt;
use std::str::FromStr;

use super::{
    Bytes, BytesPerSecond, Hertz, Nanometres, Nanoseconds, Picojoules, PicojoulesPerByte,
    SquareMillimetres, Volts, Watts,
};

/// Longest text that is parsed, bytes. No sensible number is longer.
const MAX_LEN: usize = 64;

/// A unit: its name, and its size as `10^ten * 2^two` base units.
#[derive(Debug, Clone, Copy)]
pub struct Unit {
    name: &'static str,
    ten: i32,
    two: i32,
}

const fn decimal(name: &'static str, ten: i32) -> Unit {
    Unit { name, ten, two: 0 }
}

const fn binary(name: &'static str, two: i32) -> Unit {
    Unit { name, ten: 0, two }
}

/// Why a text is not a quantity of the wanted kind. The text says what to write instead.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum QuantityError {
    /// A number without its unit.
    #[error("{kind} needs its unit: write e.g. \"{example}\" instead of {text}")]
    Bare {
        /// The kind of quantity, with its article.
        kind: &'static str,
        /// A right one.
        example: &'static str,
        /// What was written.
        text: String,
    },
    /// It does not start with a number.
    #[error("\"{text}\" does not start with a plain decimal number: write {kind} as \"{example}\"")]
    Number {
        /// The kind of quantity, with its article.
        kind: &'static str,
        /// A right one.
        example: &'static str,
        /// What was written.
        text: String,
    },
    /// The unit is another one.
    #[error("unknown unit `{unit}` for {kind}: use one of {known}, e.g. \"{example}\"")]
    Unit {
        /// The kind of quantity, with its article.
        kind: &'static str,
        /// A right one.
        example: &'static str,
        /// What was written.
        unit: String,
        /// The units of this kind.
        known: String,
    },
    /// Negative, zero where that makes no sense, not believable, or not a whole number of bytes.
    #[error("\"{text}\" is out of range: {kind} must be {rule}")]
    Range {
        /// The kind of quantity, with its article.
        kind: &'static str,
        /// What was written.
        text: String,
        /// The rule that it breaks.
        rule: &'static str,
    },
}

/// A measure that is written as a number with a unit.
pub trait Quantity: Copy + fmt::Display + FromStr<Err = QuantityError> {
    /// What it measures, with its article: `a bandwidth`.
    const KIND: &'static str;
    /// One written right.
    const EXAMPLE: &'static str;
    /// The units that are understood; the first one is the base unit.
    const UNITS: &'static [Unit];
    /// Which values are allowed.
    const RULE: &'static str;

    /// The names of the units, comma-separated, the base unit first.
    fn unit_names() -> String {
        Self::UNITS.iter().map(|u| u.name).collect::<Vec<_>>().join(", ")
    }
}

/// A decimal number and its unit, not yet multiplied.
struct TextParts {
    digits: u128,
    ten: i32,
    negative: bool,
    unit: Unit,
}

fn split<Q: Quantity>(text: &str) -> Result<TextParts, QuantityError> {
    let (kind, example) = (Q::KIND, Q::EXAMPLE);
    let shown: String = text.chars().take(MAX_LEN).collect();
    let bad_number = || QuantityError::Number { kind, example, text: shown.clone() };
    if text.len() > MAX_LEN {
        return Err(bad_number());
    }
    let trimmed = text.trim();
    let (negative, rest) = match trimmed.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, trimmed),
    };
    let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
    let (number, mut unit_text) = rest.split_at(end);
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    if whole.is_empty() || fraction.contains('.') || number.ends_with('.') {
        return Err(bad_number());
    }
    let digits = format!("{whole}{fraction}").parse().map_err(|_| bad_number())?;
    let mut ten = -(fraction.len() as i32);
    if let Some((exponent, after)) = exponent(unit_text) {
        ten += exponent;
        unit_text = after;
    }
    let name = unit_text.trim_start();
    if name.is_empty() {
        return Err(QuantityError::Bare { kind, example, text: shown });
    }
    let unit = Q::UNITS.iter().find(|u| u.name == name).copied();
    let unit = unit.ok_or_else(|| QuantityError::Unit {
        kind,
        example,
        unit: name.to_owned(),
        known: Q::unit_names(),
    })?;
    Ok(TextParts { digits, ten, negative, unit })
}

/// An exponent as in `1e9` at the start of `text`, and what follows it.
fn exponent(text: &str) -> Option<(i32, &str)> {
    let rest = text.strip_prefix(['e', 'E'])?;
    let digits = rest.strip_prefix(['+', '-']).unwrap_or(rest);
    let len = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    let end = rest.len() - digits.len() + len;
    (1..=3).contains(&len).then(|| Some((rest[..end].parse().ok()?, &rest[end..])))?
}

fn range<Q: Quantity>(text: &str) -> QuantityError {
    QuantityError::Range { kind: Q::KIND, text: text.trim().to_owned(), rule: Q::RULE }
}

fn parse_real<Q: Quantity>(text: &str) -> Result<f64, QuantityError> {
    let parts = split::<Q>(text)?;
    let decimal = format!("{}e{}", parts.digits, parts.ten + parts.unit.ten);
    let value = decimal.parse::<f64>().unwrap_or(f64::INFINITY) * 2f64.powi(parts.unit.two);
    let lost = parts.digits != 0 && value == 0.0;
    let is_believed = value == 0.0 || (LEAST..=MOST).contains(&value);
    if parts.negative || lost || !is_believed {
        return Err(range::<Q>(text));
    }
    Ok(value)
}

fn parse_bytes(text: &str) -> Result<u64, QuantityError> {
    let parts = split::<Bytes>(text)?;
    let bad = || range::<Bytes>(text);
    if parts.negative {
        return Err(bad());
    }
    let ten = parts.ten + parts.unit.ten;
    let scaled = parts.digits.checked_mul(1 << parts.unit.two).ok_or_else(bad)?;
    let power = 10u128.checked_pow(ten.unsigned_abs()).ok_or_else(bad)?;
    let bytes = if ten >= 0 {
        scaled.checked_mul(power).ok_or_else(bad)?
    } else if scaled.is_multiple_of(power) {
        scaled / power
    } else {
        return Err(bad());
    };
    u64::try_from(bytes).map_err(|_| bad())
}

/// Prints `value` in the largest decimal unit that leaves at least 1 before the point.
fn print_real(value: f64, units: &[Unit], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let scientific = format!("{value:e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let digits = mantissa.replace('.', "");
    let fits = |u: &&Unit| u.two == 0 && u.ten <= exponent;
    let base = decimal(units[0].name, 0);
    let unit = if value == 0.0 {
        base
    } else {
        let smallest = units.iter().filter(|u| u.two == 0).min_by_key(|u| u.ten);
        let largest = units.iter().filter(fits).rev().max_by_key(|u| u.ten);
        *largest.or(smallest).unwrap_or(&base)
    };
    let point = exponent - unit.ten + 1;
    let text = if point <= 0 {
        format!("0.{}{digits}", "0".repeat(point.unsigned_abs() as usize))
    } else if point as usize >= digits.len() {
        format!("{digits}{}", "0".repeat(point as usize - digits.len()))
    } else {
        format!("{}.{}", &digits[..point as usize], &digits[point as usize..])
    };
    write!(f, "{text} {}", unit.name)
}

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
        let exact = units.iter().find(|(two, _)| self.0 != 0 && self.0.trailing_zeros() >= *two);
        match exact {
            Some((two, name)) => write!(f, "{} {name}", self.0 >> two),
            None => write!(f, "{} B", self.0),
        }
    }
}

impl FromStr for Bytes {
    type Err = QuantityError;
    fn from_str(text: &str) -> Result<Self, QuantityError> {
        parse_bytes(text).map(Bytes)
    }
}

impl Quantity for Bytes {
    const KIND: &'static str = "a size";
    const EXAMPLE: &'static str = "64 KiB";
    const UNITS: &'static [Unit] = &[
        decimal("B", 0),
        decimal("kB", 3),
        decimal("KB", 3),
        decimal("MB", 6),
        decimal("GB", 9),
        binary("KiB", 10),
        binary("MiB", 20),
        binary("GiB", 30),
    ];
    const RULE: &'static str = "a whole number of bytes, not negative (KB = 1000 B, KiB = 1024 B)";
}

macro_rules! real {
    ($t:ident, $kind:literal, $example:literal, $rule:ident, $units:expr) => {
        impl fmt::Display for $t {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                print_real(self.0, Self::UNITS, f)
            }
        }
        impl FromStr for $t {
            type Err = QuantityError;
            fn from_str(text: &str) -> Result<Self, QuantityError> {
                let value = parse_real::<Self>(text)?;
                if Self::RULE == POSITIVE && value == 0.0 {
                    return Err(range::<Self>(text));
                }
                Ok(Self(value))
            }
        }
        impl Quantity for $t {
            const KIND: &'static str = $kind;
            const EXAMPLE: &'static str = $example;
            const UNITS: &'static [Unit] = $units;
            const RULE: &'static str = $rule;
        }
    };
}

/// The smallest number other than zero that is believed, in the base unit. Within these bounds the
/// sums of a simulation stay finite, and every number that is printed can be read again.
const LEAST: f64 = 1e-15;
/// The largest number that is believed, in the base unit.
const MOST: f64 = 1e15;

const POSITIVE: &str = "greater than zero and believable: from 1e-15 to 1e15 of its base unit";
const NOT_NEGATIVE: &str = "zero, or believable: from 1e-15 to 1e15 of its base unit";

real!(
    Hertz,
    "a frequency",
    "1 GHz",
    POSITIVE,
    &[decimal("Hz", 0), decimal("kHz", 3), decimal("MHz", 6), decimal("GHz", 9)]
);
real!(
    BytesPerSecond,
    "a bandwidth",
    "51.2 GB/s",
    NOT_NEGATIVE,
    &[
        decimal("B/s", 0),
        decimal("kB/s", 3),
        decimal("MB/s", 6),
        decimal("GB/s", 9),
        decimal("TB/s", 12),
        binary("KiB/s", 10),
        binary("MiB/s", 20),
        binary("GiB/s", 30),
        Unit { name: "Mbit/s", ten: 6, two: -3 },
        Unit { name: "Gbit/s", ten: 9, two: -3 },
        Unit { name: "Tbit/s", ten: 12, two: -3 },
    ]
);
real!(
    Nanoseconds,
    "a time",
    "100 ns",
    NOT_NEGATIVE,
    &[decimal("ns", 0), decimal("ps", -3), decimal("us", 3), decimal("ms", 6), decimal("s", 9)]
);
real!(
    Picojoules,
    "an energy",
    "0.53 pJ",
    NOT_NEGATIVE,
    &[
        decimal("pJ", 0),
        decimal("fJ", -3),
        decimal("nJ", 3),
        decimal("uJ", 6),
        decimal("mJ", 9),
        decimal("J", 12)
    ]
);
real!(
    PicojoulesPerByte,
    "an energy per byte",
    "10.88 pJ/B",
    NOT_NEGATIVE,
    &[
        decimal("pJ/B", 0),
        decimal("fJ/B", -3),
        decimal("nJ/B", 3),
        Unit { name: "pJ/bit", ten: 0, two: 3 }
    ]
);
real!(
    Watts,
    "a power",
    "0.25 W",
    NOT_NEGATIVE,
    &[decimal("W", 0), decimal("mW", -3), decimal("uW", -6), decimal("nW", -9)]
);
real!(
    SquareMillimetres,
    "an area",
    "3.95 mm2",
    NOT_NEGATIVE,
    &[decimal("mm2", 0), decimal("um2", -6)]
);
real!(Volts, "a voltage", "0.9 V", POSITIVE, &[decimal("V", 0), decimal("mV", -3)]);
real!(Nanometres, "a technology node", "28 nm", POSITIVE, &[decimal("nm", 0), decimal("um", 3)]);
