//! The scheduler of a channel: which commands could go next, and which of them goes first.
//!
//! Commands for requests fall into three classes: columns, activates, precharges. Those of a class
//! are held back by constraints of their banks and by those that the class shares (tRRD, tCCD), and
//! the latter move only when a command of the class is issued. So each class keeps its first
//! command, and looks at its banks again only when that was issued or another may overtake it.

use super::channel::{ACTIVATE, BankedChannel, PRECHARGE};
use super::class::{Class, NO_KEY, goes_first};
use super::queue::NONE;
use super::rules::{Known, READ, WRITE};

/// A kind of command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PlannedCommand {
    /// Open the row of an entry.
    Activate,
    /// Close a bank for an entry.
    Precharge,
    /// Read or write for an entry.
    Column,
    /// Close all banks of a pseudo channel to refresh it.
    PrechargeAll,
    /// Close a bank to refresh it.
    PrechargeBank,
    /// Refresh a pseudo channel.
    RefreshAll,
    /// Refresh a bank.
    RefreshBank,
}

/// A command that could be issued.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// First CK in which it meets all timing constraints.
    pub time: u64,
    /// Of two commands at one time, the one with the smaller key goes.
    pub key: u64,
    pub command: PlannedCommand,
    /// Its bank, or the first bank of its pseudo channel; [`NO_BANK`] if there is no command.
    pub bank: u8,
    /// The entry that it is for.
    pub entry: u16,
}

/// No bank.
const NO_BANK: u8 = u8::MAX;

impl Candidate {
    /// Nothing can go.
    pub(super) const NEVER: Candidate = Candidate {
        time: u64::MAX,
        key: NO_KEY,
        command: PlannedCommand::RefreshAll,
        bank: NO_BANK,
        entry: NONE,
    };

    /// Of two commands the one that goes first.
    #[inline]
    fn or(self, other: Candidate) -> Candidate {
        if goes_first((other.time, other.key), (self.time, self.key)) { other } else { self }
    }
}

/// Keys: columns of activated rows come first, by age, then refreshes, then requests by age.
const REFRESH: u64 = 1 << 62;
/// See [`REFRESH`].
pub(super) const BY_AGE: u64 = 1 << 63;
/// Where the class of columns is kept; those of row commands are at their numbers.
pub(super) const COLUMN: usize = 2;

impl BankedChannel {
    /// Decides between reads and writes by the fill of their queues and the wait of writes.
    #[inline]
    pub(super) fn set_direction<const P: bool>(&mut self, now: u64, rules: Known<'_, P>) {
        self.look_from = u64::MAX;
        if self.turns(now, rules) {
            self.write_mode = !self.write_mode;
            if self.write_mode {
                // Writes that begin because they waited too long go on until all that wait now have
                // gone (A117).
                self.overdue = if now >= self.late_from { self.len[WRITE] } else { 0 };
                self.late_from = u64::MAX;
            } else {
                self.writes_wait_from(now, rules);
            }
            self.forget_classes();
        }
    }

    /// Whether the direction is to change in the CK `now`.
    #[inline]
    pub(super) fn turns<const P: bool>(&self, now: u64, rules: Known<'_, P>) -> bool {
        let [reads, writes] = self.len;
        // Two marks, because every turn of the data bus costs time: writes go in groups.
        if self.write_mode {
            writes < rules.write_low && reads > 0 && self.overdue == 0
        } else {
            writes > rules.write_high || reads == 0 || now >= self.late_from
        }
    }

    /// From the CK `now` on, writes wait for reads, if there are any.
    #[inline]
    pub(super) fn writes_wait_from<const P: bool>(&mut self, now: u64, rules: Known<'_, P>) {
        if self.len[WRITE] > 0 {
            self.late_from = now.saturating_add(rules.write_wait);
        }
    }

    /// Looks at all banks again for the next plan.
    pub(super) fn forget_classes(&mut self) {
        self.classes.iter_mut().for_each(Class::set_stale);
    }

    /// Finds the keys of the next commands of a bank in a direction: the column of its active entry
    /// or of the oldest row hit, and a precharge or an activate for the oldest other entry.
    #[inline]
    pub(super) fn set_keys<const P: bool>(
        &mut self,
        number: usize,
        direction: usize,
        rules: Known<'_, P>,
    ) {
        let bank = self.banks.at_mut(number);
        let list = &bank.lists[direction];
        let (mut column, mut row) = (NO_KEY, NO_KEY);
        if list.hit != NONE {
            column = self.entries.get(list.hit).key;
        }
        if bank.active != NONE {
            if self.columns[direction] >> number & 1 != 0 {
                column = self.entries.get(bank.active).key & !BY_AGE;
            }
        } else if list.miss != NONE {
            let miss = self.entries.get(list.miss);
            // Closing the row now would make its older request open it once more.
            let keeps_row = column != NO_KEY
                && rules.keeps_rows
                && self.entries.get(list.hit).accepted <= miss.accepted;
            row = if keeps_row { NO_KEY } else { miss.key };
        }
        bank.column_key[direction] = column;
        bank.row_key[direction] = row;
        let wanted = &mut self.wanted[direction];
        let others = !(1 << number);
        wanted[0] = wanted[0] & others | u64::from(row != NO_KEY) << number;
        wanted[1] = wanted[1] & others | u64::from(column != NO_KEY) << number;
    }

