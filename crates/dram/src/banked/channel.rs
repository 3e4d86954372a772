//! One channel and its controller: queues, banks, command buses.
//!
//! Timing rule: of all commands that meet their timing constraints in a CK, the column command of a
//! request whose row was activated for it goes first, then a refresh, then the oldest request of
//! the current direction (read or write). The channel keeps the earliest command as its plan; an
//! accepted request can only improve the plan, an issued command makes a new one. The scheduler is
//! in `plan`, the effects of commands on the state in `issue`, the command log in `log`.
//! Source: `ramulator`, controllers of version 2.1.

use super::class::{Class, NO_KEY};
use super::counts::BankedCounts;
use super::front::{Burst, Fifo, Front};
use super::log::{CommandKind, Logged};
use super::plan::{Candidate, PlannedCommand};
use super::queue::{CLOSED, Entries, NONE, QueueList, Writes};
use super::rules::{Known, READ, Rules, WRITE};
use super::sleep::Sleep;
use super::table::Table;
use crate::device::Refresh;
use crate::stats::CLASSES;

/// A bank.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Bank {
    /// First CK in which a read and a write meet the timing constraints of the bank.
    pub column_ok: [u64; 2],
    /// The same of an activate and a precharge: of the row command while the bank is closed and
    /// while it is open.
    pub row_ok: [u64; 2],
    /// Keys of its next column commands in each direction (`plan`).
    pub column_key: [u64; 2],
    /// The same of the row command that its waiting requests of each direction want.
    pub row_key: [u64; 2],
    /// The open row, or [`CLOSED`].
    pub row: u32,
    /// The entry whose row was activated and whose column command has not been issued.
    pub active: u16,
    /// Pseudo channel, and group counted through the channel.
    pub pseudo: u8,
    pub group: u8,
    /// Waiting reads and writes.
    pub lists: [QueueList; 2],
}

impl Bank {
    const CLOSED: Bank = Bank {
        column_ok: [0; 2],
        row_ok: [0; 2],
        column_key: [NO_KEY; 2],
        row_key: [NO_KEY; 2],
        row: CLOSED,
        active: NONE,
        pseudo: 0,
        group: 0,
        lists: [QueueList::EMPTY; 2],
    };
}

/// Row commands: while a bank is closed, and while it is open.
pub(super) const ACTIVATE: usize = 0;
/// See [`ACTIVATE`].
pub(super) const PRECHARGE: usize = 1;

/// Timing constraints that the banks of a bank group share.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ChannelGroup {
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
    /// First CK for the next activate after the last four.
    pub faw_ok: u64,
    pub precharge_ok: u64,
    /// First CK for a refresh after a precharge of all banks.
    pub refresh_ok: u64,
    /// Bursts on the data bus so far.
    pub bursts: u64,
}

/// A refresh that is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Due {
    PseudoChannel(u8),
    Bank(u8),
}

/// A channel.
#[derive(Debug, Clone)]
pub(super) struct BankedChannel {
    /// Bursts that wait for the controller.
    pub fifo: Fifo,
    /// The CK in which the first of them may be accepted, as far as is known.
    pub accepts: u64,
    /// The CK of the next step.
    pub wake: u64,
    pub entries: Entries,
    pub banks: Table<Bank>,
    pub groups: Table<ChannelGroup>,
    pub pseudo_channels: Table<PseudoChannel>,
    /// Entries in the read and the write queue.
    pub len: [usize; 2],
    /// Banks with an open row, one bit each.
    pub open: u64,
    /// Banks with an active entry.
    pub active: u64,
    /// Of these, the ones whose row is open, by the direction of the entry.
    pub columns: [u64; 2],
    /// Banks that want a row command and a column, by the direction of the requests.
    pub wanted: [[u64; 2]; 2],
    /// The first activate, precharge and column of all banks.
    pub classes: [Class; 3],
    /// Bursts in the write queue: later accesses to them are forwarded or absorbed.
    pub written: Writes,
    /// Whether writes are drained.
    pub write_mode: bool,
    /// The first CK in which writes have waited for too long while reads go on.
    pub late_from: u64,
    /// Writes that still go before the direction turns, because they had waited for too long.
    pub overdue: usize,
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
    pub synced: Option<Candidate>,
    /// The CK in which the data clock stops; never if it always runs.
    pub clock_until: u64,
    pub sleep: Sleep,
    pub counts: BankedCounts,
    /// The commands, if they are kept.
    pub log: Option<Vec<Logged>>,
}

