//! Issue of commands: their effects on the state of a channel.

use super::channel::{Channel, Due, StepResult};
use super::log::CommandKind;
use super::plan::{Candidate, Command};
use super::queue::{CLOSED, Entry, NONE};
use super::rules::{READ, Rules, WRITE};
use crate::dram::device::{Page, Refresh};
use crate::dram::stats::{Stats, Traffic};

impl Channel {
    /// Issues a command at `now`.
    pub(super) fn issue(
        &mut self,
        command: Command,
        now: u64,
        rules: &Rules,
        stats: &mut Stats,
        outcome: &mut StepResult,
    ) {
        self.planned = false;
        self.look_from = now + 1;
        self.log(now, command, rules);
        match command {
            Command::Column(entry) => {
                self.occupy(0, now + rules.column_cycles, rules);
                outcome.column = Some(self.column(entry, now, rules, stats));
                outcome.freed = true;
            }
            Command::Activate(entry) => {
                self.occupy(1, now + rules.activate_cycles, rules);
                self.activate(entry, now, rules, stats);
                outcome.freed = true;
            }
            Command::Precharge(entry) => {
                self.occupy(1, now + rules.precharge_cycles, rules);
                self.count_first(entry, stats, |t| &mut t.row_conflicts);
                let bank = self.entries.get(entry).bank;
                self.precharge(bank, now, rules, stats);
            }
            Command::PrechargeBank(bank) => {
                self.occupy(1, now + rules.precharge_cycles, rules);
                self.precharge(bank, now, rules, stats);
            }
            Command::PrechargeAll(pseudo) => {
                self.occupy(1, now + rules.precharge_cycles, rules);
                self.precharge_all(pseudo, now, rules, stats);
            }
            Command::RefreshAll(pseudo) => {
                self.occupy(1, now + rules.precharge_cycles, rules);
                self.refresh_all(pseudo, now, rules);
                stats.refreshes_all += 1;
                self.due.remove(0);
            }
            Command::RefreshBank(bank) => {
                self.occupy(1, now + rules.precharge_cycles, rules);
                self.refresh_bank(bank, now, rules);
                stats.refreshes_bank += 1;
                self.due.remove(0);
            }
        }
    }

    fn occupy(&mut self, bus: usize, until: u64, rules: &Rules) {
        if rules.column_bus {
            self.bus_free[bus] = until;
        } else {
            self.bus_free = [until; 2];
        }
    }

    /// Counts a row hit, miss or conflict: what the first command for an entry was.
    fn count_first(&mut self, entry: u16, stats: &mut Stats, which: fn(&mut Traffic) -> &mut u64) {
        let entry = self.entries.get_mut(entry);
        if !entry.tried {
            entry.tried = true;
            *which(&mut stats.total) += 1;
            *which(&mut stats.classes[usize::from(entry.class)]) += 1;
        }
    }

    /// Takes an entry out of its queue.
    fn leave_queue(&mut self, index: u16) {
        let Entry { burst, bank: number, write, .. } = *self.entries.get(index);
        let kind = usize::from(write);
        let bank = &mut self.banks[usize::from(number)];
        let list = &mut bank.lists[kind];
        self.entries.unlink(index, list, bank.row);
        if list.head == NONE {
            self.waiting[kind] &= !(1 << number);
        }
        self.len[kind] -= 1;
        if write && let Some(at) = self.written.iter().position(|w| *w == burst) {
            self.written.swap_remove(at);
        }
    }

    fn column(&mut self, index: u16, now: u64, rules: &Rules, stats: &mut Stats) -> (u32, u64) {
        self.count_first(index, stats, |t| &mut t.row_hits);
        let Entry { slot, bank: number, write, class, .. } = *self.entries.get(index);
        let number = usize::from(number);
        if self.banks[number].active == index {
            self.banks[number].active = NONE;
            self.active &= !(1 << number);
        } else {
            self.leave_queue(index);
        }
        self.entries.release(index);
        let kind = usize::from(write);
        let (pseudo, own) = (usize::from(self.banks[number].pseudo), self.banks[number].group);
        let first = pseudo * rules.groups;
        let turn = [rules.write_to_read_short, rules.read_to_write];
        for (i, group) in self.groups[first..first + rules.groups].iter_mut().enumerate() {
            let same = first + i == usize::from(own);
            let apart = if same { rules.column_long } else { rules.column_short };
            let other = match (kind, same) {
                (WRITE, true) => rules.write_to_read_long,
                (WRITE, false) => turn[0],
                _ => turn[1],
            };
            let ok = &mut group.column_ok;
            ok[kind] = ok[kind].max(now + apart);
            ok[1 - kind] = ok[1 - kind].max(now + other);
        }
        self.pseudo_channels[pseudo].bursts += 1;
        let bank = &mut self.banks[number];
        bank.precharge_ok = bank.precharge_ok.max(now + rules.column_to_precharge[kind]);
        if let Some(runs) = rules.clock_runs {
            self.clock_until = self.clock_until.max(now + runs[kind]);
        }
        if write {
            stats.writes += 1
        } else {
            stats.reads += 1
        }
        for traffic in [&mut stats.total, &mut stats.classes[usize::from(class)]] {
            traffic.moved_bytes += rules.burst_bytes;
            *(if write { &mut traffic.writes } else { &mut traffic.reads }) += 1;
        }
        if rules.page == Page::Closed {
            self.auto_precharge(number, now, rules, stats);
        }
        if self.is_empty() {
            self.sleep.rest(now, self.open_banks > 0, &rules.sleep_after);
        }
        (slot, if write { now } else { now + rules.read_data })
    }

