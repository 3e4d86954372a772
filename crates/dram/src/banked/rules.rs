//! The constraints of a device as a channel applies them, in CK.
//!
//! Every gap is from command to command, so the latencies of the data (RL, WL and BL, the CK of a
//! burst) are part of those that JEDEC counts from the data.

use std::ops::Deref;

use crate::device::{Device, Page, Refresh, Scheduler};

/// Reads and writes where an array has one of each.
pub(super) const READ: usize = 0;
/// See [`READ`].
pub(super) const WRITE: usize = 1;

/// A device as a channel sees it.
#[derive(Debug, Clone)]
pub(super) struct Rules {
    /// Whether no row is closed while an older request to it waits.
    pub keeps_rows: bool,
    /// Whether only the oldest request goes.
    pub in_order: bool,
    /// See [`Rules::is_plain`].
    pub plain: bool,
    pub page: Page,
    pub refresh: Refresh,
    /// Bytes of a burst.
    pub burst_bytes: u64,
    /// Pseudo channels of a channel.
    pub pseudo_channels: usize,
    /// Groups of a pseudo channel.
    pub groups: usize,
    /// Banks of a group.
    pub group_banks: usize,
    /// Groups of all pseudo channels.
    pub all_groups: usize,
    /// The banks of the first of them, one bit each.
    pub group_mask: u64,
    /// Entries of the read and of the write queue.
    pub queue: [usize; 2],
    /// More writes than this begin writing.
    pub write_high: usize,
    /// Fewer writes than this end it: none at the latest.
    pub write_low: usize,
    /// CK of reads after which writes that wait go.
    pub write_wait: u64,
    /// Whether columns have a command bus of their own.
    pub column_bus: bool,
    /// CK of the command bus: activate, column, precharge or refresh.
    pub activate_cycles: u64,
    pub column_cycles: u64,
    pub precharge_cycles: u64,
    /// The second half of an activate follows within this.
    pub second_within: Option<u64>,
    /// The data clock runs for this long after a read and a write.
    pub clock_runs: Option<[u64; 2]>,
    /// BL: a burst on the data bus.
    pub burst_cycles: u64,
    /// tCCD_S.
    pub column_short: u64,
    /// tCCD_L.
    pub column_long: u64,
    /// RL + BL.
    pub read_data: u64,
    /// tRTW.
    pub read_to_write: u64,
    /// WL + BL + tWTR_S.
    pub write_to_read_short: u64,
    /// WL + BL + tWTR_L.
    pub write_to_read_long: u64,
    /// tRCD, for reads and for writes.
    pub activate_to_column: [u64; 2],
    /// tRAS.
    pub activate_to_precharge: u64,
    /// tRC.
    pub activate_to_activate: u64,
    /// tRRD_S.
    pub activate_short: u64,
    /// tRRD_L.
    pub activate_long: u64,
    /// tFAW.
    pub four_activates: u64,
    /// tRTP, and WL + BL + tWR.
    pub column_to_precharge: [u64; 2],
    /// tRP.
    pub precharge_to_activate: u64,
    /// tPPD.
    pub precharge_to_precharge: u64,
    /// tRP of all banks.
    pub precharge_all_to_refresh: u64,
    /// How much longer the command of an activate is than that of a refresh: a refresh may end no
    /// earlier than an activate in its place.
    pub refresh_after_activate: u64,
    /// tREFI of a pseudo channel; with refreshes of single banks, that over their number.
    pub refresh_interval: u64,
    /// tRFC, all banks.
    pub refresh_all_to_activate: u64,
    /// tRFC of a single bank.
    pub refresh_bank_to_activate: u64,
    /// Bursts that a controller accepts in a CK.
    pub acceptances: u32,
    /// CK without requests until power-down and self-refresh.
    pub sleep_after: [u64; 2],
}

