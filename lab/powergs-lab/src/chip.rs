//! `chip`: the cores of `rtl/`, cycle by cycle, beside the cycle model, on the same lists.

pub mod assumptions;
mod bench;
mod design;
mod tiles;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use bench::{Bench, COUNTS, ChipRun, Stalls, Task, TileEnd};
use design::{CHIP, Design};
use powergs_base::picture::Picture;
use powergs_core::flow::tile_wise::{
    BinningImpl, FrameContext, FrameReplay,
    bsu::Bsu,
    qsu::{Qsu, SPILL},
    replay_with,
    vru::Vru,
};
use powergs_core::kernel::timeline::{Observer, Span, State};
use powergs_core::kernel::{Memo, Unit, UnitCycles};
use powergs_core::machine::Machine;
use powergs_core::stage::Stall;
use powergs_datapath::TILE;
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::{is_foveated, open_model};
use powergs_scene::{Camera, Gaussians};
use powergs_sim::cli::camera_file::CameraArgs;
use powergs_sim::cli::output_file::Overwrite;
use powergs_sim::cli::render::{check_output, targets, write_png};
use powergs_sim::cli::scene_file::warn;
use powergs_sim::cli::{Context, Exit, Failure, inputs, out};
use tiles::{Asked, ChipFrame, Pivots};

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
    /// One memory port for all, behind an arbiter: a request and an answer a cycle, which the cycle
    /// model knows nothing of
    #[arg(long)]
    one_port: bool,
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
    /// Write what the RTL drew: a .png file, or a folder for several views
    #[arg(long, value_name = "PATH")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Where compiled benches are kept [default: target/chip of the checkout]
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
    if inputs::is_trace(&args.scene) {
        let what = format!(
            "{}: is a trace, without the parameters of splats that the RTL blends: name the model \
             and its cameras (--cameras)",
            args.scene.display()
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    args.picture.iter().try_for_each(|path| check_output(path))?;
    let arch = args.arch.as_ref().map_or(CHIP.into(), |path| path.display().to_string());
    let system = inputs::system(&arch, &args.changes.sets, None)?;
    let model = open_model(&args.scene, args.detail)?;
    warn(&model, context);
    let views = args.cameras.cameras(Some(&args.scene), || SceneBounds::of(&model.gaussians))?;
    views.warn(context);
    let comparison = Comparison {
        machine: system.machine(),
        design: Design::of(system.machine(), args.front)?.with_one_port(args.one_port),
        tiles: args.tiles,
        offset: args.offset,
        pivots: args.pivots,
        stalls: args.stalls.map(|shares| Stalls { shares, seed: args.seed }),
        place: args.build.as_deref().unwrap_or(Path::new(BENCHES)),
    };
    let files = args.picture.as_ref().map(|path| targets(path, &views.cameras)).transpose()?;
    let files = files.unwrap_or_default();
    files.iter().try_for_each(|file| args.overwrite.check(file))?;
    if !files.is_empty() && files.len() < views.cameras.len() {
        let what = format!("--picture: one file, and {} views: name a folder", views.cameras.len());
        return Err(Failure::new(Exit::Usage, what));
    }
    let mut all = Vec::new();
    let mut exit = Exit::Done;
    for (i, camera) in views.cameras.iter().enumerate() {
        let Some(view) = comparison.view(&model.gaussians, camera, context)? else {
            return Ok(Exit::Interrupted);
        };
        if !view.wrong.is_empty() {
            exit = Exit::GoalMissed;
        }
        files.get(i).map_or(Ok(()), |file| write_png(file, &view.picture))?;
        if context.global.json {
            all.push(view.json());
        } else {
            out::text(&view.text())?;
        }
    }
    if context.global.json {
        out::json(&all)?;
    }
    Ok(exit)
}

/// Both sides, and what they are given.
struct Comparison<'a> {
    machine: &'a Machine,
    design: Design,
    tiles: Option<usize>,
    offset: usize,
    pivots: Pivots,
    /// Random stalls, which have no cycles to be compared.
    stalls: Option<Stalls>,
    /// Where compiled benches are kept.
    place: &'a Path,
}

