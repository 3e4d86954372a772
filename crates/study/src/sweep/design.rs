//! One machine of a sweep with everything that a simulation and a price need.

use std::sync::Arc;

use toml::Value;
use xxhash_rust::xxh3::Xxh3;

use super::library::LibraryDocument;
use powergs_core::machine::Machine;
use powergs_core::sim::cost::untimed;
use powergs_core::stage::EnergyTable;
use powergs_dram::Device;
use powergs_energy::Prices;
use powergs_frame::display::Display;

/// A design: a machine that fits together, with its prices.
#[derive(Debug, Clone)]
pub struct Design {
    /// Number of its point.
    pub index: u64,
    /// The machine, linked to its DRAM device.
    pub machine: Machine,
    /// One for every energy table of the sweep, in its order; at least one has prices.
    pub prices: Vec<DesignPriced>,
    /// The DRAM device as it is in a file, before the machine's own channels and mapping; `None`
    /// where the machine has a mere rate.
    pub device: Option<Arc<LibraryDocument<Device>>>,
    /// The display, where the sweep has one.
    pub display: Option<Arc<LibraryDocument<Display>>>,
    /// Frames per second that the display shows.
    pub display_fps: f64,
    /// The columns of the sweep: keys of axes and derived keys with their values, axes of variants
    /// with their names.
    pub settings: Vec<DesignSetting>,
    /// Hash of everything that decides timing. Designs that agree in it have the same cycles and
    /// action counts on the same frame.
    pub timing_id: u128,
    /// Hash of everything that decides any result: timing, prices, display.
    pub id: u128,
}

/// The prices of one energy table.
#[derive(Debug, Clone)]
pub struct DesignPriced {
    /// Label of the table in the sweep; its name where the machine names it.
    pub label: String,
    /// The table.
    pub table: Arc<LibraryDocument<EnergyTable>>,
    /// What it says of this machine; `Err` where it has no price for a part of it, with which.
    pub prices: Result<Prices, String>,
}

/// A column of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignSetting {
    /// A key, or the name of an axis of variants.
    pub name: String,
    /// Its value as in a file; the name of a variant, or `-` where an axis of variants does not
    /// count.
    pub value: Value,
}

/// Why a point is no design.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Rejected {
    /// An axis does not count here, and this is not its first value: the same as another point.
    #[error("the same as point {canonical}: axis `{axis}` does not count here")]
    Duplicate {
        /// The axis.
        axis: String,
        /// The point that stands for all of them.
        canonical: u64,
    },
    /// A constraint does not hold.
    #[error("`{text}` does not hold")]
    Constraint {
        /// Place in the list of constraints, from 0.
        number: usize,
        /// The constraint.
        text: String,
    },
    /// A derived key cannot have the value that came out.
    #[error("derived `{key}`: {message}")]
    Derived {
        /// The key.
        key: String,
        /// What is wrong.
        message: String,
    },
    /// An expression has no value.
    #[error("{place}: {message}")]
    Expression {
        /// Place in the sweep file: `constraints.2`.
        place: String,
        /// What is wrong, with the column.
        message: String,
    },
    /// The keys do not fit together, or a file is missing.
    #[error("{0}")]
    Machine(String),
    /// A table has no price for it.
    #[error("with energy table `{label}`: {message}")]
    Price {
        /// Label of the table.
        label: String,
        /// What is wrong.
        message: String,
    },
}

impl Rejected {
    /// What many points have in common that are no designs: the constraint, the key, the kind of
    /// contradiction; without their numbers.
    pub fn cause(&self) -> String {
        match self {
            Rejected::Duplicate { axis, .. } => format!("axis `{axis}` does not count there"),
            Rejected::Constraint { text, .. } => format!("constraint `{text}`"),
            Rejected::Derived { key, .. } => format!("derived `{key}` has no such value"),
            Rejected::Expression { place, .. } => format!("`{place}` has no value"),
            Rejected::Machine(message) => {
                let key = message.split('`').nth(1).unwrap_or("machine");
                format!("`{key}`")
            }
            Rejected::Price { label, .. } => format!("no price in energy table `{label}`"),
        }
    }
}

impl Design {
    /// The machine as a file: every key, no comments. Keys of other files that the sweep changes
    /// are in [`Design::files`].
    pub fn resolved_machine_toml(&self) -> String {
        self.machine.to_toml()
    }

    /// Every file of the design but the machine as TOML text: what it is (`energy LABEL`, `dram`,
    /// `display`) and its text.
    pub fn files(&self) -> Vec<(String, String)> {
        let tables = self.prices.iter();
        let mut files: Vec<(String, String)> =
            tables.map(|p| (format!("energy {}", p.label), p.table.table.to_string())).collect();
        files.extend(self.device.iter().map(|d| ("dram".to_owned(), d.table.to_string())));
        files.extend(self.display.iter().map(|d| ("display".to_owned(), d.table.to_string())));
        files
    }

    /// The value of a column.
    pub fn setting(&self, name: &str) -> Option<&Value> {
        self.settings.iter().find(|s| s.name == name).map(|s| &s.value)
    }
}

/// Hash of what decides any result.
pub(super) fn full_id(
    timing: u128,
    machine: &Machine,
    prices: &[DesignPriced],
    display: Option<(u128, f64)>,
) -> u128 {
    let mut hash = Xxh3::new();
    hash.update(&timing.to_le_bytes());
    untimed(machine).iter().for_each(|x| hash.update(&x.to_le_bytes()));
    for priced in prices {
        hash.update(priced.label.as_bytes());
        hash.update(&priced.table.id.to_le_bytes());
    }
    if let Some((id, fps)) = display {
        hash.update(&id.to_le_bytes());
        hash.update(&fps.to_le_bytes());
    }
    hash.digest128()
}
