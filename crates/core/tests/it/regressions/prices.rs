//! Prices of another memory, for another clock, and of chips that never rest.

use powergs_base::config::embedded::{MACHINES, find};
use powergs_core::machine::Machine;
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{System, SystemSpec};
use powergs_core::sim::cost;
use powergs_core::stage::EnergyTable;
use powergs_core::stage::{DRAM_READ, DRAM_WRITE};
use powergs_dram::CommandPrices;
use powergs_energy::IdleShares;

fn system(machine: &str, sets: &[&str]) -> System {
    let sets = sets.iter().map(|set| (*set).to_owned()).collect();
    let spec = SystemSpec { sets, ..SystemSpec::named(machine) };
    System::load(&spec, &EmbeddedFiles).expect("a machine")
}

/// `gscore` with an LPDDR5X memory and this model of it.
fn lpddr5x(model: &str, more: &[&str]) -> System {
    let model = format!("dram.model={model}");
    let memory = ["dram.device=lpddr5x-8533-x16x4", "dram.channels=4", "dram.mapping=bg64"];
    system("gscore", &[&memory[..], &[model.as_str()], more].concat())
}

#[test]
fn lpddr5x_was_priced_as_lpddr4_where_no_commands_are_counted() {
    let [banked, bandwidth] = ["banked", "bandwidth"].map(|model| lpddr5x(model, &[]));
    let device = bandwidth.machine().device.as_deref().expect("a device");
    let prices = CommandPrices::of(device).expect("prices of commands");
    // Of four bursts one opens a row (A150).
    let bytes = 4.0 * device.organisation.burst.0 as f64;
    let [read, write] = [DRAM_READ, DRAM_WRITE].map(|action| bandwidth.prices().of(action).0);
    for (found, four) in [(read, prices.commands(4, 0, 1)), (write, prices.commands(0, 4, 1))] {
        assert!((found * bytes / four.0 - 1.0).abs() < 1e-12, "{found} pJ/B");
    }
    assert!(read < 40.0, "{read} pJ/B: 64 are those of LPDDR4");
    assert_eq!(bandwidth.prices().dram.standby_w(), banked.prices().dram.standby_w());
    let dearer = lpddr5x("bandwidth", &["dram:energy.scale=1.0"]);
    assert!(dearer.prices().of(DRAM_READ).0 > 1.5 * read, "its assumptions move it");
    let missing = lpddr5x("bandwidth", &["energy:dram.row-hits.share=0.0"]);
    assert!(missing.prices().of(DRAM_READ).0 > read);
}

#[test]
fn tables_that_do_not_ask_the_device_keep_their_own_price() {
    let flat = lpddr5x("bandwidth", &["energy=gscore-28nm-flat"]);
    assert_eq!(flat.prices().of(DRAM_READ).0, 10.88);
}

#[test]
fn half_the_clock_seemed_to_cost_a_gpu_more_and_nobody_said_why() {
    let doubts = |machine: &str, clock: &str| system(machine, &[clock]).doubts();
    assert_eq!(doubts("orin-nx", "clock=918 MHz"), Vec::<String>::new());
    let slow = doubts("orin-nx", "clock=459 MHz").join("\n");
    for part in ["`orin-nx-module`", "918 MHz", "459 MHz", "`supply.curve`"] {
        assert!(slow.contains(part), "{part}: {slow}");
    }
    // A table with a curve prices other clocks.
    assert_eq!(doubts("gscore", "clock=500 MHz"), Vec::<String>::new());
}

#[test]
fn a_module_took_as_much_between_frames_as_in_them() {
    let table = |leakage: &str| {
        EnergyTable::parse(&format!(
            "base = \"orin-nx-module\"\nname = \"mine\"\n\
             [idle]\nleakage = {leakage}\nbackground = 0.5\nsource = \"A140\"\n"
        ))
    };
    let machine = Machine::parse(find(MACHINES, "orin-nx").expect("a machine")).expect("it");
    let kept = |table: &EnergyTable| cost::prices(table, &machine).expect("prices").kept;
    let idle = table("0.25").expect("a table");
    assert_eq!(kept(&idle), IdleShares { leakage: 0.25, background: 0.5 });
    assert_eq!(kept(system("orin-nx", &[]).energy_table()), IdleShares::ALL);
    let error = table("1.5").expect_err("more than there is").to_string();
    assert!(error.contains("`idle.leakage` must be at most 1"), "{error}");
}
