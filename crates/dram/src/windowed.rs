//! Level `window`: counts instead of commands.
//!
//! Timing rule: requests are served one after the other. In each window of 128 KiB of bursts in
//! program order every channel counts its bursts, its activates by bank and its columns by bank
//! group. The time of the window is that of the slowest channel, and that of a channel the largest
//! of what its data bus, its activates, its busiest bank, its busiest group and its command bus
//! need, and the turnarounds of its writes, stretched by the share of refreshes. A request takes
//! the time by which it lengthens its window. A row is open if it was the last of its bank, or was
//! used within the last 16 bursts of the channel; reads and writes are counted apart.
//!
//! It knows no queue and no latency under load: use [`super::Banked`] for those.

use super::banked::AddressRange;
use super::device::{Device, Page, Refresh};
use super::mapping::Decoder;
use super::stats::{CLASSES, Stats};

/// Bytes of a window.
const WINDOW: u64 = 2048 * 64;

/// A row is still open if it was used within this many bursts of its channel.
const REACH: u64 = 16;

/// Rows that a bank remembers, for reads and for writes.
const ROWS: usize = 4;

/// CK that a refresh costs besides its own intervals: work that waits for it to begin.
const REFRESH_EXTRA: f64 = 40.0;

/// Waiting requests let younger ones pass: the scheduler chooses among this many read queues.
const REACH_OF_QUEUE: u32 = 3;

/// Times are in 1/256 CK.
const FINE: u64 = 256;

/// Rows that were used last.
#[derive(Debug, Clone, Copy)]
struct Rows {
    rows: [u32; ROWS],
    used: [u64; ROWS],
    /// The slot of the last one, and the slot that is overwritten next.
    last: u8,
    oldest: u8,
}

impl Rows {
    const NONE: Rows = Rows { rows: [u32::MAX; ROWS], used: [0; ROWS], last: 0, oldest: 0 };

    /// Uses a row as burst number `burst` of its channel. Whether it was open, and whether another
    /// one was.
    fn touch(&mut self, row: u32, burst: u64) -> (bool, bool) {
        let last = usize::from(self.last);
        if self.rows[last] == row {
            self.used[last] = burst;
            return (true, false);
        }
        for i in 0..ROWS {
            if self.rows[i] == row {
                let recent = burst - self.used[i] <= REACH;
                self.used[i] = burst;
                self.last = i as u8;
                return (recent, true);
            }
        }
        let other = self.rows[last] != u32::MAX;
        let slot = self.oldest;
        self.rows[usize::from(slot)] = row;
        self.used[usize::from(slot)] = burst;
        self.last = slot;
        self.oldest = (slot + 1) % ROWS as u8;
        (false, other)
    }
}

/// Counts of a bank in the window.
#[derive(Debug, Clone, Copy)]
struct Bank {
    rows: [Rows; 2],
    activates: u32,
}

/// Counts of a pseudo channel in the window.
#[derive(Debug, Clone, Copy, Default)]
struct Rank {
    /// Data-bus time of the batches before this one, bursts of this one, and those of its busiest
    /// group.
    columns: u64,
    batch: u32,
    busiest: u32,
    activates: u32,
    writes: u32,
    reads: u32,
    bursts_ever: u64,
}

/// What things take, in 1/256 CK.
#[derive(Debug, Clone, Copy)]
struct Costs {
    burst: u64,
    activate: u64,
    bank: u64,
    group: u64,
    /// Bursts among which the scheduler can choose.
    batch: u32,
    turn: u64,
    command: [u64; 2],
    column_bus: bool,
}

/// The memory as counts.
#[derive(Debug, Clone)]
pub struct Windowed {
    decoder: Decoder,
    costs: Costs,
    /// Stretch by refreshes.
    stretch: f64,
    closed_page: bool,
    group_shift: u32,
    rank_shift: u32,
    groups_shift: u32,
    banks: Vec<Bank>,
    groups: Vec<u32>,
    ranks: Vec<Rank>,
    /// Command-bus time of each channel in the window.
    commands: Vec<u64>,
    banks_per_channel: usize,
    burst_bytes: u64,
    /// Bursts that are left in the window.
    left: u64,
    bursts_per_window: u64,
    /// Time of the window so far.
    window: u64,
    /// When the server is free, 1/256 CK.
    free: u64,
    read_data: u64,
    /// CK to open a row, and to close another one before.
    open_row: u64,
    close_row: u64,
    latency: u64,
    refresh: Option<(u64, bool)>,
    stats: Stats,
}

