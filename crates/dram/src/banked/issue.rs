//! Issue of commands: their effects on the state of a channel.

use super::channel::{ACTIVATE, BankedChannel, Due, PRECHARGE};
use super::front::Front;
use super::log::CommandKind;
use super::plan::{COLUMN, Candidate, PlannedCommand};
use super::queue::{CLOSED, NONE, QueueEntry};
use super::rules::{Known, READ, Rules, WRITE};
use crate::device::Refresh;
use crate::stats::CLASSES;

/// What the first command for a burst was: it found its row open, the bank closed, or another row.
const HIT: usize = 0;
const MISS: usize = 1;
const CONFLICT: usize = 2;

impl BankedChannel {
    /// Issues a command at `now`.
    pub(super) fn issue<const P: bool>(
        &mut self,
        candidate: Candidate,
        now: u64,
        rules: Known<'_, P>,
        front: &mut Front,
    ) {
        self.planned = false;
        self.look_from = now + 1;
        self.log(now, &candidate);
        let (number, entry) = (usize::from(candidate.bank), candidate.entry);
        match candidate.command {
            PlannedCommand::Column => {
                self.occupy(0, now + rules.column_cycles, rules);
                let (slot, time) = self.column(number, entry, now, rules);
                front.burst_done(slot, time);
                // An entry of a queue may be free.
                self.may_accept(now + 1);
            }
            PlannedCommand::Activate => {
                self.occupy(1, now + rules.activate_cycles, rules);
                self.activate(number, entry, now, rules);
                // An entry of a queue may be free.
                self.may_accept(now + 1);
            }
            PlannedCommand::Precharge => {
                self.occupy(1, now + rules.precharge_cycles, rules);
                self.count_first(entry, CONFLICT);
                self.precharge(number, now, rules);
            }
            PlannedCommand::PrechargeBank
            | PlannedCommand::PrechargeAll
            | PlannedCommand::RefreshAll
            | PlannedCommand::RefreshBank => {
                self.occupy(1, now + rules.precharge_cycles, rules);
                self.refresh(candidate.command, number, now, rules);
            }
        }
    }

    /// Issues a command of a refresh.
    #[cold]
    fn refresh<const P: bool>(
        &mut self,
        command: PlannedCommand,
        number: usize,
        now: u64,
        rules: Known<'_, P>,
    ) {
        match command {
            PlannedCommand::PrechargeBank => self.precharge(number, now, rules),
            PlannedCommand::PrechargeAll => self.precharge_all(number, now, rules),
            PlannedCommand::RefreshAll => {
                self.refresh_all(number, now, rules);
                self.counts.refreshes_all += 1;
                self.due.remove(0);
            }
            _ => {
                self.refresh_bank(number, now, rules);
                self.counts.refreshes_bank += 1;
                self.due.remove(0);
            }
        }
        // Times of many banks have moved at once, so that no class is still right.
        self.forget_classes();
    }

    #[inline]
    fn occupy<const P: bool>(&mut self, bus: usize, until: u64, rules: Known<'_, P>) {
        if rules.column_bus() {
            self.bus_free[bus] = until;
        } else {
            self.bus_free = [until; 2];
        }
    }

    /// Counts a row hit, miss or conflict: what the first command for an entry was.
    #[inline]
    fn count_first(&mut self, entry: u16, which: usize) {
        let entry = self.entries.get_mut(entry);
        let first = u64::from(!entry.tried);
        entry.tried = true;
        self.counts.classes[usize::from(entry.class) % CLASSES].first[which] += first;
    }

    /// Takes an entry out of its queue.
    #[inline]
    fn leave_queue(&mut self, number: usize, index: u16) {
        let &QueueEntry { burst, write, .. } = self.entries.get(index);
        let kind = usize::from(write);
        let bank = self.banks.at_mut(number);
        self.entries.unlink(index, &mut bank.lists[kind], bank.row);
        self.len[kind] -= 1;
        if write {
            self.written.remove(burst);
            self.overdue = self.overdue.saturating_sub(1);
        }
    }

