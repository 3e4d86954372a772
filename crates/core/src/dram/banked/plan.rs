//! The scheduler of a channel: which commands could go next, and which of them goes first.

use super::channel::Channel;
use super::queue::{CLOSED, NONE};
use super::rules::{READ, Rules, WRITE};
use crate::dram::device::Scheduler;

/// A command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Command {
    /// Read or write for an entry.
    Column(u16),
    /// Open the row of an entry.
    Activate(u16),
    /// Close a bank for an entry.
    Precharge(u16),
    /// Close all banks of a pseudo channel to refresh it.
    PrechargeAll(u8),
    /// Close a bank to refresh it.
    PrechargeBank(u8),
    /// Refresh a pseudo channel.
    RefreshAll(u8),
    /// Refresh a bank.
    RefreshBank(u8),
}

/// A command that could be issued.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// First CK in which it meets all timing constraints.
    pub time: u64,
    /// Of two commands at one time, the one with the smaller priority value goes.
    pub priority: u64,
    pub command: Command,
}

impl Candidate {
    /// Nothing can go.
    pub(super) const NEVER: Candidate =
        Candidate { time: u64::MAX, priority: u64::MAX, command: Command::RefreshAll(u8::MAX) };
}

/// Priority values below this: columns of activated rows; from here: requests by age.
const BY_AGE: u64 = 1 << 63;

impl Channel {
    /// The bank that a command is for; `usize::MAX` for commands to several.
    pub(super) fn bank_of(&self, command: Command) -> usize {
        match command {
            Command::Column(e) | Command::Activate(e) | Command::Precharge(e) => {
                usize::from(self.entries.get(e).bank)
            }
            Command::PrechargeBank(b) | Command::RefreshBank(b) => usize::from(b),
            Command::PrechargeAll(_) | Command::RefreshAll(_) => usize::MAX,
        }
    }

    /// Switches between reads and writes by the fill of their queues.
    pub(super) fn set_direction(&mut self, rules: &Rules) {
        self.look_from = u64::MAX;
        self.write_mode = self.next_direction(rules);
    }

    pub(super) fn next_direction(&self, rules: &Rules) -> bool {
        let (reads, writes) = (self.len[READ], self.len[WRITE] as f64);
        if self.write_mode {
            !(writes < rules.write_low && reads > 0)
        } else {
            writes > rules.write_high || reads == 0
        }
    }

    /// Finds the earliest commands at or after `now`.
    pub(super) fn plan(&mut self, now: u64, rules: &Rules) {
        let mut best = [Candidate::NEVER; 2];
        let mut left = self.active;
        while left != 0 {
            let number = left.trailing_zeros() as usize;
            left &= left - 1;
            let bank = &self.banks[number];
            if !bank.half {
                let entry = self.entries.get(bank.active);
                let kind = usize::from(entry.write);
                let group = self.groups[usize::from(bank.group)].column_ok[kind];
                let time = bank.column_ok[kind].max(group);
                let command = Command::Column(bank.active);
                self.consider(time, entry.age, command, now, rules, &mut best);
            }
        }
        if !self.due.is_empty() {
            self.consider_refresh(now, rules, &mut best);
        } else {
            if best[0].time > now || rules.column_bus {
                self.set_direction(rules);
            }
            let mode = self.direction();
            let mut left = self.waiting[mode];
            if rules.scheduler == Scheduler::Fcfs {
                left = self.oldest(mode);
            }
            while left != 0 {
                let number = left.trailing_zeros() as usize;
                left &= left - 1;
                self.consider_bank(number, mode, now, rules, &mut best);
            }
        }
        self.best = best;
        self.planned = true;
    }

    /// The bank of the oldest entry of a direction.
    fn oldest(&self, mode: usize) -> u64 {
        let mut left = self.waiting[mode];
        let mut oldest = (u64::MAX, 0);
        while left != 0 {
            let number = left.trailing_zeros();
            left &= left - 1;
            let head = self.banks[number as usize].lists[mode].head;
            oldest = oldest.min((self.entries.get(head).age, 1 << number));
        }
        oldest.1
    }

    /// Considers the next commands for the entries of a bank: the column of the oldest row hit, and
    /// a precharge or an activate for the oldest other entry.
    #[inline]
    pub(super) fn consider_bank(
        &self,
        number: usize,
        mode: usize,
        now: u64,
        rules: &Rules,
        best: &mut [Candidate; 2],
    ) {
        let bank = &self.banks[number];
        let (list, group) = (&bank.lists[mode], &self.groups[usize::from(bank.group)]);
        let mut blocked = bank.active != NONE;
        let only_head = rules.scheduler == Scheduler::Fcfs;
        if list.hit != NONE && !(only_head && list.hit != list.head) {
            let hit = self.entries.get(list.hit);
            let time = bank.column_ok[mode].max(group.column_ok[mode]);
            self.consider(time, BY_AGE | hit.age, Command::Column(list.hit), now, rules, best);
            blocked |= rules.scheduler == Scheduler::FrFcfsRowHit
                && list.miss != NONE
                && hit.accepted <= self.entries.get(list.miss).accepted;
        }
        if blocked || list.miss == NONE || (only_head && list.miss != list.head) {
            return;
        }
        let age = BY_AGE | self.entries.get(list.miss).age;
        let pseudo = &self.pseudo_channels[usize::from(bank.pseudo)];
        if bank.row != CLOSED {
            let time = bank.precharge_ok.max(pseudo.precharge_ok);
            self.consider(time, age, Command::Precharge(list.miss), now, rules, best);
        } else if self.second.is_none() {
            let faw_end = pseudo.faw_ends[pseudo.faw_oldest];
            let time = bank.activate_ok.max(group.activate_ok).max(faw_end);
            self.consider(time, age, Command::Activate(list.miss), now, rules, best);
        }
    }

    /// Keeps a command if it is the best of its bus.
    #[inline]
    pub(super) fn consider(
        &self,
        time: u64,
        priority: u64,
        command: Command,
        now: u64,
        rules: &Rules,
        best: &mut [Candidate; 2],
    ) {
        let bus = usize::from(rules.column_bus && !matches!(command, Command::Column(_)));
        let time = time.max(self.bus_free[bus]).max(now);
        let best = &mut best[bus];
        if (time, priority) < (best.time, best.priority) {
            *best = Candidate { time, priority, command };
        }
    }
}
