//! One channel and its controller: queues, banks, command buses.
//!
//! Timing rule: of all commands that meet their timing constraints in a CK, the column command of a
//! request whose row was activated for it goes first, then a refresh, then the oldest request of
//! the current direction (read or write). The channel keeps the earliest command as its plan; an
//! accepted request can only improve the plan, an issued command makes a new one. The scheduler is
//! in `plan`, the effects of commands on the state in `issue`, the command log in `log`.
//! Source: `ramulator`, controllers of version 2.1.

use super::log::{CommandKind, Logged};
use super::plan::{Candidate, Command};
use super::queue::{CLOSED, Entries, Entry, List, NONE};
use super::rules::{READ, Rules, WRITE};
use super::sleep::Sleep;
use crate::dram::device::{Page, Refresh, Scheduler};
use crate::dram::stats::Stats;

/// A bank.
#[derive(Debug, Clone)]
pub(super) struct Bank {
    /// The open row, or [`CLOSED`].
    pub row: u32,
    /// Pseudo channel, and group counted through the channel.
    pub pseudo: u8,
    pub group: u8,
    /// The entry whose row was activated and whose column command has not been issued.
    pub active: u16,
    /// Whether the second half of its activate is missing.
    pub half: bool,
    /// First CK in which an activate meets the timing constraints of the bank.
    pub activate_ok: u64,
    /// The same of a read and a write.
    pub column_ok: [u64; 2],
    /// The same of a precharge.
    pub precharge_ok: u64,
    /// Waiting reads and writes.
    pub lists: [List; 2],
}

/// Timing constraints that the banks of a bank group share.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Group {
    pub activate_ok: u64,
    pub column_ok: [u64; 2],
}

/// Timing constraints that the banks of a pseudo channel share.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PseudoChannel {
    /// Ends of the four-activate windows (tFAW) of the last four activates, as a ring.
    pub faw_ends: [u64; 4],
    /// The oldest of them.
    pub faw_oldest: usize,
    pub precharge_ok: u64,
    /// First CK for a refresh after a precharge of all banks.
    pub refresh_ok: u64,
    /// Bursts on the data bus so far.
    pub bursts: u64,
}

/// The result of one CK of a channel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StepResult {
    /// Slot of the request whose column command was issued, and the CK in which its data is there.
    pub column: Option<(u32, u64)>,
    /// Whether an entry of a queue became free.
    pub freed: bool,
    /// The CK of the next step.
    pub wake: u64,
}

/// A refresh that is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Due {
    PseudoChannel(u8),
    Bank(u8),
}

/// A channel.
#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub entries: Entries,
    pub banks: Vec<Bank>,
    pub groups: Vec<Group>,
    pub pseudo_channels: Vec<PseudoChannel>,
    /// Entries in the read and the write queue.
    pub len: [usize; 2],
    /// Banks that have them, one bit each.
    pub waiting: [u64; 2],
    /// Banks with an active entry, one bit each.
    pub active: u64,
    /// Bursts in the write queue: later accesses to them are forwarded or absorbed.
    pub written: Vec<u64>,
    /// Whether writes are drained.
    pub write_mode: bool,
    /// First CK after the last command, in which the direction has not been decided again.
    pub look_from: u64,
    /// First CK in which each command bus is free: that of all or of column commands, that of row
    /// commands.
    pub bus_free: [u64; 2],
    /// Earliest command of each bus, if `planned`.
    pub best: [Candidate; 2],
    pub planned: bool,
    /// The CK in which the next refresh is due.
    pub next_refresh: u64,
    /// Refreshes that are due, in order.
    pub due: Vec<Due>,
    /// The bank that is refreshed next.
    pub refresh_bank: u8,
    /// The second half of an activate: bank and deadline.
    pub second: Option<(u8, u64)>,
    /// The entry for which the data clock was synchronised (CAS) in the last CK.
    pub synced: Option<u16>,
    /// The CK in which the data clock stops.
    pub clock_until: u64,
    pub open_banks: u32,
    pub sleep: Sleep,
    /// The commands, if they are kept.
    pub log: Option<Vec<Logged>>,
}

impl Channel {
    pub(super) fn new(rules: &Rules) -> Self {
        let bank = |i: usize| Bank {
            row: CLOSED,
            pseudo: (i / (rules.groups * rules.group_banks)) as u8,
            group: (i / rules.group_banks) as u8,
            active: NONE,
            half: false,
            activate_ok: 0,
            column_ok: [0; 2],
            precharge_ok: 0,
            lists: [List::EMPTY; 2],
        };
        let refresh = match rules.refresh {
            Refresh::None => u64::MAX,
            Refresh::AllBank | Refresh::PerBank => rules.refresh_interval,
        };
        Self {
            entries: Entries::new(rules.queue[0] + rules.queue[1] + rules.banks()),
            banks: (0..rules.banks()).map(bank).collect(),
            groups: vec![Group::default(); rules.pseudo_channels * rules.groups],
            pseudo_channels: vec![PseudoChannel::default(); rules.pseudo_channels],
            len: [0; 2],
            waiting: [0; 2],
            active: 0,
            written: Vec::new(),
            write_mode: false,
            look_from: u64::MAX,
            bus_free: [0; 2],
            best: [Candidate::NEVER; 2],
            planned: false,
            next_refresh: refresh,
            due: Vec::new(),
            refresh_bank: 0,
            second: None,
            synced: None,
            clock_until: 0,
            open_banks: 0,
            sleep: Sleep::default(),
            log: None,
        }
    }

    /// Whether no burst waits in the channel.
    pub(super) fn is_empty(&self) -> bool {
        self.len == [0; 2] && self.active == 0
    }