impl Comparison<'_> {
    /// A view on both sides; `None` when interrupted.
    fn view(
        &self,
        scene: &Gaussians,
        camera: &Camera,
        context: &Context,
    ) -> Result<Option<ComparedView>, Failure> {
        let Comparison { machine, ref design, .. } = *self;
        if context.is_cancelled() {
            return Ok(None);
        }
        let refuse =
            |what: String| Err(Failure::new(Exit::Usage, format!("view {}: {what}", camera.name)));
        if let Err(what) = fits(camera, design.units > 0) {
            return refuse(what);
        }
        let frame = ChipFrame::new(
            scene,
            camera,
            &Asked {
                queue: design.queue,
                most: self.tiles,
                offset: self.offset,
                units: design.units,
            },
        );
        if frame.longest() > design.entries {
            let (longest, entries) = (frame.longest(), design.entries);
            let keys = "buffers.sorting.capacity, geometry.chunk";
            let block = if design.units > 0 { ", binning.block" } else { "" };
            return refuse(format!(
                "a list of {longest} entries, and room for {entries} ({keys}{block})"
            ));
        }
        let [.., memory] = frame.layout(design);
        if memory > MEMORY {
            return refuse(format!(
                "{memory} bytes of memory, and the RTL has addresses for {MEMORY}"
            ));
        }
        if let Err(over) = context.global.memory.check(memory) {
            return refuse(format!("the memory of the chip {over}"));
        }
        let Some(pivots) = frame.pivots(design.chunk, self.pivots) else {
            let what = "a list needs more than two splits (--pivots exact needs fewer)";
            return refuse(what.to_owned());
        };
        let workload = frame.workload(machine.tiles().geometry);
        let mut own = machine.clone();
        if design.units == 0 {
            // Lists are there: nobody writes them.
            own.tiles_mut().binning.implementation = BinningImpl::Free;
        }
        let mut ends = ModelEnds(vec![TileEnd::default(); workload.tiles.len()]);
        let ours =
            replay_with(&workload, &own, FrameContext::default(), &Memo::default(), &mut ends);
        let Some(bench) = Bench::build(design, self.place, context)? else { return Ok(None) };
        let task = Task {
            frame: &frame,
            pivots: &pivots,
            design,
            machine,
            stalls: self.stalls.unwrap_or_default(),
            expected: ours.timing.frame,
        };
        let Some(rtl) = bench.run(&task, context)? else { return Ok(None) };
        Ok(Some(ComparedView {
            name: camera.name.clone(),
            tiles: frame.tiles.len(),
            entries: frame.entries(),
            needed: frame.needed(),
            wrong: frame
                .wrong(&rtl.pixels)
                .into_iter()
                .map(|tile| frame.tiles[tile].place)
                .collect(),
            rows: match self.stalls {
                Some(_) => Vec::new(),
                None => rows(&ours, &rtl, machine),
            },
            picture: frame.picture(&rtl.pixels),
            parts: match self.stalls {
                Some(_) => None,
                None => parts(&frame, &ends.0, &rtl.ends),
            },
        }))
    }
}

/// Where compiled benches are kept.
const BENCHES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/chip");
/// Bytes that the RTL has addresses for.
const MEMORY: u64 = u32::MAX as u64;
/// Most columns and rows of tiles.
const SIDE: u32 = 511;
/// Tiles that a front has pointers for.
const POINTERS: u32 = 4096;

/// Whether the RTL can count the tiles of a view; why not.
fn fits(camera: &Camera, front: bool) -> Result<(), String> {
    let grid = [camera.width, camera.height].map(|length| length.div_ceil(TILE));
    let most = if front { POINTERS } else { SIDE * SIDE };
    if grid.iter().any(|side| *side > SIDE) || grid[0] * grid[1] > most {
        let [columns, rows] = grid;
        return Err(format!(
            "{columns} x {rows} tiles, and the RTL counts {SIDE} a side, {most} in all (--size)"
        ));
    }
    Ok(())
}

/// A view on both sides.
#[derive(Debug)]
struct ComparedView {
    name: String,
    tiles: usize,
    entries: usize,
    needed: usize,
    /// Column and row of the tiles whose pixels differ.
    wrong: Vec<[u32; 2]>,
    /// Nothing where requests and answers stall at random.
    rows: Vec<Row>,
    picture: Picture,
    /// The first tile at which both sides part.
    parts: Option<Parting>,
}

/// A tile that takes longer on one side than on the other by more than [`ALIKE`], or that another
/// core has.
#[derive(Debug)]
struct Parting {
    place: [u32; 2],
    /// Cores of the model and of the RTL.
    cores: [u32; 2],
    /// Cycles from the end of the tile before, on the same core.
    cycles: [u64; 2],
}

/// Cycles, and one in so many cycles of a tile, within which both sides are said to be together.
const ALIKE: [u64; 2] = [64, 50];

/// When tiles of the cycle model leave the rendering units.
struct ModelEnds(Vec<TileEnd>);

