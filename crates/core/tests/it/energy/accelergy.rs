//! Reference tables of Accelergy: what they become, and hostile ones.

use powergs_base::config::embedded::{MACHINES, find};
use powergs_base::quantity::Hertz;
use powergs_core::machine::Machine;
use powergs_core::sim::cost;
use powergs_core::stage::{DRAM_WRITE, buffer_id, sram_read, sram_write, work_id};
use powergs_energy::accelergy::{AccelergyError, TEXT_MAX, doubt, table};

use powergs_core::stage::EnergyTable;
use powergs_energy::DramCosts;

const COMPONENTS: [(&str, &[&str]); 12] = [
    ("ccu[0..3]", &["cull", "project", "obb_prepare", "obb_test", "sh_colour", "leak"]),
    ("qsu", &["pivot_key", "leak"]),
    ("bsu", &["compare_exchange", "leak"]),
    ("core[0..3].vru[0..15]", &["alpha", "blend", "pixel_finish", "queue_entry", "leak"]),
    ("gaussian_in", &["read", "write", "leak"]),
    ("tile_list", &["read", "write", "leak"]),
    ("sorting", &["read", "write", "leak"]),
    ("feature", &["read", "write", "leak"]),
    ("pixel_out", &["read", "write", "leak"]),
    ("pointers", &["read", "write", "leak"]),
    ("combining", &["read", "write", "leak"]),
    ("dram", &["read", "write", "leak", "refresh"]),
];

/// Energies 1, 2, 3, ... in the order above, as Accelergy writes them.
fn ert() -> String {
    let mut text = String::from("ERT:\n    version: '0.4'\n    tables:\n");
    let mut energy = 0;
    for (name, actions) in COMPONENTS {
        text += &format!("    -   name: system.chip.{name}\n        actions:\n");
        for action in actions {
            energy += 1;
            text += &format!(
                "        -   name: {action}\n            arguments:\n                \
                 global_cycle_seconds: 1.0e-9\n            energy: {energy}.0\n"
            );
        }
    }
    text
}

fn art() -> String {
    let mut text = String::from("ART:\n    version: 0.4\n    tables:\n");
    for (i, (name, _)) in COMPONENTS.iter().enumerate() {
        text += &format!("    -   name: system.chip.{name}\n        area: {}\n", (i + 1) * 1000);
    }
    text
}

fn read(ert: &str, art: Option<&str>) -> Result<EnergyTable, AccelergyError> {
    table("mine", ert, art, Hertz(2e9))
}

#[track_caller]
fn refused(text: &str, because: &str) {
    let error = read(text, None).expect_err(because).to_string();
    assert!(error.contains(because), "{error}");
}

#[test]
fn energies_become_prices_of_the_machine() {
    let machine = Machine::parse(find(MACHINES, "gscore").unwrap()).unwrap();
    let table = read(&ert(), Some(&art())).unwrap();
    let prices = cost::prices(&table, &machine).unwrap();
    let pj = |action| prices.of(action).0;
    assert_eq!(
        [work_id("cull"), work_id("sh-colour"), work_id("pivot-key")].map(pj),
        [1.0, 5.0, 7.0]
    );
    assert_eq!(
        [work_id("compare-exchange"), work_id("alpha"), work_id("pixel-finish")].map(pj),
        [9.0, 11.0, 13.0]
    );
    // Prices per word become prices per byte of that word.
    let words = machine.inventory().memories.iter().map(|m| m.word.0 as f64).collect::<Vec<_>>();
    assert_eq!(pj(sram_read(buffer_id("gaussian_in"))), 16.0 / words[0]);
    assert_eq!(pj(sram_write(buffer_id("feature"))), 26.0 / words[3]);
    assert_eq!(pj(DRAM_WRITE), 38.0);
    // 6 pJ a cycle at 2 GHz are 12 mW; four CCUs.
    assert!((prices.unit_leakage_w[0] - 4.0 * 12e-3).abs() < 1e-15);
    let DramCosts::Bytes { background_w, refresh_w, .. } = prices.dram else { panic!("flat") };
    assert!((background_w - 78e-3).abs() < 1e-15 && (refresh_w - 80e-3).abs() < 1e-15);
    // 1000 um2 x 4 CCUs, and banks of 8000 um2.
    let banks = f64::from(machine.inventory().memories[3].banks);
    let area = prices.area.unwrap();
    assert!((area.units[0].0 - 4e-3).abs() < 1e-15);
    assert!((area.buffers[buffer_id("feature").index()].0 - banks * 8e-3).abs() < 1e-15);
    assert_eq!(area.rest.0, 0.0);
    let without = cost::prices(&read(&ert(), None).unwrap(), &machine).unwrap();
    assert_eq!(without.area, None);
    // What is recorded of the run can be read again, except for the unknown node.
    let text = toml::to_string(&table).unwrap();
    assert_eq!(toml::from_str::<EnergyTable>(&text).unwrap(), table);
}

