//! `synth`: seeded scenes that behave like trained ones.

use powergs_base::format::counted;
use powergs_report::document::{Block, Column, Document, Kind, Table};
use std::path::PathBuf;

use serde_json::{Value, json};

use super::output_file::Overwrite;
use super::progress::Progress;
use super::{Context, Exit, Failure, out};
use powergs_core::run::store::atomic::write_atomically;
use powergs_scene::camera::inria;

use powergs_base::config::embedded::SYNTH;
use powergs_core::run::RunError;
use powergs_core::run::files::read;
use powergs_scene::synth::{Preset, Statistic, Target, cameras, generate, presets};
use powergs_scene::{Camera, Gaussians, write_ply};
use powergs_views::statistics::{SceneStatistics, measure, statistics};

/// Examples at the end of the help.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim synth --list
  powergs-sim synth demo -o demo.ply --cameras demo-cameras.json
  powergs-sim synth lego --points 100000 --seed 7 -o lego.ply
  powergs-sim synth train --check
  powergs-sim arch show lego > mine.toml
  powergs-sim synth mine.toml -o mine.ply";

/// Most Gaussians of a synthetic scene: 24 GB in memory.
const MAX_POINTS: usize = 100_000_000;

/// Make a synthetic scene that behaves like a trained one
#[derive(Debug, clap::Args)]
pub struct SynthArgs {
    /// What to make: a name of --list, or a TOML file
    #[arg(required_unless_present = "list", value_name = "NAME|FILE")]
    preset: Option<String>,
    /// List the presets
    #[arg(long, conflicts_with_all = ["output", "cameras", "check", "points"])]
    list: bool,
    /// File to write: an INRIA PLY with SH degree 3
    #[arg(long, short, required_unless_present_any = ["list", "check", "cameras"])]
    output: Option<PathBuf>,
    /// Write the views of the preset to this INRIA cameras.json
    #[arg(long, value_name = "FILE")]
    cameras: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Gaussians [default: as the preset]; sizes follow, so that the look stays
    #[arg(long, value_name = "N")]
    points: Option<usize>,
    /// The same seed gives the same bytes
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Render some views and print how near the scene comes to published statistics
    #[arg(long)]
    check: bool,
    /// Views that --check renders, evenly spaced
    #[arg(long, value_name = "N", default_value = "4", requires = "check")]
    check_views: std::num::NonZeroUsize,
}

/// Runs the command.
pub fn run(args: &SynthArgs, context: &Context) -> Result<Exit, Failure> {
    let Some(name) = args.preset.as_deref().filter(|_| !args.list) else {
        return list(context);
    };
    let preset = &find(name)?;
    let points = args.points.unwrap_or(preset.points);
    if !(1..=MAX_POINTS).contains(&points) {
        let what = format!("--points {points}: must be 1 to {MAX_POINTS}");
        return Err(Failure::new(Exit::Usage, what));
    }
    let files = args.cameras.iter().chain(&args.output);
    files.into_iter().try_for_each(|path| args.overwrite.check(path))?;
    let views = cameras(preset);
    if let Some(path) = &args.cameras {
        let text = inria::write(&views);
        write_atomically(path, |w| w.write_all(text.as_bytes()))?;
        let count = counted(views.len(), "view");
        tell(context, format_args!("{}: {count}", path.display()));
    }
    if args.output.is_none() && !args.check {
        return Ok(Exit::Done);
    }
    let scene = generate(preset, points, args.seed);
    if let Some(path) = &args.output {
        write_atomically(path, |mut w| write_ply(&scene, &mut w))?;
        tell(context, format_args!("{}: {points} Gaussians, SH degree 3", path.display()));
    }
    if args.check { check(args, context, preset, &scene, &views) } else { Ok(Exit::Done) }
}

/// Says on standard error what was written; standard output is for results.
fn tell(context: &Context, message: std::fmt::Arguments<'_>) {
    if !context.global.quiet {
        out::complain(message);
    }
}