    #[inline]
    fn column<const P: bool>(
        &mut self,
        number: usize,
        index: u16,
        now: u64,
        rules: Known<'_, P>,
    ) -> (u32, u64) {
        self.count_first(index, HIT);
        let &QueueEntry { slot, write, class, .. } = self.entries.get(index);
        let kind = usize::from(write);
        let bank = self.banks.at_mut(number);
        let (pseudo, own) = (rules.shared(bank.pseudo), rules.shared(bank.group));
        let precharge_ok = &mut bank.row_ok[PRECHARGE];
        *precharge_ok = (*precharge_ok).max(now + rules.column_to_precharge[kind]);
        if bank.active == index {
            bank.active = NONE;
            let has_others = bank.lists[1 - kind].head != NONE;
            self.active &= !(1 << number);
            self.columns[kind] &= !(1 << number);
            if has_others {
                self.set_keys(number, 1 - kind, rules);
            }
        } else {
            self.leave_queue(number, index);
        }
        self.set_keys(number, kind, rules);
        self.entries.release(index);
        let (short, long) = match write {
            true => (rules.write_to_read_short, rules.write_to_read_long),
            false => (rules.read_to_write, rules.read_to_write),
        };
        // Columns keep their distance within the pseudo channel, a longer one within the bank
        // group.
        let first = pseudo * rules.groups();
        for i in first..first + rules.groups() {
            let same = i == own;
            let apart = if same { rules.column_long } else { rules.column_short };
            let other = if same { long } else { short };
            let ok = &mut self.groups.at_mut(i).column_ok;
            ok[kind] = ok[kind].max(now + apart);
            ok[1 - kind] = ok[1 - kind].max(now + other);
        }
        self.pseudo_channels.at_mut(pseudo).bursts += 1;
        if rules.has_extras()
            && let Some(runs) = rules.clock_runs
        {
            self.clock_until = self.clock_until.max(now + runs[kind]);
        }
        self.counts.classes[usize::from(class) % CLASSES].columns[kind] += 1;
        self.classes[COLUMN].set_stale();
        self.row_changed(number, self.bus_free[1].max(now), rules);
        if rules.closes_rows() {
            self.auto_precharge(number, now, rules);
        }
        if self.is_empty() {
            self.sleep.rest(now, self.open != 0, &rules.sleep_after);
        }
        // A read is done with its data; what is written has been in the queue since its acceptance.
        (slot, if write { now } else { now + rules.read_data })
    }

    /// Auto-precharge (closed page): the bank closes by itself if no burst waits for its row.
    fn auto_precharge<const P: bool>(&mut self, number: usize, now: u64, rules: Known<'_, P>) {
        let bank = self.banks.at_mut(number);
        if bank.active != NONE || bank.lists[READ].hit != NONE || bank.lists[WRITE].hit != NONE {
            return;
        }
        // No command is issued: the bank closes as soon as tRAS and tRTP or tWR allow it.
        let closes = bank.row_ok[PRECHARGE];
        let activate_ok = &mut bank.row_ok[ACTIVATE];
        *activate_ok = (*activate_ok).max(closes + rules.precharge_to_activate);
        self.close(number, now, rules);
        self.forget_classes();
        self.counts.precharges += 1;
        self.note(closes, number, CommandKind::AutoPrecharge);
    }