impl Windowed {
    /// An idle memory.
    pub fn new(device: &Device) -> Windowed {
        let (o, t) = (&device.organisation, &device.timing);
        let channels = o.channels as usize;
        let ranks = channels * o.pseudo_channels as usize;
        let groups = ranks * o.bank_groups as usize;
        let burst_bytes = o.burst.0;
        let no_rows = Bank { rows: [Rows::NONE; 2], activates: 0 };
        let refresh = match device.controller.refresh {
            Refresh::None => None,
            Refresh::AllBank => Some((u64::from(t.refresh_interval), false)),
            Refresh::PerBank => Some((u64::from(t.refresh_interval), true)),
        };
        let lost = f64::from(t.refresh_all_to_activate + t.precharge_all_to_refresh);
        let interval = f64::from(t.refresh_interval);
        let stretch = match device.controller.refresh {
            Refresh::AllBank | Refresh::PerBank => {
                interval / (interval - lost - REFRESH_EXTRA).max(interval * 0.05)
            }
            Refresh::None => 1.0,
        };
        Windowed {
            decoder: Decoder::new(device),
            costs: Costs::new(device),
            stretch,
            closed_page: device.controller.page == Page::Closed,
            group_shift: o.banks.trailing_zeros(),
            rank_shift: (o.banks * o.bank_groups).trailing_zeros(),
            groups_shift: o.bank_groups.trailing_zeros(),
            banks: vec![no_rows; groups * o.banks as usize],
            groups: vec![0; groups],
            ranks: vec![Rank::default(); ranks],
            commands: vec![0; channels],
            banks_per_channel: (o.pseudo_channels * o.bank_groups * o.banks) as usize,
            burst_bytes,
            left: (WINDOW / burst_bytes).max(1),
            bursts_per_window: (WINDOW / burst_bytes).max(1),
            window: 0,
            free: 0,
            read_data: u64::from(t.read_data),
            open_row: u64::from(t.activate_to_read),
            close_row: u64::from(t.precharge_to_activate),
            latency: device.ck(device.controller.latency),
            refresh,
            stats: Stats::default(),
        }
    }

    /// Serves a request that comes at `now` CK, after all that came before; returns the CK in which
    /// a read has its last data or a write is done. `class` is for statistics.
    ///
    /// # Panics
    /// If the class is not below 16.
    pub fn serve(
        &mut self,
        now: u64,
        write: bool,
        class: u8,
        pieces: impl IntoIterator<Item = AddressRange>,
    ) -> u64 {
        assert!(usize::from(class) < CLASSES, "class {class} of a request");
        let class = usize::from(class);
        let before = self.stats.total;
        let mut service = 0;
        let mut opening = 0;
        let mut bytes = 0;
        let mut any = false;
        for span in pieces {
            bytes += span.bytes;
            if span.bytes == 0 {
                continue;
            }
            any = true;
            let first = span.address >> self.decoder.shift;
            let last = span.address.saturating_add(span.bytes - 1) >> self.decoder.shift;
            for burst in first..=last {
                let burst = self.decoder.burst(burst << self.decoder.shift);
                let start = self.window;
                opening = opening.max(self.burst(burst, write));
                service += self.window - start;
                self.left -= 1;
                if self.left == 0 {
                    self.next_window();
                }
            }
        }
        self.count(class, write, bytes, &before);
        if !any {
            return now;
        }
        let begin = now.saturating_mul(FINE).max(self.free);
        self.free = begin + (service as f64 * self.stretch).round() as u64;
        let done = self.free.div_ceil(FINE);
        if write {
            self.stats.until = self.stats.until.max(done);
            return done;
        }
        let done = done + self.read_data + self.latency + opening;
        self.stats.until = self.stats.until.max(done);
        self.stats.latency.add(done - now);
        for traffic in [&mut self.stats.total, &mut self.stats.classes[class]] {
            traffic.latency += done - now;
            traffic.latency_requests += 1;
        }
        done
    }

    /// Bytes of a burst.
    pub fn burst_bytes(&self) -> u64 {
        self.burst_bytes
    }

    /// Activity so far. Every activate counts a precharge.
    pub fn stats(&self) -> Stats {
        let mut stats = self.stats.clone();
        stats.precharges = stats.activates;
        let cycles = self.costs.burst / FINE;
        let bursts = self.ranks.iter().map(|r| r.bursts_ever);
        stats.busy_max = bursts.clone().max().unwrap_or(0) * cycles;
        stats.busy_mean = (bursts.sum::<u64>() * cycles) as f64 / self.ranks.len() as f64;
        if let Some((interval, by_bank)) = self.refresh {
            let rounds = stats.until / interval * self.ranks.len() as u64;
            if by_bank {
                stats.refreshes_bank = rounds * (1 << self.rank_shift);
            } else {
                stats.refreshes_all = rounds;
            }
        }
        stats.active = stats.until * self.commands.len() as u64;
        stats
    }

