//! `chip`: the cores of `rtl/`, cycle by cycle, beside the cycle model, on the same lists.

mod bench;
mod design;
mod tiles;

use std::path::PathBuf;

use serde_json::{Map, Value, json};

use bench::{Bench, COUNTS, ChipRun, Stalls};
use design::{CHIP, Design};
use powergs_core::flow::tile_wise::{
    BinningImpl, FrameReplay, bsu::Bsu, qsu::Qsu, replay, vru::Vru,
};
use powergs_core::kernel::{Unit, UnitCycles};
use powergs_core::machine::Machine;
use powergs_core::stage::Stall;
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::{is_foveated, open_model};
use powergs_sim::cli::camera_file::CameraArgs;
use powergs_sim::cli::scene_file::warn;
use powergs_sim::cli::{Context, Exit, Failure, inputs, out};
use tiles::{ChipFrame, Pivots};

/// Shown under `chip --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-lab chip scene.ply --orbit 1 --size 320x240
  powergs-lab chip scene.ply --cameras cams.json --frames 0..1 --tiles 60 \\
      --set vru.cores=1 --set dram.latency=200ns";

/// Arguments of `chip`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The model: PLY, compressed PLY, .splat, .spz, .glb, .sog, or a folder with one
    scene: PathBuf,
    /// Detail of a streamed scene (lod-meta.json), 0 is the finest
    #[arg(long, value_name = "N")]
    detail: Option<u32>,
    #[command(flatten)]
    cameras: CameraArgs,
    /// Machine file; what the RTL cannot be is refused [default: lab/powergs-lab/chip.toml]
    #[arg(long, value_name = "FILE")]
    arch: Option<PathBuf>,
    #[command(flatten)]
    changes: inputs::SetArgs,
    /// The whole chip: a front makes the lists from the scene
    #[arg(long, conflicts_with = "tiles")]
    front: bool,
    /// Only about N tiles of the view, spread over it
    #[arg(long, value_name = "N")]
    tiles: Option<usize>,
    /// Which of the tiles that are left out between two of them
    #[arg(long, value_name = "K", default_value_t = 0, requires = "tiles")]
    offset: usize,
    /// Where pivots come from
    #[arg(long, value_enum, default_value_t = Pivots::Exact)]
    pivots: Pivots,
    /// Random stalls, in eighths of cycles: of requests, of answers, and answers out of order.
    /// Only the pixels are compared then
    #[arg(long, value_name = "ASK,COME,ORDER", value_parser = shares)]
    stalls: Option<[u32; 3]>,
    /// Seed of the stalls
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,
    /// Where compiled benches are kept [default: powergs-chip in the folder of temporary files]
    #[arg(long, value_name = "DIR")]
    build: Option<PathBuf>,
}

fn shares(text: &str) -> Result<[u32; 3], String> {
    let numbers: Vec<u32> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match <[u32; 3]>::try_from(numbers) {
        Ok(shares) if shares.iter().all(|share| *share < 8) => Ok(shares),
        _ => Err("three numbers from 0 to 7, such as 2,2,4".into()),
    }
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    if is_foveated(&args.scene) {
        let what = format!("{}: the RTL blends one level", args.scene.display());
        return Err(Failure::new(Exit::Usage, what));
    }
    let arch = args.arch.as_ref().map_or(CHIP.into(), |path| path.display().to_string());
    let system = inputs::system(&arch, &args.changes.sets, None)?;
    let machine = system.machine();
    let design = Design::of(machine, args.front)?;
    // Lists are there: nobody writes them.
    let mut alone = machine.clone();
    if !args.front {
        alone.tiles_mut().binning.implementation = BinningImpl::Free;
    }
    let model = open_model(&args.scene, args.detail)?;
    warn(&model, context);
    let views = args.cameras.cameras(Some(&args.scene), || SceneBounds::of(&model.gaussians))?;
    views.warn(context);
    let place = args.build.clone().unwrap_or_else(|| std::env::temp_dir().join("powergs-chip"));
    let stalls = Stalls { shares: args.stalls.unwrap_or_default(), seed: args.seed };
    let mut all = Vec::new();
    let mut exit = Exit::Done;
    for camera in &views.cameras {
        if context.is_cancelled() {
            return Ok(Exit::Interrupted);
        }
        let frame = ChipFrame::new(&model.gaussians, camera, design.queue, (args.tiles, args.offset), args.front);
        if frame.longest() > design.entries {
            let what = format!(
                "view {}: a list of {} entries, and room for {} (buffers.sorting.capacity)",
                camera.name,
                frame.longest(),
                design.entries
            );
            return Err(Failure::new(Exit::Usage, what));
        }
        let Some(pivots) = frame.pivots(design.chunk, args.pivots) else {
            let what = format!(
                "view {}: a list needs more than two splits (--pivots exact needs fewer)",
                camera.name
            );
            return Err(Failure::new(Exit::Usage, what));
        };
        let bench = Bench::build(&design, &place)?;
        let rtl = bench.run(&frame, &pivots, &design, machine, stalls)?;
        let wrong = frame.wrong(&rtl.pixels);
        if !wrong.is_empty() {
            exit = Exit::GoalMissed;
        }
        let workload = frame.workload(machine.tiles().geometry);
        let ours = replay(&workload, &alone);
        let rows = rows(&ours, &rtl, machine);
        if context.global.json {
            all.push(told(&camera.name, &frame, &rows, &wrong));
        } else {
            shown(&camera.name, &frame, &rows, &wrong, args.stalls.is_some())?;
        }
    }
    if context.global.json {
        out::json(&all)?;
    }
    Ok(exit)
}

