//! The tables of an energy table's file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::node;
use crate::supply::Curve;
use powergs_base::number::NumberFormat;
use powergs_base::quantity::{
    Hertz, Nanometres, Picojoules, PicojoulesPerByte, SquareMillimetres, Volts, Watts,
};

/// The price of one action: exactly one of `energy`, `flops` and `free`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ActionPrice {
    /// Energy of one action.
    pub energy: Option<Picojoules>,
    /// Floating-point operations of one action, each at the price of `flop`.
    #[schemars(range(min = 1, max = 1000000), extend("x-unit" = "FLOPs"))]
    pub flops: Option<u32>,
    /// Costs nothing, on purpose.
    #[serde(default, skip_serializing_if = "is_false")]
    pub free: bool,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// What areas and powers of a table are of: numbers of blocks and of whole modules stand side by
/// side, and are not the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PriceScope {
    /// What the area is of.
    pub area: AreaScope,
    /// What the power is of.
    pub power: PowerScope,
}

/// What an area is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AreaScope {
    /// The units that render, their buffers, and the chip's side of the memory.
    Block,
    /// A die that does little else: that of a GPU.
    Die,
    /// A die with processors, codecs and all else that a module needs.
    Soc,
}

impl AreaScope {
    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            AreaScope::Block => "block",
            AreaScope::Die => "die",
            AreaScope::Soc => "soc",
        }
    }
}

/// What a power is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PowerScope {
    /// The block that renders, and the memory.
    BlockAndMemory,
    /// A module: processors, memory and converters of voltages too.
    Module,
    /// A graphics card.
    Board,
}

impl PowerScope {
    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            PowerScope::BlockAndMemory => "block-and-memory",
            PowerScope::Module => "module",
            PowerScope::Board => "board",
        }
    }
}

/// The price of moving one byte.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BytePrice {
    /// Energy of one byte.
    pub energy: PicojoulesPerByte,
    /// Costs nothing, on purpose: `energy` is then zero.
    #[serde(default, skip_serializing_if = "is_false")]
    pub free: bool,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// Power that is paid for time.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PowerPrice {
    /// Power, all the time.
    pub power: Watts,
    /// Costs nothing, on purpose: `power` is then zero.
    #[serde(default, skip_serializing_if = "is_false")]
    pub free: bool,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// Area of one thing.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct AreaPrice {
    /// Area.
    pub area: SquareMillimetres,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// Whether a flag is left out of a file.
pub(super) fn is_false(flag: &bool) -> bool {
    !flag
}

/// The price of a cycle.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CyclePrice {
    /// Energy of one cycle.
    pub energy: Picojoules,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// The `[numbers]` table: what the numbers of a rendering unit do to its prices.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct UnitNumbers {
    /// Formats that there are prices for. A machine without `record.numbers` has the units of the
    /// table as they are.
    pub formats: Vec<FormatFactors>,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// Factors of a number format on the prices of a rendering unit.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FormatFactors {
    /// The format.
    pub numbers: NumberFormat,
    /// On the energy of its actions.
    #[schemars(range(min = 0.01, max = 100.0), extend("x-unit" = "factor"))]
    pub energy: f64,
    /// On what it takes in every cycle: in a table with `[clock]`.
    #[schemars(range(min = 0.01, max = 100.0), extend("x-unit" = "factor"))]
    pub clock: Option<f64>,
    /// On its leakage.
    #[schemars(range(min = 0.01, max = 100.0), extend("x-unit" = "factor"))]
    pub leakage: f64,
    /// On its area.
    #[schemars(range(min = 0.01, max = 100.0), extend("x-unit" = "factor"))]
    pub area: f64,
}

/// The `[dram]` table: `flat`, `device` or both.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DramPrices {
    /// One price per byte, and powers of the whole memory. With `device = true` it is the price
    /// of a memory without a device: `dram.device = "none"` in the machine.
    pub flat: Option<FlatDram>,
    /// The machine's DRAM device at the prices of that device's file: of its commands, or, where
    /// `dram.model = "bandwidth"` of the machine counts none, of its bytes with `row-hits`.
    #[serde(default, skip_serializing_if = "is_false")]
    pub device: bool,
    /// How often a row is opened where no commands are counted. 0.75 without the table.
    pub row_hits: Option<RowHitShare>,
}

/// The `[dram.row-hits]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RowHitShare {
    /// Share of the bursts that find their row open, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "fraction"))]
    pub share: f64,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

impl DramPrices {
    /// Share of row hits in a table that does not say it (A150).
    const ROW_HITS: f64 = 0.75;

    /// Share of the bursts that find their row open where no commands are counted.
    pub fn row_hits(&self) -> f64 {
        self.row_hits.as_ref().map_or(DramPrices::ROW_HITS, |hits| hits.share)
    }
}

