//! What the numbers of a side are of: the task, the memory, who pays for it, the technology, the
//! scope. Where sides differ in it, differences are not of the machines alone.

use powergs_core::flow::Task;
use toml::Value;

use super::Side;
use super::side::configured;

/// A part of the basis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// What a frame is.
    Task,
    /// The memory: its device and channels, or a mere rate.
    Memory,
    /// How it is timed.
    MemoryModel,
    /// What its prices rest on.
    MemoryPrice,
    /// Whether the chip has PHY and controllers of the memory.
    Phy,
    /// Who else uses the memory, and how.
    SecondMaster,
    /// The technology.
    Node,
    /// The clock of the prices, where they are as given at any other.
    PriceClock,
    /// What areas are of.
    AreaScope,
    /// What powers are of.
    PowerScope,
}

impl Basis {
    /// All of it, in the order of reports.
    pub const ALL: [Basis; 10] = [
        Basis::Task,
        Basis::Memory,
        Basis::MemoryModel,
        Basis::MemoryPrice,
        Basis::Phy,
        Basis::SecondMaster,
        Basis::Node,
        Basis::PriceClock,
        Basis::AreaScope,
        Basis::PowerScope,
    ];

    /// The name in JSON: snake_case.
    pub const fn name(self) -> &'static str {
        match self {
            Basis::Task => "task",
            Basis::Memory => "memory",
            Basis::MemoryModel => "memory_model",
            Basis::MemoryPrice => "memory_price",
            Basis::Phy => "memory_phy",
            Basis::SecondMaster => "second_master",
            Basis::Node => "node",
            Basis::PriceClock => "price_clock",
            Basis::AreaScope => "area_scope",
            Basis::PowerScope => "power_scope",
        }
    }

    /// What it is of a side, in words; `None` where its record does not say.
    pub fn of(self, side: &Side) -> Option<String> {
        let at = |path: &[&str]| configured(&side.record, path);
        let text = |path: &[&str]| at(path).and_then(Value::as_str).map(str::to_owned);
        match self {
            Basis::Task => Some(side.task.name()),
            Basis::Memory => {
                let peak = side.dram_peak_gb_s.map(|peak| format!("{peak:.1} GB/s"))?;
                let device = text(&["machine", "dram", "device"]).filter(|name| name != "none");
                let channels = at(&["machine", "dram", "channels"]).and_then(Value::as_integer);
                Some(match (device, channels) {
                    (Some(device), Some(n)) => format!("{device} x {n}, {peak}"),
                    _ => format!("a rate of {peak}"),
                })
            }
            Basis::MemoryModel => Some(side.dram_model.clone()).filter(|name| !name.is_empty()),
            Basis::MemoryPrice => {
                Some(side.dram_prices.join(" and ")).filter(|prices| !prices.is_empty())
            }
            Basis::Phy => {
                at(&["energy"])?;
                let has = at(&["energy", "phy"]).is_some();
                Some(if has { "of the chip" } else { "left out" }.to_owned())
            }
            Basis::SecondMaster => {
                at(&["machine", "dram"])?;
                let master = ["machine", "dram", "second-master"];
                let own = |key| text(&[&master[..], &[key]].concat());
                let number = |key| at(&[&master[..], &[key]].concat()).map(Value::to_string);
                let Some(rate) = own("rate").filter(|rate| !rate.starts_with("0 ")) else {
                    return Some("none".to_owned());
                };
                let facts = [
                    Some(rate),
                    own("pattern"),
                    number("reads").map(|share| format!("reads {share}")),
                    own("request").map(|bytes| format!("of {bytes}")),
                    number("in-flight").map(|n| format!("{n} in flight")),
                ];
                Some(facts.into_iter().flatten().collect::<Vec<_>>().join(", "))
            }
            Basis::Node => side.node_nm.map(|nm| format!("{nm} nm")),
            Basis::PriceClock => side.off_clock.map(|clocks| clocks.prices.to_string()),
            Basis::AreaScope => {
                at(&["energy"])?;
                Some(text(&["energy", "scope", "area"]).unwrap_or_else(|| "block".into()))
            }
            Basis::PowerScope => {
                at(&["energy"])?;
                Some(side.power_scope.clone())
            }
        }
    }
}

/// The task that a record tells of. Records of before know no other than rendering.
pub(super) fn task(facts: Option<&toml::Table>) -> Task {
    let name = facts.and_then(|facts| facts.get("task")).and_then(Value::as_str);
    name.and_then(Task::named).unwrap_or(Task::RENDER)
}
