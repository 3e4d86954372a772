//! `vectors`: real work of a unit as words for a test bench of its RTL, and the events that it must
//! answer with.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::json;

use crate::unit_work::lists::{self, Lists};
use crate::unit_work::views::Scene;
use crate::{CorePixels, CoreWork, FrontEnd};
use powergs_core::run::store::atomic::write_atomically;
use powergs_datapath::vectors::{self, Core, CoreTile, Vectors};
use powergs_datapath::{NumberFormat, Vrc, Vru};
use powergs_sim::cli::output_file::Overwrite;
use powergs_sim::cli::{Context, Exit, Failure, OrExit, out};

/// Shown under `vectors --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-lab vectors bsu --trace traces/demo.bin --out bsu/
  powergs-lab vectors vru --scene scene.ply --orbit 8 --out vru/
  powergs-lab vectors ccu --scene scene.ply --cameras cameras.json --out ccu/

Then, with the test bench compiled as rtl/README.md says:
  Vvru < vru/stimulus.bin | cmp - vru/expected.bin";

/// Arguments of `vectors`.
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
    Vrc(Rendering),
    /// Rendering unit: lists of tiles of some views
    Vru(Rendering),
    /// Culling and conversion unit: Gaussians of a scene in a view
    Ccu(Front),
}

/// The folder.
#[derive(Debug, clap::Args)]
struct Target {
    /// Folder for stimulus.bin and expected.bin
    #[arg(long, short, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Arguments of `vectors qsu` and `bsu`.
#[derive(Debug, clap::Args)]
struct Sorting {
    #[command(flatten)]
    lists: Lists,
    #[command(flatten)]
    target: Target,
}

/// Arguments of `vectors vrc` and `vru`.
#[derive(Debug, clap::Args)]
struct Rendering {
    #[command(flatten)]
    scene: Scene,
    #[command(flatten)]
    target: Target,
    /// Slots in all views together, a splat at a pixel each: tiles or sub-tiles are picked all over
    /// the images
    #[arg(long, value_name = "N", default_value_t = 500_000)]
    #[arg(value_parser = clap::value_parser!(u64).range(1_000..=100_000_000))]
    slots: u64,
    /// Numbers of the cores: e5m10 (FP16), or another with four bits of exponent and more
    #[arg(long, value_name = "FORMAT", default_value = "e5m10")]
    format: NumberFormat,
}

/// Arguments of `vectors ccu`.
#[derive(Debug, clap::Args)]
struct Front {
    #[command(flatten)]
    scene: Scene,
    #[command(flatten)]
    target: Target,
    /// Gaussians of the first view, picked all over the scene
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    gaussians: u64,
}

/// Names of the files.
const FILES: [&str; 2] = ["stimulus.bin", "expected.bin"];

impl Target {
    fn check(&self) -> Result<(), Failure> {
        FILES.iter().try_for_each(|file| self.overwrite.check(&self.out.join(file)))
    }

    fn write(&self, unit: &str, vectors: &Vectors, context: &Context) -> Result<Exit, Failure> {
        std::fs::create_dir_all(&self.out).or_exit(Exit::Usage, self.out.display())?;
        let [stimulus, expected] = FILES.map(|file| self.out.join(file));
        let write = |path: &Path, words: &[u16]| {
            let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            write_atomically(path, |writer| writer.write_all(&bytes))
        };
        write(&stimulus, &vectors.stimulus)?;
        write(&expected, &vectors.expected_words())?;
        let (words, events) = (vectors.stimulus.len(), vectors.expected.len());
        if context.global.json {
            out::json(&json!({
                "unit": unit,
                "stimulus": stimulus.display().to_string(),
                "expected": expected.display().to_string(),
                "words": words,
                "events": events,
                "words_of_an_event": vectors.event_words,
                "cycles": vectors.cycles(),
            }))?;
        } else if !context.global.quiet {
            let cycles = match vectors.cycles() {
                Some(cycles) => format!(" in {cycles} cycles without stalls"),
                None => ", whose cycles are not stated".into(),
            };
            let folder = self.out.display();
            out::text(&format!(
                "{folder}: {unit}, {words} words of stimulus, {events} events{cycles}\n"
            ))?;
        }
        Ok(Exit::Done)
    }
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    match &args.unit {
        Unit::Qsu(args) => args.run("qsu", lists::whole, vectors::qsu, context),
        Unit::Bsu(args) => args.run("bsu", lists::chunks, vectors::bsu, context),
        Unit::Vrc(args) => args.cores(context),
        Unit::Vru(args) => args.tiles(context),
        Unit::Ccu(args) => args.run(context),
    }
}

impl Sorting {
    fn run(
        &self,
        unit: &str,
        given: lists::Given,
        vectors: fn(&[Vec<u16>]) -> Vectors,
        context: &Context,
    ) -> Result<Exit, Failure> {
        self.target.check()?;
        let Some(keys) = self.lists.keys(given, context)? else { return Ok(Exit::Interrupted) };
        if keys.is_empty() {
            let what = format!(
                "{}: no list is long enough for this unit; give other frames",
                self.lists.source()
            );
            return Err(Failure::new(Exit::Usage, what));
        }
        self.target.write(unit, &vectors(&keys), context)
    }
}

impl Rendering {
    fn core(&self) -> Result<Vrc, Failure> {
        self.target.check()?;
        let few = format!("--format {}: pixels of a tile need four bits of exponent", self.format);
        Vrc::new(self.format).ok_or_else(|| Failure::new(Exit::Usage, few))
    }

    fn none(&self) -> Failure {
        let what = format!("{}: nothing of it is seen in these views", self.scene.source());
        Failure::new(Exit::Usage, what)
    }

    fn cores(&self, context: &Context) -> Result<Exit, Failure> {
        let vrc = self.core()?;
        let pixels = CorePixels { columns: 2, rows: 2 };
        let Some(work) = self.scene.cores((&vrc, pixels), self.slots, context)? else {
            return Ok(Exit::Interrupted);
        };
        if work.is_empty() {
            return Err(self.none());
        }
        let tile = |work: &CoreWork| CoreTile {
            place: work.place.map(u32::from),
            mask: work.mask as u32,
            splats: work.splats.iter().map(|splat| splat.record).collect(),
        };
        let tiles: Vec<CoreTile> = work.iter().map(tile).collect();
        let core = Core { vrc, split: true, pixels: 4, columns: 2 };
        self.target.write("vrc", &vectors::vrc(&core, &tiles), context)
    }

    fn tiles(&self, context: &Context) -> Result<Exit, Failure> {
        let vrc = self.core()?;
        let Some(work) = self.scene.tiles(&vrc, self.slots, context)? else {
            return Ok(Exit::Interrupted);
        };
        if work.is_empty() {
            return Err(self.none());
        }
        let tiles: Vec<vectors::Tile> =
            work.into_iter().map(|tile| (tile.size, tile.entries)).collect();
        let unit = Vru { vrc, split: true, queue: 2 };
        self.target.write("vru", &vectors::vru(&unit, &tiles), context)
    }
}

impl Front {
    fn run(&self, context: &Context) -> Result<Exit, Failure> {
        self.target.check()?;
        let told = |front: &FrontEnd, picked: &[usize]| {
            let work: Vec<_> = picked.par_iter().map(|&i| front.work(i)).collect();
            vectors::ccu(&front.unit, &front.settings, front.degree, 0, &work)
        };
        let vectors = self.scene.front_end(self.gaussians, told, context)?;
        self.target.write("ccu", &vectors, context)
    }
}
