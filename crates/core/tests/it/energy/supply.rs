//! Clock and voltage: the law, what it was fitted to, and its ends.

use approx::assert_relative_eq;
use powergs_base::config::embedded::{ENERGY, MACHINES, find};
use powergs_base::quantity::{Hertz, Volts};
use powergs_core::machine::Machine;
use powergs_core::sim::cost;

use powergs_core::stage::EnergyTable;
use powergs_core::stage::{DRAM_READ, buffer_id, sram_read, work_id};
use powergs_energy::supply::Curve;
use powergs_energy::table::CurveChoice;
use powergs_energy::{Prices, same_costs};

fn table(name: &str) -> EnergyTable {
    EnergyTable::parse(find(ENERGY, name).expect("a table")).expect("a good table")
}

fn at(name: &str, clock: &str) -> Result<Prices, String> {
    let machine = Machine::parse_with(
        find(MACHINES, "gscore").expect("a machine"),
        &[format!("clock={clock}")],
    )
    .expect("a good machine");
    cost::prices(&table(name), &machine).map_err(|e| e.to_string())
}

fn curve(name: &str) -> Curve {
    table(name).supply.and_then(|supply| supply.curve).expect("it").curve().expect("a curve")
}

#[test]
fn the_curve_at_16_nm_goes_through_the_two_points_of_vorion() {
    let curve = curve("gscore-16nm");
    assert_eq!((curve.lowest, curve.highest), (Volts(0.57), Volts(1.15)));
    let f = |volts: f64| curve.clock_at(volts, Hertz(100e6), Volts(0.57)) * 1e-6;
    // Three digits of threshold and exponent: half a percent.
    assert_relative_eq!(f(1.15), 530.0, max_relative = 6e-3);
    // "Quasi-linear in voltage": a straight line between the two, within 2 %.
    for i in 0..=20 {
        let volts = 0.57 + 0.029 * f64::from(i);
        assert_relative_eq!(f(volts), 100.0 + 21.5 * f64::from(i), max_relative = 0.02);
    }
}

/// Of the chip of ISSCC 2025 the ratio was used: 0.581 mJ a frame at 150 MHz, 1.780 mJ at 700 MHz.
#[test]
fn the_curve_at_28_nm_has_the_ratio_of_the_chip_of_isscc_2025() {
    let curve = curve("gscore-28nm");
    let (clock, top) = (Hertz(700e6), Volts(1.05));
    let least = |f: f64| curve.supply(Hertz(f), clock, top).expect("below the highest");
    assert_relative_eq!(least(150e6).voltage, 0.58, max_relative = 5e-3);
    // A tenth of the power is leakage at 0.9 V, where that chip reaches 530 MHz.
    let nominal = Volts(0.9);
    let f_nominal = curve.clock_at(0.9, clock, top);
    let frame = |f: f64| {
        let supply = curve.supply(Hertz(f), Hertz(f_nominal), nominal).expect("a voltage");
        0.9 * supply.energy + 0.1 * supply.leakage * f_nominal / f
    };
    assert_relative_eq!(
        frame(700e6) / frame(150e6),
        (664.0 / 373.0) / (46.5 / 80.0),
        max_relative = 0.02
    );
}

#[test]
fn a_slower_clock_saves_energy_and_leakage_down_to_the_lowest_voltage() {
    let (full, half) = (at("gscore-28nm", "1 GHz").unwrap(), at("gscore-28nm", "500 MHz").unwrap());
    let supply = half.supply.expect("a curve");
    assert_relative_eq!(supply.voltage, 0.676, max_relative = 1e-3);
    let ratio = supply.voltage / 0.9;
    assert_relative_eq!(supply.energy, ratio * ratio, max_relative = 1e-12);
    for action in [work_id("alpha"), work_id("cull"), sram_read(buffer_id("feature"))] {
        assert_relative_eq!(
            half.of(action).0 / full.of(action).0,
            supply.energy,
            max_relative = 1e-12
        );
    }
    assert_eq!(half.of(DRAM_READ), full.of(DRAM_READ), "another chip");
    assert_relative_eq!(half.leakage_w() / full.leakage_w(), supply.leakage, max_relative = 1e-9);
    assert!(supply.leakage < supply.energy, "leakage is steeper");
    assert_eq!(half.area, full.area);
    let (slow, slower) =
        (at("gscore-28nm", "280 MHz").unwrap(), at("gscore-28nm", "10 MHz").unwrap());
    assert_eq!(slow.supply.unwrap().voltage, 0.58);
    assert!(same_costs(&slow, &slower), "the voltage stays");
    let mut last = 0.0;
    for mhz in (300..=1300).step_by(20) {
        let now = at("gscore-28nm", &format!("{mhz} MHz")).unwrap().supply.unwrap();
        assert!(now.voltage > last && now.voltage <= 1.05, "{mhz} MHz");
        assert_relative_eq!(now.highest_clock, 1.3219e9, max_relative = 1e-3);
        last = now.voltage;
    }
}