impl BankedChannel {
    pub(super) fn new(rules: &Rules) -> Self {
        let mut banks = Table::new(Bank::CLOSED);
        for i in 0..rules.banks() {
            let bank = banks.at_mut(i);
            bank.pseudo = (i / (rules.groups * rules.group_banks)) as u8;
            bank.group = (i / rules.group_banks) as u8;
        }
        let refresh = match rules.refresh {
            Refresh::None => u64::MAX,
            Refresh::AllBank | Refresh::PerBank => rules.refresh_interval,
        };
        Self {
            fifo: Fifo::new(),
            accepts: u64::MAX,
            wake: refresh,
            entries: Entries::new(rules.queue[0] + rules.queue[1] + rules.banks()),
            banks,
            groups: Table::new(ChannelGroup::default()),
            pseudo_channels: Table::new(PseudoChannel::default()),
            len: [0; 2],
            open: 0,
            active: 0,
            columns: [0; 2],
            wanted: [[0; 2]; 2],
            classes: [Class::STALE; 3],
            written: Writes::default(),
            write_mode: false,
            late_from: u64::MAX,
            overdue: 0,
            look_from: u64::MAX,
            bus_free: [0; 2],
            best: [Candidate::NEVER; 2],
            planned: false,
            next_refresh: refresh,
            due: Vec::new(),
            refresh_bank: 0,
            second: None,
            synced: None,
            clock_until: if rules.clock_runs.is_some() { 0 } else { u64::MAX },
            sleep: Sleep::default(),
            counts: BankedCounts::default(),
            log: None,
        }
    }

