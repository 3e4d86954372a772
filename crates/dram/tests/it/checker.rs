//! Every command of random runs against the rules of the device, pair by pair: no state machine,
//! nothing shared with the model.

use powergs_dram::banked::{CommandKind, Logged};
use powergs_dram::device::Refresh;
use powergs_dram::drive::Drive;
use powergs_dram::{Device, Mode};
use proptest::prelude::*;

use super::device;
use super::streams::traffic;

use CommandKind::{
    Activate, AutoPrecharge, ClockSync, Precharge, PrechargeAll, Read, RefreshAll, RefreshBank,
    SecondHalf, Write,
};

/// Commands further back than this cannot matter: no interval is longer.
const BACK: u64 = 1500;

struct Rules<'a> {
    device: &'a Device,
    banks_of_group: u32,
    banks_of_rank: u32,
}

impl Rules<'_> {
    fn rank(&self, c: &Logged) -> u32 {
        c.bank / self.banks_of_rank
    }

    fn group(&self, c: &Logged) -> u32 {
        c.bank / self.banks_of_group
    }

    /// Least CK from `a` to `b`, by everything that the two have in common.
    fn least(&self, a: &Logged, b: &Logged) -> u32 {
        let t = &self.device.timing;
        let (bank, group, rank) =
            (a.bank == b.bank, self.group(a) == self.group(b), self.rank(a) == self.rank(b));
        let after = self.device.commands.activate.saturating_sub(self.device.commands.precharge);
        match (a.kind, b.kind) {
            (Activate, Activate) if bank => t.activate_to_activate,
            (Activate, Activate) if group => t.activate_long,
            (Activate, Activate) if rank => t.activate_short,
            (Activate, Read) if bank => t.activate_to_read,
            (Activate, Write) if bank => t.activate_to_write,
            (Activate, Precharge | AutoPrecharge) if bank => t.activate_to_precharge,
            (Activate, PrechargeAll) if rank => t.activate_to_precharge,
            (Activate, RefreshAll) if rank => t.activate_to_activate + after,
            (Activate, RefreshBank) if bank => t.activate_to_activate + after,
            (Read, Read) | (Write, Write) if group => t.column_long,
            (Read, Read) | (Write, Write) if rank => t.column_short,
            (Read, Write) if rank => t.read_to_write,
            (Write, Read) if group => t.write_to_read_long,
            (Write, Read) if rank => t.write_to_read_short,
            (Read, Precharge | AutoPrecharge) if bank => t.read_to_precharge,
            (Write, Precharge | AutoPrecharge) if bank => t.write_to_precharge,
            (Read, PrechargeAll) if rank => t.read_to_precharge,
            (Write, PrechargeAll) if rank => t.write_to_precharge,
            (Precharge | AutoPrecharge, Activate) if bank => t.precharge_to_activate,
            (Precharge | AutoPrecharge, RefreshBank) if bank => t.precharge_to_activate + after,
            (Precharge | AutoPrecharge, RefreshAll) if rank => t.precharge_to_activate + after,
            (Precharge | PrechargeAll, Precharge | PrechargeAll) if rank => {
                t.precharge_to_precharge
            }
            (PrechargeAll, RefreshAll) if rank => t.precharge_all_to_refresh,
            (RefreshAll, Activate) if rank => t.refresh_all_to_activate,
            (RefreshBank, Activate) if bank => t.refresh_bank_to_activate,
            (RefreshBank, Activate) if rank => t.activate_short,
            _ => 0,
        }
    }

    /// Command bus and CK on it.
    fn bus(&self, c: &Logged) -> Option<(bool, u64)> {
        let commands = &self.device.commands;
        let (column, cycles) = match c.kind {
            Activate => (false, commands.activate),
            SecondHalf | ClockSync => (false, 1),
            Read | Write => (commands.column_bus, commands.column),
            Precharge | PrechargeAll | RefreshAll | RefreshBank => (false, commands.precharge),
            AutoPrecharge => return None,
        };
        Some((column, u64::from(cycles)))
    }
}