    /// Whether a write of this burst is in the write queue.
    pub(super) fn has_write(&self, burst: u64) -> bool {
        self.written.contains(&burst)
    }

    /// Whether the queue of this direction has a free entry.
    pub(super) fn has_room(&self, write: bool, rules: &Rules) -> bool {
        self.len[usize::from(write)] < rules.queue[usize::from(write)]
    }

    /// Accepts an entry; returns the CK of the next step of the channel.
    pub(super) fn accept(&mut self, entry: Entry, now: u64, rules: &Rules) -> u64 {
        if self.look_from < now {
            self.set_direction(rules);
        }
        if self.is_empty() {
            self.sleep.wake(now, self.open_banks > 0, &rules.sleep_after);
        }
        self.look_from = now;
        let direction = usize::from(entry.write);
        let number = usize::from(entry.bank);
        let bank = &mut self.banks[number];
        let list = &mut bank.lists[direction];
        let index = self.entries.push(entry, now, list, bank.row);
        let first = list.hit == index || list.miss == index;
        self.len[direction] += 1;
        self.waiting[direction] |= 1 << number;
        if entry.write {
            self.written.push(entry.burst);
        }
        let turns = self.next_direction(rules) != self.write_mode;
        if !self.planned || (self.due.is_empty() && turns) {
            self.planned = false;
            return self.bus_free[0].min(self.bus_free[1]).max(now);
        }
        let mode = self.direction();
        if first && mode == direction && self.due.is_empty() {
            // A younger request changes nothing for older ones, with one exception: a hit that was
            // accepted in the same CK keeps the row open.
            let same = |c: &Candidate| self.bank_of(c.command) == number;
            if self.best.iter().any(same) || rules.scheduler == Scheduler::Fcfs {
                self.planned = false;
                return self.bus_free[0].min(self.bus_free[1]).max(now);
            }
            let mut best = self.best;
            self.consider_bank(number, mode, now, rules, &mut best);
            self.best = best;
        }
        self.best_time()
    }

    pub(super) fn best_time(&self) -> u64 {
        self.best[0].time.min(self.best[1].time)
    }

    pub(super) fn direction(&self) -> usize {
        if self.write_mode { WRITE } else { READ }
    }

    /// Issues what can be issued in the CK `now`.
    pub(super) fn step(&mut self, now: u64, rules: &Rules, stats: &mut Stats) -> StepResult {
        let mut outcome = StepResult::default();
        if now >= self.next_refresh {
            self.refresh_due(now, rules);
        }
        let issued = if rules.column_bus {
            self.step_two_buses(now, rules, stats, &mut outcome)
        } else {
            self.step_one_bus(now, rules, stats, &mut outcome)
        };
        let steady = self.synced.is_none() && self.due.is_empty();
        if issued && steady && self.next_direction(rules) == self.write_mode {
            self.plan(now + 1, rules);
        }
        let next = if self.planned && steady {
            self.best_time()
        } else {
            self.bus_free[0].min(self.bus_free[1])
        };
        outcome.wake = next.max(now + 1).min(self.next_refresh);
        if self.second.is_some() {
            outcome.wake = outcome.wake.min(now + 1);
        }
        outcome
    }

    fn ready(&mut self, now: u64, bus: usize, rules: &Rules) -> Option<Command> {
        if !self.planned {
            self.plan(now, rules);
        }
        let best = &self.best[bus];
        (best.time <= now).then_some(best.command)
    }

    fn step_two_buses(
        &mut self,
        now: u64,
        rules: &Rules,
        stats: &mut Stats,
        outcome: &mut StepResult,
    ) -> bool {
        let column = self.ready(now, 0, rules);
        if let Some(command) = column {
            // The plan of the row bus holds unless it was for this bank.
            let bank = self.bank_of(command);
            let other = self.bank_of(self.best[1].command) != bank;
            self.issue(command, now, rules, stats, outcome);
            let before = self.write_mode;
            if self.due.is_empty() {
                self.set_direction(rules);
            }
            self.planned = other && before == self.write_mode && rules.page == Page::Open;
        }
        let row = self.ready(now, 1, rules);
        if let Some(command) = row {
            self.issue(command, now, rules, stats, outcome);
        }
        if column.is_some() || row.is_some() {
            self.planned = false;
            self.look_from = now + 1;
            return true;
        }
        false
    }

    fn step_one_bus(
        &mut self,
        now: u64,
        rules: &Rules,
        stats: &mut Stats,
        outcome: &mut StepResult,
    ) -> bool {
        if self.second.is_some_and(|(_, deadline)| deadline <= now) {
            self.second_half(now, rules);
            return true;
        }
        if let Some(entry) = self.synced.take() {
            self.issue(Command::Column(entry), now, rules, stats, outcome);
            return true;
        }
        match self.ready(now, 0, rules) {
            None if self.second.is_some() && self.bus_free[0] <= now => {
                self.second_half(now, rules);
                true
            }
            None => false,
            Some(Command::Column(entry))
                if now >= self.clock_until && rules.clock_runs.is_some() =>
            {
                if self.second.is_some_and(|(_, deadline)| deadline <= now + 1) {
                    self.second_half(now, rules);
                } else {
                    stats.clock_syncs += 1;
                    let bank = usize::from(self.entries.get(entry).bank);
                    self.note(now, bank, CommandKind::ClockSync);
                    self.bus_free = [now + 1; 2];
                    self.synced = Some(entry);
                }
                true
            }
            Some(command) => {
                self.issue(command, now, rules, stats, outcome);
                true
            }
        }
    }
}