    #[inline]
    fn activate<const P: bool>(
        &mut self,
        number: usize,
        index: u16,
        now: u64,
        rules: Known<'_, P>,
    ) {
        self.count_first(index, MISS);
        self.counts.activates += 1;
        // Its place in the queue is free before its column: the bank stays open for it (`active`).
        self.leave_queue(number, index);
        let row = self.entries.get(index).row;
        let bank = self.banks.at_mut(number);
        bank.active = index;
        bank.row_ok = [now + rules.activate_to_activate, now + rules.activate_to_precharge];
        bank.column_ok = rules.activate_to_column.map(|d| now + d);
        let (pseudo, own) = (rules.shared(bank.pseudo), rules.shared(bank.group));
        self.active |= 1 << number;
        let first = pseudo * rules.groups();
        for i in first..first + rules.groups() {
            let apart = if i == own { rules.activate_long } else { rules.activate_short };
            let ok = &mut self.groups.at_mut(i).activate_ok;
            *ok = (*ok).max(now + apart);
        }
        let pseudo = self.pseudo_channels.at_mut(pseudo);
        // Of the last four windows the oldest bounds the next activate.
        pseudo.faw_ends[pseudo.faw_oldest % 4] = now + rules.four_activates;
        pseudo.faw_oldest = (pseudo.faw_oldest + 1) % 4;
        pseudo.faw_ok = pseudo.faw_ends[pseudo.faw_oldest];
        self.classes[ACTIVATE].set_stale();
        match rules.second_within {
            Some(within) if rules.has_extras() => {
                self.second = Some((number as u8, now + within));
                self.set_keys(number, READ, rules);
                self.set_keys(number, WRITE, rules);
            }
            _ => self.open(number, row, now, rules),
        }
    }

    /// The second half of an activate.
    pub(super) fn second_half<const P: bool>(&mut self, now: u64, rules: Known<'_, P>) {
        let Some((number, _)) = self.second.take() else { return };
        self.planned = false;
        self.look_from = now + 1;
        self.bus_free = [now + 1; 2];
        let number = usize::from(number);
        let row = self.entries.get(self.banks.at(number).active).row;
        self.open(number, row, now, rules);
        self.note(now, number, CommandKind::SecondHalf);
    }

    /// Opens a row for the active entry of a bank.
    #[inline]
    fn open<const P: bool>(&mut self, number: usize, row: u32, now: u64, rules: Known<'_, P>) {
        // Time with a row open begins with the first row of the channel.
        if self.open == 0 {
            self.sleep.count(now, false, &rules.sleep_after);
        }
        self.open |= 1 << number;
        let bank = self.banks.at_mut(number);
        bank.row = row;
        let kind = usize::from(self.entries.get(bank.active).write);
        self.columns[kind] |= 1 << number;
        for direction in [READ, WRITE] {
            let list = &mut self.banks.at_mut(number).lists[direction];
            if list.head != NONE || direction == kind {
                self.entries.row_opened(list, row);
                self.set_keys(number, direction, rules);
            }
        }
        let floor = self.bus_free[0].max(now);
        self.column_changed(number, kind, floor, rules);
        // The column of an activated row goes whatever the direction is.
        if kind != self.direction() {
            self.column_changed(number, 1 - kind, floor, rules);
        }
    }

    #[inline]
    fn close<const P: bool>(&mut self, number: usize, now: u64, rules: Known<'_, P>) {
        self.open &= !(1 << number);
        if self.open == 0 {
            self.sleep.count(now, true, &rules.sleep_after);
        }
        self.banks.at_mut(number).row = CLOSED;
        self.set_closed_keys(number, READ);
        self.set_closed_keys(number, WRITE);
    }

    #[inline]
    fn precharge<const P: bool>(&mut self, number: usize, now: u64, rules: Known<'_, P>) {
        self.counts.precharges += 1;
        let bank = self.banks.at_mut(number);
        let activate_ok = &mut bank.row_ok[ACTIVATE];
        *activate_ok = (*activate_ok).max(now + rules.precharge_to_activate);
        let pseudo = self.pseudo_channels.at_mut(rules.shared(bank.pseudo));
        pseudo.precharge_ok = now + rules.precharge_to_precharge;
        self.close(number, now, rules);
        self.classes[PRECHARGE].set_stale();
        self.row_changed(number, self.bus_free[1].max(now), rules);
        self.column_changed(number, self.direction(), self.bus_free[0].max(now), rules);
    }

    fn precharge_all<const P: bool>(&mut self, first: usize, now: u64, rules: Known<'_, P>) {
        self.counts.precharges_all += 1;
        for number in first..first + rules.groups * rules.group_banks {
            if self.banks.at(number).row != CLOSED {
                self.close(number, now, rules);
            }
        }
        let pseudo = self.pseudo_channels.at_mut(self.banks.at(first).pseudo);
        pseudo.precharge_ok = now + rules.precharge_to_precharge;
        pseudo.refresh_ok = now + rules.precharge_all_to_refresh;
    }