fn check(
    args: &SynthArgs,
    context: &Context,
    preset: &Preset,
    scene: &Gaussians,
    views: &[Camera],
) -> Result<Exit, Failure> {
    let count = args.check_views.get().min(views.len());
    let progress = Progress::new(context, count as u64, "views");
    let wants_pairs = preset.targets.contains_key(&Statistic::PairsExact);
    let mut frames = Vec::with_capacity(count);
    for idx in 0..count {
        if context.is_cancelled() {
            return Ok(Exit::Interrupted);
        }
        frames.push(measure(scene, &views[idx * views.len() / count], wants_pairs));
        progress.advance(1);
    }
    drop(progress);
    let measured = statistics(scene, &frames);
    if context.global.json {
        out::json(&as_json(preset, &measured))?;
    } else {
        out::document(&document(preset, scene.len(), &measured))?;
    }
    Ok(Exit::Done)
}

fn find(name: &str) -> Result<Preset, Failure> {
    let file = read("preset", name, SYNTH, None)?;
    Ok(Preset::parse(&file.text).map_err(|e| RunError::config(&file.origin, e))?)
}

fn list(context: &Context) -> Result<Exit, Failure> {
    if context.global.json {
        let preset = |p: &Preset| {
            json!({ "name": p.name, "description": p.description, "points": p.points,
                    "width_px": p.image.width, "height_px": p.image.height })
        };
        out::json(&presets().iter().map(preset).collect::<Value>())?;
        return Ok(Exit::Done);
    }
    let mut table = Table::new([
        Column::text("preset"),
        Column::count("Gaussians"),
        Column::count("pixels"),
        Column::text("like").wraps(),
    ]);
    for p in presets() {
        let size = format!("{}x{}", p.image.width, p.image.height);
        let like = p.description.as_str();
        table.row([p.name.as_str().into(), p.points.into(), size.into(), like.into()]);
    }
    let mut page = Document::new();
    page.table(table);
    out::document(&page)?;
    Ok(Exit::Done)
}

/// The targets of `preset` beside what was measured, and what was measured without a target.
pub fn document(preset: &Preset, points: usize, measured: &SceneStatistics) -> Document {
    let mut table = Table::new([
        Column::text(preset.name.as_str()),
        Column::new("measured", Kind::Real(number)),
        Column::count("published"),
        Column::text(""),
    ]);
    for (statistic, value) in measured {
        let target = preset.targets.get(statistic);
        let range = target.map(|t| format!("{} to {}", number(t.low), number(t.high)));
        let is_near = target.is_none_or(|t| (t.low..=t.high).contains(value));
        let mark = if is_near { "" } else { "OUTSIDE" };
        table.row([
            statistic.name().to_string().into(),
            (*value).into(),
            range.into(),
            mark.into(),
        ]);
    }
    let mut page = Document::new();
    page.table(table);
    if points != preset.points {
        let published = preset.points;
        page.paragraph(format!(
            "Published values are for about {published} Gaussians, not {points}."
        ));
    }
    let source = |(s, t): (&Statistic, &Target)| format!("{}: {}", s.name(), t.publication).into();
    page.add(Block::List(preset.targets.iter().map(source).collect()));
    page
}

/// The same as JSON.
pub fn as_json(preset: &Preset, measured: &SceneStatistics) -> Value {
    let statistic = |(statistic, value): (&Statistic, &f64)| {
        let target = preset.targets.get(statistic);
        let target =
            target.map(|t| json!({ "low": t.low, "high": t.high, "publication": t.publication }));
        (statistic.name().to_string(), json!({ "measured": value, "published": target }))
    };
    let statistics: serde_json::Map<String, Value> = measured.iter().map(statistic).collect();
    json!({ "preset": preset.name, "statistics": statistics })
}

/// Three or more digits, without an exponent.
fn number(value: f64) -> String {
    match value.abs() {
        v if v >= 1e6 => format!("{:.2}M", value / 1e6),
        v if v >= 100.0 => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        v if v >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}