/// Checks the log of a channel.
fn check(device: &Device, log: &[Logged]) {
    let o = &device.organisation;
    let rules = Rules { device, banks_of_group: o.banks, banks_of_rank: o.banks * o.bank_groups };
    let mut log = log.to_vec();
    log.sort_by_key(|c| c.time);
    for (i, b) in log.iter().enumerate() {
        let near = log[..i].iter().rev().take_while(|a| b.time - a.time <= BACK);
        for a in near.clone() {
            let least = u64::from(rules.least(a, b));
            assert!(b.time - a.time >= least, "{a:?} to {b:?}: at least {least}");
            if let (Some((bus, cycles)), Some((other, _))) = (rules.bus(a), rules.bus(b)) {
                assert!(bus != other || b.time - a.time >= cycles, "{a:?} and {b:?} on one bus");
            }
        }
        if b.kind == Activate {
            let in_window = near
                .filter(|a| a.kind == Activate && rules.rank(a) == rules.rank(b))
                .filter(|a| b.time - a.time < u64::from(device.timing.four_activates))
                .count();
            assert!(in_window < 4, "{b:?} is the fifth within tFAW");
        }
        rows(&rules, &log[..i], b);
        clock(device, &log[..i], b);
    }
}

/// Columns go to open rows, activates and refreshes to closed banks.
fn rows(rules: &Rules, before: &[Logged], c: &Logged) {
    let open = |bank: u32| {
        let of_bank = |a: &&Logged| match a.kind {
            Activate | Precharge | AutoPrecharge => a.bank == bank,
            PrechargeAll => rules.rank(a) == bank / rules.banks_of_rank,
            _ => false,
        };
        let last = before.iter().rev().find(of_bank);
        last.filter(|a| a.kind == Activate).map(|a| a.row)
    };
    let banks = c.bank..c.bank + rules.banks_of_rank;
    match c.kind {
        Read | Write => {
            assert_eq!(open(c.bank), Some(c.row), "{c:?}: another row is open");
            if rules.device.split_activate.is_some() {
                let halves = [Activate, SecondHalf];
                let last = before.iter().rev();
                let last = last.clone().find(|a| a.bank == c.bank && halves.contains(&a.kind));
                assert_eq!(last.map(|a| a.kind), Some(SecondHalf), "{c:?}: half an activate");
            }
        }
        Activate | RefreshBank => assert_eq!(open(c.bank), None, "{c:?}: a row is open"),
        Precharge => assert!(open(c.bank).is_some(), "{c:?}: nothing to close"),
        RefreshAll => assert!(banks.clone().all(|b| open(b).is_none()), "{c:?}: a row is open"),
        SecondHalf => {
            let first = before.iter().rev().find(|a| a.kind == Activate).expect("a first half");
            let within = rules.device.split_activate.as_ref().expect("split").second_within;
            assert_eq!(first.bank, c.bank);
            assert!(c.time - first.time <= u64::from(within), "{first:?} to {c:?}");
        }
        AutoPrecharge | PrechargeAll | ClockSync => {}
    }
}

/// A column finds the data clock running, or it was synchronised in the CK before.
fn clock(device: &Device, before: &[Logged], c: &Logged) {
    let Some(sync) = device.clock_sync.as_ref().filter(|_| matches!(c.kind, Read | Write)) else {
        return;
    };
    let running = before.iter().rev().take_while(|a| c.time - a.time <= BACK).any(|a| {
        let runs = match a.kind {
            Read => sync.after_read,
            Write => sync.after_write,
            ClockSync => return c.time - a.time == 1,
            _ => 0,
        };
        c.time - a.time < u64::from(runs)
    });
    assert!(running, "{c:?}: the data clock stands still");
}