    /// Counts a burst and lengthens the window; CK to open its row first.
    fn burst(&mut self, burst: u64, write: bool) -> u64 {
        let place = self.decoder.place(burst);
        let channel = place.channel as usize;
        let bank_at = channel * self.banks_per_channel + place.bank as usize;
        let (group_at, rank_at) = (bank_at >> self.group_shift, bank_at >> self.rank_shift);
        let costs = &self.costs;
        let rank = &mut self.ranks[rank_at];
        rank.bursts_ever += 1;
        let bank = &mut self.banks[bank_at];
        let (mut open, other) = bank.rows[usize::from(write)].touch(place.row, rank.bursts_ever);
        open &= !self.closed_page || !other;
        let commands = &mut self.commands[channel];
        *commands += costs.command[1];
        if write {
            rank.writes += 1
        } else {
            rank.reads += 1
        }
        let group = &mut self.groups[group_at];
        *group += 1;
        rank.batch += 1;
        rank.busiest = rank.busiest.max(*group);
        let batch = u64::from(rank.batch) * costs.burst;
        let columns = rank.columns + batch.max(u64::from(rank.busiest) * costs.group);
        if rank.batch == costs.batch {
            (rank.columns, rank.batch, rank.busiest) = (columns, 0, 0);
            let first = rank_at << self.groups_shift;
            self.groups[first..first + (1 << self.groups_shift)].fill(0);
        }
        let mut time = columns;
        if !open {
            rank.activates += 1;
            bank.activates += 1;
            *commands += costs.command[0];
            self.stats.activates += 1;
            time = time.max(u64::from(bank.activates) * costs.bank);
        }
        time = time.max(u64::from(rank.activates) * costs.activate);
        if !costs.column_bus {
            time = time.max(*commands);
        }
        if rank.writes > 0 && rank.reads > 0 {
            time += u64::from(rank.writes.min(rank.reads)) * costs.turn;
        }
        self.window = self.window.max(time);
        let total = &mut self.stats.total;
        total.bursts += 1;
        match (open, other) {
            (true, _) => {
                total.row_hits += 1;
                0
            }
            (false, false) => {
                total.row_misses += 1;
                self.open_row
            }
            (false, true) => {
                total.row_conflicts += 1;
                self.open_row + self.close_row
            }
        }
    }

    fn next_window(&mut self) {
        self.left = self.bursts_per_window;
        self.window = 0;
        self.commands.fill(0);
        self.groups.fill(0);
        self.banks.iter_mut().for_each(|b| b.activates = 0);
        for rank in &mut self.ranks {
            *rank = Rank { bursts_ever: rank.bursts_ever, ..Rank::default() };
        }
    }

    /// Attributes to a class of requests the growth of the total since `before`.
    fn count(&mut self, class: usize, write: bool, bytes: u64, before: &super::stats::Traffic) {
        let total = &mut self.stats.total;
        let bursts = total.bursts - before.bursts;
        let of_class = &mut self.stats.classes[class];
        of_class.row_hits += total.row_hits - before.row_hits;
        of_class.row_misses += total.row_misses - before.row_misses;
        of_class.row_conflicts += total.row_conflicts - before.row_conflicts;
        of_class.bursts += bursts;
        for traffic in [total, of_class] {
            traffic.requests += 1;
            traffic.moved_bytes += bursts * self.burst_bytes;
            if write {
                traffic.write_bytes += bytes;
                traffic.writes += bursts;
            } else {
                traffic.read_bytes += bytes;
                traffic.reads += bursts;
            }
        }
        if write {
            self.stats.writes += bursts;
        } else {
            self.stats.reads += bursts;
        }
    }
}

impl Costs {
    fn new(device: &Device) -> Costs {
        let (t, c) = (&device.timing, &device.controller);
        let fine = |ck: u32| u64::from(ck) * FINE;
        let batch = (c.write_high - c.write_low) * f64::from(c.write_queue) + 1.0;
        let batch = batch / f64::from(device.organisation.pseudo_channels);
        let turn = f64::from(t.read_to_write + t.write_to_read_long) - 2.0 * f64::from(t.burst);
        let second = u32::from(device.split_activate.is_some());
        let opening = device.commands.activate + device.commands.precharge + second;
        Costs {
            burst: fine(t.burst),
            activate: fine(t.activate_short).max(fine(t.four_activates) / 4),
            bank: fine(t.activate_to_activate),
            group: fine(t.column_long),
            batch: REACH_OF_QUEUE * c.read_queue,
            turn: (turn.max(0.0) / batch * FINE as f64) as u64,
            command: [fine(opening), fine(device.commands.column)],
            column_bus: device.commands.column_bus,
        }
    }
}