    /// The same where no row is open and no entry active.
    #[inline]
    pub(super) fn set_closed_keys(&mut self, number: usize, direction: usize) {
        let bank = self.banks.at_mut(number);
        let list = &mut bank.lists[direction];
        (list.hit, list.miss) = (NONE, list.head);
        bank.column_key[direction] = NO_KEY;
        let wanted = &mut self.wanted[direction];
        wanted[1] &= !(1 << number);
        if list.head != NONE {
            bank.row_key[direction] = self.entries.get(list.head).key;
            wanted[0] |= 1 << number;
        }
    }

    /// First CK for the column of a bank in a direction, but for the bus.
    #[inline]
    fn column_time<const P: bool>(
        &self,
        number: usize,
        direction: usize,
        rules: Known<'_, P>,
    ) -> u64 {
        let bank = self.banks.at(number);
        let group = self.groups.at(rules.shared(bank.group));
        bank.column_ok[direction].max(group.column_ok[direction])
    }

    /// The same of its activate.
    #[inline]
    fn activate_time<const P: bool>(&self, number: usize, rules: Known<'_, P>) -> u64 {
        let bank = self.banks.at(number);
        let pseudo = self.pseudo_channels.at(rules.shared(bank.pseudo));
        let group = self.groups.at(rules.shared(bank.group));
        bank.row_ok[ACTIVATE].max(group.activate_ok).max(pseudo.faw_ok)
    }

    /// The same of its precharge.
    #[inline]
    fn precharge_time<const P: bool>(&self, number: usize, rules: Known<'_, P>) -> u64 {
        let bank = self.banks.at(number);
        bank.row_ok[PRECHARGE].max(self.pseudo_channels.at(rules.shared(bank.pseudo)).precharge_ok)
    }

    /// The row command of a bank changed.
    #[inline]
    pub(super) fn row_changed<const P: bool>(
        &mut self,
        number: usize,
        floor: u64,
        rules: Known<'_, P>,
    ) {
        let key = self.banks.at(number).row_key[self.direction()];
        if self.open >> number & 1 != 0 {
            let time = self.precharge_time(number, rules);
            self.classes[PRECHARGE].change(floor, time, key, number);
            self.classes[ACTIVATE].forget(number);
        } else {
            let time = self.activate_time(number, rules);
            self.classes[ACTIVATE].change(floor, time, key, number);
            self.classes[PRECHARGE].forget(number);
        }
    }

    /// The column command of a bank in a direction changed.
    #[inline]
    pub(super) fn column_changed<const P: bool>(
        &mut self,
        number: usize,
        direction: usize,
        floor: u64,
        rules: Known<'_, P>,
    ) {
        let time = self.column_time(number, direction, rules);
        let key = self.banks.at(number).column_key[direction];
        self.classes[COLUMN].change(floor, time, key, number);
    }

    /// Banks of a group among some.
    #[inline]
    fn in_group<const P: bool>(
        &self,
        banks: u64,
        group: usize,
        rules: Known<'_, P>,
    ) -> impl Iterator<Item = usize> {
        let own = if P { u64::MAX } else { rules.group_mask << (group * rules.group_banks) };
        bits(banks & own)
    }

    #[inline]
    fn look_for_columns<const P: bool>(&mut self, mode: usize, floor: u64, rules: Known<'_, P>) {
        let mut found = Class::EMPTY;
        for index in 0..rules.all_groups() {
            let least = self.groups.at(index).column_ok[mode];
            for number in self.in_group(self.wanted[mode][1], index, rules) {
                let bank = self.banks.at(number);
                let time = bank.column_ok[mode].max(least);
                found.add(floor, time, bank.column_key[mode], number);
            }
        }
        // A row that was opened for a request is used even if the direction has turned since.
        for number in bits(self.columns[1 - mode]) {
            let key = self.banks.at(number).column_key[1 - mode];
            found.add(floor, self.column_time(number, 1 - mode, rules), key, number);
        }
        self.classes[COLUMN] = found;
    }

