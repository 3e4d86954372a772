//! Energy tables: what they cost on GSCore, and what is refused.

use approx::assert_relative_eq;
use powergs_base::config::embedded::ENERGY;
use powergs_base::quantity::{Bytes, Hertz};
use powergs_core::machine::Machine;
use powergs_core::sim::cost;
use powergs_core::stage::EnergyTable;
use powergs_core::stage::{
    DRAM_READ, DRAM_WRITE, buffer_id, hardware, sram_read, sram_write, work_id,
};
use powergs_energy::action::{ActionId, Inventory, Memory};
use powergs_energy::hardware::Does;
use powergs_energy::table::PriceError;
use powergs_energy::{Area, Built, DramCosts, Prices};

use super::gscore;

fn text(name: &str) -> String {
    let file = ENERGY.iter().find(|file| file.name == name).expect("an embedded table");
    file.complete()
}

fn table(name: &str) -> EnergyTable {
    EnergyTable::parse(&text(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn on_gscore(name: &str) -> Prices {
    let sets = ["dram.model=bandwidth".to_owned()];
    let machine = Machine::parse_with(gscore(), &sets).expect("gscore");
    cost::prices(&table(name), &machine).expect("prices of gscore")
}

fn priced(table: &EnergyTable, inventory: &Inventory) -> Result<Prices, PriceError> {
    let (channels, clock) = (8.0, Hertz(1e9));
    table.prices(&Built {
        inventory,
        idle_leakage: 1.0,
        gated: false,
        numbers: None,
        device: None,
        channels,
        phy_channels: channels,
        standby_share: 1.0,
        clock,
    })
}

/// Prices per byte of DRAM read, its background and refresh.
fn dram(prices: &Prices) -> [f64; 3] {
    match prices.dram {
        DramCosts::Bytes { read_pj, background_w, refresh_w, .. } => {
            [read_pj, background_w, refresh_w]
        }
        DramCosts::Commands(_) | DramCosts::Uncounted { .. } => panic!("flat prices"),
    }
}

/// One bank of this size in every buffer, one unit of every kind.
fn inventory(bytes: u64) -> Inventory {
    let memory = Memory { bank: Bytes(bytes), banks: 1, word: Bytes(32), two_ports: false };
    Inventory {
        memories: vec![memory; hardware().buffers().count()],
        units: vec![1; hardware().stages().count()],
        parts: vec![1.0; hardware().parts().count()],
    }
}

fn pj(prices: &Prices, action: ActionId) -> f64 {
    prices.per_action[action.index()]
}

#[test]
fn paper_prices_are_the_published_constants() {
    let table = table("paper");
    assert_eq!(table.flat_pj(), Some([0.53, 0.24, 10.88]));
    let counts = [
        (work_id("cull"), 47),
        (work_id("project"), 169 + 39),
        (work_id("obb-prepare"), 38),
        (work_id("obb-test"), 48),
        (work_id("sh-colour"), 133),
        (work_id("alpha"), 13),
        (work_id("blend"), 11),
        (work_id("pixel-finish"), 6),
    ];
    let prices = on_gscore("paper");
    for (action, n) in counts {
        let declared = |does| matches!(does, Does::Work(_, work) if work.flops == n);
        assert!(declared(hardware().does(action)), "{action:?}");
        assert_eq!(pj(&prices, action), f64::from(n) * 0.53);
    }
    assert_eq!(pj(&prices, work_id("pivot-key")), 0.0);
    assert_eq!(pj(&prices, sram_write(buffer_id("feature"))), 0.24);
    assert_eq!(pj(&prices, DRAM_READ), 10.88);
    assert_eq!((prices.leakage_w(), prices.area.as_ref()), (0.0, None));
    assert_eq!(dram(&prices), [10.88, 0.0, 0.0]);
}

/// A busy unit draws its published power, leakage included: GSCore's Table 7, and Table VI of
/// NeRArch-Sim. The prices are written with four digits: 5e-4.
#[test]
fn a_busy_unit_draws_its_published_power() {
    let table_7 = [0.52 / 4.0, 0.01 / 8.0, 0.05 / 4.0, 0.25 / 64.0];
    draws("gscore-28nm", table_7, 0.83);
    draws("gscore-28nm-nerarch", [0.140, 0.13e-3, 13.7e-3, 3.27e-3], 0.825);
}

fn draws(name: &str, published: [f64; 4], together: f64) {
    let prices = on_gscore(name);
    let table = table(name);
    let leaks = |unit: &str| table.leakage[unit].power.0;
    let sum =
        |actions: &[&str]| actions.iter().map(|a| pj(&prices, work_id(a))).sum::<f64>() * 1e-3;
    let ccu = sum(&["cull", "project", "obb-prepare", "obb-test", "sh-colour"]) + leaks("ccu");
    assert_relative_eq!(ccu, published[0], max_relative = 5e-4);
    let qsu = sum(&["pivot-key"]) + leaks("qsu");
    assert_relative_eq!(qsu, published[1], max_relative = 5e-4);
    let bsu = 80.0 * sum(&["compare-exchange"]) + leaks("bsu");
    assert_relative_eq!(bsu, published[2], max_relative = 5e-4);
    let vrc = sum(&["alpha", "blend"]) + leaks("vru");
    assert_relative_eq!(vrc, published[3], max_relative = 5e-4);
    // Units only: the published 0.87 W are the chip.
    let units = 4.0 * ccu + 8.0 * qsu + 4.0 * bsu + 64.0 * vrc;
    assert_relative_eq!(units, together, max_relative = 1e-3);
}

/// The published chip draws 0.87 W. With every unit busy and every bank accessed in every cycle, a
/// bound that no frame reaches, ours draws a fifth more.
#[test]
fn gscore_at_its_peak() {
    let machine = Machine::parse(gscore()).expect("gscore");
    let peak = cost::peak_w(&machine, &on_gscore("gscore-28nm"));
    let of = |name: &str| peak.iter().find(|(block, _)| *block == name).expect(name).1;
    assert_relative_eq!(of("ccu"), 0.52, max_relative = 5e-4);
    assert_relative_eq!(of("vru"), 0.25, max_relative = 5e-4);
    let units = ["ccu", "qsu", "bsu", "vru"].map(of).iter().sum::<f64>();
    assert_relative_eq!(units, 0.83, max_relative = 1e-3);
    let total: f64 = peak.iter().map(|(_, watts)| watts).sum();
    assert!((0.9..1.2).contains(&total), "{total} W");
}

/// Published: 3.95 mm2 at 28 nm; 1.45 at 16 nm and 0.417 at 7 nm as others scale it.
#[test]
fn area_of_gscore() {
    let core = |name: &str| on_gscore(name).area.expect("an area").core().0;
    let area = on_gscore("gscore-28nm").area.expect("an area");
    println!("{area:?}");
    for (name, published) in [("gscore-28nm", 3.95), ("gscore-16nm", 1.45), ("gscore-7nm", 0.417)] {
        let ours = core(name);
        println!("{name}: {ours} mm2 for {published}");
        assert_relative_eq!(ours, published, max_relative = 0.1);
    }
    let parts: f64 = area.areas().iter().map(|x| x.0).sum();
    assert_relative_eq!(parts, area.total().0, max_relative = 1e-12);
    // Table 7: units, and buffers with those that nobody names.
    for (ours, published) in area.units.iter().zip([0.82, 0.01, 0.06, 1.81]) {
        assert_relative_eq!(ours.0, published, max_relative = 1e-3);
    }
    let buffers: f64 = area.buffers.iter().map(|x| x.0).sum();
    assert_relative_eq!(buffers + area.rest.0, 1.25, max_relative = 1e-3);
    assert_relative_eq!(area.core().0, 3.95, max_relative = 1e-3);
    // Eight channels, each with its PHY and its controller.
    assert_relative_eq!(area.total().0, area.core().0 + 8.0 * (1.0 + 0.1), max_relative = 1e-12);
    assert_eq!(area.buffers[buffer_id("cache").index()].0, 0.0, "gscore has no cache");
    assert_eq!(Area::blocks(hardware()).len(), area.areas().len());
}

#[test]
fn area_grows_with_units_and_buffers() {
    let base = Machine::parse(gscore()).expect("gscore");
    let area = |machine: &Machine| {
        cost::prices(&table("gscore-28nm"), machine).expect("prices").area.expect("an area")
    };
    let mut wide = base.clone();
    wide.tiles_mut().vru.units_per_core *= 2;
    let (a, b) = (area(&base), area(&wide));
    // Twice the units hold half of the pixels and of the queues each.
    let each = 1.0 - 0.145 / 2.0 - 0.0317 * 36.0 / 224.0;
    assert_relative_eq!(b.units[3].0, 2.0 * each * a.units[3].0, max_relative = 1e-12);
    assert_eq!(b.buffers, a.buffers);
    let mut large = base.clone();
    large.tiles_mut().buffers.feature.capacity = Bytes(2 * base.tiles().buffers.feature.capacity.0);
    let c = area(&large);
    assert!(c.buffers[buffer_id("feature").index()] > a.buffers[buffer_id("feature").index()]);
    assert!(c.total().0 > a.total().0);
}

fn on_gscore_units_leakage() -> f64 {
    4.0 * 13e-3 + 8.0 * 125e-6 + 4.0 * 1.25e-3 + 64.0 * 0.3906e-3
}

#[test]
fn leakage_grows_with_units_and_buffers() {
    let prices = on_gscore("gscore-28nm");
    let units: f64 = prices.unit_leakage_w.iter().sum();
    assert_relative_eq!(units, on_gscore_units_leakage(), max_relative = 1e-12);
    // 32 banks of 2 KiB and 8 of 16 KiB are rows of CACTI.
    let [sorting, feature] =
        ["sorting", "feature"].map(|name| prices.sram_leakage_w[buffer_id(name).index()]);
    assert_relative_eq!(sorting, 0.8 * 32.0 * 0.39899e-3, max_relative = 1e-12);
    assert_relative_eq!(feature, 0.8 * 8.0 * 2.66704e-3, max_relative = 1e-12);
    let buffers: f64 = prices.sram_leakage_w.iter().sum();
    assert_eq!(prices.leakage_w(), units + buffers);
    assert!((0.034..0.042).contains(&buffers), "{buffers} W of 0.04");
}

/// A table with prices by size in place of CACTI's.
fn by_size(extrapolate: bool) -> String {
    let text = text("gscore-28nm");
    let (from, to) =
        (text.find("[sram.cacti]").expect("it"), text.find("# What the commands").expect("it"));
    let rows = [
        r#"{ capacity = "1 KiB", read = "0.05 pJ/B", write = "0.06 pJ/B","#,
        r#" leakage = "0.2 mW", area = "0.004 mm2" },"#,
        r#"{ capacity = "64 KiB", read = "0.4 pJ/B", write = "0.3 pJ/B","#,
        r#" leakage = "9 mW", area = "0.1 mm2" },"#,
    ];
    let head = format!("source = \"cacti\"\nallow-extrapolation = {extrapolate}\nsizes = [\n");
    let sizes = ["[sram.table]\n", &head, &rows.concat(), "\n]\n\n"].concat();
    [&text[..from], &sizes, &text[to..]].concat()
}

#[test]
fn prices_by_size_are_interpolated_in_logarithms() {
    let price = |text: &str, bytes: u64| {
        let table = EnergyTable::parse(text).expect("a good table");
        let mut inventory = inventory(bytes);
        for (id, unit) in hardware().units() {
            // Units of machines that the table is not for.
            let is_priced = unit.counted_in.is_some() || table.leakage.contains_key(unit.key);
            inventory.units[id.index()] = u32::from(is_priced);
        }
        let prices = priced(&table, &inventory)?;
        Ok::<_, PriceError>(pj(&prices, sram_read(buffer_id("sorting"))))
    };
    let strict = by_size(false);
    assert_relative_eq!(price(&strict, 1 << 10).expect("a row"), 0.05, max_relative = 1e-12);
    // Half-way in the logarithm of the size is the geometric mean of the two rows.
    let middle = price(&strict, 8 << 10).expect("between");
    assert_relative_eq!(middle, (0.05f64 * 0.4).sqrt(), max_relative = 1e-9);
    let error = price(&strict, 128 << 10).expect_err("above the table").to_string();
    assert!(error.contains("128 KiB") && error.contains("1 KiB to 64 KiB"), "{error}");
    assert!(error.contains("allow-extrapolation = true"), "{error}");
    let beyond = price(&by_size(true), 128 << 10).expect("allowed");
    assert_relative_eq!(beyond / 0.4, 8f64.powf(1.0 / 6.0), max_relative = 1e-9);
    assert!(price(&by_size(true), 0).is_err(), "no bank has no bytes");
}

#[test]
fn tables_of_other_memories_differ_in_dram_only() {
    let [flat, device] = ["gscore-28nm-flat", "gscore-28nm"].map(table);
    let chip = |t: &EnergyTable| {
        let sram = t.sram.clone();
        (t.actions.clone(), sram, t.leakage.clone(), t.area.clone(), t.parts.clone())
    };
    assert_eq!(chip(&flat), chip(&device));
    assert_eq!((&flat.phy, &flat.supply), (&device.phy, &device.supply));
    let (low, high) = (on_gscore("gscore-28nm-flat"), on_gscore("gscore-28nm"));
    for (action, does) in hardware().actions() {
        let same = pj(&low, action) == pj(&high, action);
        assert_eq!(same, !matches!(does, Does::DramRead | Does::DramWrite), "{does:?}");
    }
    assert_eq!((low.leakage_w(), &low.area), (high.leakage_w(), &high.area));
    assert_eq!(pj(&low, DRAM_READ), 10.88);
    assert_eq!(dram(&low), [10.88, 0.0252, 0.0228]);
    // Half of the published prices (A40): bursts of 32 bytes, and an activate for every fourth.
    let of_burst = |pj: f64| (pj + 602.5 / 4.0) / 32.0;
    assert_relative_eq!(pj(&high, DRAM_READ), of_burst(1084.5), max_relative = 1e-12);
    assert_relative_eq!(pj(&high, DRAM_WRITE), of_burst(644.0), max_relative = 1e-12);
}

#[test]
fn smaller_nodes_are_the_same_prices_times_published_factors() {
    let base = on_gscore("gscore-28nm");
    let nodes = [("gscore-16nm", 0.28, 0.38, 0.6, 2.72), ("gscore-7nm", 0.11, 0.15, 0.3, 9.47)];
    for (name, energy, sram, leak, area) in nodes {
        let prices = on_gscore(name);
        for (action, does) in hardware().actions() {
            let factor = match does {
                Does::SramRead(_) | Does::SramWrite(_) => sram,
                Does::DramRead | Does::DramWrite => 1.0,
                _ => energy,
            };
            let (ours, theirs) = (pj(&prices, action), pj(&base, action) * factor);
            assert_relative_eq!(ours, theirs, max_relative = 1e-12);
        }
        let ratio = |i: usize| prices.unit_leakage_w[i] / base.unit_leakage_w[i];
        assert_relative_eq!(ratio(0), energy, max_relative = 1e-12);
        let buffers = prices.sram_leakage_w[2] / base.sram_leakage_w[2];
        assert_relative_eq!(buffers, leak, max_relative = 1e-12);
        let core = |p: &Prices| p.area.as_ref().expect("an area").core().0;
        assert_relative_eq!(core(&base) / core(&prices), area, max_relative = 1e-9);
    }
}

#[test]
fn nodes_without_a_row_are_refused_with_those_that_exist() {
    let of = |from: &str, to: &str| {
        let text = text("gscore-16nm").replacen(from, to, 1);
        EnergyTable::parse(&text).expect_err(to).to_string()
    };
    let error = of("node = \"16 nm\"", "node = \"12 nm\"");
    assert!(error.contains("no energy for 28 nm (`from`) to 12 nm (`node`)"), "{error}");
    assert!(error.contains("28 nm to 22 nm") && error.contains("give `factor`"), "{error}");
    let error = of("node = \"16 nm\"", "node = \"14 nm\"");
    assert!(
        error.contains("no area for 28 nm (`from`) to 14 nm (`node`): `deepscaletool` has"),
        "{error}"
    );
    let error = of("fit = \"stillmaker\"", "fit = \"moore\"");
    let known = "no fit `moore`; there are asap7, deepscaletool, neo, stillmaker";
    assert!(error.contains(known), "{error}");
    let error = of("node = \"16 nm\"", "node = \"28 nm\"");
    assert!(error.contains("`scaling.from` and `node` are both 28 nm"), "{error}");
    let error = of("node = \"28 nm\"\ncell", "node = \"22 nm\"\ncell");
    assert!(error.contains("`sram.cacti.node` = 22 nm and `scaling.from` = 28 nm"), "{error}");
    let error = of("factor = 0.38, source = \"A53\"", "factor = 0.38");
    assert!(error.contains("say where it is from"), "{error}");
    let error = of("factor = 0.38, source = \"A53\"", "factor = 0.38, fit = \"stillmaker\"");
    assert!(error.contains("exactly one of `fit` and `factor`"), "{error}");
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
    let alpha = "alpha = { energy = \"1.904 pJ\", source = \"A10\" }";
    refused(alpha, "", "missing key `alpha` in [actions]");
    refused("\"1.904 pJ\"", "\"0 pJ\"", "zero: give a price, or say `free = true`");
    refused("\"1.904 pJ\"", "1.594", "an energy needs its unit");
    refused("\"1.904 pJ\"", "\"1.594 pJ/B\"", "unknown unit `pJ/B` for an energy:");
    refused(alpha, "alpha = { flops = 13, source = \"A10\" }", "add [flop]");
    let both = "alpha = { energy = \"1 pJ\", free = true, source = \"A10\" }";
    refused(alpha, both, "exactly one of `energy`, `flops` and `free = true`");
    refused(alpha, "alpha = { source = \"A10\" }", "exactly one of");
    refused(alpha, "alpha = { energy = \"1 pJ\" }", "missing key `source`");
    refused(alpha, "alpha = { energy = \"1 pJ\", source = \"me\" }", "neither a key of references");
    refused("source = \"cacti\"", "source = \"cactus\"", "\"cactus\" is neither");
    refused("\"25.2 mW\"", "\"0 W\"", "`dram.flat.background.power` is zero");
    refused("\"22.8 mW\", source", "\"22.8 mW\", free = true, source", "free and has a price");
    refused(
        "[sram.cacti]",
        "[sram.flat]\nenergy = \"1 pJ/B\"\nsource = \"A1\"\n[sram.cacti]",
        "exactly one of [sram.flat], [sram.table]",
    );
    let (rows, others) = ("node = \"28 nm\"\ncell = \"lop\"", "node = \"22 nm\"\ncell = \"hp\"");
    refused(rows, others, "all prices of a file are for one node");
    refused("cell = \"lop\"", "cell = \"lopp\"", "did you mean \"lop\"");
    refused("temperature = 350", "temperature = 320", "no rows at 320 K: 300 K, 350 K");
    refused("\"205000 um2\"", "\"0 um2\"", "no unit takes no area");
    refused("node = \"28 nm\"\n\n#", "\n#", "missing key `node`");
    refused("node = \"28 nm\"", "node = 28", "a technology node needs its unit");
}