impl Observer for ModelEnds {
    fn span(&mut self, span: Span) {
        if let (State::Busy(tile), true) = (span.state, span.unit == Vru::STAGE) {
            self.0[tile as usize] = TileEnd { core: span.instance, cycle: span.to };
        }
    }
}

/// Where both sides part, in the order in which tiles are dealt.
fn parts(frame: &ChipFrame, model: &[TileEnd], rtl: &[TileEnd]) -> Option<Parting> {
    // When the tile before was done, by core, on either side.
    let mut before: [BTreeMap<u32, u64>; 2] = Default::default();
    for (tile, ours) in frame.tiles.iter().zip(model) {
        let theirs = rtl[(tile.place[1] * frame.grid[0] + tile.place[0]) as usize];
        let mut cycles = [0; 2];
        let mut is_first = false;
        for ((end, before), cycles) in [ours, &theirs].into_iter().zip(&mut before).zip(&mut cycles)
        {
            let last = before.insert(end.core, end.cycle);
            // The first tile of a core begins with its list.
            is_first |= last.is_none();
            *cycles = end.cycle.saturating_sub(last.unwrap_or_default());
        }
        let near = cycles[0].abs_diff(cycles[1]) <= ALIKE[0].max(cycles[0] / ALIKE[1]);
        let is_done = ours.cycle > 0 && theirs.cycle > 0;
        let alike = ours.core == theirs.core && (near || is_first);
        if is_done && !alike {
            let cores = [ours.core, theirs.core];
            return Some(Parting { place: tile.place, cores, cycles });
        }
    }
    None
}

/// A number of both sides.
#[derive(Debug)]
struct Row {
    name: &'static str,
    model: u64,
    rtl: u64,
}

impl Row {
    /// By how much the RTL's is more, in percent of the model's.
    fn percent(&self) -> Option<f64> {
        (self.model > 0).then(|| (self.rtl as f64 / self.model as f64 - 1.0) * 100.0)
    }
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
        of(qsu, gsu.qsu_per_core, &|unit| stalled(list)(unit) + stalled(SPILL)(unit)),
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
    // What is written while lists are sorted is what is read back.
    let spilled = sorting.write;
    for (name, model, i) in [
        ("bytes of lists", sorting.read - spilled, 0),
        ("bytes of features", rendering.read, 1),
        ("bytes of pixels", rendering.write, 2),
        ("bytes spilled", spilled, 7),
        ("bytes read back", spilled, 8),
    ] {
        rows.push(Row { name, model, rtl: rtl.bytes[i] });
    }
    rows
}

impl ComparedView {
    fn text(&self) -> String {
        let ComparedView { name, tiles, entries, needed, wrong, rows, .. } = self;
        let mut text = format!("{name}: {tiles} tiles, {entries} entries, {needed} needed\n");
        text += &match wrong.first() {
            None => "pixels: those of the datapath, bit for bit\n".to_owned(),
            Some([x, y]) => {
                let count = wrong.len();
                format!("pixels: {count} TILES DIFFER, the first in column {x}, row {y}\n")
            }
        };
        if rows.is_empty() {
            text += "cycles are not compared: requests and answers stall at random\n\n";
            return text;
        }
        text += &format!("{:<20} {:>12} {:>12} {:>9}\n", "", "model", "RTL", "RTL is");
        for row in rows {
            let Row { name, model, rtl } = row;
            let share = row.percent().map_or(String::new(), |percent| format!("{percent:+.2} %"));
            text += &format!("{name:<20} {model:>12} {rtl:>12} {share:>9}\n");
        }
        if let Some(Parting { place: [x, y], cores, cycles }) = &self.parts {
            text += &match cores[0] == cores[1] {
                true => format!(
                    "first part at the tile in column {x}, row {y}: {} cycles, {} in RTL\n",
                    cycles[0], cycles[1]
                ),
                false => format!(
                    "first part at the tile in column {x}, row {y}: on core {}, on {} in RTL\n",
                    cores[0], cores[1]
                ),
            };
        }
        text + "\n"
    }

    fn json(&self) -> Value {
        let row = |row: &Row| (row.name.to_owned(), json!({ "model": row.model, "rtl": row.rtl }));
        let rows: Map<String, Value> = self.rows.iter().map(row).collect();
        json!({
            "view": self.name,
            "tiles": self.tiles,
            "entries": self.entries,
            "needed": self.needed,
            "wrong_tiles": self.wrong,
            "rows": rows,
            "first_part": self.parts.as_ref().map(|Parting { place, cores, cycles }| {
                json!({ "tile": place, "cores": cores, "cycles": cycles })
            }),
        })
    }
}
