//! Consistency of the keys of a machine file: those that all machines have, then those of the
//! dataflow.

use super::{DramModel, Machine, NO_DEVICE, exclusion};
use powergs_base::quantity::Bytes;

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

/// Share of a memory that a second master may take: the rest is left to the accelerator.
const SHARE_MAX: f64 = 0.95;

/// Why the second master leaves too little of the memory; `None` where it does not.
pub(super) fn taken(m: &Machine) -> Option<String> {
    let (master, peak) = (&m.dram.second_master, m.dram_peak());
    let share = master.share(peak.0);
    (share > SHARE_MAX).then(|| {
        format!(
            "`dram.second-master.rate` = {} takes {:.0} % of the memory, {peak} of which it \
             reaches {:.0} %: the accelerator needs at least {:.0} %; lower the rate, or raise \
             `dram.channels`",
            master.rate,
            100.0 * share,
            100.0 * master.efficiency,
            100.0 * (1.0 - SHARE_MAX)
        )
    })
}

/// A memory is a device, or a rate; and a second master takes a part of it.
fn memory(m: &Machine, found: &mut Found) {
    let dram = &m.dram;
    let master = &dram.second_master;
    if master.is_on() && !(1e3..=1e15).contains(&master.rate.0) {
        let message = format!(
            "`dram.second-master.rate` = {} must be 0 B/s or from 1 kB/s to 1 PB/s",
            master.rate
        );
        found.add("dram.second-master.rate", message);
    }
    if !(1..=RECORD_MAX.0).contains(&master.request.0) {
        let message = format!(
            "`dram.second-master.request` = {} must be from 1 B to {RECORD_MAX}",
            master.request
        );
        found.add("dram.second-master.request", message);
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
        && let Some(message) = taken(m)
    {
        found.add("dram.second-master.rate", message);
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
