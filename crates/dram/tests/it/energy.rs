//! Energy of the memory: commands first, then prices.

use powergs_dram::drive::{Access, Run, banked};
use powergs_dram::{CommandPrices, Device, EnergyUse, Mode};

use super::device;
use super::streams::traffic;

/// Prices 1, 2, 3, ... pJ and 1, 2, 3, 4 W.
fn simple(name: &str) -> Device {
    let mut device = device(name, &["energy.scale=1"]);
    let actions = device.energy.actions.as_mut().expect("prices of commands");
    let prices = [
        &mut actions.activate,
        &mut actions.read,
        &mut actions.read_io,
        &mut actions.write,
        &mut actions.write_io,
        &mut actions.refresh,
    ];
    for (i, price) in prices.into_iter().enumerate() {
        price.energy.0 = (i + 1) as f64;
    }
    let b = &mut actions.background;
    let states = [&mut b.active, &mut b.precharged, &mut b.power_down, &mut b.self_refresh];
    for (i, state) in states.into_iter().enumerate() {
        state.power.0 = (i + 1) as f64;
    }
    device
}

fn run(device: &Device, mode: &str, n: usize) -> Run {
    banked(device, mode.parse::<Mode>().expect("a mode"), traffic(5, n, 4))
}

#[test]
fn commands_times_prices() {
    let device = simple("lpddr4-3200-x16x8");
    let run = run(&device, "sat", 4000);
    let (stats, used) = (&run.stats, EnergyUse::new(&device, &run.stats, run.cycles));
    assert!(stats.activates > 100 && stats.reads > 100 && stats.writes > 100);
    assert_eq!(used.activate.0, stats.activates as f64);
    assert_eq!(used.read.0, 2.0 * stats.reads as f64);
    assert_eq!(used.read_io.0, 3.0 * stats.reads as f64);
    assert_eq!(used.write.0, 4.0 * stats.writes as f64);
    assert_eq!(used.write_io.0, 5.0 * stats.writes as f64);
    assert_eq!(used.refresh.0, 6.0 * stats.refreshes_all as f64);
    assert_eq!(used.flat.0, 0.0);
    // 1 W with a row open, 2 W with none: nJ per ns.
    let all = device.ns(run.cycles * 8);
    let open = device.ns(stats.active);
    let expected = 1e3 * (open + 2.0 * (all - open));
    assert!((used.background.0 / expected - 1.0).abs() < 1e-12);
    let sum: f64 = used.parts().iter().map(|p| p.1.0).sum();
    assert_eq!(used.total().0, sum);
}

#[test]
fn a_flat_price_is_exact_on_requested_bytes() {
    let device = device("lpddr4-3200-x16x8-flat", &[]);
    let run = run(&device, "sat", 3000);
    let used = EnergyUse::new(&device, &run.stats, run.cycles * 10);
    let bytes = run.stats.total.requested_bytes();
    assert!(run.stats.total.moved_bytes != bytes, "requests are no whole bursts");
    assert_eq!(used.total().0, bytes as f64 * 10.88);
}

#[test]
fn a_memory_without_requests_sleeps() {
    let mut device = simple("lpddr4-3200-x16x2");
    device.controller.refresh = powergs_dram::device::Refresh::AllBank;
    let one = [Access { write: false, address: 0, bytes: 32 }];
    let run = banked(&device, Mode::Saturated, one);
    let later = run.cycles + device.ck(powergs_base::quantity::Nanoseconds(3e6));
    let used = EnergyUse::new(&device, &run.stats, later);
    // Two channels: 1 us of standby at 2 W, then power-down at 3 W, after 1 ms self-refresh at 4 W.
    let rest = 2.0 * (1e3 * 2.0 + (1e6 - 1e3) * 3.0 + 2e6 * 4.0) * 1e3;
    let busy = used.background.0 - rest;
    assert!(busy > 0.0 && busy < 2.0 * device.ns(run.cycles) * 2.0 * 1e3 + 1.0, "{busy}");
    // Refreshes of 1 ms; those of self-refresh are part of its power.
    let refreshes = 2.0 * 1e6 / (6246.0 * 0.625);
    assert!((used.refresh.0 / 6.0 - refreshes).abs() < 4.0, "{}", used.refresh.0 / 6.0);
}

#[test]
fn sleep_inside_a_run_is_found() {
    let device = simple("lpddr4-3200-x16x2");
    // 64 B in 20 us: most of the time in power-down; 64 B in 4 ms: mostly in self-refresh.
    let down = run(&device, "rate0.003", 40).stats;
    let all = (down.until * 2) as f64;
    assert!(down.power_down as f64 > 0.9 * all && down.self_refresh == 0, "{down:?}");
    let mut slow = simple("lpddr4-3200-x16x2");
    slow.energy.actions.as_mut().expect("prices").background.self_refresh_after.0 = 5e3;
    let own = run(&slow, "rate0.003", 40).stats;
    assert!(own.self_refresh as f64 > 0.6 * all, "{own:?}");
    assert_eq!(own.power_down + own.self_refresh, down.power_down);
}

#[test]
fn both_readings_of_lpddr4_are_there() {
    let half = device("lpddr4-3200-x16x8", &[]);
    let full = device("lpddr4-3200-x16x8-full", &[]);
    assert_eq!((half.energy.scale, full.energy.scale), (0.5, 1.0));
    let accesses: Vec<Access> =
        (0..20_000).map(|i| Access { write: false, address: i * 64, bytes: 64 }).collect();
    let per_byte = |device: &Device| {
        let run = banked(device, Mode::Saturated, accesses.iter().copied());
        let used = EnergyUse::new(device, &run.stats, run.cycles);
        used.total().0 / run.stats.total.requested_bytes() as f64
    };
    let (half, full) = (per_byte(&half), per_byte(&full));
    assert!((full / half - 2.0).abs() < 1e-9);
    // The published totals of a sequential read: 37.7 and 75.3 pJ/B.
    assert!((full - 75.3).abs() < 1.5, "{full}");
}

/// One formula: a run of the device alone and a frame of the simulator cost the same for the same
/// commands. Background differs by what is known of the channels (A56).
#[test]
fn a_device_alone_and_a_replay_pay_the_same_for_commands() {
    for (refresh, is_per_bank) in [("all-bank", false), ("per-bank", true)] {
        let device = device("lpddr4-3200-x32x4", &[&format!("controller.refresh={refresh}")]);
        let run = run(&device, "rate0.3", 4000);
        let stats = &run.stats;
        assert_eq!(stats.refreshes_bank > 0, is_per_bank, "{refresh}");
        let alone = EnergyUse::new(&device, stats, run.cycles);
        let prices = CommandPrices::of(&device).expect("prices of commands");
        let work = prices.commands(stats.reads, stats.writes, stats.activates).0;
        let parts = alone.activate.0 + alone.read.0 + alone.read_io.0;
        let parts = parts + alone.write.0 + alone.write_io.0;
        assert!((work / parts - 1.0).abs() < 1e-12, "{refresh}: {work} for {parts}");
        if stats.self_refresh == 0 && stats.until == run.cycles {
            let refreshes = prices.refreshes(stats.refreshes_all, stats.refreshes_bank);
            assert_eq!(refreshes * prices.refresh_pj, alone.refresh.0, "{refresh}");
        }
    }
}
