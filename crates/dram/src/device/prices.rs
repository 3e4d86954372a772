//! Prices of a device: a flat price per byte, or one per command and standing powers.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use powergs_base::quantity::{Nanoseconds, Picojoules, PicojoulesPerByte, Watts};

/// Prices of a device: exactly one of `flat` and `actions`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Energy {
    /// Factor on every price: which reading of the published currents is meant.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1000, "x-unit" = "factor"))]
    pub scale: f64,
    /// Key of `references.toml` or assumption number that justifies `scale`.
    pub scale_source: String,
    /// One price per requested byte and nothing else.
    pub flat: Option<FlatPrice>,
    /// A price per command, and standing powers.
    pub actions: Option<ActionPrices>,
}

/// A price per requested byte.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FlatPrice {
    /// Energy of a byte, read or written.
    pub energy: PicojoulesPerByte,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// A price with its source.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Price {
    /// Energy of one.
    pub energy: Picojoules,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// A power with its source.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct StandingPrice {
    /// Power of one channel.
    pub power: Watts,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// A price per command, and standing powers.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ActionPrices {
    /// One activate with its precharge.
    pub activate: Price,
    /// One read burst: array and data path.
    pub read: Price,
    /// One read burst: drivers of the data pins.
    pub read_io: Price,
    /// One write burst: array and data path.
    pub write: Price,
    /// One write burst: drivers and termination of the data pins.
    pub write_io: Price,
    /// One refresh of all banks of a pseudo channel; a refresh of one bank costs its share.
    pub refresh: Price,
    /// Standing powers of a channel.
    pub background: Background,
}

/// Standing powers of a channel by its state.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Background {
    /// A row is open.
    pub active: StandingPrice,
    /// All rows are closed.
    pub precharged: StandingPrice,
    /// Power-down, after nothing waited for `power-down-after`.
    pub power_down: StandingPrice,
    /// Self-refresh, after nothing waited for `self-refresh-after`; refreshes are then included.
    pub self_refresh: StandingPrice,
    /// Time without requests until a channel powers down; costs no time to leave.
    pub power_down_after: Nanoseconds,
    /// Time without requests until a channel refreshes itself; costs no time to leave.
    pub self_refresh_after: Nanoseconds,
}

impl ActionPrices {
    /// The priced commands with their keys.
    pub(crate) fn commands(&self) -> [(&'static str, &Price); 6] {
        [
            ("activate", &self.activate),
            ("read", &self.read),
            ("read-io", &self.read_io),
            ("write", &self.write),
            ("write-io", &self.write_io),
            ("refresh", &self.refresh),
        ]
    }
}

impl Background {
    /// The priced states with their keys.
    pub(crate) fn states(&self) -> [(&'static str, &StandingPrice); 4] {
        [
            ("active", &self.active),
            ("precharged", &self.precharged),
            ("power-down", &self.power_down),
            ("self-refresh", &self.self_refresh),
        ]
    }
}
