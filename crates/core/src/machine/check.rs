//! Consistency of the keys of a machine file: those that all machines have, then those of the
//! dataflow.

use super::{
    DramModel, DramSpec, MASTERS, Machine, MasterSpec, MemoryOwner, NO_DEVICE, Priority, exclusion,
};
use powergs_base::quantity::{Bytes, BytesPerSecond};

/// The largest buffer or record that is believed: 1 GiB.
pub const SIZE_MAX: Bytes = Bytes(1 << 30);

/// The largest record that is believed.
pub const RECORD_MAX: Bytes = Bytes(1 << 16);

/// The least share of the peak that a DRAM delivers: below it the machine stands still.
const EFFICIENCY_MIN: f64 = 1e-3;

/// Keys that contradict each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contradiction {
    /// The key that it is shown at.
    pub key: &'static str,
    /// What is wrong and what to do.
    pub message: String,
    /// Keys with values that would end it, as `--set` takes them, where any is plain: each alone
    /// does, the best first.
    pub remedies: Vec<(&'static str, String)>,
}

/// What was found so far.
#[derive(Debug, Default)]
pub struct Found(Vec<Contradiction>);

impl Found {
    /// Adds what is wrong at a key.
    pub fn add(&mut self, key: &'static str, message: String) {
        self.0.push(Contradiction { key, message, remedies: Vec::new() });
    }

    /// Says what would end the contradiction that was added last.
    pub fn ends_with(&mut self, key: &'static str, value: impl ToString) {
        if let Some(last) = self.0.last_mut() {
            last.remedies = vec![(key, value.to_string())];
        }
    }

    /// Adds contradictions.
    pub fn extend(&mut self, more: impl Iterator<Item = Contradiction>) {
        self.0.extend(more);
    }

    /// Whether nothing was.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What was found.
    pub fn all(self) -> Vec<Contradiction> {
        self.0
    }
}

/// Every contradiction.
pub(super) fn problems(machine: &Machine) -> Vec<Contradiction> {
    let mut found = Found::default();
    names(machine, &mut found);
    rates(machine, &mut found);
    memory(machine, &mut found);
    for check in machine.flow().stages().iter().filter_map(|stage| stage.check) {
        check(machine, &mut found);
    }
    exclusion::check(machine, &mut found);
    machine.flow().check(machine, &mut found);
    found.all()
}

fn names(m: &Machine, found: &mut Found) {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if m.name.is_empty() || !m.name.chars().all(plain) || m.name.starts_with('.') {
        let message = "must be letters, digits, `-`, `_` and `.`: it becomes part of file names";
        found.add("name", format!("`name` {message}"));
    }
    if m.energy.trim().is_empty() {
        found.add("energy", "`energy` must name an energy table or a path of one".into());
    }
}

/// Share of a memory that other masters may take: the rest is left to the accelerator.
const SHARE_MAX: f64 = 0.95;

/// The keys of other masters that are shown where they contradict something.
struct MasterKeys {
    table: &'static str,
    rate: &'static str,
    request: &'static str,
    guaranteed: &'static str,
}

macro_rules! master_keys {
    ($table:literal) => {
        MasterKeys {
            table: $table,
            rate: concat!($table, ".rate"),
            request: concat!($table, ".request"),
            guaranteed: concat!($table, ".guaranteed"),
        }
    };
}

/// Those of each, in the order of [`MASTERS`].
const MASTER_KEYS: [MasterKeys; MASTERS.len()] = [
    master_keys!("dram.second-master"),
    master_keys!("dram.third-master"),
    master_keys!("dram.fourth-master"),
];

/// The other masters that there are, with their keys.
fn masters(dram: &DramSpec) -> impl Iterator<Item = (&MasterSpec, &'static MasterKeys)> {
    dram.masters().into_iter().zip(&MASTER_KEYS).filter(|(master, _)| master.is_on())
}

/// The key and the reason where other masters leave too little of the memory.
pub(super) fn taken(m: &Machine) -> Option<(&'static str, String)> {
    let peak = m.dram_peak();
    let share = m.dram.share(peak.0);
    let before = masters(&m.dram).filter(|(master, _)| master.priority != Priority::Last);
    let before: Vec<_> = before.collect();
    let (_, last) = *before.last().filter(|_| share > SHARE_MAX)?;
    let asked: Vec<_> = before
        .iter()
        .map(|(master, keys)| {
            let reached = 100.0 * master.efficiency;
            format!("`{}` = {}, at {reached:.0} % of the peak,", keys.rate, master.rate)
        })
        .collect();
    let message = format!(
        "{} {} {:.0} % of the memory, which has {peak}: the accelerator needs at least {:.0} %; \
         lower a rate, or raise `dram.channels`",
        asked.join(" and "),
        if asked.len() == 1 { "takes" } else { "take" },
        100.0 * share,
        100.0 * (1.0 - SHARE_MAX)
    );
    Some((last.rate, message))
}

