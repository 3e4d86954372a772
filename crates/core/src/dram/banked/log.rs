//! The log of the commands of a run, for checks of the timing constraints.

use super::channel::Channel;
use super::plan::Command;
use super::rules::Rules;

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

impl Channel {
    /// Notes a command that has no row.
    pub(super) fn note(&mut self, time: u64, bank: usize, kind: CommandKind) {
        if let Some(log) = &mut self.log {
            log.push(Logged { time, kind, bank: bank as u32, row: 0 });
        }
    }

    /// Notes an command before it is done.
    pub(super) fn log(&mut self, time: u64, command: Command, rules: &Rules) {
        if self.log.is_none() {
            return;
        }
        let of = |index: u16| {
            let entry = self.entries.get(index);
            (u32::from(entry.bank), entry.row, entry.write)
        };
        let first = |pseudo: u8| u32::from(pseudo) * (rules.groups * rules.group_banks) as u32;
        let (bank, row, kind) = match command {
            Command::Column(e) => {
                let (bank, row, write) = of(e);
                (bank, row, if write { CommandKind::Write } else { CommandKind::Read })
            }
            Command::Activate(e) => (of(e).0, of(e).1, CommandKind::Activate),
            Command::Precharge(e) => (of(e).0, of(e).1, CommandKind::Precharge),
            Command::PrechargeBank(b) => (u32::from(b), 0, CommandKind::Precharge),
            Command::PrechargeAll(r) => (first(r), 0, CommandKind::PrechargeAll),
            Command::RefreshAll(r) => (first(r), 0, CommandKind::RefreshAll),
            Command::RefreshBank(b) => (u32::from(b), 0, CommandKind::RefreshBank),
        };
        self.log.iter_mut().for_each(|log| log.push(Logged { time, kind, bank, row }));
    }
}
