//! Every assumption with its knob: `arch-configs/assumptions.toml`.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::embedded::ASSUMPTIONS;

/// One assumption.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Assumption {
    /// What is assumed, in a few words; the whole text is in `docs/`.
    pub text: String,
    /// What varies it.
    #[serde(default)]
    pub knobs: Vec<Knob>,
    /// Why nothing does.
    pub none: Option<String>,
}

/// Keys that are varied together.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Knob {
    /// Which file has the keys.
    pub file: KnobFile,
    /// Dotted keys; `*` is any name.
    pub keys: Vec<String>,
    /// The value of all keys instead of half of what they have; `x 0.8`: so many times what each
    /// of them has.
    pub low: Option<String>,
    /// As `low`, instead of one and a half times what they have.
    pub high: Option<String>,
    /// The values that are tried instead of a lower and a higher one.
    pub values: Option<Vec<String>>,
    /// `--set` values of the machine without which the keys move nothing: what the knob is compared
    /// with has them too.
    #[serde(default)]
    pub with: Vec<String>,
    /// The machine that comes with the program and that the assumption is about, where it is about
    /// one.
    pub on: Option<String>,
    /// The technology node that `low` and `high` are numbers of, nanometres, where they are of one.
    pub node: Option<u32>,
}

/// What a side of a knob does to its keys.
#[derive(Debug, Clone, PartialEq)]
pub enum Turn {
    /// All of them get this value, as in a file.
    Set(String),
    /// Each gets so many times what it has.
    Times(f64),
}

impl Knob {
    /// What its two sides do; `None` where it has names.
    pub fn turns(&self) -> Option<[Turn; 2]> {
        let turn = |given: &Option<String>, usual| match given {
            None => Turn::Times(usual),
            Some(text) => match text.strip_prefix("x ").and_then(|factor| factor.parse().ok()) {
                Some(factor) => Turn::Times(factor),
                None => Turn::Set(text.clone()),
            },
        };
        let sides = [turn(&self.low, LOW), turn(&self.high, HIGH)];
        self.values.is_none().then_some(sides)
    }
}

/// Half.
const LOW: f64 = 0.5;
/// One and a half times.
const HIGH: f64 = 1.5;

/// A kind of configuration file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum KnobFile {
    /// The machine file.
    Machine,
    /// The machine's energy table.
    Energy,
    /// The machine's DRAM device.
    Dram,
}

impl KnobFile {
    /// All, a machine's own first.
    pub const ALL: [KnobFile; 3] = [KnobFile::Machine, KnobFile::Energy, KnobFile::Dram];

    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            KnobFile::Machine => "machine",
            KnobFile::Energy => "energy",
            KnobFile::Dram => "dram",
        }
    }
}

/// All assumptions by number.
pub fn assumptions() -> &'static BTreeMap<u32, Assumption> {
    static ALL: OnceLock<BTreeMap<u32, Assumption>> = OnceLock::new();
    ALL.get_or_init(|| {
        let read = super::parse::<BTreeMap<String, Assumption>>(ASSUMPTIONS, &[]);
        let all = read.unwrap_or_else(|e| panic!("arch-configs/assumptions.toml: {e}")).value;
        let number = |name: &str| name.strip_prefix('A').and_then(|n| n.parse().ok());
        let place = |(name, a): (String, Assumption)| {
            let number = number(&name);
            (number.unwrap_or_else(|| panic!("arch-configs/assumptions.toml: `{name}`")), a)
        };
        all.into_iter().map(place).collect()
    })
}
