//! A memory device and its controller, as in `arch-configs/dram/*.toml`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use powergs_base::config::embedded::DRAM;
use powergs_base::config::{self, ConfigError, layer};
use powergs_base::quantity::{Bytes, Nanoseconds};

mod check;
mod prices;

pub use prices::{ActionPrices, Background, Energy, FlatPrice, Price, StandingPrice};

/// A DRAM device with its controller and the front end before it.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Device {
    /// Name in reports.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// Period of the command clock CK; all timings count in it.
    pub clock_period: Nanoseconds,
    /// Channels, banks, rows.
    pub organisation: Organisation,
    /// Which address bits select what.
    pub mapping: Mapping,
    /// Least CK from the start of one command to the start of another.
    pub timing: Timing,
    /// How long commands occupy the command bus.
    pub commands: Commands,
    /// Activations in two commands (LPDDR5); absent: one command.
    pub split_activate: Option<SplitActivate>,
    /// A data clock that stops and must be synchronised (WCK of LPDDR5); absent: always on.
    pub clock_sync: Option<ClockSync>,
    /// Queues and policies.
    pub controller: Controller,
    /// What may be on the way between the requesters and the controllers.
    pub front_end: FrontEnd,
    /// Prices.
    pub energy: Energy,
}

/// Channels, banks, rows.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Organisation {
    /// Channels, each with its own command bus and controller.
    #[schemars(extend("minimum" = 1, "maximum" = 64, "x-unit" = "channels"))]
    pub channels: u32,
    /// Parts of a channel with their own data bus and activation limits that share the command bus
    /// and the queues (HBM2: 2).
    #[schemars(extend("minimum" = 1, "maximum" = 4, "x-unit" = "pseudo channels per channel"))]
    pub pseudo_channels: u32,
    /// Bank groups of a pseudo channel; columns of one group are further apart.
    #[schemars(extend("minimum" = 1, "maximum" = 16, "x-unit" = "groups per pseudo channel"))]
    pub bank_groups: u32,
    /// Banks of a group.
    #[schemars(extend("minimum" = 1, "maximum" = 64, "x-unit" = "banks per group"))]
    pub banks: u32,
    /// Rows of a bank. Addresses beyond the capacity wrap.
    #[schemars(extend("minimum" = 1, "maximum" = 16_777_216, "x-unit" = "rows per bank"))]
    pub rows: u32,
    /// Bytes of one row (page) of one bank.
    pub row: Bytes,
    /// Data pins of a pseudo channel.
    #[schemars(extend("minimum" = 1, "maximum" = 1024, "x-unit" = "pins"))]
    pub width: u32,
    /// Transfers on each data pin in one burst. `width` x `beats` bits may be more than `burst`
    /// holds: LPDDR6 moves 32 B of data and 4 B of metadata in 24 beats on 12 pins.
    #[schemars(extend("minimum" = 1, "maximum" = 256, "x-unit" = "beats"))]
    pub beats: u32,
    /// Bytes of data that one read or write command moves.
    pub burst: Bytes,
}

/// Which address bits select what.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Mapping {
    /// Order of the fields.
    pub order: Order,
    /// Consecutive bytes in one channel; not used by `fields`.
    pub interleave: Bytes,
    /// With `order = "fields"`: fields with their bits from the lowest above the burst to the
    /// highest, e.g. `"column:1"`, `"channel:2"`, `"bank-group:2"`, `"row:15"`.
    pub fields: Option<Vec<String>>,
}

/// Order of the address fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
pub enum Order {
    /// Channel, column, pseudo channel, bank group, bank, row from the bottom.
    RoBaCoCh,
    /// Two column bits, pseudo channel, bank group, bank, column, row from the bottom; all above
    /// the column exclusive-or'ed with it.
    #[serde(rename = "mop")]
    Mop,
    /// 64-byte blocks go round pseudo channels and bank groups and stay in one row.
    #[serde(rename = "bg64")]
    Bg64,
    /// As listed in `mapping.fields`.
    #[serde(rename = "fields")]
    Fields,
}

