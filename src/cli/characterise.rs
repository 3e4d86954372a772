//! `characterise`: prices of a unit's actions, from real lists that run through its gates.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::camera_file::{FrameRange, frame_range};
use super::output_file::{Overwrite, say};
use super::{Context, Exit, Failure, inputs, out};
use powergs_core::run::store::atomic::write_atomically;
use powergs_core::run::{Frames, Window};
use powergs_core::workload::order::DepthKey;
use powergs_core::workload::{FrameWorkload, Geometry};
use powergs_gates::characterise::{Characterised, Price, bsu, qsu};
use powergs_gates::committed;
use powergs_gates::netlist::Netlist;

/// Shown under `characterise --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim characterise bsu --library 45nm --trace traces/demo.bin
  powergs-sim characterise qsu --library 7nm --trace scene.bin -o qsu-7nm.toml

docs/rtl.md says where the gates and their energies come from.";

/// Arguments of `characterise`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The unit: quick sorting unit or bitonic sorting unit
    #[arg(value_enum)]
    pub unit: Unit,
    /// The library that it is mapped to
    #[arg(long, value_enum, value_name = "LIB")]
    pub library: Library,
    /// Trace whose lists are sorted
    #[arg(long, value_name = "FILE")]
    pub trace: PathBuf,
    /// Frames of the trace [default: the first]
    #[arg(long, value_name = "RANGE", value_parser = frame_range)]
    pub frames: Option<FrameRange>,
    /// File to write, TOML [default: standard output]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// What may be replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
}

/// Units that a trace is enough for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Unit {
    /// Quick sorting unit: lists that are longer than a chunk
    Qsu,
    /// Bitonic sorting unit: chunks of 256
    Bsu,
}

/// Libraries of the committed netlists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Library {
    /// Nangate45, 1.1 V
    #[value(name = "45nm")]
    Nm45,
    /// ASAP7, 0.7 V
    #[value(name = "7nm")]
    Nm7,
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    if let Some(output) = &args.output {
        args.overwrite.check(output)?;
    }
    let (unit, library) = (
        if args.unit == Unit::Qsu { "qsu" } else { "bsu" },
        if args.library == Library::Nm45 { "45nm" } else { "7nm" },
    );
    let Some(lists) = lists(args, context)? else { return Ok(Exit::Interrupted) };
    let netlist = committed::netlist(unit, library).expect("every unit is there in every library");
    let found = match args.unit {
        Unit::Qsu => qsu::prices(&netlist, &lists),
        Unit::Bsu => bsu::prices(&netlist, &lists),
    };
    let found = found
        .map_err(|error| Failure::new(Exit::Usage, format!("{}: {error}", args.trace.display())))?;
    if context.global.json {
        out::json(&as_json(unit, &netlist, &found))?;
        return Ok(Exit::Done);
    }
    let text = as_toml(unit, &args.trace.display().to_string(), &netlist, &found);
    match &args.output {
        None => out::text(&text)?,
        Some(path) => {
            write_atomically(path, |writer| writer.write_all(text.as_bytes()))?;
            say(path, format_args!("held out {:+.2} %", 100.0 * found.held_out), context)?;
        }
    }
    Ok(Exit::Done)
}

/// What the unit is given, FP16 keys in the order of their arrival; `None`: interrupted.
fn lists(args: &Args, context: &Context) -> Result<Option<Vec<Vec<u16>>>, Failure> {
    let mut trace = inputs::trace(&args.trace, args.frames, context)?;
    let range = trace.range();
    let last = if args.frames.is_some() { range.end } else { range.end.min(range.start + 1) };
    let mut lists = Vec::new();
    for position in range.start..last {
        if context.is_cancelled() {
            return Ok(None);
        }
        // One frame: it is checked against the budget before it is binned.
        let window = Window::bin(&mut trace, Geometry::REFERENCE, position, 1)?;
        let workload = &window.frames[0].bins[&Geometry::REFERENCE].workload;
        for tile in &workload.tiles {
            let list = workload.list_of(tile);
            let chunk = workload.geometry.chunk as usize;
            match args.unit {
                Unit::Qsu if list.len() > chunk => lists.push(arriving(workload, list)),
                Unit::Qsu => {}
                // Pivots cut the list into stretches of the exact order.
                Unit::Bsu => lists.extend(list.chunks(chunk).map(|part| arriving(workload, part))),
            }
        }
    }
    Ok(Some(lists))
}

/// Keys of some ranks in storage order.
fn arriving(workload: &FrameWorkload, ranks: &[u32]) -> Vec<u16> {
    let mut ranks = ranks.to_vec();
    ranks.sort_unstable_by_key(|rank| workload.index[*rank as usize]);
    let key = |rank: &u32| DepthKey::Fp16.of(workload.depth[*rank as usize]) as u16;
    ranks.iter().map(key).collect()
}

/// A string as TOML writes it: names of files may have any characters.
fn toml_text(text: &str) -> String {
    toml::Value::from(text).to_string()
}

fn as_toml(unit: &str, trace: &str, netlist: &Netlist, found: &Characterised) -> String {
    let about = &netlist.parts().about;
    let mut lines = vec![
        "# Energy of what a unit does, from its gates on real lists (powergs-sim characterise)."
            .into(),
        "# No layout: wires are the library's wire-load model or nothing, the clock is ideal."
            .into(),
        format!("unit = {}", toml_text(unit)),
        format!("library = {}", toml_text(&about.library)),
        format!("corner = {}", toml_text(&about.corner)),
        format!("trace = {}", toml_text(trace)),
        format!("critical-path = \"{} ns\"", about.critical_path_ns),
        format!("area = \"{:.1} um2\"", netlist.area()),
        format!("leakage = \"{:.6} mW\"", found.leakage_mw),
        String::new(),
        "# A cycle has the clock in it, which is not gated; the others come on top of it.".into(),
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
        "# Prices times counts against the measured energy, on lists that were not fitted.".into(),
        "[check]".into(),
        format!("held-out = {:.6}", found.held_out),
        format!("energy-per-cycle = \"{:.5} pJ\"", found.held_out_pj_per_cycle),
        format!("windows = {}", found.windows),
        format!("left-in-a-window = {:.6}", found.spread),
        "# Actions that these lists do not tell from the others.".into(),
        format!("left-out = {:?}", found.left_out),
        String::new(),
    ]);
    lines.join("\n")
}

fn as_json(unit: &str, netlist: &Netlist, found: &Characterised) -> Value {
    let about = &netlist.parts().about;
    let price = |price: &Price| {
        let Price { action, pj, error_pj, count } = price;
        json!({
            "action": action, "energy_pj": pj, "standard_error_pj": error_pj, "count": count,
        })
    };
    json!({
        "unit": unit,
        "library": about.library,
        "corner": about.corner,
        "area_um2": netlist.area(),
        "critical_path_ns": about.critical_path_ns,
        "leakage_mw": found.leakage_mw,
        "actions": found.prices.iter().map(price).collect::<Vec<_>>(),
        "left_out": found.left_out,
        "held_out": found.held_out,
        "energy_per_cycle_pj": found.held_out_pj_per_cycle,
        "windows": found.windows,
        "left_in_a_window": found.spread,
    })
}