/// The key and the reason where a master asks for more than its pattern can have of the device,
/// which nobody else used; or those that go first leave nothing.
pub(super) fn beyond_pattern(m: &Machine) -> Option<(&'static str, String)> {
    let device = m.device.as_deref().filter(|_| m.dram.timed() == DramModel::Banked)?;
    let mut first = 0.0;
    for (master, keys) in masters(&m.dram) {
        let most = master.ceiling(device);
        let has = format!(
            "with `pattern` = {}, requests of {}, {} of them under way and `reads` = {} that is {} \
             if nobody else asks",
            master.pattern.name(),
            master.request,
            master.in_flight,
            master.reads,
            BytesPerSecond(1e7 * (most / 1e7).floor())
        );
        if master.rate.0 > most {
            let message = format!(
                "`{}` = {} is more than its pattern can have of this memory: {has}; lower the \
                 rate, or raise `{}.in-flight` or its `request`",
                keys.rate, master.rate, keys.table
            );
            return Some((keys.rate, message));
        }
        first += match master.priority {
            Priority::First => master.rate.0,
            Priority::Equal | Priority::Last => master.guaranteed.0,
        } / most;
        if first > SHARE_MAX {
            let message = format!(
                "what goes first takes {:.0} % of what its pattern can have of this memory: {has}; \
                 the accelerator needs at least {:.0} %; lower `{}` or its `guaranteed`",
                100.0 * first,
                100.0 * (1.0 - SHARE_MAX),
                keys.rate
            );
            return Some((keys.rate, message));
        }
    }
    None
}

/// A memory is a device, or a rate; and other masters take a part of it.
fn memory(m: &Machine, found: &mut Found) {
    let dram = &m.dram;
    for (master, keys) in masters(dram) {
        if !(1e3..=1e15).contains(&master.rate.0) {
            let (key, rate) = (keys.rate, master.rate);
            found.add(key, format!("`{key}` = {rate} must be 0 B/s or from 1 kB/s to 1 PB/s"));
        }
        if master.guaranteed.0 > master.rate.0 {
            let (key, guaranteed) = (keys.guaranteed, master.guaranteed);
            let message = format!(
                "`{key}` = {guaranteed} is more than it asks for, `{}` = {}: lower it",
                keys.rate, master.rate
            );
            found.add(key, message);
        }
    }
    for (master, keys) in dram.masters().into_iter().zip(&MASTER_KEYS) {
        if !(1..=RECORD_MAX.0).contains(&master.request.0) {
            let (key, request) = (keys.request, master.request);
            found.add(key, format!("`{key}` = {request} must be from 1 B to {RECORD_MAX}"));
        }
    }
    if dram.owner == MemoryOwner::Shared && dram.standby_share.is_none() {
        let message = "`dram.owner` = \"shared\" needs `dram.standby-share`, the part of the \
                       memory's background and refresh that the machine pays: 0 where the others \
                       keep it awake anyway";
        found.add("dram.standby-share", message.to_owned());
    }
    if dram.has_device() {
        return;
    }
    let rate = dram.bandwidth.or_else(|| m.flow().memory_rate(m));
    if rate.is_none() {
        let message = format!(
            "`dram.device` = \"{NO_DEVICE}\" needs `dram.bandwidth`, the peak rate of the memory: \
             add e.g. `bandwidth = \"51.2 GB/s\"`, or name a device"
        );
        found.add("dram.bandwidth", message);
    }
    if rate.is_some()
        && let Some((key, message)) = taken(m)
    {
        found.add(key, message);
    }
    if dram.model != DramModel::Bandwidth {
        let message = format!(
            "`dram.model` = \"{}\" times a device, and `dram.device` is \"{NO_DEVICE}\": name one, \
             or set `dram.model` = \"bandwidth\"",
            dram.model.name()
        );
        found.add("dram.model", message);
    }
}

/// Rates outside of what any chip has are typing errors, and the arithmetic of time stays exact
/// within them.
fn rates(m: &Machine, found: &mut Found) {
    let (clock, latency) = (m.clock, m.dram.latency);
    if !(1e4..=1e11).contains(&clock.0) {
        found.add("clock", format!("`clock` = {clock} must be from 10 kHz to 100 GHz"));
    }
    if let Some(bandwidth) = m.dram.bandwidth.filter(|rate| !(1e6..=1e15).contains(&rate.0)) {
        let message = format!("`dram.bandwidth` = {bandwidth} must be from 1 MB/s to 1 PB/s");
        found.add("dram.bandwidth", message);
    }
    if m.dram.efficiency < EFFICIENCY_MIN {
        let efficiency = m.dram.efficiency;
        let message =
            format!("`dram.efficiency` = {efficiency:?} must be at least {EFFICIENCY_MIN}");
        found.add("dram.efficiency", message);
    }
    if latency.0 > 1e6 {
        let message = format!("`dram.latency` = {latency} must be at most 1000000 ns");
        found.add("dram.latency", message);
    }
}
