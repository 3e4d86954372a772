//! Makes the committed netlists, and what their energy is checked with.
//!
//! ```text
//! netlist price FOLDER/UNIT.json LIBERTY... OUT.gates
//! netlist activity FOLDER/UNIT.json LIBERTY... OUT.txt
//! ```
//!
//! `price` takes what `rtl/synth/synthesise.py` wrote (with `report.json` beside it) and the
//! library, and writes a netlist with its prices. `activity` runs the same circuit with random
//! inputs for 2,000 cycles in 64 lanes, writes for each driving pin its cell (`-` for ports), name,
//! toggles a cycle and share of time at 1, and prints what our prices make of them, a JSON object;
//! in it also what the circuit draws when all its inputs stay at 0 after reset.

use std::error::Error;
use std::path::Path;
use std::{env, fs};

use powergs_gates::energy;
use powergs_gates::liberty::{library::Library, unpack};
use powergs_gates::netlist::Netlist;
use powergs_gates::price::{Conditions, Priced, price};
use powergs_gates::simulator::Simulator;
use powergs_gates::yosys::Mapped;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Cycles that are counted, in 64 lanes.
const CYCLES: u32 = 2000;

fn main() -> Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let (Some(what), Some(json)) = (arguments.first(), arguments.get(1)) else {
        return Err("price|activity UNIT.json LIBERTY... OUT".into());
    };
    let Some((out, liberty)) = arguments[2..].split_last() else {
        return Err("give the Liberty files and the file to write".into());
    };
    let (mapped, priced) = read(Path::new(json), liberty)?;
    match what.as_str() {
        "price" => write(&priced.netlist, out),
        "activity" => activity(&mapped, &priced, out),
        _ => Err(format!("unknown command {what}; price or activity").into()),
    }
}

fn read(json: &Path, liberty: &[String]) -> Result<(Mapped, Priced)> {
    let text = fs::read_to_string(json)?;
    let mapped = Mapped::parse(&json.display().to_string(), &text)?;
    let report = json.with_file_name("report.json");
    let conditions =
        Conditions::parse(&report.display().to_string(), &fs::read_to_string(&report)?)?;
    let mut texts = Vec::new();
    for file in liberty {
        texts.push((file.as_str(), unpack(file, &fs::read(file)?)?));
    }
    let texts: Vec<(&str, &str)> = texts.iter().map(|(f, text)| (*f, text.as_str())).collect();
    let priced = price(&mapped, &Library::parse(&texts)?, &conditions)?;
    Ok((mapped, priced))
}

fn write(netlist: &Netlist, out: &str) -> Result<()> {
    let bytes = netlist.to_bytes();
    assert!(*netlist == Netlist::from_bytes(out, &bytes)?, "a file that reads differently");
    fs::write(out, &bytes)?;
    let cells = netlist.parts().cells.len();
    println!("{out}: {cells} cells, {:.1} um2, {} bytes", netlist.area(), bytes.len());
    Ok(())
}

fn activity(mapped: &Mapped, priced: &Priced, out: &str) -> Result<()> {
    let netlist = &priced.netlist;
    let mut simulator = Simulator::new(netlist);
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let clock = netlist.parts().clock;
    let inputs: Vec<(bool, u32)> = (netlist.parts().ports.iter())
        .filter(|port| port.input)
        .flat_map(|port| port.nets.iter().map(|net| (port.name == "rst_n", *net)))
        .filter(|(_, net)| *net != clock)
        .collect();
    let mut ones = vec![0u64; netlist.nets()];
    for cycle in 0..CYCLES + 4 {
        for &(reset, net) in &inputs {
            let value = if reset && cycle < 4 { 0 } else { random.next_u64() };
            simulator.set(net, if reset && cycle >= 4 { !0 } else { value });
        }
        simulator.settle();
        if cycle == 3 {
            simulator.count_anew();
        }
        if cycle >= 4 {
            for (net, ones) in (0..).zip(&mut ones) {
                *ones += u64::from(simulator.get(net).count_ones());
            }
        }
        simulator.clock();
    }
    let toggles = simulator.toggles();
    let cycles = toggles.lane_cycles as f64;
    let of = |net: u32| {
        let net = net as usize;
        let density = (toggles.rises[net] + toggles.falls[net]) as f64 / cycles;
        (density, ones[net] as f64 / cycles)
    };
    let mut lines = Vec::new();
    for port in netlist.parts().ports.iter().filter(|port| port.input) {
        for (bit, net) in port.nets.iter().enumerate().filter(|(_, net)| **net != clock) {
            let single = port.nets.len() == 1;
            let name = if single { port.name.clone() } else { format!("{}_{bit}", port.name) };
            let (density, duty) = of(*net);
            lines.push(format!("- {name} {density:.6} {duty:.6}"));
        }
    }
    for (cell, &place) in priced.instances.iter().enumerate() {
        let instance = &mapped.cells[place];
        let (_, outputs) = netlist.pins(cell);
        for (pin, name) in outputs.iter().zip(&priced.outputs[&instance.kind]) {
            if instance.pins.iter().any(|(pin, _)| pin == name) {
                let (density, duty) = of(pin.net);
                lines.push(format!("{} {name} {density:.6} {duty:.6}", instance.name));
            }
        }
    }
    fs::write(out, lines.join("\n") + "\n")?;
    println!("{}", parts(priced, &energy::of(netlist, &toggles), cycles));
    Ok(())
}

/// What 100 cycles of all lanes cost after reset, with all inputs at 0.
fn idle(netlist: &Netlist) -> energy::Energy {
    let mut simulator = Simulator::new(netlist);
    for cycle in 0..108 {
        if cycle == 4 {
            let reset = netlist.port("rst_n").map_or(&[][..], |port| &port.nets);
            reset.iter().for_each(|net| simulator.set(*net, !0));
        }
        if cycle == 8 {
            simulator.count_anew();
        }
        simulator.settle();
        simulator.clock();
    }
    energy::of(netlist, &simulator.toggles())
}

/// Power at the period, W, by parts; what only one of the two tools counts is apart.
fn parts(priced: &Priced, energy: &energy::Energy, cycles: f64) -> Value {
    let netlist = &priced.netlist;
    let watts = |fj: f64| fj / cycles / netlist.parts().about.period_ns * 1e-6;
    let idle = idle(netlist);
    let idle_watts = |fj: f64| watts(fj) * cycles / 6400.0;
    json!({
        "unit": netlist.parts().about.unit,
        "cells": netlist.parts().cells.len(),
        "clock_gates": netlist.clock_gates(),
        "switching_w": watts(energy.nets + energy.gated_nets),
        "internal_w": watts(energy.internal()),
        "of_it_gates_w": watts(energy.gates),
        "of_it_flip_flops_w": watts(energy.flip_flops),
        "of_it_clock_pins_w": watts(energy.clock_pins),
        "of_it_clock_gates_w": watts(energy.clock_gates),
        "leakage_w": netlist.leakage() * 1e-9,
        "clock_net_w": watts(energy.clock_net),
        "input_nets_w": watts(energy.inputs),
        "total_w": watts(energy.total()),
        "clock_w": watts(energy.clock()),
        "clock_ungated_w": watts(energy.clock_ungated),
        "idle_w": idle_watts(idle.total()),
        "idle_ungated_w": idle_watts(idle.total_ungated()),
    })
}