impl Rules {
    pub(super) fn new(device: &Device) -> Self {
        let (o, t, c) = (&device.organisation, &device.timing, &device.controller);
        let banks = u64::from(o.pseudo_channels * o.bank_groups * o.banks);
        // A refresh of one bank comes as often as all of them have to be refreshed in an interval.
        let each = match c.refresh {
            Refresh::PerBank => u64::from(t.refresh_interval) / banks,
            Refresh::None | Refresh::AllBank => u64::from(t.refresh_interval),
        };
        let n = u64::from;
        let (activate, precharge) = (n(device.commands.activate), n(device.commands.precharge));
        let actions = device.energy.actions.as_ref();
        let sleep =
            actions.map(|a| [a.background.power_down_after, a.background.self_refresh_after]);
        let rules = Self {
            plain: false,
            keeps_rows: c.scheduler == Scheduler::FrFcfsRowHit,
            in_order: c.scheduler == Scheduler::Fcfs,
            page: c.page,
            refresh: c.refresh,
            burst_bytes: o.burst.0,
            pseudo_channels: o.pseudo_channels as usize,
            groups: o.bank_groups as usize,
            group_banks: o.banks as usize,
            all_groups: (o.pseudo_channels * o.bank_groups) as usize,
            group_mask: u64::MAX >> (64 - o.banks),
            queue: [c.read_queue as usize, c.write_queue as usize],
            write_high: (c.write_high * f64::from(c.write_queue)).floor() as usize,
            write_low: ((c.write_low * f64::from(c.write_queue)).ceil() as usize).max(1),
            write_wait: match c.write_wait.0 > 0.0 {
                true => device.ck(c.write_wait).max(1),
                false => u64::MAX,
            },
            column_bus: device.commands.column_bus,
            activate_cycles: activate,
            column_cycles: n(device.commands.column),
            precharge_cycles: precharge,
            second_within: device.split_activate.as_ref().map(|s| n(s.second_within)),
            clock_runs: device.clock_sync.as_ref().map(|s| [n(s.after_read), n(s.after_write)]),
            burst_cycles: n(t.burst),
            column_short: n(t.column_short),
            column_long: n(t.column_long),
            read_data: n(t.read_data),
            read_to_write: n(t.read_to_write),
            write_to_read_short: n(t.write_to_read_short),
            write_to_read_long: n(t.write_to_read_long),
            activate_to_column: [n(t.activate_to_read), n(t.activate_to_write)],
            activate_to_precharge: n(t.activate_to_precharge),
            activate_to_activate: n(t.activate_to_activate),
            activate_short: n(t.activate_short),
            activate_long: n(t.activate_long),
            four_activates: n(t.four_activates),
            column_to_precharge: [n(t.read_to_precharge), n(t.write_to_precharge)],
            precharge_to_activate: n(t.precharge_to_activate),
            precharge_to_precharge: n(t.precharge_to_precharge),
            precharge_all_to_refresh: n(t.precharge_all_to_refresh),
            refresh_after_activate: activate.saturating_sub(precharge),
            refresh_interval: each.max(1),
            refresh_all_to_activate: n(t.refresh_all_to_activate),
            refresh_bank_to_activate: n(t.refresh_bank_to_activate),
            acceptances: device.front_end.acceptances,
            sleep_after: sleep.map_or([u64::MAX; 2], |s| s.map(|ns| device.ck(ns))),
        };
        Self { plain: rules.is_plain(), ..rules }
    }

    /// Whether a channel has one command bus and one group of banks whose rows stay open, takes the
    /// oldest request that can go, and needs no second commands: LPDDR4. The controller is compiled
    /// for such devices and for all others.
    pub(super) fn is_plain(&self) -> bool {
        let extras = self.second_within.is_some() || self.clock_runs.is_some();
        let one_group = self.all_groups == 1 && !self.column_bus;
        one_group && !extras && !self.in_order && self.page == Page::Open
    }

    /// Banks of a channel.
    pub(super) fn banks(&self) -> usize {
        self.pseudo_channels * self.groups * self.group_banks
    }
}

/// The constraints of a device, of which the compiler knows whether it is a plain one: see
/// [`Rules::is_plain`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Known<'a, const PLAIN: bool>(pub &'a Rules);

impl<const PLAIN: bool> Deref for Known<'_, PLAIN> {
    type Target = Rules;

    #[inline]
    fn deref(&self) -> &Rules {
        self.0
    }
}

impl<const PLAIN: bool> Known<'_, PLAIN> {
    /// Whether columns have a command bus of their own.
    #[inline]
    pub(super) fn column_bus(self) -> bool {
        !PLAIN && self.0.column_bus
    }

    /// Whether only the oldest request goes.
    #[inline]
    pub(super) fn in_order(self) -> bool {
        !PLAIN && self.0.in_order
    }

    /// Whether rows close by themselves.
    #[inline]
    pub(super) fn closes_rows(self) -> bool {
        !PLAIN && self.0.page == Page::Closed
    }

    /// Whether activates have two halves or the data clock stops.
    #[inline]
    pub(super) fn has_extras(self) -> bool {
        !PLAIN && (self.0.second_within.is_some() || self.0.clock_runs.is_some())
    }

    /// Groups of a pseudo channel.
    #[inline]
    pub(super) fn groups(self) -> usize {
        if PLAIN { 1 } else { self.0.groups }
    }

    /// Groups of all pseudo channels.
    #[inline]
    pub(super) fn all_groups(self) -> usize {
        if PLAIN { 1 } else { self.0.all_groups }
    }

    /// The number of a group or pseudo channel.
    #[inline]
    pub(super) fn shared(self, number: u8) -> usize {
        if PLAIN { 0 } else { usize::from(number) }
    }
}
