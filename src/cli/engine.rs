//! What `replay` runs on: a trace and a model of a machine, opened and checked.
//!
//! Frames are read in order, decoded, binned and simulated in parallel, and handed on in order; at
//! most one frame a thread is in memory.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::ops::{ControlFlow, Range};
use std::path::Path;

use xxhash_rust::xxh3::Xxh3;

use super::machine_file::{LoadedMachine, Text, load_machine, read};
use super::replay::{Args, EachFrame, Engine, ModelArg, doubled};
use super::{Exit, Failure, OrExit};
use crate::config::embedded::{DISPLAYS, ENERGY};
use crate::display::Display;
use crate::energy::EnergyTable;
use crate::report::tile_load::Picture;
use crate::report::{Facts, Input, Limit, MachineFacts, TileLoad, TraceFacts};
use crate::sim::paper::UnitPrices;
use crate::sim::{FrameReport, Label, frames, paper, simulate};
use crate::trace::{EncodedFrame, Reader};
use crate::workload::paper::Padding;
use crate::workload::{FrameWorkload, Geometry, bin};

/// The energy table of the `paper` model.
const PAPER_TABLE: &str = "paper";

/// How frames become reports.
enum Simulator {
    Cycle(Box<LoadedMachine>),
    Paper { prices: UnitPrices, padding: Padding, table: Text },
}

impl Simulator {
    fn new(args: &Args) -> Result<Simulator, Failure> {
        if args.model == ModelArg::Cycle {
            if args.reference_padding {
                let what = "--reference-padding belongs to --model paper";
                return Err(Failure::new(Exit::Usage, what));
            }
            return Ok(Simulator::Cycle(Box::new(load_machine(&args.arch, &args.sets)?)));
        }
        if !args.sets.is_empty() {
            let what = "--set: the paper model has no machine; use --model cycle";
            return Err(Failure::new(Exit::Usage, what));
        }
        let table = read("energy table", PAPER_TABLE, ENERGY, None)?;
        let parsed = EnergyTable::parse(&table.text).or_exit(Exit::Internal, &table.origin)?;
        let flat = parsed
            .flat_pj()
            .ok_or_else(|| Failure::new(Exit::Internal, "the table `paper` has no flat prices"))?;
        let [flop_pj, sram_pj_per_byte, dram_pj_per_byte] = flat;
        let prices = UnitPrices { flop_pj, sram_pj_per_byte, dram_pj_per_byte };
        let padding = if args.reference_padding { Padding::Reference } else { Padding::TrueTiles };
        Ok(Simulator::Paper { prices, padding, table })
    }

    fn geometry(&self) -> Geometry {
        match self {
            Simulator::Cycle(loaded) => loaded.machine.geometry,
            Simulator::Paper { .. } => Geometry::REFERENCE,
        }
    }

    fn report(&self, label: Label, workload: &FrameWorkload) -> Result<FrameReport, Failure> {
        match self {
            Simulator::Cycle(loaded) => {
                let name = label.name.clone();
                simulate(label, workload, &loaded.machine, &loaded.prices)
                    .or_exit(Exit::Internal, format_args!("internal error in frame {name}"))
            }
            Simulator::Paper { prices, padding, .. } => {
                Ok(paper::simulate(label, workload, *padding, prices))
            }
        }
    }

    fn facts(&self) -> MachineFacts {
        match self {
            Simulator::Cycle(loaded) => MachineFacts {
                name: loaded.machine.name.clone(),
                energy_table: loaded.energy_table.name.clone(),
                clock_hz: Some(loaded.machine.clock.0),
                dram_peak_gb_s: Some(loaded.machine.dram.bandwidth.0 * 1e-9),
            },
            Simulator::Paper { table, .. } => MachineFacts {
                name: "paper".into(),
                energy_table: table.origin.clone(),
                clock_hz: None,
                dram_peak_gb_s: None,
            },
        }
    }

    /// Configuration files that were read, with their roles and what they resolved to.
    fn files(&self) -> Vec<(&'static str, &Text, &str)> {
        match self {
            Simulator::Cycle(l) => vec![
                ("machine", &l.machine_file, l.resolved_toml.as_str()),
                ("energy", &l.energy_file, l.energy_file.text.as_str()),
            ],
            Simulator::Paper { table, .. } => vec![("energy", table, table.text.as_str())],
        }
    }
}

/// A trace and a simulator.
pub struct TraceEngine {
    reader: Reader<BufReader<File>>,
    path: String,
    frames: Range<u64>,
    simulator: Simulator,
    display: Display,
    facts: Facts,
}