#[test]
fn a_clock_above_the_highest_is_refused_with_the_highest() {
    let error = at("gscore-28nm", "10 GHz").unwrap_err();
    for part in ["`clock` = 10 GHz", "28 nm", "1.321 GHz at 1.05 V", "`energy`", "gscore-28nm"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    // The limit that is named is kept, and the next megahertz is not.
    assert!(at("gscore-28nm", "1321 MHz").is_ok() && at("gscore-28nm", "1322 MHz").is_err());
    assert!(at("gscore-16nm", "1.9 GHz").is_ok() && at("gscore-16nm", "2 GHz").is_err());
    assert!(at("gscore-7nm", "1.7 GHz").is_ok() && at("gscore-7nm", "1.8 GHz").is_err());
    // PowerGS states no clock: its prices are as given.
    let (one, ten) = (at("paper", "1 GHz").unwrap(), at("paper", "10 GHz").unwrap());
    assert!(one.supply.is_none() && one.per_action == ten.per_action);
}

#[test]
fn tables_with_a_supply_that_cannot_be_are_refused() {
    let text = find(ENERGY, "gscore-28nm").expect("a table");
    let refused = |from: &str, to: &str, because: &str| {
        assert!(text.contains(from), "{from}");
        let error = EnergyTable::parse(&text.replacen(from, to, 1)).expect_err(to).to_string();
        assert!(error.contains(because), "{to}: {error}");
    };
    let own = "curve = { threshold = \"0.4 V\", exponent = 1.65, leakage-slope = \"0.3 V\", \
               lowest = \"0.6 V\", highest = \"1.1 V\"";
    let node = "curve = { node = \"28 nm\"";
    refused(node, own, "say where it is from in `source`");
    refused(node, &own.replace("0.6 V", "0.3 V"), "must ascend");
    refused(node, "curve = { node = \"16 nm\"", "`supply.curve.node` = 16 nm and `node` = 28 nm");
    refused(node, "curve = { threshold = \"0.4 V\"", "needs either `node`, or `threshold`");
    refused("voltage = \"0.9 V\"", "voltage = \"1.2 V\"", "is outside of `supply.curve`");
    refused("voltage = \"0.9 V\"", "voltage = 0.9", "a voltage needs its unit");
    refused("voltage = \"0.9 V\"", "", "missing key `voltage` in [supply]");
    refused("curve = { node = \"28 nm\" }", "", "does nothing without `supply.curve`");
    refused("channels = 8", "", "missing key `channels` in [dram.flat]");
    refused("[parts.qsu]", "[parts.qus]", "parts");
    refused("share = 0.6, at = 426", "share = 0.95, at = 426", "`parts.ccu` sum to 1.090");
    let cut = |from: &str, to: &str| {
        let (a, b) = (text.find(from).expect(from), text.find(to).expect(to));
        EnergyTable::parse(&[&text[..a], &text[b..]].concat()).expect_err(from).to_string()
    };
    let error = cut("[parts.ltu]", "[phy]");
    assert!(error.contains("missing table [parts]") && error.contains("gscore-28nm"), "{error}");
    let error = cut("[phy]", "[supply]");
    assert!(error.contains("missing table [phy]"), "{error}");
    let choice = CurveChoice {
        node: Some(powergs_base::quantity::Nanometres(3.0)),
        threshold: None,
        exponent: None,
        leakage_slope: None,
        lowest: None,
        highest: None,
        source: None,
    };
    let error = choice.curve().expect_err("no curve at 3 nm");
    assert!(
        error.contains("no voltage-frequency curve for 3 nm: there are 45 nm, 28 nm"),
        "{error}"
    );
}
