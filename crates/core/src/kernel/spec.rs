//! The tables of memories: buffers on the chip, and the memory outside of it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use powergs_base::quantity::{Bytes, BytesPerSecond, Hertz, Nanoseconds};
use powergs_dram::Device;
use powergs_dram::device::Order;
use powergs_energy::action::Memory;

/// One on-chip buffer.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BufferSpec {
    /// Size of the whole buffer, divided evenly among the CCUs or cores that use it.
    pub capacity: Bytes,
    /// Bytes of one access of one bank.
    pub word: Bytes,
    /// Banks of the share of one CCU or core.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "banks"))]
    pub banks: u32,
    /// Accesses of one bank per cycle.
    pub ports: Ports,
}

/// Accesses of a bank per cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
pub enum Ports {
    /// One read or one write.
    #[serde(rename = "1rw")]
    ReadOrWrite,
    /// One read and one write.
    #[serde(rename = "1r1w")]
    ReadAndWrite,
}

/// How DRAM requests are timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DramModel {
    /// One server with a latency and a rate.
    Bandwidth,
    /// One server with rates, latencies and commands as a `banked` run of the frame has them: as
    /// fast, for sweeps.
    Calibrated,
    /// The device, with its banks, rows, queues and timings.
    Banked,
}

impl DramModel {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            DramModel::Bandwidth => "bandwidth",
            DramModel::Calibrated => "calibrated",
            DramModel::Banked => "banked",
        }
    }
}

/// What `dram.device` says where there is only a rate.
pub const NO_DEVICE: &str = "none";

impl DramSpec {
    /// Whether the machine file names a device.
    pub fn has_device(&self) -> bool {
        self.device != NO_DEVICE
    }

    /// The model that times its requests: with other masters `calibrated` is `banked`.
    pub fn timed(&self) -> DramModel {
        match self.model {
            DramModel::Calibrated if !self.is_alone() => DramModel::Banked,
            model => model,
        }
    }
}

/// The `[dram]` table: the `bandwidth` model, and the device of the others.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DramSpec {
    /// Timing model.
    #[schemars(extend("x-gone" = { "window": "calibrated" }))]
    pub model: DramModel,
    /// Peak rate of a memory without a device. With one, `device` and `channels` have their own:
    /// leave it out, or give the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bandwidth: Option<BytesPerSecond>,
    /// Fraction of the peak that transfers reach, 0 to 1.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "fraction"))]
    pub efficiency: f64,
    /// From request to first data.
    pub latency: Nanoseconds,
    /// Name of the device (`arch-configs/dram/NAME.toml`) or path of one: its peak rate with
    /// `channels`, and what the `calibrated` and `banked` models time; or `none`: a mere
    /// rate, `bandwidth`.
    pub device: String,
    /// Channels of that device in this machine.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "channels"))]
    pub channels: u32,
    /// Order of its address fields: `RoBaCoCh`, `mop`, `bg64`, or `fields` for the device's own.
    pub mapping: Order,
    /// Controller, PHY and interconnect of the `calibrated` and `banked` models, added to
    /// every read.
    pub controller_latency: Nanoseconds,
    /// Whose it is: who has its PHY and controllers, and pays while it stands by.
    #[serde(default)]
    pub owner: MemoryOwner,
    /// The part of its background and refresh that the machine pays, where others own it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0, "maximum" = 1, "x-unit" = "fraction"))]
    pub standby_share: Option<f64>,
    /// Another user of the memory.
    #[serde(default)]
    pub second_master: MasterSpec,
    /// A further one.
    #[serde(default)]
    pub third_master: MasterSpec,
    /// A further one.
    #[serde(default)]
    pub fourth_master: MasterSpec,
}

/// Who owns a memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MemoryOwner {
    /// The machine, alone.
    #[default]
    Chip,
    /// The chip around it, which would have it anyway: the machine has no PHY and no controllers.
    Shared,
}

/// The `[dram.second-master]` table and those of further ones: a GPU, a display or a camera that
/// takes its part of the memory all the time.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct MasterSpec {
    /// Bytes that it asks for in a second; without it, or with 0 B/s, there is none.
    pub rate: BytesPerSecond,
    /// Where its requests go.
    pub pattern: AccessOrder,
    /// Bytes of one request.
    pub request: Bytes,
    /// Share of its requests that read, 0 to 1; the others write.
    #[schemars(extend("minimum" = 0, "maximum" = 1, "x-unit" = "fraction of requests"))]
    pub reads: f64,
    /// Fraction of the peak that its transfers reach, 0 to 1, with the `bandwidth` model.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "fraction"))]
    pub efficiency: f64,
    /// Requests that it has under way at most, with the `banked` and `calibrated` models: further
    /// ones wait outside.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "requests"))]
    pub in_flight: u32,
    /// When its requests enter, of all that wait for the memory.
    pub priority: Priority,
    /// Bytes a second with which its requests enter before all others, whatever its priority.
    pub guaranteed: BytesPerSecond,
}

impl Default for MasterSpec {
    /// None; what there is where the file says only its rate (A18).
    fn default() -> MasterSpec {
        MasterSpec {
            rate: BytesPerSecond(0.0),
            pattern: AccessOrder::Stream,
            request: Bytes(64),
            reads: 1.0,
            efficiency: 0.9,
            in_flight: 64,
            priority: Priority::Equal,
            guaranteed: BytesPerSecond(0.0),
        }
    }
}

/// When requests of a master enter the memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Priority {
    /// Before those of the accelerator.
    First,
    /// By arrival, as they do.
    Equal,
    /// While the accelerator has none that wait.
    Last,
}

/// Where the requests of a master go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AccessOrder {
    /// One after the other.
    Stream,
    /// Anywhere.
    Random,
}

impl AccessOrder {
    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            AccessOrder::Stream => "stream",
            AccessOrder::Random => "random",
        }
    }
}

impl BufferSpec {
    /// How it is built for so many CCUs or cores: each has its own share, cut into `banks` banks
    /// (A13).
    pub fn shared(&self, owners: u32) -> Memory {
        Memory {
            bank: Bytes(self.capacity.0 / (u64::from(owners) * u64::from(self.banks)).max(1)),
            banks: owners.saturating_mul(self.banks),
            word: self.word,
            two_ports: self.ports == Ports::ReadAndWrite,
        }
    }
}

/// External memory as a frame meets it: its table, with what other files and the machine say of it.
#[derive(Debug, Clone, Copy)]
pub struct External<'a> {
    /// The table.
    pub spec: &'a DramSpec,
    /// The device; `None` where it has not been looked up, or there is only a rate.
    pub device: Option<&'a Device>,
    /// Peak rate.
    pub peak: BytesPerSecond,
    /// Clock of the units that ask.
    pub clock: Hertz,
}

impl<'a> External<'a> {
    /// The device that a model needs.
    ///
    /// # Panics
    /// When it was never looked up.
    pub(crate) fn timed_device(&self) -> &'a Device {
        self.device.expect("a machine is linked to its DRAM device")
    }

    /// Share of it that other masters take in the `bandwidth` model, 0 to 1.
    pub(crate) fn others_share(&self) -> f64 {
        self.spec.share(self.peak.0)
    }
}