fn refreshes(device: &Device, log: &[Logged], cycles: u64) {
    let o = &device.organisation;
    let kind = match device.controller.refresh {
        Refresh::None => return assert!(!log.iter().any(|c| c.kind == RefreshAll)),
        Refresh::AllBank => RefreshAll,
        Refresh::PerBank => RefreshBank,
    };
    let per_interval = match device.controller.refresh {
        Refresh::PerBank => o.pseudo_channels * o.bank_groups * o.banks,
        Refresh::None | Refresh::AllBank => o.pseudo_channels,
    };
    let due = cycles / u64::from(device.timing.refresh_interval) * u64::from(per_interval);
    let done = log.iter().filter(|c| c.kind == kind).count() as u64;
    // The last round may be on its way, or due after the last request.
    assert!(done + 2 * u64::from(per_interval) >= due, "{done} of {due} refreshes");
}

fn sets() -> impl Strategy<Value = Vec<String>> {
    let pick = |key: &'static str, values: &'static [&'static str]| {
        proptest::sample::select(values).prop_map(move |v| format!("{key}={v}"))
    };
    (
        pick("mapping.order", &["RoBaCoCh", "mop", "bg64"]),
        pick("mapping.interleave", &["64 B", "128 B", "256 B"]),
        pick("controller.page", &["open", "closed"]),
        pick("controller.scheduler", &["fr-fcfs", "fr-fcfs-row-hit"]),
        pick("controller.refresh", &["none", "all-bank", "per-bank"]),
        pick("controller.read-queue", &["1", "5", "32", "70"]),
        pick("controller.write-queue", &["2", "9", "32"]),
        pick("timing.four-activates", &["64", "90", "137"]),
        pick("timing.activate-to-read", &["15", "29", "44"]),
        pick("front-end.acceptances", &["1", "2", "4"]),
        pick("front-end.window", &["256 B", "4 KiB", "32 KiB"]),
        pick("timing.precharge-to-activate", &["9", "27"]),
    )
        .prop_map(|(a, b, c, d, e, f, g, h, i, j, k, l)| vec![a, b, c, d, e, f, g, h, i, j, k, l])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn every_command_is_legal_and_bytes_are_conserved(
        name in proptest::sample::select(
            &[
                "lpddr4-3200-x16x2",
                "lpddr4-3200-x32x4",
                "lpddr5-6400-x16x2",
                "lpddr6-10667-x12x4",
                "hbm2-8ch",
            ][..]),
        sets in sets(),
        seed in 0u64..1 << 32,
        kind in 0u8..10,
        mode in proptest::sample::select(&["sat", "mlp4", "rate3", "idle"][..]),
    ) {
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let device = device(name, &sets);
        let accesses = traffic(seed, 1500, kind);
        let mode: Mode = mode.parse().expect("a mode");
        let mut drive = Drive::new(&device, mode).with_log();
        accesses.iter().for_each(|a| drive.take(*a));
        let (run, memory) = drive.finish();
        for channel in 0..device.organisation.channels as usize {
            check(&device, memory.log(channel));
            refreshes(&device, memory.log(channel), run.cycles);
        }
        let (stats, total) = (&run.stats, &run.stats.total);
        let asked: u64 = accesses.iter().map(|a| u64::from(a.bytes)).sum();
        prop_assert_eq!(total.requested_bytes(), asked);
        prop_assert_eq!(total.requests, accesses.len() as u64);
        let served = stats.reads + stats.writes;
        prop_assert_eq!(served + total.absorbed_writes + total.forwarded_reads, total.bursts);
        prop_assert_eq!(total.moved_bytes, served * device.organisation.burst.0);
        prop_assert_eq!(total.row_hits + total.row_misses + total.row_conflicts, served);
        prop_assert!(device.ns(run.cycles) * device.peak_gb_s() >= total.moved_bytes as f64);
        prop_assert!(stats.busy_max <= run.cycles + u64::from(device.timing.burst));
        prop_assert!(stats.busy_mean <= stats.busy_max as f64);
    }
}