    #[inline]
    fn look_for_activates<const P: bool>(&mut self, mode: usize, floor: u64, rules: Known<'_, P>) {
        let mut found = Class::EMPTY;
        for index in 0..rules.all_groups() {
            let pseudo = self.banks.at(index * rules.group_banks).pseudo;
            let least = self.pseudo_channels.at(rules.shared(pseudo)).faw_ok;
            let least = self.groups.at(index).activate_ok.max(least);
            for number in self.in_group(self.wanted[mode][0] & !self.open, index, rules) {
                let bank = self.banks.at(number);
                let time = bank.row_ok[ACTIVATE].max(least);
                found.add(floor, time, bank.row_key[mode], number);
            }
        }
        self.classes[ACTIVATE] = found;
    }

    #[inline]
    fn look_for_precharges<const P: bool>(&mut self, mode: usize, floor: u64, rules: Known<'_, P>) {
        let mut found = Class::EMPTY;
        for number in bits(self.wanted[mode][0] & self.open) {
            let key = self.banks.at(number).row_key[mode];
            found.add(floor, self.precharge_time(number, rules), key, number);
        }
        self.classes[PRECHARGE] = found;
    }

    /// Finds the earliest commands at or after `now`.
    pub(super) fn plan<const P: bool>(&mut self, now: u64, rules: Known<'_, P>) {
        if self.due.is_empty() && !rules.in_order() {
            self.look_for_direction(now, self.bus_free[0].max(now), rules);
            return self.plan_steadily(now, rules);
        }
        self.planned = true;
        self.plan_one(now, rules);
    }

    /// The same where the direction has been decided and no refresh is due.
    pub(super) fn plan_steadily<const P: bool>(&mut self, now: u64, rules: Known<'_, P>) {
        if rules.in_order() {
            return self.plan(now, rules);
        }
        self.planned = true;
        let floors = self.bus_free.map(|free| free.max(now));
        let floors = if P { [floors[0]; 2] } else { floors };
        let mode = self.direction();
        if floors[0] >= self.classes[COLUMN].overtaken {
            self.look_for_columns(mode, floors[0], rules);
        }
        if floors[1] >= self.classes[ACTIVATE].overtaken {
            self.look_for_activates(mode, floors[1], rules);
        }
        if floors[1] >= self.classes[PRECHARGE].overtaken {
            self.look_for_precharges(mode, floors[1], rules);
        }
        let (activate, precharge) = (&self.classes[ACTIVATE], &self.classes[PRECHARGE]);
        let (mut row, mut command) = (precharge, PlannedCommand::Precharge);
        let (mut time, late) = (precharge.time.max(floors[1]), activate.time.max(floors[1]));
        // The other half of the last activate comes first.
        if !(rules.has_extras() && self.second.is_some())
            && goes_first((late, activate.key), (time, precharge.key))
        {
            (row, command, time) = (activate, PlannedCommand::Activate, late);
        }
        let column = &self.classes[COLUMN];
        let column_time = column.time.max(floors[0]);
        if rules.column_bus() {
            self.best = [
                self.candidate(column_time, column, PlannedCommand::Column, mode),
                self.candidate(time, row, command, mode),
            ];
        } else {
            if goes_first((column_time, column.key), (time, row.key)) {
                (row, command, time) = (column, PlannedCommand::Column, column_time);
            }
            self.best[0] = self.candidate(time, row, command, mode);
        }
        debug_assert!(self.is_first_of_all(now, rules), "a stale plan in CK {now}");
    }

    /// Whether the plan is what a look at all banks finds.
    fn is_first_of_all<const P: bool>(&self, now: u64, rules: Known<'_, P>) -> bool {
        let mut best = [Candidate::NEVER; 2];
        best[0] = self.active_columns(now, rules).fold(best[0], Candidate::or);
        for [column, row] in (0..rules.banks()).map(|bank| self.commands_of(bank, now, rules)) {
            best[0] = best[0].or(column);
            let bus = usize::from(rules.column_bus());
            best[bus] = best[bus].or(row);
        }
        let of = |c: &Candidate| (c.time, c.key, c.command, c.bank, c.entry);
        self.best.iter().map(of).eq(best.iter().map(of))
    }

    #[inline]
    fn candidate(
        &self,
        time: u64,
        class: &Class,
        command: PlannedCommand,
        mode: usize,
    ) -> Candidate {
        if class.key == NO_KEY {
            return Candidate::NEVER;
        }
        let entry = self.entry_of(class.bank, class.key, command, mode);
        Candidate { time, key: class.key, command, bank: class.bank as u8, entry }
    }

    /// The entry that a command of a bank is for.
    #[inline]
    fn entry_of(&self, number: usize, key: u64, command: PlannedCommand, mode: usize) -> u16 {
        let bank = self.banks.at(number);
        match command {
            PlannedCommand::Column if key < REFRESH => bank.active,
            PlannedCommand::Column => bank.lists[mode].hit,
            _ => bank.lists[mode].miss,
        }
    }

