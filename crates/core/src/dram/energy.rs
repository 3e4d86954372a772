//! Energy of what a memory did: commands times prices, and standing powers times time.

use super::device::{ActionPrices, Device};
use super::stats::Stats;
use powergs_base::quantity::Picojoules;

/// Energy by part.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyUse {
    /// Requested bytes at a flat price; the other parts are then zero.
    pub flat: Picojoules,
    /// Activates and precharges.
    pub activate: Picojoules,
    /// Reads: array and data path.
    pub read: Picojoules,
    /// Reads: data pins.
    pub read_io: Picojoules,
    /// Writes: array and data path.
    pub write: Picojoules,
    /// Writes: data pins.
    pub write_io: Picojoules,
    /// Refreshes.
    pub refresh: Picojoules,
    /// Standing powers.
    pub background: Picojoules,
}

impl EnergyUse {
    /// Energy of a device in `elapsed` CK. The channels rest, and are refreshed, from where the
    /// statistics end to `elapsed`; a smaller `elapsed` counts as the end of the statistics.
    pub fn new(device: &Device, stats: &Stats, elapsed: u64) -> EnergyUse {
        let scale = device.energy.scale;
        if let Some(flat) = &device.energy.flat {
            let bytes = stats.total.requested_bytes() as f64;
            return EnergyUse {
                flat: Picojoules(bytes * flat.energy.0 * scale),
                ..EnergyUse::default()
            };
        }
        let Some(prices) = &device.energy.actions else { return EnergyUse::default() };
        let times =
            |n: u64, price: &super::device::Price| Picojoules(n as f64 * price.energy.0 * scale);
        let elapsed = elapsed.max(stats.until);
        EnergyUse {
            flat: Picojoules(0.0),
            activate: times(stats.activates, &prices.activate),
            read: times(stats.reads, &prices.read),
            read_io: times(stats.reads, &prices.read_io),
            write: times(stats.writes, &prices.write),
            write_io: times(stats.writes, &prices.write_io),
            refresh: Picojoules(
                refreshes(device, stats, elapsed) * prices.refresh.energy.0 * scale,
            ),
            background: Picojoules(background(device, prices, stats, elapsed) * scale),
        }
    }

    /// The parts with their names.
    pub fn parts(&self) -> [(&'static str, Picojoules); 8] {
        [
            ("flat", self.flat),
            ("activate", self.activate),
            ("read", self.read),
            ("read_io", self.read_io),
            ("write", self.write),
            ("write_io", self.write_io),
            ("refresh", self.refresh),
            ("background", self.background),
        ]
    }

    /// The sum of all parts.
    pub fn total(&self) -> Picojoules {
        self.parts().into_iter().map(|(_, e)| e).sum()
    }
}

/// Refreshes of all banks of a pseudo channel that were paid for: those that were issued and those
/// of the rest, without those in self-refresh, whose power includes them.
fn refreshes(device: &Device, stats: &Stats, elapsed: u64) -> f64 {
    let o = &device.organisation;
    let banks = f64::from(o.pseudo_channels * o.bank_groups * o.banks);
    let issued = stats.refreshes_all as f64
        + stats.refreshes_bank as f64 / (banks / f64::from(o.pseudo_channels));
    let interval = f64::from(device.timing.refresh_interval);
    let ranks = f64::from(o.pseudo_channels);
    let none = device.controller.refresh == super::device::Refresh::None;
    let rest = rest(device, stats, elapsed);
    let (awake, asleep) = ((rest.standby + rest.down) as f64, stats.self_refresh as f64);
    let rate = if none { 0.0 } else { ranks / interval };
    (issued + (awake - asleep) * rate).max(0.0)
}

/// Channel CK after the end of the statistics.
struct Rest {
    standby: u64,
    down: u64,
    own: u64,
}

/// Nobody asks for anything after the end of the statistics: standby, power-down, self-refresh.
fn rest(device: &Device, stats: &Stats, elapsed: u64) -> Rest {
    let time = elapsed - stats.until;
    let channels = u64::from(device.organisation.channels);
    let [down, own] = device.energy.actions.as_ref().map_or([u64::MAX; 2], |a| {
        [a.background.power_down_after, a.background.self_refresh_after].map(|t| device.ck(t))
    });
    let (standby, before_own) = (time.min(down), time.min(own));
    Rest {
        standby: channels * standby,
        down: channels * (before_own - standby.min(before_own)),
        own: channels * (time - before_own),
    }
}

/// Standing energy, pJ.
fn background(device: &Device, prices: &ActionPrices, stats: &Stats, elapsed: u64) -> f64 {
    let rest = rest(device, stats, elapsed);
    let all = u64::from(device.organisation.channels) * stats.until;
    let asleep = stats.power_down + stats.self_refresh;
    let precharged = all.saturating_sub(stats.active + asleep);
    let states = [
        (stats.active, &prices.background.active),
        (precharged + rest.standby, &prices.background.precharged),
        (stats.power_down + rest.down, &prices.background.power_down),
        (stats.self_refresh + rest.own, &prices.background.self_refresh),
    ];
    // W x ns = nJ.
    states.iter().map(|(ck, p)| device.ns(*ck) * p.power.0 * 1e3).sum()
}