impl TraceEngine {
    /// Opens and checks everything that `args` name.
    pub fn open(args: &Args) -> Result<TraceEngine, Failure> {
        let simulator = Simulator::new(args)?;
        let display_file = read("display preset", &args.display, DISPLAYS, None)?;
        let display =
            Display::parse(&display_file.text).or_exit(Exit::Usage, &display_file.origin)?;
        let path = args.trace.display().to_string();
        let mut file = BufReader::new(File::open(&args.trace).or_exit(Exit::BadInput, &path)?);
        let mut inputs = vec![hashed("trace", &file_name(&args.trace), &mut file, &path)?];
        file.rewind().or_exit(Exit::BadInput, &path)?;
        let mut reader = Reader::open(file).or_exit(Exit::BadInput, &path)?;
        let frames = selected(args, reader.len(), &path)?;
        let first = reader.info(frames.start).or_exit(Exit::BadInput, &path)?;
        let camera = &first.head.facts.camera;
        let trace = TraceFacts {
            name: args.trace.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            frames: (frames.end - frames.start) as usize,
            width: camera.width,
            height: camera.height,
        };
        let mut configuration = toml::Table::new();
        let mut files = simulator.files();
        files.push(("display", &display_file, &display_file.text));
        for (role, file, resolved) in files {
            inputs.push(hashed(role, &file.origin, &mut file.text.as_bytes(), &file.origin)?);
            let table = resolved.parse().or_exit(Exit::Internal, &file.origin)?;
            configuration.insert(role.to_owned(), toml::Value::Table(table));
        }
        let facts = Facts {
            model: args.model.into(),
            display_fps: args.fps,
            trace,
            machine: simulator.facts(),
            inputs,
            configuration,
        };
        Ok(TraceEngine { reader, path, frames, simulator, display, facts })
    }
}

/// The frames that `--frames` leaves.
fn selected(args: &Args, len: u64, path: &str) -> Result<Range<u64>, Failure> {
    if len == 0 {
        let what = format!("{path}: the trace has no frames; extract it again");
        return Err(Failure::new(Exit::BadInput, what));
    }
    let Some(range) = args.frames else { return Ok(0..len) };
    let start = range.start as u64;
    if start >= len {
        let what = format!("--frames {start}..: {path} has {len} frames, from 0");
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok(start..range.end.map_or(len, |end| (end as u64).min(len)))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Hashes everything that `input` gives.
fn hashed(
    role: &'static str,
    name: &str,
    input: &mut impl Read,
    place: &str,
) -> Result<Input, Failure> {
    let (mut hash, mut bytes) = (Xxh3::new(), 0u64);
    let mut buffer = vec![0u8; 1 << 18];
    loop {
        let n = input.read(&mut buffer).or_exit(Exit::BadInput, place)?;
        if n == 0 {
            break;
        }
        hash.update(&buffer[..n]);
        bytes += n as u64;
    }
    // Folders are not part of the record: the same file elsewhere gives the same report.
    let name = file_name(Path::new(name));
    Ok(Input { role, name, bytes, xxh3: hash.digest128() })
}

/// Why the frames ended early.
enum Stop {
    Asked,
    Failed(Failure),
}

/// A simulated frame and what its heatmap needs.
struct Done {
    report: FrameReport,
    tiles: TileLoad,
}

impl Engine for TraceEngine {
    fn facts(&self) -> Facts {
        self.facts.clone()
    }

    fn frames(&mut self, each: &mut EachFrame<'_>) -> Result<(), Failure> {
        let (simulator, display, path) = (&self.simulator, &self.display, &self.path);
        let reader = &mut self.reader;
        let blocks = self.frames.clone().map(|k| {
            let block = reader.read_block(k).or_exit(Exit::BadInput, path);
            block.map(|block| (k as usize, block)).map_err(Stop::Failed)
        });
        let work = |(frame, block): (usize, EncodedFrame)| {
            one_frame(simulator, display, path, frame, &block).map_err(Stop::Failed)
        };
        let outcome = frames::in_order(blocks, work, |done: Done| {
            let mut tiles = Some(done.tiles);
            let mut take = || tiles.take().expect("the tiles of a frame are asked for once");
            match each(done.report, &mut take) {
                ControlFlow::Continue(()) => Ok(()),
                ControlFlow::Break(()) => Err(Stop::Asked),
            }
        });
        match outcome {
            Ok(()) | Err(Stop::Asked) => Ok(()),
            Err(Stop::Failed(failure)) => Err(failure),
        }
    }

    fn relieve(&self, limit: Limit) -> Option<String> {
        match &self.simulator {
            Simulator::Cycle(loaded) => doubled(&loaded.machine, limit),
            Simulator::Paper { .. } => None,
        }
    }
}

fn one_frame(
    simulator: &Simulator,
    display: &Display,
    path: &str,
    number: usize,
    block: &EncodedFrame,
) -> Result<Done, Failure> {
    let frame = block.decode().or_exit(Exit::BadInput, path)?;
    let workload = bin(&frame, simulator.geometry());
    let label = Label {
        frame: number,
        name: frame.facts.camera.name.clone(),
        display_w: frame.facts.mean_linear_rgb.map(|mean| display.power(mean).0),
    };
    let report = simulator.report(label, &workload)?;
    let picture = frame.preview.map(|p| Picture { width: p.width, height: p.height, rgb: p.rgb });
    Ok(Done { report, tiles: TileLoad::of(number, &workload, picture) })
}
