//! `assumptions`: the chip on several machines and scenes, and what each assumption of the cycle
//! model is off by.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::thread;

use clap::Parser;
use serde::Deserialize;
use serde_json::Value;

use super::bench::{self, Bench};
use super::design::{CHIP, Design};
use super::tiles::Pivots;
use super::{BENCHES, Comparison};
use powergs_core::machine::Machine;
use powergs_core::run::store::atomic::write_atomically;
use powergs_core::run::system::System;
use powergs_core::sim::MODEL_VERSION;
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::open_model;
use powergs_scene::{Camera, Gaussians};
use powergs_sim::cli::camera_file::CameraArgs;
use powergs_sim::cli::output_file::Overwrite;
use powergs_sim::cli::{Context, Exit, Failure, OrExit, inputs, out};

/// Shown under `assumptions --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim synth demo -o scenes/synthetic/demo.ply \\
      --cameras scenes/synthetic/cameras.json
  powergs-lab assumptions --scenes scenes --out target/chip --write chip.md

Hours; a second call goes on where the first was stopped.";

/// Arguments of `assumptions`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What is run, and what measures what [default: lab/powergs-lab/chips.toml]
    runs: Option<PathBuf>,
    /// Folder that its paths of scenes are from
    #[arg(long, value_name = "DIR")]
    scenes: PathBuf,
    /// Folder of compiled benches and of the results of runs, which are not made again while
    /// neither RTL, model, machine nor scene change [default: target/chip of the checkout]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Only machines whose name begins so; others are left out of the page
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// Write the page, Markdown
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
    /// Write what `docs/limits.md` says of them: crates/report/src/rtl.toml
    #[arg(long, value_name = "FILE")]
    limits: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// A file of runs.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Runs {
    /// Pixels of all views.
    size: String,
    scene: Vec<SceneRun>,
    base: Base,
    machine: Vec<MachineRun>,
    assumption: Vec<Assumption>,
    /// What the chip says nothing of.
    #[serde(default)]
    not_measured: Vec<NotMeasured>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct NotMeasured {
    ids: Vec<String>,
    why: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneRun {
    name: String,
    model: PathBuf,
    cameras: PathBuf,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Base {
    set: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MachineRun {
    name: String,
    what: String,
    #[serde(default)]
    front: bool,
    /// Whether all memory ports are behind one.
    #[serde(default)]
    one_port: bool,
    #[serde(default)]
    set: Vec<String>,
    #[serde(default)]
    pivots: Pivots,
    /// Pixels of its views, where they are others.
    size: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Assumption {
    ids: Vec<String>,
    what: String,
    machine: String,
    row: String,
    /// The phase of a frame whose time this is about, for the list of limits.
    phase: Option<String>,
    /// What is behind the error, as far as it is known.
    why: Option<String>,
}

/// Views as on a command line.
#[derive(Debug, Parser)]
struct Views {
    #[command(flatten)]
    cameras: CameraArgs,
}

/// A scene and its first view.
struct OpenScene {
    gaussians: Gaussians,
    camera: Camera,
    /// Of its bytes.
    hash: u64,
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    args.write.iter().chain(&args.limits).try_for_each(|path| args.overwrite.check(path))?;
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("chips.toml");
    let path = args.runs.as_ref().unwrap_or(&own);
    let text = fs::read_to_string(path).or_exit(Exit::Usage, path.display())?;
    let mut runs: Runs = toml::from_str(&text).or_exit(Exit::Usage, path.display())?;
    if let Some(only) = &args.only {
        runs.machine.retain(|machine| machine.name.starts_with(only));
    }
    // What limits say of an assumption is of one phase.
    let mut phases: BTreeMap<&str, &str> = BTreeMap::new();
    for own in &runs.assumption {
        let Some(phase) = &own.phase else { continue };
        for id in &own.ids {
            let first = *phases.entry(id).or_insert(phase);
            if first != phase {
                let what = format!("{}: {id} has two phases: {first}, {phase}", path.display());
                return Err(Failure::new(Exit::Usage, what));
            }
        }
    }
    let mut scenes = BTreeMap::new();
    for machine in &runs.machine {
        let size = machine.size(&runs);
        if !scenes.contains_key(size) {
            let all: Result<Vec<OpenScene>, Failure> =
                runs.scene.iter().map(|scene| scene.open(&args.scenes, size)).collect();
            scenes.insert(size.to_owned(), all?);
        }
    }
    // What cannot be is said before hours of the others.
    runs.machine.iter().try_for_each(|machine| machine.system(&runs).map(|_| ()))?;
    let place = args.out.clone().unwrap_or_else(|| PathBuf::from(BENCHES));
    fs::create_dir_all(&place).or_exit(Exit::Usage, place.display())?;
    let mut found = Vec::new();
    for machine in &runs.machine {
        let scenes = &scenes[machine.size(&runs)];
        let Some(views) = machine.on_all(scenes, &runs, &place, context)? else {
            return Ok(Exit::Interrupted);
        };
        if !context.global.quiet {
            out::complain(format_args!("{}: done", machine.name));
        }
        found.push(views);
    }
    let page = Page { runs: &runs, found: &found };
    if context.global.json {
        let all = runs.machine.iter().map(|machine| machine.name.as_str()).zip(&found);
        out::json(&all.collect::<BTreeMap<_, _>>())?;
    }
    let write = |path: &PathBuf, text: String| {
        write_atomically(path, |w| w.write_all(text.as_bytes()))
            .or_exit(Exit::Usage, path.display())
    };
    args.limits.iter().try_for_each(|path| write(path, page.limits()))?;
    match &args.write {
        Some(path) => write(path, page.text())?,
        None if !context.global.json => out::text(&page.text())?,
        None => {}
    }
    let is_wrong = |view: &Value| view["wrong_tiles"].as_array().is_none_or(|all| !all.is_empty());
    Ok(if found.iter().flatten().any(is_wrong) { Exit::GoalMissed } else { Exit::Done })
}

impl SceneRun {
    fn open(&self, from: &Path, size: &str) -> Result<OpenScene, Failure> {
        let (model, cameras) = (from.join(&self.model), from.join(&self.cameras));
        let gaussians = open_model(&model, None)?.gaussians;
        let words = [Path::new("views"), Path::new("--cameras"), &cameras, Path::new("--size")];
        let words = words.into_iter().chain([Path::new(size)]);
        let views = Views::try_parse_from(words.map(Path::as_os_str))
            .or_exit(Exit::Usage, cameras.display())?
            .cameras
            .cameras(Some(&model), || SceneBounds::of(&gaussians))?;
        let mut hasher = DefaultHasher::new();
        for path in [&model, &cameras] {
            fs::read(path).or_exit(Exit::Usage, path.display())?.hash(&mut hasher);
        }
        size.hash(&mut hasher);
        let camera = views.cameras.into_iter().next();
        let what = || Failure::new(Exit::Usage, format!("{}: no view", cameras.display()));
        Ok(OpenScene { gaussians, camera: camera.ok_or_else(what)?, hash: hasher.finish() })
    }
}

impl MachineRun {
    fn size<'a>(&'a self, runs: &'a Runs) -> &'a str {
        self.size.as_deref().unwrap_or(&runs.size)
    }

    fn system(&self, runs: &Runs) -> Result<(System, Design), Failure> {
        let sets = [&runs.base.set[..], &self.set].concat();
        let system = inputs::system(CHIP, &sets, None)?;
        let design = Design::of(system.machine(), self.front)?.with_one_port(self.one_port);
        Ok((system, design))
    }

    /// What is found on all scenes, at a time; `None` when interrupted.
    fn on_all(
        &self,
        scenes: &[OpenScene],
        runs: &Runs,
        place: &Path,
        context: &Context,
    ) -> Result<Option<Vec<Value>>, Failure> {
        let (system, design) = self.system(runs)?;
        if Bench::build(&design, place, context)?.is_none() {
            return Ok(None);
        }
        let run = Run { machine: system.machine(), design: &design, pivots: self.pivots, place };
        thread::scope(|scope| {
            let all: Vec<_> =
                scenes.iter().map(|scene| scope.spawn(|| run.on(scene, context))).collect();
            all.into_iter().map(|one| one.join().expect("a thread that does not panic")).collect()
        })
    }
}

/// A machine of which there is a bench.
struct Run<'a> {
    machine: &'a Machine,
    design: &'a Design,
    pivots: Pivots,
    place: &'a Path,
}

impl Run<'_> {
    /// What is found on a scene, or was found before; `None` when interrupted.
    fn on(&self, scene: &OpenScene, context: &Context) -> Result<Option<Value>, Failure> {
        let Run { machine, design, pivots, place } = *self;
        let mut hasher = DefaultHasher::new();
        bench::hash(&mut hasher)?;
        (scene.hash, &design.parameters, machine.to_toml(), pivots as u8, MODEL_VERSION)
            .hash(&mut hasher);
        let file = place.join(format!("view-{:016x}.json", hasher.finish()));
        if let Ok(bytes) = fs::read(&file) {
            return serde_json::from_slice(&bytes).map(Some).or_exit(Exit::Usage, file.display());
        }
        let comparison = Comparison {
            machine,
            design: design.clone(),
            tiles: None,
            offset: 0,
            pivots,
            stalls: None,
            place,
        };
        let Some(view) = comparison.view(&scene.gaussians, &scene.camera, context)? else {
            return Ok(None);
        };
        let view = view.json();
        write_atomically(&file, |w| Ok(serde_json::to_writer(w, &view)?))
            .or_exit(Exit::Usage, file.display())?;
        Ok(Some(view))
    }
}

/// What a page is made from.
struct Page<'a> {
    runs: &'a Runs,
    /// For each machine, the first view of each scene.
    found: &'a [Vec<Value>],
}

/// Rows of the table of machines that have an error: what they are called in its head.
const SHOWN: [(&str, &str); 6] = [
    ("frame, cycles", "frame"),
    ("preprocessing", "before tiles"),
    ("tile phase, cycles", "tiles"),
    ("qsu busy", "QSU"),
    ("bsu busy", "BSU"),
    ("vru busy", "VRU"),
];

/// Bytes on both sides.
const BYTES: [&str; 7] = [
    "bytes read before",
    "bytes written before",
    "bytes of lists",
    "bytes of features",
    "bytes of pixels",
    "bytes spilled",
    "bytes read back",
];

impl Page<'_> {
    fn text(&self) -> String {
        let mut text = String::from(
            "# What the assumptions are off by\n\n<!-- Written by `powergs-lab assumptions`: \
             change lab/powergs-lab/chips.toml or the RTL, then run it again. -->\n\n",
        );
        let names: Vec<&str> = self.runs.scene.iter().map(|scene| scene.name.as_str()).collect();
        let _ = write!(
            text,
            "The chip of [rtl/](../rtl/README.md) and the cycle model (version {MODEL_VERSION}), \
             on the same Gaussians, lists and stops, with the same memory: the first view of {} at \
             {}. A percentage says by how much the RTL has more than the model, of the model's \
             number; the RTL is right about itself, and where both differ, the model is off by as \
             much. Machines are `lab/powergs-lab/chip.toml` with one core, but for what is \
             said.\n\n",
            names.join(", "),
            self.runs.size
        );
        self.machines(&mut text);
        self.assumptions(&mut text);
        text
    }

    fn percent(&self, machine: usize, scene: usize, row: &str) -> Option<f64> {
        let row = &self.found[machine][scene]["rows"][row];
        let [model, rtl] = ["model", "rtl"].map(|side| row[side].as_f64());
        let (model, rtl) = (model?, rtl?);
        (model > 0.0).then(|| (rtl / model - 1.0) * 100.0)
    }

    fn cell(percent: Option<f64>) -> String {
        percent.map_or("-".to_owned(), |percent| format!("{percent:+.2} %"))
    }

    /// What of pixels and bytes is not equal.
    fn differences(&self, machine: usize, scene: usize) -> String {
        let view = &self.found[machine][scene];
        let mut found = Vec::new();
        if view["wrong_tiles"].as_array().is_none_or(|tiles| !tiles.is_empty()) {
            found.push("PIXELS".to_owned());
        }
        for name in BYTES {
            let row = &view["rows"][name];
            if row["model"] != row["rtl"] {
                let percent = Self::cell(self.percent(machine, scene, name));
                let name = name.trim_start_matches("bytes ").trim_start_matches("of ");
                found.push(format!("{name} {percent}"));
            }
        }
        if found.is_empty() { "equal".to_owned() } else { found.join(", ") }
    }

    fn machines(&self, text: &mut String) {
        text.push_str("## Machines\n\n| machine | scene |");
        SHOWN.iter().for_each(|(_, head)| text.extend([" ", head, " |"]));
        text.push_str(" pixels, bytes |\n|---|---|");
        text.push_str(&"--:|".repeat(SHOWN.len()));
        text.push_str("---|\n");
        for (m, machine) in self.runs.machine.iter().enumerate() {
            for (s, scene) in self.runs.scene.iter().enumerate() {
                let name = if s == 0 { machine.name.as_str() } else { "" };
                let _ = write!(text, "| {name} | {} |", scene.name);
                for (row, _) in SHOWN {
                    let _ = write!(text, " {} |", Self::cell(self.percent(m, s, row)));
                }
                let _ = writeln!(text, " {} |", self.differences(m, s));
            }
        }
        text.push('\n');
        for machine in &self.runs.machine {
            let sets: Vec<String> = machine.set.iter().map(|set| format!("`{set}`")).collect();
            let sets =
                if sets.is_empty() { String::new() } else { format!(" ({})", sets.join(", ")) };
            let _ = writeln!(text, "- **{}**: {}{sets}.", machine.name, machine.what);
        }
        text.push('\n');
    }

    /// The percentages of a row of an assumption, scene by scene; `None` where its machine was left
    /// out.
    fn errors(&self, own: &Assumption) -> Option<Vec<Option<f64>>> {
        let m = self.runs.machine.iter().position(|machine| machine.name == own.machine)?;
        Some((0..self.runs.scene.len()).map(|s| self.percent(m, s, &own.row)).collect())
    }

    /// For `docs/limits.md`: the least and the most of an assumption's times.
    fn limits(&self) -> String {
        let mut all: BTreeMap<&str, (&str, Vec<f64>)> = BTreeMap::new();
        for own in &self.runs.assumption {
            let (Some(phase), Some(errors)) = (&own.phase, self.errors(own)) else { continue };
            for id in &own.ids {
                let entry = all.entry(id).or_insert((phase, Vec::new()));
                entry.1.extend(errors.iter().flatten());
            }
        }
        let mut text = String::from(
            "# By how much the chip of rtl/ takes longer than the cycle model, percent of a phase: \
             the least\n# and the most of all machines and scenes that measure an assumption.\n\
             # Written by `powergs-lab assumptions --limits`; see evidence/chip.md.\n",
        );
        for (id, (phase, errors)) in all {
            let low = errors.iter().fold(f64::INFINITY, |low, &error| low.min(error));
            let high = errors.iter().fold(f64::NEG_INFINITY, |high, &error| high.max(error));
            let _ = write!(text, "\n[{id}]\nof = \"{phase}\"\nlow = {low:.2}\nhigh = {high:.2}\n");
        }
        text
    }

    /// Largest first.
    fn assumptions(&self, text: &mut String) {
        text.push_str("## Assumptions, largest error first\n\n| | what | machine | number |");
        self.runs.scene.iter().for_each(|scene| text.extend([" ", &scene.name, " |"]));
        text.push_str("\n|---|---|---|---|");
        text.push_str(&"--:|".repeat(self.runs.scene.len()));
        text.push('\n');
        let mut rows: Vec<(f64, String)> = Vec::new();
        for own in &self.runs.assumption {
            let Some(all) = self.errors(own) else { continue };
            let most = all.iter().flatten().fold(0.0f64, |most, percent| most.max(percent.abs()));
            let cells: Vec<String> = all.into_iter().map(Self::cell).collect();
            let (ids, cells) = (own.ids.join(", "), cells.join(" | "));
            let row = format!("| {ids} | {} | {} | {} | {cells} |", own.what, own.machine, own.row);
            rows.push((most, row));
        }
        rows.sort_by(|a, b| b.0.total_cmp(&a.0));
        rows.iter().for_each(|(_, row)| text.extend([row, "\n"]));
        let whys = self.runs.assumption.iter().filter_map(|own| Some((own, own.why.as_ref()?)));
        let mut whys = whys.peekable();
        if whys.peek().is_some() {
            text.push_str("\nWhat is behind them:\n\n");
        }
        whys.for_each(|(own, why)| {
            let _ = writeln!(text, "- **{}**, {}: {why}", own.ids.join(", "), own.what);
        });
        if !self.runs.not_measured.is_empty() {
            text.push_str("\n## Not measured\n\n");
        }
        for own in &self.runs.not_measured {
            let _ = writeln!(text, "- **{}**: {}", own.ids.join(", "), own.why);
        }
    }
}