/// Least CK from the start of one command to the start of another.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Timing {
    /// CK for which one burst holds the data bus.
    #[schemars(extend("minimum" = 1, "maximum" = 1024, "x-unit" = "CK"))]
    pub burst: u32,
    /// Read or write to the next of the same kind, another bank group.
    #[schemars(extend("minimum" = 1, "maximum" = 1024, "x-unit" = "CK"))]
    pub column_short: u32,
    /// The same in one bank group.
    #[schemars(extend("minimum" = 1, "maximum" = 1024, "x-unit" = "CK"))]
    pub column_long: u32,
    /// Read to the end of its data.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub read_data: u32,
    /// Read to write.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub read_to_write: u32,
    /// Write to read, another bank group.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub write_to_read_short: u32,
    /// Write to read, one bank group.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub write_to_read_long: u32,
    /// Activate to read of the row.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub activate_to_read: u32,
    /// Activate to write of the row.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub activate_to_write: u32,
    /// Activate to precharge of the bank.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub activate_to_precharge: u32,
    /// Activate to activate of one bank.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub activate_to_activate: u32,
    /// Activate to activate of banks of different groups.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub activate_short: u32,
    /// Activate to activate of banks of one group.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub activate_long: u32,
    /// A pseudo channel activates at most four rows in this time.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub four_activates: u32,
    /// Read to precharge of the bank.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub read_to_precharge: u32,
    /// Write to precharge of the bank.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub write_to_precharge: u32,
    /// Precharge to activate of the bank.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub precharge_to_activate: u32,
    /// Precharge to precharge of one pseudo channel.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub precharge_to_precharge: u32,
    /// Precharge of all banks to refresh.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub precharge_all_to_refresh: u32,
    /// Mean time between refreshes of a pseudo channel; a bank-wise refresh comes once in this
    /// time to each bank.
    #[schemars(extend("minimum" = 64, "maximum" = 1_048_576, "x-unit" = "CK"))]
    pub refresh_interval: u32,
    /// Refresh of all banks to activate.
    #[schemars(extend("minimum" = 1, "maximum" = 65_536, "x-unit" = "CK"))]
    pub refresh_all_to_activate: u32,
    /// Refresh of one bank to activate of it.
    #[schemars(extend("minimum" = 1, "maximum" = 65_536, "x-unit" = "CK"))]
    pub refresh_bank_to_activate: u32,
}

/// How long commands occupy the command bus.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Commands {
    /// An activate; its first half if activates are split.
    #[schemars(extend("minimum" = 1, "maximum" = 64, "x-unit" = "CK"))]
    pub activate: u32,
    /// A read or a write.
    #[schemars(extend("minimum" = 1, "maximum" = 64, "x-unit" = "CK"))]
    pub column: u32,
    /// A precharge or a refresh.
    #[schemars(extend("minimum" = 1, "maximum" = 64, "x-unit" = "CK"))]
    pub precharge: u32,
    /// Whether reads and writes have a bus of their own (HBM).
    pub column_bus: bool,
}

/// Activations in two commands.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SplitActivate {
    /// The second half follows within this time; it takes the first slot that nobody else wants.
    #[schemars(extend("minimum" = 1, "maximum" = 64, "x-unit" = "CK"))]
    pub second_within: u32,
}

/// A data clock that stops after the last transfer.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ClockSync {
    /// From a read to the stop of the clock; a later one needs a synchronising command before it.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub after_read: u32,
    /// The same from a write.
    #[schemars(extend("minimum" = 1, "maximum" = 4096, "x-unit" = "CK"))]
    pub after_write: u32,
}

/// Queues and policies of the controller of one channel.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Controller {
    /// Which command goes first.
    pub scheduler: Scheduler,
    /// When rows are closed.
    pub page: Page,
    /// How the device is refreshed.
    pub refresh: Refresh,
    /// Bursts that may wait for a read command.
    #[schemars(extend("minimum" = 1, "maximum" = 1024, "x-unit" = "bursts per channel"))]
    pub read_queue: u32,
    /// Bursts that may wait for a write command.
    #[schemars(extend("minimum" = 1, "maximum" = 1024, "x-unit" = "bursts per channel"))]
    pub write_queue: u32,
    /// Writes begin when more than this part of the write queue is full, or no read waits.
    #[schemars(extend("minimum" = 0, "maximum" = 1, "x-unit" = "fraction of the write queue"))]
    pub write_high: f64,
    /// Writes end when less than this part of it is full and a read waits.
    #[schemars(extend("minimum" = 0, "maximum" = 1, "x-unit" = "fraction of the write queue"))]
    pub write_low: f64,
    /// Writes begin too when some wait and none went for this long, and go on until all that waited
    /// then have gone; `0 ns`: they wait for as long as reads go on.
    #[serde(default = "no_limit")]
    pub write_wait: Nanoseconds,
    /// Added to every read: controller, PHY and interconnect.
    pub latency: Nanoseconds,
}