/// The `[dram.flat]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FlatDram {
    /// One byte read.
    pub read: BytePrice,
    /// One byte written.
    pub write: BytePrice,
    /// Standby of the whole memory.
    pub background: PowerPrice,
    /// Refresh of the whole memory.
    pub refresh: PowerPrice,
    /// Channels that `background` and `refresh` are for: a machine with another number in
    /// `dram.channels` has them in proportion. Needed in a file.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "channels"))]
    pub channels: Option<u32>,
}

/// The `[phy]` table: what serves one memory channel on the chip. It is no part of the core, whose
/// area papers print.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PhyPrices {
    /// Drivers, receivers and delay lines of one channel.
    pub area: AreaPrice,
    /// Standby of one channel.
    pub standby: PowerPrice,
    /// The controller of one channel.
    pub controller: AreaPrice,
}

/// The `[supply]` table: the clock that the prices are for, and, where they are known, the voltage
/// of that clock and how fast the gates are at others.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SupplyPrices {
    /// Clock that the prices are for: units reach it at `voltage`.
    pub clock: Hertz,
    /// Voltage that the prices are for. Needed where there is a curve.
    pub voltage: Option<Volts>,
    /// Key of `references.toml` or assumption number.
    pub source: String,
    /// How fast the gates are at other voltages. Without it prices are as given at any clock, and
    /// reports say so where the machine has another one than `clock`.
    pub curve: Option<CurveChoice>,
}

/// The `[idle]` table: what stays between frames, when nothing runs. Without it everything does.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct IdlePrices {
    /// Share of the leakage of units and buffers; of what `gating.residual` of a machine leaves.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "fraction"))]
    pub leakage: f64,
    /// Share of the background power of the memory and of the standby of the PHY.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "fraction"))]
    pub background: f64,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// A voltage-frequency curve: `node` of `nodes.toml`, or all the other keys.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CurveChoice {
    /// The curve of this node in `nodes.toml`.
    pub node: Option<Nanometres>,
    /// Effective threshold.
    pub threshold: Option<Volts>,
    /// Exponent of the overdrive.
    #[schemars(range(min = 1.0, max = 3.0), extend("x-unit" = "exponent"))]
    pub exponent: Option<f64>,
    /// Voltage that makes the leakage current e times as large.
    pub leakage_slope: Option<Volts>,
    /// Lowest voltage.
    pub lowest: Option<Volts>,
    /// Highest voltage.
    pub highest: Option<Volts>,
    /// Key of `references.toml` or assumption number; a curve of `nodes.toml` brings its own.
    pub source: Option<String>,
}

impl CurveChoice {
    /// The curve.
    ///
    /// # Errors
    /// What is missing or wrong, in one line.
    pub fn curve(&self) -> Result<Curve, String> {
        let own = (|| {
            Some(Curve {
                threshold: self.threshold?,
                exponent: self.exponent?,
                leakage_slope: self.leakage_slope?,
                lowest: self.lowest?,
                highest: self.highest?,
            })
        })();
        let curve = match (self.node, own) {
            (Some(node), None) => node::curve(node)?,
            (None, Some(own)) => own,
            _ => {
                return Err("needs either `node`, or `threshold`, `exponent`, `leakage-slope`, \
                            `lowest`, `highest` and `source`"
                    .into());
            }
        };
        curve.problem().map_or(Ok(curve), Err)
    }
}

/// A factor on an area, or on an area and a leakage.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Overhead {
    /// Factor, 1 for none.
    #[schemars(range(min = 0.1, max = 100.0), extend("x-unit" = "factor"))]
    pub factor: f64,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// Area of interconnect and control.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RestArea {
    /// Share of the area of units and buffers.
    #[schemars(range(min = 0.0, max = 100.0), extend("x-unit" = "fraction"))]
    pub share: f64,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// The `[scaling]` table: the prices of the file are for another node, and become those of `node`.
/// DRAM prices are not scaled: the memory is another chip.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Scaling {
    /// The node that the prices of the file are for.
    pub from: Nanometres,
    /// On the energy of actions.
    pub energy: Factor,
    /// On the leakage of units; a fit gives its energy factor, as if the share of leakage stayed.
    pub leakage: Factor,
    /// On the area of units.
    pub area: Factor,
    /// On the energy of buffer accesses.
    pub sram_energy: Factor,
    /// On the leakage of buffers.
    pub sram_leakage: Factor,
    /// On the area of buffers.
    pub sram_area: Factor,
}

/// A factor between two nodes: exactly one of `fit` and `factor`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Factor {
    /// Name of a fit of `nodes.toml`: `stillmaker`, `deepscaletool`.
    pub fit: Option<String>,
    /// The factor itself, with its source.
    #[schemars(range(min = 0.0001, max = 10000.0), extend("x-unit" = "factor"))]
    pub factor: Option<f64>,
    /// Key of `references.toml` or assumption number; a fit brings its own.
    pub source: Option<String>,
}