    fn refresh_all<const P: bool>(&mut self, first: usize, now: u64, rules: Known<'_, P>) {
        for number in first..first + rules.groups * rules.group_banks {
            self.banks.at_mut(number).row_ok[ACTIVATE] = now + rules.refresh_all_to_activate;
        }
    }

    /// A refresh of one bank counts as an activate for tRRD of the other banks.
    fn refresh_bank<const P: bool>(&mut self, number: usize, now: u64, rules: Known<'_, P>) {
        let bank = self.banks.at_mut(number);
        bank.row_ok[ACTIVATE] = now + rules.refresh_bank_to_activate;
        let first = usize::from(bank.pseudo) * rules.groups;
        for group in first..first + rules.groups {
            let ok = &mut self.groups.at_mut(group).activate_ok;
            *ok = (*ok).max(now + rules.activate_short);
        }
    }

    /// Puts the refreshes whose interval (tREFI) has passed into the list of those due.
    pub(super) fn refresh_due<const P: bool>(&mut self, now: u64, rules: Known<'_, P>) {
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
    pub(super) fn skip_refreshes(&mut self, until: u64, rules: &Rules) -> bool {
        if self.next_refresh == u64::MAX || self.open != 0 || !self.due.is_empty() {
            return false;
        }
        let intervals = until.saturating_sub(self.next_refresh) / rules.refresh_interval;
        // Whole rounds, so that the bank whose turn it is stays the same.
        let round = if rules.refresh == Refresh::PerBank { rules.banks() as u64 } else { 1 };
        // The last round is simulated, so that banks are as a refresh leaves them.
        let skipped = (intervals / round).saturating_sub(1) * round;
        self.next_refresh += skipped * rules.refresh_interval;
        if rules.refresh == Refresh::PerBank {
            self.counts.refreshes_bank += skipped;
        } else {
            self.counts.refreshes_all += skipped * rules.pseudo_channels as u64;
        }
        skipped > 0
    }

    /// Considers the next command of the refresh that is due.
    pub(super) fn consider_refresh<const P: bool>(&mut self, now: u64, rules: Known<'_, P>) {
        let due = self.due[0];
        let (first, end) = match due {
            Due::PseudoChannel(pseudo) => {
                let banks = rules.groups * rules.group_banks;
                (usize::from(pseudo) * banks, (usize::from(pseudo) + 1) * banks)
            }
            Due::Bank(bank) => (usize::from(bank), usize::from(bank) + 1),
        };
        let banks = || (first..end).map(|number| self.banks.at(number));
        // Rows that were opened for a request are used first, or their activates were wasted.
        if banks().any(|b| b.active != NONE) {
            return;
        }
        let bank = self.banks.at(first);
        let pseudo = self.pseudo_channels.at(bank.pseudo);
        let open = banks().any(|b| b.row != CLOSED);
        let after = rules.refresh_after_activate;
        let closed = banks().map(|b| b.row_ok[ACTIVATE] + after).max().unwrap_or(0);
        let precharge = banks().map(|b| b.row_ok[PRECHARGE]).max().unwrap_or(0);
        let precharge = precharge.max(pseudo.precharge_ok);
        let (time, command) = match (due, open) {
            (Due::PseudoChannel(_), true) => (precharge, PlannedCommand::PrechargeAll),
            (Due::PseudoChannel(_), false) => {
                (closed.max(pseudo.refresh_ok), PlannedCommand::RefreshAll)
            }
            (Due::Bank(_), true) => (precharge, PlannedCommand::PrechargeBank),
            (Due::Bank(_), false) => {
                let group = self.groups.at(bank.group).activate_ok;
                (closed.max(group + after), PlannedCommand::RefreshBank)
            }
        };
        // After the columns of activated rows; no request is considered while a refresh is due.
        self.consider_row(time, command, first as u8, now, rules);
    }
}