/// The limit of files that have none.
const fn no_limit() -> Nanoseconds {
    Nanoseconds(0.0)
}

/// Which command goes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheduler {
    /// The oldest that can go; no row is closed while an older request to it waits.
    FrFcfsRowHit,
    /// The oldest that can go.
    FrFcfs,
    /// The oldest request only.
    Fcfs,
}

/// When rows are closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Page {
    /// When another row of the bank is wanted, or at a refresh.
    Open,
    /// With the last waiting access to the row (auto-precharge).
    Closed,
}

/// How the device is refreshed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Refresh {
    /// Not at all: a limit study.
    None,
    /// All banks of a pseudo channel at once.
    AllBank,
    /// One bank after the other.
    PerBank,
}

/// What may be on the way between the requesters and the controllers.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FrontEnd {
    /// Bursts run ahead of the oldest one that no controller has accepted by less than this.
    pub window: Bytes,
    /// Read requests that may be in flight; 0: no limit.
    #[schemars(extend("minimum" = 0, "maximum" = 1_048_576, "x-unit" = "requests"))]
    pub reads_in_flight: u32,
    /// Bursts that a controller accepts in one CK.
    #[schemars(extend("minimum" = 1, "maximum" = 64, "x-unit" = "bursts per CK and channel"))]
    pub acceptances: u32,
}

impl Device {
    /// Reads and checks a device file.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line.
    pub fn parse(text: &str) -> Result<Device, ConfigError> {
        Device::parse_with(text, &[])
    }

    /// The same with `key=value` overlays.
    ///
    /// # Errors
    /// As [`Device::parse`].
    pub fn parse_with(text: &str, sets: &[String]) -> Result<Device, ConfigError> {
        let text = &layer::on_embedded(text, DRAM)?;
        let config = config::parse::<Device>(text, sets)?;
        let found = check::problems(&config.value);
        let problems = found.into_iter().map(|(key, message)| config.problem(key, message));
        let problems = problems.collect();
        config.checked(problems)
    }

    /// The same device with another named order of address fields.
    ///
    /// # Errors
    /// Why the order does not fit the device.
    pub fn with_order(mut self, order: Order) -> Result<Device, String> {
        self.mapping.order = order;
        self.mapping.fields = None;
        crate::mapping::layout(&self).map(|_| self)
    }

    /// Every key with its value.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a device has only keys that TOML can say")
    }

    /// Peak rate of all data buses, bytes per nanosecond, which is GB/s.
    pub fn peak_gb_s(&self) -> f64 {
        let o = &self.organisation;
        let buses = f64::from(o.channels) * f64::from(o.pseudo_channels);
        buses * o.burst.0 as f64 / (f64::from(self.timing.burst) * self.clock_period.0)
    }

    /// Bytes of all channels; addresses beyond them wrap.
    pub fn capacity(&self) -> u64 {
        let o = &self.organisation;
        let banks = [o.channels, o.pseudo_channels, o.bank_groups, o.banks, o.rows];
        banks.into_iter().fold(o.row.0, |bytes, n| bytes.saturating_mul(u64::from(n)))
    }

    /// Rate of one data pin, 10⁹ bits per second: all beats of a burst, also those that carry no
    /// data.
    pub fn pin_gbit_s(&self) -> f64 {
        f64::from(self.organisation.beats) / (f64::from(self.timing.burst) * self.clock_period.0)
    }

    /// A time in CK, rounded to the nearest.
    pub fn ck(&self, time: Nanoseconds) -> u64 {
        (time.0 / self.clock_period.0).round() as u64
    }

    /// CK as nanoseconds.
    pub fn ns(&self, ck: u64) -> f64 {
        ck as f64 * self.clock_period.0
    }
}