#[test]
fn an_argument_says_for_how_many_bytes_an_energy_is() {
    let arguments = "global_cycle_seconds: 1.0e-9\n            energy: 37.0";
    assert!(ert().contains(arguments));
    let text = ert().replace(arguments, "bytes: 64\n            energy: 37.0");
    let DramCosts::Bytes { read_pj, .. } = cost::prices(
        &read(&text, None).unwrap(),
        &Machine::parse(find(MACHINES, "gscore").unwrap()).unwrap(),
    )
    .unwrap()
    .dram
    else {
        panic!("flat")
    };
    assert_eq!(read_pj, 37.0 / 64.0);
    refused(&text.replace("bytes: 64", "bytes: 0"), "energy per byte");
}

#[test]
fn a_machine_with_a_cache_needs_its_price() {
    let sets = ["cache.capacity=32 KiB".to_owned()];
    let machine = Machine::parse_with(find(MACHINES, "gscore").unwrap(), &sets).unwrap();
    let error = cost::prices(&read(&ert(), None).unwrap(), &machine).unwrap_err().to_string();
    assert!(error.contains("`cache`") && error.contains("sram.macros"), "{error}");
}

#[test]
fn a_word_of_dram_in_place_of_a_byte_is_doubted() {
    let with = |energy: &str, arguments: &str| {
        let text = ert();
        let (head, dram) = text.split_once("chip.dram").expect("a component");
        let dram = dram.replacen("energy: 37.0", &format!("energy: {energy}"), 1);
        let dram = dram.replacen("arguments:", &format!("arguments:{arguments}"), 1);
        doubt(&read(&format!("{head}chip.dram{dram}"), None).expect("a table"))
    };
    let said = with("512.0", "").expect("a doubt");
    assert!(said.contains("512 pJ") && said.contains("bytes: 8"), "{said}");
    assert_eq!(with("512.0", "\n                bytes: 8"), None);
    assert_eq!(with("64.0", ""), None);
}

#[test]
fn what_is_missing_or_wrong_is_named() {
    let twice = "        -   name: pivot_key\n            energy: 9.0\n";
    let qsu = "chip.qsu\n        actions:\n";
    refused(&ert().replace(qsu, &format!("{qsu}{twice}")), "the action `pivot_key` 2 times");
    let without = read(&ert().replace("chip.qsu", "chip.sorter"), None).unwrap();
    let machine = Machine::parse(find(MACHINES, "gscore").unwrap()).unwrap();
    let error = cost::prices(&without, &machine).unwrap_err().to_string();
    assert!(error.contains("no price of `leakage.qsu`, which the quick sorting units"), "{error}");
    refused(&ert().replace("chip.dram", "chip.b"), "no `dram`");
    refused(&ert().replace("sh_colour", "sh"), "system.chip.ccu[0..3] has no action `sh_colour`");
    refused(&ert().replace("chip.bsu", "chip.qsu"), "two components `qsu`");
    refused(&ert().replace("'0.4'", "0.2"), "`ERT.version` is 0.2");
    refused(&ert().replace("energy: 3.0", "energy: -3.0"), "energy of `obb_prepare` = -3");
    refused(&ert().replace("energy: 3.0", "energy: .nan"), "must be zero or more");
    refused(&ert().replace("energy: 3.0", "energy: .inf"), "must be zero or more");
    refused(&ert().replace("energy: 3.0", "energy: much"), "not a reference table");
    refused(&ert().replace("ERT:", "ETR:"), "not a reference table");
    let art = art().replace("chip.vru", "chip.x").replace("vru[0..15]", "x");
    let error = read(&ert(), Some(&art)).unwrap_err().to_string();
    assert!(error.contains("`ART.tables` has no `vru`"), "{error}");
}

#[test]
fn hostile_texts_are_refused() {
    for text in
        ["", "ERT:", "ERT: 1", "ERT: {version: 0.4}", "\u{0}", "- - - -", "ERT: &a [*a]", "{{{{"]
    {
        assert!(read(text, None).is_err(), "{text:?}");
    }
    let whole = ert();
    for end in (0..whole.len()).step_by(whole.len() / 61) {
        // A cut inside of the last numbers only may still be a table.
        assert!(read(&whole[..end], None).is_err(), "cut at {end}");
    }
    assert_eq!(read(&" ".repeat(TEXT_MAX + 1), None), Err(AccelergyError::TooLong));
    // A billion laughs: ten levels of ten.
    let mut laughs = String::from("l0: &l0 [ha, ha, ha, ha, ha, ha, ha, ha, ha, ha]\n");
    for i in 1..10 {
        let inner = vec![format!("*l{}", i - 1); 10].join(", ");
        laughs += &format!("l{i}: &l{i} [{inner}]\n");
    }
    assert!(read(&format!("{laughs}ERT: *l9\n"), None).is_err());
    assert!(read(&format!("ERT: {}", "[".repeat(100_000)), None).is_err(), "deep");
    assert!(
        read(&format!("ERT: {{version: 0.4, tables: {}}}", "[[".repeat(50_000)), None).is_err()
    );
}
