//! Energy of a memory: commands times prices, and time in each state times background power.
//!
//! [`CommandPrices`] is the one formula. `powergs-sim dram` applies it to the statistics of a
//! device ([`EnergyUse`]), which know the state of every channel. The simulator applies it to the
//! commands of a frame, of which no states are kept: its channels have open rows while the frame
//! runs and are powered down between frames (A56).

use super::device::{Device, Refresh};
use super::stats::Stats;
use powergs_base::quantity::Picojoules;

/// Prices of the commands and the states of a device, with `energy.scale` applied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandPrices {
    /// Picojoules per activate with its precharge.
    pub activate_pj: f64,
    /// Picojoules per read burst: array and data path.
    pub read_pj: f64,
    /// Picojoules per read burst: data pins.
    pub read_io_pj: f64,
    /// Picojoules per write burst: array and data path.
    pub write_pj: f64,
    /// Picojoules per write burst: data pins.
    pub write_io_pj: f64,
    /// Picojoules per refresh of all banks of a pseudo channel.
    pub refresh_pj: f64,
    /// Banks of a pseudo channel: a refresh of one bank costs its share.
    pub banks: f64,
    /// Power of refreshes at their nominal rate, all channels together, watts.
    pub refresh_w: f64,
    /// Background power of a channel, watts: row open, all rows closed, power-down, self-refresh.
    pub background_w: [f64; 4],
    /// Channels.
    pub channels: f64,
}

impl CommandPrices {
    /// The prices of a device; `None` where a flat price per byte is all that it has.
    pub fn of(device: &Device) -> Option<CommandPrices> {
        let prices = device.energy.actions.as_ref()?;
        let (organisation, scale) = (&device.organisation, device.energy.scale);
        let pseudo = f64::from(organisation.channels * organisation.pseudo_channels);
        let interval_s = device.ns(u64::from(device.timing.refresh_interval)) * 1e-9;
        let refresh_pj = prices.refresh.energy.0 * scale;
        let background = prices.background.states();
        Some(CommandPrices {
            activate_pj: prices.activate.energy.0 * scale,
            read_pj: prices.read.energy.0 * scale,
            read_io_pj: prices.read_io.energy.0 * scale,
            write_pj: prices.write.energy.0 * scale,
            write_io_pj: prices.write_io.energy.0 * scale,
            refresh_pj,
            banks: f64::from(organisation.bank_groups * organisation.banks),
            refresh_w: match device.controller.refresh {
                Refresh::None => 0.0,
                Refresh::AllBank | Refresh::PerBank => refresh_pj * 1e-12 * pseudo / interval_s,
            },
            background_w: background.map(|(_, price)| price.power.0 * scale),
            channels: f64::from(organisation.channels),
        })
    }

    /// Energy of so many bursts read, bursts written and activates.
    pub fn commands(&self, reads: u64, writes: u64, activates: u64) -> Picojoules {
        Picojoules(
            activates as f64 * self.activate_pj
                + reads as f64 * (self.read_pj + self.read_io_pj)
                + writes as f64 * (self.write_pj + self.write_io_pj),
        )
    }

    /// Refreshes of all banks of a pseudo channel that cost as much as `all` of them and `bank`
    /// refreshes of one bank.
    pub fn refreshes(&self, all: u64, bank: u64) -> f64 {
        all as f64 + bank as f64 / self.banks
    }

    /// Background energy of channel nanoseconds in each state.
    pub(crate) fn background(&self, channel_ns: [f64; 4]) -> Picojoules {
        // W x ns = nJ.
        Picojoules(channel_ns.iter().zip(self.background_w).map(|(ns, w)| ns * w * 1e3).sum())
    }

    /// Background power while all channels have open rows, watts.
    pub fn active_w(&self) -> f64 {
        self.background_w[0] * self.channels
    }

    /// Background power while all channels are powered down, watts.
    pub fn power_down_w(&self) -> f64 {
        self.background_w[2] * self.channels
    }
}

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
    /// Background of all states.
    pub background: Picojoules,
}

impl EnergyUse {
    /// Energy of a device in `elapsed` CK. The channels are idle, and are refreshed, from the end
    /// of the statistics to `elapsed`; a smaller `elapsed` counts as the end of the statistics.
    pub fn new(device: &Device, stats: &Stats, elapsed: u64) -> EnergyUse {
        if let Some(flat) = &device.energy.flat {
            let bytes = stats.total.requested_bytes() as f64;
            return EnergyUse {
                flat: Picojoules(bytes * flat.energy.0 * device.energy.scale),
                ..EnergyUse::default()
            };
        }
        let Some(prices) = CommandPrices::of(device) else { return EnergyUse::default() };
        let elapsed = elapsed.max(stats.until);
        let times = |n: u64, pj: f64| Picojoules(n as f64 * pj);
        EnergyUse {
            flat: Picojoules(0.0),
            activate: times(stats.activates, prices.activate_pj),
            read: times(stats.reads, prices.read_pj),
            read_io: times(stats.reads, prices.read_io_pj),
            write: times(stats.writes, prices.write_pj),
            write_io: times(stats.writes, prices.write_io_pj),
            refresh: Picojoules(refreshes(device, &prices, stats, elapsed) * prices.refresh_pj),
            background: prices.background(channel_ns(device, stats, elapsed)),
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

/// Refreshes of all banks of a pseudo channel: those that were issued and those of the idle time at
/// the end, without those in self-refresh, whose power includes them.
fn refreshes(device: &Device, prices: &CommandPrices, stats: &Stats, elapsed: u64) -> f64 {
    let issued = prices.refreshes(stats.refreshes_all, stats.refreshes_bank);
    let interval = f64::from(device.timing.refresh_interval);
    let ranks = f64::from(device.organisation.pseudo_channels);
    let idle = idle(device, stats, elapsed);
    // Refreshes were issued during self-refresh as well, but its power includes them.
    let (awake, asleep) = ((idle.standby + idle.down) as f64, stats.self_refresh as f64);
    let rate = if device.controller.refresh == Refresh::None { 0.0 } else { ranks / interval };
    (issued + (awake - asleep) * rate).max(0.0)
}

/// Channel CK after the end of the statistics.
struct Idle {
    standby: u64,
    down: u64,
    self_refresh: u64,
}

/// The idle time after the end of the statistics: standby, then power-down, then self-refresh.
fn idle(device: &Device, stats: &Stats, elapsed: u64) -> Idle {
    let time = elapsed - stats.until;
    let channels = u64::from(device.organisation.channels);
    let [down, own] = device.energy.actions.as_ref().map_or([u64::MAX; 2], |a| {
        [a.background.power_down_after, a.background.self_refresh_after].map(|t| device.ck(t))
    });
    let (standby, before_own) = (time.min(down), time.min(own));
    Idle {
        standby: channels * standby,
        down: channels * (before_own - standby.min(before_own)),
        self_refresh: channels * (time - before_own),
    }
}

/// Channel nanoseconds with a row open, with all rows closed, in power-down and in self-refresh.
fn channel_ns(device: &Device, stats: &Stats, elapsed: u64) -> [f64; 4] {
    let idle = idle(device, stats, elapsed);
    let all = u64::from(device.organisation.channels) * stats.until;
    let asleep = stats.power_down + stats.self_refresh;
    let precharged = all.saturating_sub(stats.active + asleep);
    [
        stats.active,
        precharged + idle.standby,
        stats.power_down + idle.down,
        stats.self_refresh + idle.self_refresh,
    ]
    .map(|ck| device.ns(ck))
}
