//! The log of the commands of a run, for checks of the timing constraints.

use super::channel::BankedChannel;
use super::plan::{Candidate, PlannedCommand};

/// A kind of command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandKind {
    /// Opens a row; the first half if activates are split.
    Activate,
    /// The second half of an activate.
    SecondHalf,
    /// Moves a burst from the open row.
    Read,
    /// Moves a burst to the open row.
    Write,
    /// Closes a bank.
    Precharge,
    /// A bank that closes by itself after its last column; takes no command.
    AutoPrecharge,
    /// Closes all banks of a pseudo channel.
    PrechargeAll,
    /// Refreshes all banks of a pseudo channel.
    RefreshAll,
    /// Refreshes a bank.
    RefreshBank,
    /// Synchronises the data clock.
    ClockSync,
}

/// A command that was issued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Logged {
    /// When, CK. The commands of a channel are in order of time, except
    /// [`CommandKind::AutoPrecharge`], which is logged ahead of its time.
    pub time: u64,
    /// What.
    pub kind: CommandKind,
    /// The bank in its channel: pseudo channel, group, bank; the first bank of the pseudo channel
    /// for commands to all of them.
    pub bank: u32,
    /// The row of its request; 0 for commands without one.
    pub row: u32,
}

impl BankedChannel {
    /// Notes a command that has no row.
    pub(super) fn note(&mut self, time: u64, bank: usize, kind: CommandKind) {
        if let Some(log) = &mut self.log {
            log.push(Logged { time, kind, bank: bank as u32, row: 0 });
        }
    }

    /// Notes a command before it is done.
    #[inline]
    pub(super) fn log(&mut self, time: u64, candidate: &Candidate) {
        if self.log.is_some() {
            self.keep(time, candidate);
        }
    }

    #[cold]
    fn keep(&mut self, time: u64, candidate: &Candidate) {
        let entry = self.entries.find_entry(candidate.entry);
        let kind = match candidate.command {
            PlannedCommand::Column if entry.is_some_and(|e| e.write) => CommandKind::Write,
            PlannedCommand::Column => CommandKind::Read,
            PlannedCommand::Activate => CommandKind::Activate,
            PlannedCommand::Precharge | PlannedCommand::PrechargeBank => CommandKind::Precharge,
            PlannedCommand::PrechargeAll => CommandKind::PrechargeAll,
            PlannedCommand::RefreshAll => CommandKind::RefreshAll,
            PlannedCommand::RefreshBank => CommandKind::RefreshBank,
        };
        let (bank, row) = (u32::from(candidate.bank), entry.map_or(0, |e| e.row));
        self.log.iter_mut().for_each(|log| log.push(Logged { time, kind, bank, row }));
    }
}
