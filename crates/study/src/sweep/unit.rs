//! The unit of a column of results. Users' columns have it in their name as ours do
//! (`docs/sweep-file.md`), so a name says it: this is the one table of endings.

use super::measure::Measure;

/// What the numbers of a column count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Bytes.
    Bytes,
    /// 10⁹ bytes per second.
    GigabytesPerSecond,
    /// Megahertz.
    Megahertz,
    /// Hertz.
    Hertz,
    /// Nanoseconds.
    Nanoseconds,
    /// Microseconds.
    Microseconds,
    /// Milliseconds.
    Milliseconds,
    /// Seconds.
    Seconds,
    /// Picojoules.
    Picojoules,
    /// Nanojoules.
    Nanojoules,
    /// Microjoules.
    Microjoules,
    /// Millijoules.
    Millijoules,
    /// Picojoule-seconds.
    PicojouleSeconds,
    /// Milliwatts.
    Milliwatts,
    /// Watts.
    Watts,
    /// Square millimetres.
    SquareMillimetres,
    /// Nanometres.
    Nanometres,
    /// Frames per second.
    FramesPerSecond,
    /// Clock cycles.
    Cycles,
    /// A share, 0 to 1.
    Fraction,
}

/// Endings of a part of a name; the first that fits.
const ENDINGS: [(&str, Unit); 20] = [
    ("_pj_s", Unit::PicojouleSeconds),
    ("_bytes", Unit::Bytes),
    ("_gb_s", Unit::GigabytesPerSecond),
    ("_mhz", Unit::Megahertz),
    ("_hz", Unit::Hertz),
    ("_ns", Unit::Nanoseconds),
    ("_us", Unit::Microseconds),
    ("_ms", Unit::Milliseconds),
    ("_s", Unit::Seconds),
    ("_pj", Unit::Picojoules),
    ("_nj", Unit::Nanojoules),
    ("_uj", Unit::Microjoules),
    ("_mj", Unit::Millijoules),
    ("_mw", Unit::Milliwatts),
    ("_w", Unit::Watts),
    ("_mm2", Unit::SquareMillimetres),
    ("_nm", Unit::Nanometres),
    ("fps", Unit::FramesPerSecond),
    ("_cycles", Unit::Cycles),
    ("_frac", Unit::Fraction),
];

impl Unit {
    /// The unit that a column has in its name: `frame_time_ms.p99` is in milliseconds. Names of
    /// keys (`vru.units-per-core`, `energy:node`) have none.
    pub fn of_column(name: &str) -> Option<Unit> {
        if name.contains(['-', ':']) {
            return None;
        }
        let ending = |part: &str| {
            let found = ENDINGS.iter().find(|(ending, _)| part.ends_with(ending));
            found.map(|&(_, unit)| unit)
        };
        name.split('.').find_map(ending)
    }

    /// What it measures, and how many of it are in one of [`Measure`]; `None` for what no literal
    /// of an expression can be.
    pub(crate) const fn measure(self) -> Option<(Measure, f64)> {
        Some(match self {
            Unit::Bytes => (Measure::Size, 1.0),
            Unit::GigabytesPerSecond => (Measure::Bandwidth, 1e-9),
            Unit::Megahertz => (Measure::Frequency, 1e-6),
            Unit::Hertz => (Measure::Frequency, 1.0),
            Unit::Nanoseconds => (Measure::Time, 1e9),
            Unit::Microseconds => (Measure::Time, 1e6),
            Unit::Milliseconds => (Measure::Time, 1e3),
            Unit::Seconds => (Measure::Time, 1.0),
            Unit::Picojoules => (Measure::Energy, 1e12),
            Unit::Nanojoules => (Measure::Energy, 1e9),
            Unit::Microjoules => (Measure::Energy, 1e6),
            Unit::Millijoules => (Measure::Energy, 1e3),
            Unit::Milliwatts => (Measure::Power, 1e3),
            Unit::Watts => (Measure::Power, 1.0),
            Unit::SquareMillimetres => (Measure::Area, 1.0),
            Unit::Nanometres => (Measure::Node, 1.0),
            Unit::PicojouleSeconds | Unit::FramesPerSecond | Unit::Cycles | Unit::Fraction => {
                return None;
            }
        })
    }

    /// How much one of it is in the base unit of what it measures; `None` for what no literal of an
    /// expression can be.
    pub fn in_base(self) -> Option<f64> {
        self.measure().map(|(_, per_base)| 1.0 / per_base)
    }

    /// The name in the catalogue of statistics and metrics: `1` for plain shares.
    pub const fn name(self) -> &'static str {
        match self {
            Unit::Bytes => "B",
            Unit::GigabytesPerSecond => "GB/s",
            Unit::Megahertz => "MHz",
            Unit::Hertz => "Hz",
            Unit::Nanoseconds => "ns",
            Unit::Microseconds => "us",
            Unit::Milliseconds => "ms",
            Unit::Seconds => "s",
            Unit::Picojoules => "pJ",
            Unit::Nanojoules => "nJ",
            Unit::Microjoules => "uJ",
            Unit::Millijoules => "mJ",
            Unit::PicojouleSeconds => "pJ s",
            Unit::Milliwatts => "mW",
            Unit::Watts => "W",
            Unit::SquareMillimetres => "mm2",
            Unit::Nanometres => "nm",
            Unit::FramesPerSecond => "1/s",
            Unit::Cycles => "cycles",
            Unit::Fraction => "1",
        }
    }
}
