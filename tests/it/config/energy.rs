//! Energy tables: what they cost on GSCore, and what is refused.

use approx::assert_relative_eq;
use powergs_sim::accel::Machine;
use powergs_sim::action::{Action, Buffer, Inventory, Memory};
use powergs_sim::config::embedded::{ENERGY, find};
use powergs_sim::energy::{EnergyTable, Prices};
use powergs_sim::quantity::Bytes;

use super::gscore;

fn text(name: &str) -> &'static str {
    find(ENERGY, name).expect("an embedded table")
}

fn table(name: &str) -> EnergyTable {
    EnergyTable::parse(text(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn on_gscore(name: &str) -> Prices {
    let machine = Machine::parse(gscore()).expect("gscore");
    table(name).prices(&machine.inventory()).expect("prices of gscore")
}

/// One bank of this size in every buffer, one unit of every kind.
fn inventory(bytes: u64) -> Inventory {
    let memory = Memory { bank: Bytes(bytes), banks: 1, word: Bytes(32), two_ports: false };
    Inventory { memories: [memory; Buffer::ALL.len()], units: [1; 4] }
}

fn pj(prices: &Prices, action: Action) -> f64 {
    prices.per_action[action.index()]
}

#[test]
fn paper_prices_are_the_published_constants() {
    let table = table("paper");
    assert_eq!(table.flat_pj(), Some([0.53, 0.24, 10.88]));
    let flops = [
        (Action::Cull, 47),
        (Action::Project, 169 + 39),
        (Action::ObbPrepare, 38),
        (Action::ObbTest, 48),
        (Action::ShColour, 133),
        (Action::Alpha, 13),
        (Action::Blend, 11),
        (Action::PixelFinish, 6),
    ];
    let prices = on_gscore("paper");
    for (action, n) in flops {
        assert_eq!(table.flops(action), Some(n));
        assert_eq!(pj(&prices, action), f64::from(n) * 0.53);
    }
    assert_eq!(pj(&prices, Action::PivotKey), 0.0);
    assert_eq!(pj(&prices, Action::SramWrite(Buffer::Feature)), 0.24);
    assert_eq!(pj(&prices, Action::DramRead), 10.88);
    assert_eq!((prices.leakage_w, prices.background_w), (0.0, 0.0));
}

/// A busy unit draws its published power (NeRArch-Sim, Table VI), leakage included. The prices are
/// written with four digits: 5e-4.
#[test]
fn a_busy_unit_draws_its_published_power() {
    let prices = on_gscore("gscore-28nm");
    let leakage = table("gscore-28nm").leakage;
    let sum = |actions: &[Action]| actions.iter().map(|&a| pj(&prices, a)).sum::<f64>() * 1e-3;
    use Action::*;
    let ccu = sum(&[Cull, Project, ObbPrepare, ObbTest, ShColour]) + leakage.ccu.power.0;
    assert_relative_eq!(ccu, 0.140, max_relative = 5e-4);
    let qsu = sum(&[PivotKey]) + leakage.qsu.power.0;
    assert_relative_eq!(qsu, 0.13e-3, max_relative = 5e-4);
    let bsu = 80.0 * sum(&[CompareExchange]) + leakage.bsu.power.0;
    assert_relative_eq!(bsu, 13.7e-3, max_relative = 5e-4);
    let vrc = sum(&[Alpha, Blend]) + leakage.vru.power.0;
    assert_relative_eq!(vrc, 3.27e-3, max_relative = 5e-4);
    // All units busy and the buffers' leakage, but no buffer access: the published chip draws
    // 0.87 W.
    let buffers = prices.leakage_w - on_gscore_units_leakage();
    let chip = 4.0 * ccu + 8.0 * qsu + 4.0 * bsu + 64.0 * vrc + buffers;
    assert!((0.82..0.89).contains(&chip), "{chip} W");
}

fn on_gscore_units_leakage() -> f64 {
    4.0 * 14e-3 + 8.0 * 13e-6 + 4.0 * 1.37e-3 + 64.0 * 0.327e-3
}

#[test]
fn leakage_grows_with_units_and_buffers() {
    let prices = on_gscore("gscore-28nm");
    // 8 banks each of 1, 4, 16 and 2 KiB and 32 of 2 KiB, from CACTI's rows.
    let buffers = (8.0 * (0.205 + 0.74141 + 2.66704 + 0.38556) + 32.0 * 0.38556) * 1e-3;
    assert_relative_eq!(prices.leakage_w, on_gscore_units_leakage() + buffers, max_relative = 1e-9);
}

#[test]
fn sram_prices_follow_the_size_of_a_bank() {
    let table = table("gscore-28nm");
    let price = |bytes: u64| {
        let built = inventory(bytes);
        let prices = table.prices(&built)?;
        Ok::<_, powergs_sim::energy::table::PriceError>((
            pj(&prices, Action::SramRead(Buffer::Sorting)),
            pj(&prices, Action::SramWrite(Buffer::Sorting)),
        ))
    };
    let row = price(32 << 10).expect("a row of the table");
    assert_relative_eq!(row.0, 0.1863, max_relative = 1e-12);
    assert_relative_eq!(row.1, 0.274, max_relative = 1e-12);
    // Half-way in the logarithm of the size is the geometric mean of the two rows.
    let between = price(46_341).expect("between two rows").0;
    assert_relative_eq!(between, (0.1863f64 * 0.3263).sqrt(), max_relative = 1e-5);
    let sizes =
        (10..=20).flat_map(|two| [1u64 << two, 3u64 << (two - 1)]).filter(|b| *b <= 1 << 20);
    let prices: Vec<f64> = sizes.map(|b| price(b).expect("inside").0).collect();
    assert!(prices.is_sorted(), "{prices:?}");
    let error = price(2 << 20).expect_err("above the table").to_string();
    assert!(error.contains("2 MiB") && error.contains("1 KiB to 1 MiB"), "{error}");
    assert!(error.contains("allow-extrapolation = true"), "{error}");
    assert!(price(512).is_err());
    assert!(price(0).is_err());
}

#[test]
fn extrapolation_must_be_asked_for() {
    let allowed =
        text("gscore-28nm").replace("allow-extrapolation = false", "allow-extrapolation = true");
    let table = EnergyTable::parse(&allowed).expect("a good table");
    let price = |bytes: u64| {
        let built = inventory(bytes);
        table.prices(&built).map(|p| pj(&p, Action::SramRead(Buffer::Feature)))
    };
    let (one, two) = (price(1 << 20).expect("a row"), price(2 << 20).expect("beyond"));
    assert_relative_eq!(two / one, 1.4733 / 0.9559, max_relative = 1e-9);
    assert!(price(0).is_err(), "no bank has no bytes");
}

#[test]
fn the_two_default_tables_differ_in_dram_only() {
    let (low, high) = (on_gscore("gscore-28nm"), on_gscore("gscore-28nm-lpddr4"));
    for action in Action::all() {
        let same = pj(&low, action) == pj(&high, action);
        assert_eq!(same, !matches!(action, Action::DramRead | Action::DramWrite), "{action:?}");
    }
    assert_eq!(low.leakage_w, high.leakage_w);
    assert_eq!((pj(&low, Action::DramRead), pj(&high, Action::DramWrite)), (10.88, 64.0));
    assert_eq!(low.background_w, 0.048);
    assert_eq!(high.background_w * 1e3, 318.0, "milliwatts");
}

#[track_caller]
fn refused(from: &str, to: &str, because: &str) {
    let good = text("gscore-28nm");
    assert!(good.contains(from), "{from}");
    let error = EnergyTable::parse(&good.replacen(from, to, 1)).expect_err(to).to_string();
    assert!(error.contains(because), "{to}: {error}");
    assert!(error.starts_with("line "), "{error}");
}

#[test]
fn tables_that_would_lie_are_refused() {
    let alpha = "alpha = { energy = \"1.594 pJ\", source = \"A10\" }";
    refused(alpha, "", "missing key `alpha` in [actions]");
    refused("\"1.594 pJ\"", "\"0 pJ\"", "zero: give a price, or say `free = true`");
    refused("\"1.594 pJ\"", "1.594", "an energy needs its unit");
    refused("\"1.594 pJ\"", "\"1.594 pJ/B\"", "unknown unit `pJ/B` for an energy:");
    refused(alpha, "alpha = { flops = 13, source = \"A10\" }", "add [flop]");
    let both = "alpha = { energy = \"1 pJ\", free = true, source = \"A10\" }";
    refused(alpha, both, "exactly one of `energy`, `flops` and `free = true`");
    refused(alpha, "alpha = { source = \"A10\" }", "exactly one of");
    refused(alpha, "alpha = { energy = \"1 pJ\" }", "missing key `source`");
    refused(alpha, "alpha = { energy = \"1 pJ\", source = \"me\" }", "neither a key of references");
    refused("source = \"cacti\"", "source = \"cactus\"", "\"cactus\" is neither");
    refused("\"48 mW\"", "\"0 W\"", "`dram.background.power` is zero");
    refused("\"48 mW\", source", "\"48 mW\", free = true, source", "free and has a price");
    refused(
        "[sram.table]",
        "[sram.flat]\nenergy = \"1 pJ/B\"\nsource = \"A1\"\n[sram.table]",
        "exactly one of [sram.flat] and [sram.table]",
    );
    refused("capacity = \"2 KiB\"", "capacity = \"1 KiB\"", "ascending");
    refused("read = \"0.0508 pJ/B\"", "read = \"0 pJ/B\"", "has a zero");
    refused("node = \"28 nm\"", "node = 28", "a technology node needs its unit");
}
