//! Every price of every table moves an output: the energy of a frame in which everything happens,
//! the area, or the PHY.

use powergs_base::config::embedded::{ENERGY, find};
use powergs_core::machine::DramModel;
use powergs_core::machine::Machine;
use powergs_core::run::system::doubts;
use powergs_core::sim::cost;
use powergs_core::stage::EnergyTable;
use powergs_core::stage::hardware;
use powergs_dram::{DramCommands, StageCommands};
use powergs_energy::Activity;
use powergs_energy::action::{ActionCounts, Phase};
use toml::Value;

use super::unlike;

/// Energy of a frame with some of everything, pJ, area, mm², with the PHY, and what is said: where
/// commands of the memory are counted, where its bytes are, and where it is a mere rate.
fn outputs(text: &str) -> Vec<(f64, f64, Vec<String>)> {
    let table = EnergyTable::parse(text).unwrap_or_else(|e| panic!("{e}"));
    let mut actions = ActionCounts::default();
    for (action, _) in hardware().actions() {
        actions.charge(Phase::Rendering, action, 1_000_000);
    }
    let stage = StageCommands { reads: 1000, writes: 1000, activates: 1000 };
    let dram = Some(DramCommands { stages: [stage; 3], refreshes: 10, ..DramCommands::default() });
    let activity = Activity {
        actions: &actions,
        seconds: 1e-3,
        idle: &vec![0.5; hardware().units().count()],
        dram,
    };
    let of = |machine: Machine| {
        let device = machine.device.clone();
        let memories = [
            (DramModel::Banked, device.clone()),
            (DramModel::Bandwidth, device),
            (DramModel::Bandwidth, None),
        ];
        let mut machine = machine;
        memories.map(|(model, device)| {
            (machine.dram.model, machine.device) = (model, device);
            let prices = cost::prices(&table, &machine).unwrap();
            let area = prices.area.as_ref().map_or(0.0, |a| a.total().0);
            (prices.breakdown(&activity).total().0, area, doubts(&machine, &table))
        })
    };
    unlike(&table, &[]).into_iter().flat_map(of).collect()
}

/// Every number in a table with its path, half as large again; shares, which have a limit, half.
fn larger(value: &Value, path: &str, all: &mut Vec<(String, Value)>) {
    match value {
        Value::Table(table) => {
            for (key, inner) in table {
                larger(inner, &format!("{path}.{key}"), all);
            }
        }
        Value::String(text) => {
            let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(0);
            if let Ok(number) = text[..end].parse::<f64>() {
                // A threshold stays below the lowest voltage.
                let factor = if path.ends_with(".threshold") { 1.2 } else { 1.5 };
                all.push((path.to_owned(), format!("{}{}", number * factor, &text[end..]).into()));
            }
        }
        Value::Integer(n) => all.push((path.to_owned(), (n * 2).into())),
        Value::Float(x) => {
            let is_share = path.starts_with(".parts.") || path == ".dram.row-hits.share";
            all.push((path.to_owned(), (x * if is_share { 0.5 } else { 1.5 }).into()));
        }
        Value::Boolean(_) | Value::Datetime(_) | Value::Array(_) => {}
    }
}

fn with(root: &Value, path: &str, new: &Value) -> String {
    let mut root = root.clone();
    let keys = path.trim_start_matches('.').split('.');
    let place = keys.fold(&mut root, |at, key| &mut at[key]);
    *place = new.clone();
    toml::to_string(&root).unwrap()
}

#[test]
fn every_price_moves_an_output() {
    for file in ENERGY {
        let root: Value = toml::from_str(&file.complete()).unwrap();
        let before = outputs(file.text);
        let mut all = Vec::new();
        larger(&root, "", &mut all);
        let mut tried = 0;
        for (path, new) in all {
            let zero = new.as_str().is_some_and(|text| text.starts_with("0 "));
            let free = file.name == "paper" && zero;
            // Rows of another node and temperature are refused, and the name of a node is a name.
            // A higher nominal voltage is outside of the curve; its upper end limits clocks alone.
            let node = [
                ".node",
                ".scaling.from",
                ".sram.cacti.node",
                ".sram.cacti.temperature",
                ".supply.curve.highest",
                ".supply.curve.node",
                ".supply.voltage",
            ];
            if free || path == ".description" || node.contains(&path.as_str()) {
                continue;
            }
            let after = outputs(&with(&root, &path, &new));
            assert_ne!(before, after, "{}: {path} = {new} moves nothing", file.name);
            tried += 1;
        }
        assert!(tried >= 11, "{}: {tried}", file.name);
    }
}

#[test]
fn cell_temperature_and_node_move_an_output() {
    let text = find(ENERGY, "gscore-28nm").unwrap();
    let before = outputs(text);
    for (from, to) in [
        ("cell = \"lop\"", "cell = \"hp\""),
        ("temperature = 350", "temperature = 300"),
        ("voltage = \"0.9 V\"", "voltage = \"0.85 V\""),
    ] {
        assert!(text.contains(from));
        assert_ne!(before, outputs(&text.replacen(from, to, 1)), "{to}");
    }
    let scaled = find(ENERGY, "gscore-7nm").unwrap();
    let fit = scaled.replacen("fit = \"deepscaletool\"", "fit = \"stillmaker\"", 1);
    assert_ne!(outputs(scaled), outputs(&fit));
}