    /// Auto-precharge (closed page): the bank closes by itself if no burst waits for its row.
    fn auto_precharge(&mut self, number: usize, now: u64, rules: &Rules, stats: &mut Stats) {
        let bank = &self.banks[number];
        if bank.active != NONE || bank.lists[READ].hit != NONE || bank.lists[WRITE].hit != NONE {
            return;
        }
        let closes = bank.precharge_ok;
        self.banks[number].activate_ok = bank.activate_ok.max(closes + rules.precharge_to_activate);
        self.close(number, now, rules);
        stats.precharges += 1;
        self.note(closes, number, CommandKind::AutoPrecharge);
    }

    fn activate(&mut self, index: u16, now: u64, rules: &Rules, stats: &mut Stats) {
        self.count_first(index, stats, |t| &mut t.row_misses);
        stats.activates += 1;
        self.leave_queue(index);
        let Entry { bank: number, row, .. } = *self.entries.get(index);
        let bank = &mut self.banks[usize::from(number)];
        bank.active = index;
        bank.activate_ok = now + rules.activate_to_activate;
        bank.column_ok = rules.activate_to_column.map(|d| now + d);
        bank.precharge_ok = now + rules.activate_to_precharge;
        let (pseudo, own) = (usize::from(bank.pseudo), usize::from(bank.group));
        self.active |= 1 << number;
        let first = pseudo * rules.groups;
        for (i, group) in self.groups[first..first + rules.groups].iter_mut().enumerate() {
            let same = first + i == own;
            let apart = if same { rules.activate_long } else { rules.activate_short };
            group.activate_ok = group.activate_ok.max(now + apart);
        }
        let pseudo = &mut self.pseudo_channels[pseudo];
        pseudo.faw_ends[pseudo.faw_oldest] = now + rules.four_activates;
        pseudo.faw_oldest = (pseudo.faw_oldest + 1) % 4;
        match rules.second_within {
            Some(within) => {
                self.banks[usize::from(number)].half = true;
                self.second = Some((number, now + within));
            }
            None => self.open(number, row, now, rules),
        }
    }

    /// The second half of an activate.
    pub(super) fn second_half(&mut self, now: u64, rules: &Rules) {
        let Some((number, _)) = self.second.take() else { return };
        self.planned = false;
        self.look_from = now + 1;
        self.bus_free = [now + 1; 2];
        let bank = &mut self.banks[usize::from(number)];
        bank.half = false;
        let row = self.entries.get(bank.active).row;
        self.open(number, row, now, rules);
        self.note(now, usize::from(number), CommandKind::SecondHalf);
    }

    fn open(&mut self, number: u8, row: u32, now: u64, rules: &Rules) {
        if self.open_banks == 0 {
            self.sleep.count(now, false, &rules.sleep_after);
        }
        self.open_banks += 1;
        let bank = &mut self.banks[usize::from(number)];
        bank.row = row;
        bank.lists.iter_mut().for_each(|list| self.entries.row_changed(list, row));
    }

    fn close(&mut self, number: usize, now: u64, rules: &Rules) {
        self.open_banks -= 1;
        if self.open_banks == 0 {
            self.sleep.count(now, true, &rules.sleep_after);
        }
        let bank = &mut self.banks[number];
        bank.row = CLOSED;
        bank.lists.iter_mut().for_each(|list| self.entries.row_changed(list, CLOSED));
    }

    fn precharge(&mut self, number: u8, now: u64, rules: &Rules, stats: &mut Stats) {
        stats.precharges += 1;
        let number = usize::from(number);
        let bank = &mut self.banks[number];
        bank.activate_ok = bank.activate_ok.max(now + rules.precharge_to_activate);
        let pseudo = usize::from(bank.pseudo);
        self.pseudo_channels[pseudo].precharge_ok = now + rules.precharge_to_precharge;
        self.close(number, now, rules);
    }

