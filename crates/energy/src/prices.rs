//! Prices of one machine, from an energy table: picojoules per action and command, static power in
//! watts, area.

use super::area::Area;
use super::supply::Supply;
use super::{Component, EnergyBreakdown, flops};
use crate::action::{ActionCounts, ActionId, Phase};
use crate::hardware::{Does, Hardware};
use powergs_base::quantity::{Bytes, Picojoules};
use powergs_dram::{CommandPrices, DramCommands, StageCommands};
use powergs_frame::scene::ShDegree;

/// The prices of one machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Prices {
    /// What the numbers of actions, units and buffers mean.
    pub hardware: &'static Hardware,
    /// Picojoules per action, by [`ActionId`]; per byte for SRAM and DRAM. Bytes of DRAM are free
    /// where commands are priced.
    pub per_action: Vec<f64>,
    /// Leakage of the units, watts, all of a kind together, in the order of [`Hardware::units`].
    pub unit_leakage_w: Vec<f64>,
    /// Leakage of the buffers, watts, by [`BufferId`](crate::action::BufferId): never gated.
    pub sram_leakage_w: Vec<f64>,
    /// Share of its leakage that a unit without work keeps: 1 without power gating.
    pub idle_leakage: f64,
    /// The memory.
    pub dram: DramCosts,
    /// Area of the chip, where the table knows it.
    pub area: Option<Area>,
    /// Standby of the chip's side of all memory channels (PHY), watts: a part of the background.
    pub phy_standby_w: f64,
    /// The share of the memory's own background and refresh that is paid, 0 to 1.
    pub standby_share: f64,
    /// Voltage, and what it does to the prices above; `None` where the table has no curve.
    pub supply: Option<Supply>,
    /// What stays of static powers between frames.
    pub kept: IdleShares,
}

/// Shares of static powers that stay between frames, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IdleShares {
    /// Of the leakage of units, as far as they are not gated, and buffers.
    pub leakage: f64,
    /// Of the background of the memory with the PHY.
    pub background: f64,
}

impl IdleShares {
    /// Everything stays.
    pub const ALL: IdleShares = IdleShares { leakage: 1.0, background: 1.0 };
}

/// Prices of the DRAM.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DramCosts {
    /// A price per requested byte, and static powers of the whole memory.
    Bytes {
        /// Picojoules per byte read.
        read_pj: f64,
        /// Picojoules per byte written.
        write_pj: f64,
        /// Standby, watts.
        background_w: f64,
        /// Refresh, watts.
        refresh_w: f64,
    },
    /// A price per command.
    Commands(CommandPrices),
    /// A device whose commands are not counted: a price per requested byte that follows from them,
    /// and the standing powers of the device.
    Uncounted {
        /// Picojoules per byte read.
        read_pj: f64,
        /// Picojoules per byte written.
        write_pj: f64,
        /// The device: its standing powers.
        device: CommandPrices,
    },
}

impl DramCosts {
    /// The same where no commands are counted: a byte then costs as one of a whole burst, of which
    /// a share `row_hits` finds its row open and each of the others opens one (A150).
    #[must_use]
    pub fn uncounted(self, burst: Bytes, row_hits: f64) -> DramCosts {
        match self {
            DramCosts::Commands(device) => {
                let activates = (1.0 - row_hits) * device.commands(0, 0, 1).0;
                let per_byte = |access: Picojoules| (access.0 + activates) / burst.0.max(1) as f64;
                DramCosts::Uncounted {
                    read_pj: per_byte(device.commands(1, 0, 0)),
                    write_pj: per_byte(device.commands(0, 1, 0)),
                    device,
                }
            }
            // They need no commands.
            DramCosts::Bytes { .. } | DramCosts::Uncounted { .. } => self,
        }
    }

    /// Background power while frames run, with open rows where commands are priced, and power of
    /// refreshes at their nominal rate, watts.
    pub fn standby_w(&self) -> [f64; 2] {
        match self {
            DramCosts::Bytes { background_w, refresh_w, .. } => [*background_w, *refresh_w],
            DramCosts::Commands(p) | DramCosts::Uncounted { device: p, .. } => {
                [p.active_w(), p.refresh_w]
            }
        }
    }

    /// Picojoules per byte read and written, where bytes are priced.
    pub(super) fn per_byte(&self) -> [f64; 2] {
        match *self {
            DramCosts::Bytes { read_pj, write_pj, .. }
            | DramCosts::Uncounted { read_pj, write_pj, .. } => [read_pj, write_pj],
            DramCosts::Commands(_) => [0.0; 2],
        }
    }
}

/// The activity of a frame, as far as it costs energy.
#[derive(Debug, Clone, Copy)]
pub struct Activity<'a> {
    /// How often each action happened.
    pub actions: &'a ActionCounts,
    /// Length of the frame, seconds.
    pub seconds: f64,
    /// Share of the frame for which the units of each kind had no work, 0 to 1, in the order of
    /// [`Hardware::units`].
    pub idle: &'a [f64],
    /// Commands of the DRAM, where the model counts them.
    pub dram: Option<DramCommands>,
}

