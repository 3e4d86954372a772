//! `characterise`: prices of a unit's actions, from real work that runs through its gates.

use std::path::PathBuf;

use serde_json::{Value, json};

use crate::unit_work::lists::{self, Lists};
use crate::unit_work::netlist::Gates;
use crate::unit_work::views::Scene;
use crate::{CorePixels, CoreWork, FrontEnd, TileWork};
use powergs_core::run::store::atomic::write_atomically;
use powergs_datapath::vectors::CcuWork;
use powergs_datapath::{NumberFormat, Vrc, Vru};
use powergs_gates::characterise::{
    CharacteriseError, Characterised, Price, bsu, ccu, qsu, vrc, vru,
};
use powergs_gates::netlist::Netlist;
use powergs_sim::cli::output_file::{Overwrite, say};
use powergs_sim::cli::{Context, Exit, Failure, out};
use rayon::prelude::*;

/// Shown under `characterise --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-lab characterise bsu --library 45nm --trace traces/demo.bin
  powergs-lab characterise qsu --library 7nm --trace scene.bin -o qsu-7nm.toml
  powergs-lab characterise vrc --library 45nm --scene scene.ply \\
      --cameras cameras.json --frames 0..4
  powergs-lab characterise vrc --library 7nm --scene scene.ply --orbit 8
  powergs-lab characterise ccu --library 7nm --scene scene.ply --orbit 8
  powergs-lab characterise bsu --netlist bsu.json --liberty my.lib \\
      --trace scene.bin

evidence/rtl.md says where the gates and their energies come from.";

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
    Qsu(Sorting),
    /// Bitonic sorting unit: chunks of 256 of the lists of a trace
    Bsu(Sorting),
    /// Volume-rendering core: splats of a scene in the tiles of some views
    Vrc(Core),
    /// Control of a rendering unit, without its cores: lists of tiles of some views
    Vru(Control),
    /// Culling and conversion unit: Gaussians of a scene in a view
    Ccu(Front),
}

/// Arguments of `characterise qsu` and `bsu`.
#[derive(Debug, clap::Args)]
struct Sorting {
    #[command(flatten)]
    lists: Lists,
    #[command(flatten)]
    target: Target,
}

/// Arguments of `characterise vrc`.
#[derive(Debug, clap::Args)]
struct Core {
    #[command(flatten)]
    scene: Scene,
    #[command(flatten)]
    target: Target,
    /// Slots that are simulated in all views together, a splat at a pixel each: sub-tiles are
    /// picked all over the images
    #[arg(long, value_name = "N", default_value_t = 2_000_000)]
    #[arg(value_parser = clap::value_parser!(u64).range(10_000..=1_000_000_000))]
    slots: u64,
    /// Numbers of the core: e5m10 (FP16), e5m6 or e4m3
    #[arg(long, value_name = "FORMAT", default_value = "e5m10")]
    format: NumberFormat,
}

/// Arguments of `characterise vru`.
#[derive(Debug, clap::Args)]
struct Control {
    #[command(flatten)]
    scene: Scene,
    #[command(flatten)]
    target: Target,
    /// Slots of the cores in all views together, a splat at a pixel each: tiles are picked all over
    /// the images
    #[arg(long, value_name = "N", default_value_t = 200_000_000)]
    #[arg(value_parser = clap::value_parser!(u64).range(100_000..=100_000_000_000))]
    slots: u64,
}

/// Arguments of `characterise ccu`.
#[derive(Debug, clap::Args)]
struct Front {
    #[command(flatten)]
    scene: Scene,
    #[command(flatten)]
    target: Target,
    /// Gaussians that are simulated in the first view, picked all over the scene
    #[arg(long, value_name = "N", default_value_t = 30_000)]
    #[arg(value_parser = clap::value_parser!(u64).range(1_000..=10_000_000))]
    gaussians: u64,
}

/// The gates, and where the table goes.
#[derive(Debug, clap::Args)]
struct Target {
    #[command(flatten)]
    gates: Gates,
    /// File to write, TOML [default: standard output]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

impl Target {
    /// The netlist of a unit.
    fn netlist(&self, unit: &str) -> Result<Netlist, Failure> {
        if let Some(output) = &self.output {
            self.overwrite.check(output)?;
        }
        self.gates.of(unit)
    }