/// A number of both sides.
struct Row {
    name: &'static str,
    model: u64,
    rtl: u64,
}

fn rows(ours: &FrameReplay, rtl: &ChipRun, machine: &Machine) -> Vec<Row> {
    let unit = |stage| ours.timing.units.iter().find(|unit| unit.unit == stage);
    let of = |unit: Option<&UnitCycles>, per_core: u32, of: &dyn Fn(&UnitCycles) -> u64| {
        unit.map_or(0, |unit| of(unit) / u64::from(per_core.max(1)))
    };
    let (gsu, vru) = (&machine.tiles().gsu, &machine.tiles().vru);
    let stalled = |cause: Stall| move |unit: &UnitCycles| unit.stalls[cause.index()];
    let (qsu, bsu, units) = (unit(Qsu::STAGE), unit(Bsu::STAGE), unit(Vru::STAGE));
    let (list, features) = (Stall::of("list"), Stall::of("features"));
    let model = [
        of(qsu, gsu.qsu_per_core, &|unit| unit.busy),
        of(qsu, gsu.qsu_per_core, &stalled(Stall::BANK)),
        of(qsu, gsu.qsu_per_core, &stalled(list)),
        of(qsu, gsu.qsu_per_core, &stalled(Stall::OUTPUT)),
        of(bsu, gsu.bsu_per_core, &|unit| unit.busy),
        of(units, vru.units_per_core, &|unit| unit.busy),
        of(units, vru.units_per_core, &stalled(features)),
        of(units, vru.units_per_core, &stalled(Stall::INPUT)),
        of(units, vru.units_per_core, &stalled(Stall::OUTPUT)),
    ];
    let mut rows = vec![Row {
        name: "tile phase, cycles",
        model: ours.timing.frame - ours.timing.preprocessing_end,
        rtl: rtl.cycles - rtl.listed,
    }];
    if rtl.listed > 0 {
        rows.push(Row { name: "frame, cycles", model: ours.timing.frame, rtl: rtl.cycles });
        let model = ours.timing.preprocessing_end;
        rows.push(Row { name: "preprocessing", model, rtl: rtl.listed });
        let [read, written] = [rtl.bytes[3..6].iter().sum(), rtl.bytes[6]];
        let ours = &ours.served.stages[0];
        rows.push(Row { name: "bytes read before", model: ours.read, rtl: read });
        rows.push(Row { name: "bytes written before", model: ours.write, rtl: written });
    }
    let counts = COUNTS.iter().zip(model).zip(rtl.counts);
    rows.extend(counts.map(|((name, model), rtl)| Row { name, model, rtl }));
    let [sorting, rendering] = [1, 2].map(|phase| ours.served.stages[phase]);
    let bytes = [sorting.read, rendering.read, rendering.write];
    for ((name, model), rtl) in ["bytes of lists", "bytes of features", "bytes of pixels"]
        .into_iter()
        .zip(bytes)
        .zip(rtl.bytes)
    {
        rows.push(Row { name, model, rtl });
    }
    rows
}

fn shown(
    name: &str,
    frame: &ChipFrame,
    rows: &[Row],
    wrong: &[usize],
    is_stalled: bool,
) -> Result<(), Failure> {
    let (tiles, entries, needed) = (frame.tiles.len(), frame.entries(), frame.needed());
    let mut text = format!("{name}: {tiles} tiles, {entries} entries, {needed} needed\n");
    match wrong.len() {
        0 => text.push_str("pixels: those of the datapath, bit for bit\n"),
        n => {
            let first = &frame.tiles[wrong[0]];
            let ([x, y], entries) = (first.place, first.listed());
            text.push_str(&format!(
                "pixels: {n} TILES DIFFER, the first in column {x}, row {y}, of {entries} entries\n"
            ));
        }
    }
    if is_stalled {
        text.push_str("cycles are not compared: requests and answers stall at random\n\n");
        return out::text(&text);
    }
    text.push_str(&format!("{:<20} {:>12} {:>12} {:>9}\n", "", "model", "RTL", "RTL is"));
    for Row { name, model, rtl } in rows {
        let share = match *model {
            0 => String::new(),
            model => format!("{:+.2} %", (*rtl as f64 / model as f64 - 1.0) * 100.0),
        };
        text.push_str(&format!("{name:<20} {model:>12} {rtl:>12} {share:>9}\n"));
    }
    text.push('\n');
    out::text(&text)
}

fn told(name: &str, frame: &ChipFrame, rows: &[Row], wrong: &[usize]) -> Value {
    let row = |row: &Row| (row.name.to_owned(), json!({ "model": row.model, "rtl": row.rtl }));
    let rows: Map<String, Value> = rows.iter().map(row).collect();
    json!({
        "view": name,
        "tiles": frame.tiles.len(),
        "entries": frame.entries(),
        "needed": frame.needed(),
        "wrong_tiles": wrong,
        "rows": rows,
    })
}