    /// Decides on the direction, unless the column of an activated row goes at once.
    #[inline]
    fn look_for_direction<const P: bool>(&mut self, now: u64, floor: u64, rules: Known<'_, P>) {
        if !self.turns(now, rules) {
            self.look_from = u64::MAX;
        } else if floor > now || rules.column_bus() || !self.has_column(now, rules) {
            self.set_direction(now, rules);
        }
    }

    /// Plans where only columns of activated rows, a refresh that is due or else the oldest request
    /// may go.
    fn plan_one<const P: bool>(&mut self, now: u64, rules: Known<'_, P>) {
        let column = self.active_columns(now, rules).fold(Candidate::NEVER, Candidate::or);
        self.best = [column, Candidate::NEVER];
        if !self.due.is_empty() {
            return self.consider_refresh(now, rules);
        }
        self.look_for_direction(now, self.bus_free[0].max(now), rules);
        let mode = self.direction();
        let head = |number: usize| match self.banks.at(number).lists[mode].head {
            NONE => None,
            head => Some((self.entries.get(head).key, number)),
        };
        // Keys are ages: the least is the oldest request, the only one that may go (`fcfs`).
        if let Some((_, number)) = (0..rules.banks()).filter_map(head).min() {
            let list = &self.banks.at(number).lists[mode];
            let [column, row] = self.commands_of(number, now, rules);
            let bus = usize::from(rules.column_bus() && list.hit != list.head);
            let oldest = if list.hit == list.head { column } else { row };
            self.best[bus] = self.best[bus].or(oldest);
        }
    }

    /// The columns of activated rows.
    fn active_columns<const P: bool>(
        &self,
        now: u64,
        rules: Known<'_, P>,
    ) -> impl Iterator<Item = Candidate> {
        let floor = self.bus_free[0].max(now);
        [READ, WRITE].into_iter().flat_map(move |direction| {
            bits(self.columns[direction]).map(move |number| {
                let time = self.column_time(number, direction, rules).max(floor);
                let bank = self.banks.at(number);
                let (key, command) = (bank.column_key[direction], PlannedCommand::Column);
                Candidate { time, key, command, bank: number as u8, entry: bank.active }
            })
        })
    }

    /// Whether the column of an activated row can go in the CK `now`, in which its bus is free.
    fn has_column<const P: bool>(&self, now: u64, rules: Known<'_, P>) -> bool {
        [READ, WRITE].into_iter().any(|direction| {
            bits(self.columns[direction])
                .any(|number| self.column_time(number, direction, rules) <= now)
        })
    }

    /// The column and the row command of a bank in the current direction.
    fn commands_of<const P: bool>(
        &self,
        number: usize,
        now: u64,
        rules: Known<'_, P>,
    ) -> [Candidate; 2] {
        let mode = self.direction();
        let bank = self.banks.at(number);
        let (row, row_time) = match self.open >> number & 1 != 0 {
            true => (PlannedCommand::Precharge, self.precharge_time(number, rules)),
            false => (PlannedCommand::Activate, self.activate_time(number, rules)),
        };
        let row_bus = usize::from(rules.column_bus());
        let column_time = self.column_time(number, mode, rules);
        let halved = row == PlannedCommand::Activate && self.second.is_some();
        let row_key = if halved { NO_KEY } else { bank.row_key[mode] };
        let of = |bus: usize, time: u64, key: u64, command: PlannedCommand| {
            if key == NO_KEY {
                return Candidate::NEVER;
            }
            let time = time.max(self.bus_free[bus]).max(now);
            let entry = self.entry_of(number, key, command, mode);
            Candidate { time, key, command, bank: number as u8, entry }
        };
        let column = of(0, column_time, bank.column_key[mode], PlannedCommand::Column);
        [column, of(row_bus, row_time, row_key, row)]
    }

    /// Considers the commands of a bank in the current direction.
    pub(super) fn consider_bank<const P: bool>(
        &mut self,
        number: usize,
        now: u64,
        rules: Known<'_, P>,
    ) {
        let [column, row] = self.commands_of(number, now, rules);
        self.best[0] = self.best[0].or(column);
        let best = &mut self.best[usize::from(rules.column_bus())];
        *best = best.or(row);
    }

    /// Considers a refresh command, or one that prepares it, on the bus of row commands.
    pub(super) fn consider_row<const P: bool>(
        &mut self,
        time: u64,
        command: PlannedCommand,
        bank: u8,
        now: u64,
        rules: Known<'_, P>,
    ) {
        let bus = usize::from(rules.column_bus());
        let time = time.max(self.bus_free[bus]).max(now);
        let found = Candidate { time, key: REFRESH, command, bank, entry: NONE };
        self.best[bus] = self.best[bus].or(found);
    }
}

/// The numbers of the bits that are set.
#[inline]
pub(super) fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        if mask == 0 {
            return None;
        }
        let number = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        Some(number)
    })
}