/// Static power, watts: leakage, background power of the memory (its own and the standby of the
/// chip's side of its channels), DRAM refresh.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Standby {
    /// While the frame runs, on average.
    pub running_w: [f64; 3],
    /// Idle power: between frames.
    pub idle_w: [f64; 3],
}

impl Standby {
    /// The components, in the order of both lists.
    pub const COMPONENTS: [Component; 3] =
        [Component::Leakage, Component::Background, Component::Refresh];

    /// Mean static powers, watts, when a frame of `seconds` starts `fps` times a second. A frame
    /// that takes longer than a period leaves no idle time.
    pub fn at_rate(&self, seconds: f64, fps: f64) -> [f64; 3] {
        let duty = (seconds * fps).min(1.0);
        // Both ends are exact, also in rounding.
        let mean =
            |(run, idle): (f64, f64)| if run == idle { run } else { idle + (run - idle) * duty };
        std::array::from_fn(|i| mean((self.running_w[i], self.idle_w[i])))
    }
}

impl Prices {
    /// The prices for frames of a scene of this SH degree: a colour costs in proportion to its
    /// floating-point operations. Those of an energy table are for degree 3.
    #[must_use]
    pub fn of_degree(&self, degree: ShDegree) -> Prices {
        let mut prices = self.clone();
        for (action, does) in self.hardware.actions() {
            if matches!(does, Does::Work(_, work) if work.is_colour) {
                prices.per_action[action.index()] *= flops::colour_share(degree);
            }
        }
        prices
    }

    /// The price of one action.
    pub fn of(&self, action: ActionId) -> Picojoules {
        Picojoules(self.per_action[action.index()])
    }

    /// Leakage of the chip when nothing is gated, watts.
    pub fn leakage_w(&self) -> f64 {
        self.unit_leakage_w.iter().sum::<f64>() + self.sram_leakage_w.iter().sum::<f64>()
    }

    /// Energy of the commands of one stage.
    pub fn commands(&self, commands: &StageCommands) -> Picojoules {
        match &self.dram {
            DramCosts::Bytes { .. } | DramCosts::Uncounted { .. } => Picojoules(0.0),
            DramCosts::Commands(p) => {
                p.commands(commands.reads, commands.writes, commands.activates)
            }
        }
    }

    /// Static power while a frame runs and between frames: leakage, background of the memory with
    /// the PHY, refresh.
    pub fn standby(&self, activity: &Activity<'_>) -> Standby {
        let units = self.unit_leakage_w.iter().zip(activity.idle);
        let gated = 1.0 - self.idle_leakage;
        let awake: f64 = units.map(|(watts, idle)| watts * (1.0 - idle * gated)).sum();
        let asleep = self.unit_leakage_w.iter().sum::<f64>() * self.idle_leakage;
        let buffers: f64 = self.sram_leakage_w.iter().sum();
        let [running, idle] = [awake, asleep].map(|units| units + buffers);
        let leakage = [running, idle * self.kept.leakage];
        let [background, refresh] = match &self.dram {
            DramCosts::Bytes { background_w, refresh_w, .. } => {
                [[*background_w; 2], [*refresh_w; 2]]
            }
            DramCosts::Commands(p) => {
                let refreshes =
                    activity.dram.map_or(0.0, |d| p.refreshes(d.refreshes, d.bank_refreshes));
                let running = refreshes * p.refresh_pj * 1e-12 / activity.seconds;
                let running = if activity.seconds > 0.0 { running } else { 0.0 };
                [[p.active_w(), p.power_down_w()], [running, p.refresh_w]]
            }
            DramCosts::Uncounted { device, .. } => {
                [[device.active_w(), device.power_down_w()], [device.refresh_w; 2]]
            }
        };
        let [background, refresh] =
            [background, refresh].map(|both| both.map(|watts| watts * self.standby_share));
        let [running, idle] = background.map(|watts| watts + self.phy_standby_w);
        let background = [running, idle * self.kept.background];
        let all = [leakage, background, refresh];
        Standby { running_w: all.map(|p| p[0]), idle_w: all.map(|p| p[1]) }
    }

    /// Energy of a frame, with static energy over the time of the frame.
    pub fn breakdown(&self, activity: &Activity<'_>) -> EnergyBreakdown {
        let mut energy = EnergyBreakdown::default();
        for (i, stage) in Phase::WORK.into_iter().enumerate() {
            for (action, does) in self.hardware.actions() {
                let count = activity.actions.count(stage, action) as f64;
                energy.add(stage, does.component(), self.of(action) * count);
            }
            if let Some(dram) = &activity.dram {
                energy.add(stage, Component::Dram, self.commands(&dram.stages[i]));
            }
        }
        let standby = self.standby(activity).running_w;
        for (component, watts) in Standby::COMPONENTS.into_iter().zip(standby) {
            energy.add(Phase::Standby, component, Picojoules(watts * activity.seconds * 1e12));
        }
        energy
    }
}
