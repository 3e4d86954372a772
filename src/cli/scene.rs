//! `scene`: what a trained model holds, any format as another one, and four models as the levels of
//! a foveated one and back.

mod convert;

use powergs_report::document::{Cell, Column, Document, Kind, Table};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::output_file::{self, OutputArgs};
use super::scene_file::ReadingArgs;
use super::{Context, Exit, Failure, OrExit, out};
use powergs_core::run::store::atomic::write_atomically;
use powergs_scene::files::{OpenedModel, open_foveated};
use powergs_scene::{Foveated, Gaussians, SceneStats, Warning, write_ply};

/// Examples at the end of the help.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim scene info point_cloud.ply
  powergs-sim scene info scene.spz --json
  powergs-sim scene info playbot/lod-meta.json --detail 2
  powergs-sim scene convert scene.sog scene.ply
  powergs-sim scene convert point_cloud.ply scene.sog
  powergs-sim scene convert point_cloud.ply scene --format sog-folder
  powergs-sim scene compose L1.ply L2.ply L3.ply L4.ply -o model.fov
  powergs-sim scene level model.fov --level 2 -o L2.ply

Formats, recognised by content: INRIA .ply, PlayCanvas compressed .ply, .splat,
.spz 1 to 4, glTF (.gltf, .glb), SOG 1 and 2 (folder, meta.json or .sog),
streamed SOG, foveated .fov (its level 1; `scene level` writes the others). A
folder is that of a SOG or of a training run, whose last iteration is taken.
Written, by the name: .ply, .compressed.ply, .spz (3), .gltf, .glb, .sog and
folders (SOG 2).
What a format loses is said: a table, or `kept` in --json.";

/// Inspect trained models and convert them
#[derive(Debug, clap::Args)]
pub struct SceneArgs {
    #[command(subcommand)]
    command: SceneCommand,
}

#[derive(Debug, clap::Subcommand)]
enum SceneCommand {
    /// Print count, bounds, percentiles of opacity and scale, and warnings
    Info {
        /// File, or folder of a SOG scene or of a training run
        file: PathBuf,
        #[command(flatten)]
        reading: ReadingArgs,
    },
    /// Write a model of any format as INRIA PLY, compressed PLY, SPZ, glTF or SOG
    Convert(convert::ConvertArgs),
    /// Combine four levels into one foveated model (.fov)
    Compose {
        /// Levels 1 to 4, any format: each a part of the one before that differs from it in
        /// opacity and DC colour only
        #[arg(num_args = 4, required = true, value_names = ["L1", "L2", "L3", "L4"])]
        levels: Vec<PathBuf>,
        #[command(flatten)]
        reading: ReadingArgs,
        #[command(flatten)]
        to: OutputArgs,
    },
    /// Write a level of a foveated model as INRIA PLY
    Level {
        /// The foveated model (.fov)
        file: PathBuf,
        /// Which, 1 to 4
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=4))]
        level: u8,
        #[command(flatten)]
        to: OutputArgs,
    },
}

/// Runs the command.
pub fn run(args: &SceneArgs, context: &Context) -> Result<Exit, Failure> {
    match &args.command {
        SceneCommand::Info { file, reading } => {
            let scene = reading.open_silently(file)?;
            let (stats, oddities) = SceneStats::of(&scene.gaussians);
            let warnings: Vec<Warning> = scene.warnings.iter().cloned().chain(oddities).collect();
            if context.global.json {
                out::json(&object(&scene, &stats, &warnings))?;
            } else {
                out::document(&document(&scene, &stats, &warnings))?;
            }
        }
        SceneCommand::Convert(args) => convert::run(args, context)?,
        SceneCommand::Compose { levels, reading, to } => {
            compose(levels, reading, to.file()?, context)?;
        }
        SceneCommand::Level { file, level, to } => {
            let output = to.file()?;
            let scene = open_foveated(file)?.level(usize::from(level - 1));
            write_atomically(output, |mut w| write_ply(&scene, &mut w))?;
            written(&scene, output, context)?;
        }
    }
    Ok(Exit::Done)
}

