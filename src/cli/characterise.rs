//! `characterise`: prices of a unit's actions, from real work that runs through its gates.

mod lists;
mod views;

use std::path::PathBuf;

use serde_json::{Value, json};

use super::output_file::{Overwrite, say};
use super::{Context, Exit, Failure, out};
use powergs_core::run::store::atomic::write_atomically;
use powergs_gates::characterise::{CharacteriseError, Characterised, Price, bsu, qsu};
use powergs_gates::committed;
use powergs_gates::netlist::Netlist;

/// Shown under `characterise --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim characterise bsu --library 45nm --trace traces/demo.bin
  powergs-sim characterise qsu --library 7nm --trace scene.bin -o qsu-7nm.toml
  powergs-sim characterise vrc --library 45nm --scene scene.ply \\
      --cameras cameras.json --frames 0..4
  powergs-sim characterise vrc --library 7nm --scene scene.ply --orbit 8

docs/rtl.md says where the gates and their energies come from.";

/// Arguments of `characterise`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    unit: Unit,
}

/// The units.
#[derive(Debug, clap::Subcommand)]
enum Unit {
    /// Quick sorting unit: lists of a trace that are longer than a chunk
    Qsu(lists::Args),
    /// Bitonic sorting unit: chunks of 256 of the lists of a trace
    Bsu(lists::Args),
    /// Volume-rendering core: splats of a scene in the tiles of some views
    Vrc(views::Core),
    /// Culling and conversion unit: Gaussians of a scene in a view
    Ccu(views::Front),
}

/// The library, and where the table goes.
#[derive(Debug, clap::Args)]
struct Target {
    /// The library that the unit is mapped to
    #[arg(long, value_enum, value_name = "LIB")]
    library: Library,
    /// File to write, TOML [default: standard output]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Libraries of the committed netlists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Library {
    /// Nangate45, 1.1 V
    #[value(name = "45nm")]
    Nm45,
    /// ASAP7, 0.7 V
    #[value(name = "7nm")]
    Nm7,
}

impl Target {
    /// The committed netlist of a unit.
    fn netlist(&self, unit: &str) -> Result<Netlist, Failure> {
        if let Some(output) = &self.output {
            self.overwrite.check(output)?;
        }
        let library = if self.library == Library::Nm45 { "45nm" } else { "7nm" };
        let missing = || Failure::new(Exit::Usage, format!("{unit}: no netlist for {library}"));
        committed::netlist(unit, library).ok_or_else(missing)
    }

    /// Prints or writes what was found in `source`.
    fn write(
        &self,
        (unit, source): (&str, &str),
        netlist: &Netlist,
        found: Result<Characterised, CharacteriseError>,
        context: &Context,
    ) -> Result<Exit, Failure> {
        let found = found.map_err(|e| Failure::new(Exit::Usage, format!("{source}: {e}")))?;
        if context.global.json {
            out::json(&as_json((unit, source), netlist, &found))?;
            return Ok(Exit::Done);
        }
        let text = as_toml(unit, source, netlist, &found);
        match &self.output {
            None => out::text(&text)?,
            Some(path) => {
                write_atomically(path, |writer| writer.write_all(text.as_bytes()))?;
                say(path, format_args!("held out {:+.2} %", 100.0 * found.held_out), context)?;
            }
        }
        Ok(Exit::Done)
    }
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    match &args.unit {
        Unit::Qsu(args) => args.run("qsu", lists::whole, qsu::prices, context),
        Unit::Bsu(args) => args.run("bsu", lists::chunks, bsu::prices, context),
        Unit::Vrc(args) => args.run(context),
        Unit::Ccu(args) => args.run(context),
    }
}

/// A string as TOML writes it: names of files may have any characters.
fn toml_text(text: &str) -> String {
    toml::Value::from(text).to_string()
}

fn as_toml(unit: &str, source: &str, netlist: &Netlist, found: &Characterised) -> String {
    let about = &netlist.parts().about;
    let mut lines = vec![
        "# Energy of what a unit does, from its gates on real work (powergs-sim characterise)."
            .into(),
        "# No layout: wires are the library's wire-load model or nothing, the clock is ideal."
            .into(),
        format!("unit = {}", toml_text(unit)),
        format!("library = {}", toml_text(&about.library)),
        format!("corner = {}", toml_text(&about.corner)),
        format!("work = {}", toml_text(source)),
        format!("critical-path = \"{} ns\"", about.critical_path_ns),
        format!("area = \"{:.1} um2\"", netlist.area()),
        format!("leakage = \"{:.6} mW\"", found.leakage_mw),
        String::new(),
        "# A cycle of a unit that does nothing; the others come on top of it.".into(),
        "[actions]".into(),
    ];
    for price in &found.prices {
        let Price { action, pj, error_pj, count } = price;
        lines.push(format!(
            "{action} = {{ energy = \"{pj:.5} pJ\", standard-error = \"{error_pj:.5} pJ\", \
             count = {count:.0} }}"
        ));
    }
    lines.extend([
        String::new(),
        "# Prices times counts against the measured energy, on work that was not fitted.".into(),
        "[check]".into(),
        format!("held-out = {:.6}", found.held_out),
        format!("energy-per-cycle = \"{:.5} pJ\"", found.held_out_pj_per_cycle),
        format!("clock-per-cycle = \"{:.5} pJ\"", found.clock_pj_per_cycle),
        "# The same, in any cycle, if all clock gates were open.".into(),
        format!("clock-ungated-per-cycle = \"{:.5} pJ\"", found.clock_ungated_pj_per_cycle),
        format!("windows = {}", found.windows),
        format!("left-in-a-window = {:.6}", found.spread),
        "# Actions that this work does not tell from the others.".into(),
        format!("left-out = {:?}", found.left_out),
        String::new(),
    ]);
    lines.join("\n")
}

fn as_json((unit, source): (&str, &str), netlist: &Netlist, found: &Characterised) -> Value {
    let about = &netlist.parts().about;
    let price = |price: &Price| {
        let Price { action, pj, error_pj, count } = price;
        json!({
            "action": action, "energy_pj": pj, "standard_error_pj": error_pj, "count": count,
        })
    };
    json!({
        "unit": unit,
        "work": source,
        "library": about.library,
        "corner": about.corner,
        "area_um2": netlist.area(),
        "critical_path_ns": about.critical_path_ns,
        "leakage_mw": found.leakage_mw,
        "actions": found.prices.iter().map(price).collect::<Vec<_>>(),
        "left_out": found.left_out,
        "held_out": found.held_out,
        "energy_per_cycle_pj": found.held_out_pj_per_cycle,
        "clock_per_cycle_pj": found.clock_pj_per_cycle,
        "clock_ungated_per_cycle_pj": found.clock_ungated_pj_per_cycle,
        "windows": found.windows,
        "left_in_a_window": found.spread,
    })
}