    /// Prints or writes what was found in `source`.
    fn write(
        &self,
        (unit, source): (&str, &str),
        netlist: &Netlist,
        found: Result<Characterised, CharacteriseError>,
        context: &Context,
    ) -> Result<Exit, Failure> {
        let found = found.map_err(|error| match (error.is_of_netlist(), self.gates.file()) {
            (true, Some(file)) => {
                Failure::new(Exit::BadInput, format!("{}: {error}", file.display()))
            }
            _ => Failure::new(Exit::Usage, format!("{source}: {error}")),
        })?;
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
        Unit::Qsu(Sorting { lists, target }) => {
            let netlist = target.netlist("qsu")?;
            let Some(keys) = lists.keys(lists::whole, context)? else {
                return Ok(Exit::Interrupted);
            };
            let found = qsu::prices(&netlist, &keys);
            target.write(("qsu", &lists.source()), &netlist, found, context)
        }
        Unit::Bsu(Sorting { lists, target }) => {
            let netlist = target.netlist("bsu")?;
            let Some(keys) = lists.keys(lists::chunks, context)? else {
                return Ok(Exit::Interrupted);
            };
            let found = bsu::prices(&netlist, &keys);
            target.write(("bsu", &lists.source()), &netlist, found, context)
        }
        Unit::Vrc(args) => args.run(context),
        Unit::Vru(args) => args.run(context),
        Unit::Ccu(args) => args.run(context),
    }
}

impl Core {
    fn run(&self, context: &Context) -> Result<Exit, Failure> {
        let unit = match self.format {
            NumberFormat::FP16 => "vrc".to_owned(),
            format => format!("vrc-{format}"),
        };
        let netlist = self.target.netlist(&unit)?;
        let few = "--format: a core needs four bits of exponent";
        let core = Vrc::new(self.format).ok_or_else(|| Failure::new(Exit::Usage, few))?;
        let pixels = match netlist.port("open_mask").map_or(4, |port| port.nets.len()) {
            16 => CorePixels { columns: 4, rows: 4 },
            _ => CorePixels { columns: 2, rows: 2 },
        };
        let Some(work) = self.scene.cores((&core, pixels), self.slots, context)? else {
            return Ok(Exit::Interrupted);
        };
        let work: Vec<vrc::Work> = work.iter().map(core_told).collect();
        let found = vrc::prices(&netlist, &work);
        self.target.write((&unit, &self.scene.source()), &netlist, found, context)
    }
}

impl Control {
    fn run(&self, context: &Context) -> Result<Exit, Failure> {
        let netlist = self.target.netlist("vru")?;
        let core = Vrc::new(NumberFormat::FP16).expect("FP16 has enough exponent");
        let Some(work) = self.scene.tiles(&core, self.slots, context)? else {
            return Ok(Exit::Interrupted);
        };
        let unit = Vru { vrc: core, split: true, queue: 2 };
        let work: Vec<vru::Work> = work.par_iter().map(|tile| tile_told(&unit, tile)).collect();
        let found = vru::prices(&netlist, &work);
        self.target.write(("vru", &self.scene.source()), &netlist, found, context)
    }
}

impl Front {
    fn run(&self, context: &Context) -> Result<Exit, Failure> {
        let netlist = self.target.netlist("ccu")?;
        let told = |front: &FrontEnd, picked: &[usize]| {
            let settings = &front.settings;
            let view = ccu::View {
                numbers: settings.numbers.to_vec(),
                tiles: settings.tiles,
                degree: front.degree,
            };
            let gaussians: Vec<_> = picked.par_iter().map(|&i| gaussian_told(front, i)).collect();
            (view, gaussians)
        };
        let (view, gaussians) = self.scene.front_end(self.gaussians, told, context)?;
        let found = ccu::prices(&netlist, &view, &gaussians);
        self.target.write(("ccu", &self.scene.source()), &netlist, found, context)
    }
}

/// A Gaussian and what becomes of it, as the gates are told.
fn gaussian_told(front: &FrontEnd, i: usize) -> ccu::Gaussian {
    let (unit, settings) = (&front.unit, &front.settings);
    let CcuWork { gaussian, coefficients } = front.work(i);
    let is_kept = unit.cull(settings, &gaussian.mean).kept;
    let seen = unit.splat(settings, &gaussian).map(|(splat, walk)| {
        let [a, b, c] = splat.root;
        ccu::Seen {
            splat: [splat.depth, a, b, c, splat.opacity],
            candidates: walk.candidates() as u32,
            pairs: walk.pairs(unit.narrow()).len() as u32,
            colour: unit.colour(front.degree, &splat.direction, &coefficients),
            coefficients: coefficients.to_vec(),
        }
    });
    ccu::Gaussian { mean: gaussian.mean, shape: is_kept.then_some(gaussian.shape), seen }
}

/// The work of a core, as the gates are told.
fn core_told(work: &CoreWork) -> vrc::Work {
    let splat = |splat: &crate::CoreSplat| vrc::Splat {
        numbers: splat.record.numbers(),
        outcomes: splat.outcomes,
    };
    let pixel = |pixel: &powergs_datapath::Pixel| {
        let [red, green, blue] = pixel.colour;
        [red, green, blue, pixel.transmittance]
    };
    vrc::Work {
        place: work.place,
        mask: work.mask,
        splats: work.splats.iter().map(splat).collect(),
        pixels: work.pixels.iter().map(pixel).collect(),
    }
}

/// A tile, as the gates are told.
fn tile_told(unit: &Vru, tile: &TileWork) -> vru::Work {
    let entry = |entry: &powergs_datapath::Entry| (entry.splat.numbers(), entry.bitmap);
    vru::Work {
        size: tile.size.map(|side| side as u8),
        entries: tile.entries.iter().map(entry).collect(),
        ends: unit.tile(&tile.entries, tile.size).ends,
    }
}

/// A string as TOML writes it: names of files may have any characters.
fn toml_text(text: &str) -> String {
    toml::Value::from(text).to_string()
}

fn as_toml(unit: &str, source: &str, netlist: &Netlist, found: &Characterised) -> String {
    let about = &netlist.parts().about;
    let mut lines = vec![
        "# Energy of what a unit does, from its gates on real work (powergs-lab characterise)."
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
        "# What a report without vectors says: 0.1 toggles a cycle at every net, clocks half open."
            .into(),
        format!("vectorless-per-cycle = \"{:.5} pJ\"", found.vectorless_pj_per_cycle),
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
        "vectorless_per_cycle_pj": found.vectorless_pj_per_cycle,
        "windows": found.windows,
        "left_in_a_window": found.spread,
    })
}