    /// Whether no burst waits in the channel.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.len == [0; 2] && self.active == 0
    }

    /// The next CK in which something happens here.
    #[inline]
    pub(super) fn next(&self) -> u64 {
        self.accepts.min(self.wake)
    }

    /// Does what happens in the CK `now`, which is [`BankedChannel::next`].
    #[inline]
    pub(super) fn tick(&mut self, now: u64, rules: &Rules, front: &mut Front) {
        if rules.plain {
            self.tick_known(now, Known::<true>(rules), front);
        } else {
            self.tick_known(now, Known::<false>(rules), front);
        }
    }

    #[inline]
    fn tick_known<const P: bool>(&mut self, now: u64, rules: Known<'_, P>, front: &mut Front) {
        if self.accepts <= now {
            self.accept_heads(now, rules, front);
        }
        if self.wake <= now {
            self.step(now, rules, front);
        }
    }

    /// The head of the FIFO may be accepted from the CK `now` on, but not before it entered.
    #[inline]
    pub(super) fn may_accept(&mut self, now: u64) {
        if let Some(burst) = self.fifo.front() {
            self.accepts = self.accepts.min(now.max(burst.entered));
        }
    }

    /// The heads of the FIFO go into the queues.
    #[inline]
    fn accept_heads<const P: bool>(&mut self, now: u64, rules: Known<'_, P>, front: &mut Front) {
        // A full queue leaves it so: the command that frees an entry looks again (`issue`).
        self.accepts = u64::MAX;
        for _ in 0..rules.acceptances {
            let Some(burst) = self.fifo.front() else { return };
            if burst.entered > now {
                break;
            }
            let direction = usize::from(burst.write);
            // Data that waits to be written answers a read and absorbs a write, without any
            // command.
            if self.len[WRITE] > 0 && self.written.has(burst.number) {
                self.counts.classes[usize::from(burst.class) % CLASSES].merged[direction] += 1;
                front.burst_done(burst.slot, now);
            } else if self.len[direction] < rules.queue[direction] {
                let burst = *burst;
                self.accept(&burst, now, rules);
            } else {
                return;
            }
            if let Some(burst) = self.fifo.pop_front() {
                front.accepted(burst.sequence, now);
            }
        }
        self.may_accept(now + 1);
    }

    /// Accepts a burst, and finds the CK of the next step.
    #[inline]
    fn accept<const P: bool>(&mut self, burst: &Burst, now: u64, rules: Known<'_, P>) {
        // Nothing came in the CK that were skipped: the direction is that of the last of them.
        if self.look_from < now {
            self.set_direction(now - 1, rules);
        }
        if self.is_empty() {
            self.sleep.wake(now, self.open != 0, &rules.sleep_after);
        }
        self.look_from = now;
        let direction = usize::from(burst.write);
        let number = usize::from(burst.bank);
        let bank = self.banks.at_mut(number);
        let row = bank.row;
        let first = self.entries.push(burst, now, &mut bank.lists[direction], row);
        self.len[direction] += 1;
        if burst.write {
            self.written.insert(burst.number);
            if self.len[WRITE] == 1 && !self.write_mode {
                self.writes_wait_from(now, rules);
            }
        }
        // Only the oldest entry of its kind in a bank can be next: a younger one changes no key.
        if first {
            self.set_keys(number, direction, rules);
            if self.direction() == direction {
                self.column_changed(number, direction, self.bus_free[0].max(now), rules);
                self.row_changed(number, self.bus_free[1].max(now), rules);
            }
        }
        let plain = self.due.is_empty();
        // While a refresh is due the plan does not depend on the direction.
        if self.planned && plain && self.turns(now, rules) {
            self.planned = false;
        }
        if self.planned && first && plain && self.direction() == direction {
            // A younger request changes nothing for older ones, with one exception: a hit that was
            // accepted in the same CK keeps the row open.
            let same = |c: &Candidate| usize::from(c.bank) == number;
            if rules.in_order() || same(&self.best[0]) || !P && same(&self.best[1]) {
                self.planned = false;
            } else {
                self.consider_bank(number, now, rules);
            }
        }
        let next = if self.planned { self.best_time::<P>() } else { self.bus_time::<P>() };
        self.wake = self.wake.min(next.max(now)).min(self.next_late(now));
    }

    #[inline]
    pub(super) fn best_time<const P: bool>(&self) -> u64 {
        let [first, row] = &self.best;
        if !P { first.time.min(row.time) } else { first.time }
    }

    /// The first CK in which a command bus is free.
    #[inline]
    fn bus_time<const P: bool>(&self) -> u64 {
        let [first, row] = self.bus_free;
        if P { first } else { first.min(row) }
    }

    /// The CK behind `now` in which writes will have waited for too long.
    #[inline]
    fn next_late(&self, now: u64) -> u64 {
        if self.late_from > now { self.late_from } else { u64::MAX }
    }

    #[inline]
    pub(super) fn direction(&self) -> usize {
        if self.write_mode { WRITE } else { READ }
    }

    /// Issues what can be issued in the CK `now`.
    #[inline]
    fn step<const P: bool>(&mut self, now: u64, rules: Known<'_, P>, front: &mut Front) {
        if now >= self.next_refresh {
            self.refresh_due(now, rules);
        }
        // The plan was for reads.
        self.planned &= now < self.late_from;
        let issued = if rules.column_bus() {
            self.step_two_buses(now, rules, front)
        } else {
            self.step_one_bus(now, rules, front)
        };
        // With a refresh due, or the data clock just synchronised, classes do not say what goes
        // next.
        let steady = !(rules.has_extras() && self.synced.is_some()) && self.due.is_empty();
        if issued && steady && !self.turns(now + 1, rules) {
            self.look_from = u64::MAX;
            self.plan_steadily(now + 1, rules);
        }
        let next =
            if self.planned && steady { self.best_time::<P>() } else { self.bus_time::<P>() };
        self.wake = next.max(now + 1).min(self.next_refresh).min(self.next_late(now));
        if rules.has_extras() && self.second.is_some() {
            self.wake = self.wake.min(now + 1);
        }
    }

    #[inline]
    fn ready<const P: bool>(
        &mut self,
        now: u64,
        bus: usize,
        rules: Known<'_, P>,
    ) -> Option<Candidate> {
        if !self.planned {
            self.plan(now, rules);
        }
        let best = self.best[bus];
        (best.time <= now).then_some(best)
    }

    fn step_two_buses<const P: bool>(
        &mut self,
        now: u64,
        rules: Known<'_, P>,
        front: &mut Front,
    ) -> bool {
        let column = self.ready(now, 0, rules);
        if let Some(candidate) = column {
            // The plan of the row bus holds unless it was for this bank.
            let other = self.best[1].bank != candidate.bank;
            self.issue(candidate, now, rules, front);
            // The column may have turned the direction, for which the row command was not planned.
            let before = self.write_mode;
            if self.due.is_empty() {
                self.set_direction(now, rules);
            }
            self.planned = other && before == self.write_mode && !rules.closes_rows();
        }
        let row = self.ready(now, 1, rules);
        if let Some(candidate) = row {
            self.issue(candidate, now, rules, front);
        }
        if column.is_some() || row.is_some() {
            self.planned = false;
            self.look_from = now + 1;
            return true;
        }
        false
    }

    #[inline]
    fn step_one_bus<const P: bool>(
        &mut self,
        now: u64,
        rules: Known<'_, P>,
        front: &mut Front,
    ) -> bool {
        // At its deadline the second half goes before all else, or its row would not open in time.
        if rules.has_extras() && self.second.is_some_and(|(_, deadline)| deadline <= now) {
            self.second_half(now, rules);
            return true;
        }
        if rules.has_extras()
            && self.synced.is_some()
            && let Some(candidate) = self.synced.take()
        {
            self.issue(candidate, now, rules, front);
            return true;
        }
        if !self.planned {
            self.plan(now, rules);
        }
        let candidate = self.best[0];
        if candidate.time > now {
            let halved = rules.has_extras() && self.second.is_some() && self.bus_free[0] <= now;
            if halved {
                self.second_half(now, rules);
            }
            return halved;
        }
        if rules.has_extras()
            && now >= self.clock_until
            && candidate.command == PlannedCommand::Column
        {
            // The synchronisation and its column take this CK and the next: a half that is due by
            // then goes first.
            if self.second.is_some_and(|(_, deadline)| deadline <= now + 1) {
                self.second_half(now, rules);
            } else {
                self.counts.clock_syncs += 1;
                self.note(now, usize::from(candidate.bank), CommandKind::ClockSync);
                self.bus_free = [now + 1; 2];
                self.synced = Some(candidate);
            }
            return true;
        }
        self.issue(candidate, now, rules, front);
        true
    }
}