    fn precharge_all(&mut self, pseudo: u8, now: u64, rules: &Rules, stats: &mut Stats) {
        stats.precharges_all += 1;
        for number in self.banks_of(pseudo, rules) {
            if self.banks[number].row != CLOSED {
                self.close(number, now, rules);
            }
        }
        let pseudo = &mut self.pseudo_channels[usize::from(pseudo)];
        pseudo.precharge_ok = now + rules.precharge_to_precharge;
        pseudo.refresh_ok = now + rules.precharge_all_to_refresh;
    }

    fn refresh_all(&mut self, pseudo: u8, now: u64, rules: &Rules) {
        for number in self.banks_of(pseudo, rules) {
            self.banks[number].activate_ok = now + rules.refresh_all_to_activate;
        }
    }

    /// A refresh of one bank counts as an activate for tRRD of the other banks.
    fn refresh_bank(&mut self, bank: u8, now: u64, rules: &Rules) {
        let bank = &mut self.banks[usize::from(bank)];
        bank.activate_ok = now + rules.refresh_bank_to_activate;
        let first = usize::from(bank.pseudo) * rules.groups;
        for group in &mut self.groups[first..first + rules.groups] {
            group.activate_ok = group.activate_ok.max(now + rules.activate_short);
        }
    }

    fn banks_of(&self, pseudo: u8, rules: &Rules) -> std::ops::Range<usize> {
        let banks = rules.groups * rules.group_banks;
        let first = usize::from(pseudo) * banks;
        first..first + banks
    }

    /// Puts the refreshes whose interval (tREFI) has passed into the list of those due.
    pub(super) fn refresh_due(&mut self, now: u64, rules: &Rules) {
        while now >= self.next_refresh {
            self.next_refresh += rules.refresh_interval;
            self.planned = false;
            if rules.refresh == Refresh::PerBank {
                self.due.push(Due::Bank(self.refresh_bank));
                self.refresh_bank = (self.refresh_bank + 1) % rules.banks() as u8;
            } else {
                self.due.extend((0..rules.pseudo_channels as u8).map(Due::PseudoChannel));
            }
        }
    }

    /// Counts the refreshes of an idle channel before `until`, but for the last round, without
    /// simulating them; returns whether there were any.
    pub(super) fn skip_refreshes(&mut self, until: u64, rules: &Rules, stats: &mut Stats) -> bool {
        if self.next_refresh == u64::MAX || self.open_banks > 0 || !self.due.is_empty() {
            return false;
        }
        let intervals = until.saturating_sub(self.next_refresh) / rules.refresh_interval;
        let round = if rules.refresh == Refresh::PerBank { rules.banks() as u64 } else { 1 };
        let skipped = (intervals / round).saturating_sub(1) * round;
        self.next_refresh += skipped * rules.refresh_interval;
        if rules.refresh == Refresh::PerBank {
            stats.refreshes_bank += skipped;
        } else {
            stats.refreshes_all += skipped * rules.pseudo_channels as u64;
        }
        skipped > 0
    }

    /// Considers the next command of the refresh that is due.
    pub(super) fn consider_refresh(&self, now: u64, rules: &Rules, best: &mut [Candidate; 2]) {
        let banks = match self.due[0] {
            Due::PseudoChannel(pseudo) => self.banks_of(pseudo, rules),
            Due::Bank(bank) => usize::from(bank)..usize::from(bank) + 1,
        };
        let banks = &self.banks[banks];
        if banks.iter().any(|b| b.active != NONE) {
            return;
        }
        let pseudo = &self.pseudo_channels[usize::from(banks[0].pseudo)];
        let open = banks.iter().any(|b| b.row != CLOSED);
        let after = rules.refresh_after_activate;
        let closed = banks.iter().map(|b| b.activate_ok + after).max().unwrap_or(0);
        let precharge = banks.iter().map(|b| b.precharge_ok).max().unwrap_or(0);
        let precharge = precharge.max(pseudo.precharge_ok);
        let (time, command) = match (self.due[0], open) {
            (Due::PseudoChannel(r), true) => (precharge, Command::PrechargeAll(r)),
            (Due::PseudoChannel(r), false) => {
                (closed.max(pseudo.refresh_ok), Command::RefreshAll(r))
            }
            (Due::Bank(b), true) => (precharge, Command::PrechargeBank(b)),
            (Due::Bank(b), false) => {
                let group = self.groups[usize::from(banks[0].group)].activate_ok;
                (closed.max(group + after), Command::RefreshBank(b))
            }
        };
        // After the columns of activated rows; no request is considered while a refresh is due.
        self.consider(time, 1 << 62, command, now, rules, best);
    }
}