/// Says what was written.
fn written(scene: &Gaussians, output: &Path, context: &Context) -> Result<(), Failure> {
    let (points, degree) = (scene.len(), scene.sh_degree);
    if context.global.json {
        return out::json(&json!({ "points": points, "sh_degree": degree }));
    }
    output_file::say(output, format_args!("{points} Gaussians, SH degree {degree}"), context)
}

fn compose(
    files: &[PathBuf],
    reading: &ReadingArgs,
    output: &Path,
    context: &Context,
) -> Result<(), Failure> {
    let mut levels = Vec::with_capacity(Foveated::LEVELS);
    for file in files {
        levels.push(reading.open(file, context)?.gaussians);
    }
    let levels: [Gaussians; 4] = levels.try_into().expect("clap counts the files");
    let model = Foveated::compose(&levels).or_exit(Exit::BadInput, "scene compose")?;
    write_atomically(output, |mut w| model.write(&mut w))?;
    let counts = model.counts();
    if context.global.json {
        out::json(&json!({ "file": output.display().to_string(), "points": counts }))?;
    } else if !context.global.quiet {
        let [a, b, c, d] = counts;
        let name = output.display();
        out::text(&format!("{name}: {a}, {b}, {c} and {d} Gaussians in levels 1 to 4\n"))?;
    }
    Ok(())
}

/// The facts as JSON.
fn object(scene: &OpenedModel, stats: &SceneStats, warnings: &[Warning]) -> Value {
    let warning =
        |w: &Warning| json!({ "kind": w.kind(), "count": w.count(), "text": w.to_string() });
    let mut value = json!({ "format": scene.format });
    let facts = serde_json::to_value(stats).expect("plain numbers become JSON");
    if let (Value::Object(all), Value::Object(facts)) = (&mut value, facts) {
        all.extend(facts);
    }
    value["warnings"] = warnings.iter().map(warning).collect();
    value
}

/// The facts for people.
fn document(scene: &OpenedModel, stats: &SceneStats, warnings: &[Warning]) -> Document {
    let point = |p: [f32; 3]| format!("{:.4} {:.4} {:.4}", p[0], p[1], p[2]);
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let needles = percent(stats.share_needles_at_least_3);
    let mut page = Document::new();
    page.facts([
        ("format", scene.format.to_string()),
        ("points", stats.points.to_string()),
        ("SH degree", stats.sh_degree.to_string()),
        ("memory", format!("{:.1} MB", stats.memory_bytes as f64 / 1e6)),
        ("bounds, lowest x y z", point(stats.bounds.min)),
        ("bounds, highest x y z", point(stats.bounds.max)),
        ("opacity below 0.35", percent(stats.share_opacity_below_0_35)),
        ("axis ratio 3 and more", percent(stats.share_axis_ratio_at_least_3)),
        ("needles 3 and more", format!("{needles} (longest over middle axis)")),
    ]);
    let names = stats.opacity.named().map(|(name, _)| Column::new(name, Kind::Real(short)));
    let mut table = Table::new([Column::text("percentiles")].into_iter().chain(names));
    let [x, y, z] = &stats.position;
    for (name, values) in [
        ("x, world units", x),
        ("y, world units", y),
        ("z, world units", z),
        ("opacity", &stats.opacity),
        ("scale, world units", &stats.scale),
        ("axis ratio", &stats.axis_ratio),
    ] {
        let values = values.named().map(|(_, value)| Cell::Real(value));
        table.row([Cell::from(name)].into_iter().chain(values));
    }
    page.table(table);
    match warnings {
        [] => page.facts([("warnings", "none")]),
        _ => page.facts(warnings.iter().map(|w| ("warning:", w.to_string()))),
    }
    page
}

/// At most seven characters: four significant digits where they fit.
fn short(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude >= 1e5 || (magnitude > 0.0 && magnitude < 1e-3) {
        format!("{value:.1e}")
    } else if magnitude >= 100.0 {
        format!("{value:.0}")
    } else if magnitude >= 10.0 {
        format!("{value:.1}")
    } else if magnitude >= 1.0 {
        format!("{value:.2}")
    } else {
        format!("{value:.4}")
    }
}
