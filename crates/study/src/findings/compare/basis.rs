//! What the numbers of a side are of: the task, the memory, who pays for it, the technology, the
//! scope. Where sides differ in it, differences are not of the machines alone.

use powergs_core::flow::Task;
use powergs_core::machine::MASTERS;
use toml::Value;

use super::Side;
use super::side::configured;

/// A part of the basis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// What a frame is.
    Task,
    /// What a step of training counts with, and what its loss costs.
    Step,
    /// The memory: its device and channels, or a mere rate.
    Memory,
    /// How it is timed.
    MemoryModel,
    /// What its prices rest on.
    MemoryPrice,
    /// Whether the chip has PHY and controllers of the memory.
    Phy,
    /// Who else uses the memory, and how.
    Masters,
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
    pub const ALL: [Basis; 11] = [
        Basis::Task,
        Basis::Step,
        Basis::Memory,
        Basis::MemoryModel,
        Basis::MemoryPrice,
        Basis::Phy,
        Basis::Masters,
        Basis::Node,
        Basis::PriceClock,
        Basis::AreaScope,
        Basis::PowerScope,
    ];

    /// The name in JSON: snake_case.
    pub const fn name(self) -> &'static str {
        match self {
            Basis::Task => "task",
            Basis::Step => "step",
            Basis::Memory => "memory",
            Basis::MemoryModel => "memory_model",
            Basis::MemoryPrice => "memory_price",
            Basis::Phy => "memory_phy",
            Basis::Masters => "second_master",
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
            Basis::Step if side.task.is_shown() => Some("none".to_owned()),
            Basis::Step => {
                let own = |key: &str| at(&["machine", "training", key]);
                let widths = own("widths").and_then(Value::as_table);
                let width =
                    |(key, value): (&String, &Value)| Some(format!("{key} {}", value.as_str()?));
                let widths = widths.into_iter().flatten().filter_map(width);
                let loss = own("loss").map(|n| format!("loss of {n} operations a pixel"));
                let all: Vec<String> = widths.chain(loss).collect();
                Some(all.join(", ")).filter(|text| !text.is_empty())
            }
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
                let share = at(&["machine", "dram", "standby-share"]).map(Value::to_string);
                if let Some(share) = share {
                    return Some(format!("of others; {share} of the standby is paid"));
                }
                let has = at(&["energy", "phy"]).is_some();
                Some(if has { "of the chip" } else { "left out" }.to_owned())
            }
            Basis::Masters => {
                at(&["machine", "dram"])?;
                let all = MASTERS.into_iter().filter_map(|name| {
                    let table = format!("{name}-master");
                    let own = |key| at(&["machine", "dram", &table, key]);
                    let word = |key| own(key).and_then(Value::as_str).map(str::to_owned);
                    let rate = word("rate").filter(|rate| !rate.starts_with("0 "))?;
                    let not = |usual: &'static str| move |word: &String| word != usual;
                    let facts = [
                        Some(rate),
                        word("pattern"),
                        own("reads").map(|share| format!("reads {share}")),
                        word("request").map(|bytes| format!("of {bytes}")),
                        own("in-flight").map(|n| format!("{n} in flight")),
                        word("priority").filter(not("equal")),
                        word("guaranteed")
                            .filter(|rate| !rate.starts_with("0 "))
                            .map(|rate| format!("{rate} guaranteed")),
                    ];
                    Some(facts.into_iter().flatten().collect::<Vec<_>>().join(", "))
                });
                let all: Vec<String> = all.collect();
                Some(if all.is_empty() { "none".to_owned() } else { all.join(" + ") })
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
