//! `scene convert`: a model of any format as another one, and what that lost.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;

use super::short;
use crate::cli::output_file::Overwrite;
use crate::cli::run_folder::RunFolder;
use crate::cli::scene_file::{OrderArgs, ReadingArgs};
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_core::run::store::atomic::write_atomically;
use powergs_report::document::{Cell, Column, Document, Kind, Table};
use powergs_scene::Gaussians;
use powergs_scene::export::{self, Export, Fidelity, Files, Target};

/// What to convert, and to what.
#[derive(Debug, clap::Args)]
pub struct ConvertArgs {
    /// File, or folder of a SOG scene or of a training run
    file: PathBuf,
    /// File to write; for unbundled SOG a folder, or meta.json in it
    output: PathBuf,
    /// Format to write [default: what the name of OUTPUT says]
    #[arg(long, value_name = "FORMAT", value_parser = formats())]
    format: Option<Target>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    order: OrderArgs,
}

fn formats() -> impl TypedValueParser<Value = Target> {
    let names = PossibleValuesParser::new(Target::ALL.map(Target::name));
    names.map(|name| Target::from_name(&name).expect("one of the names"))
}

/// Runs the command.
pub fn run(args: &ConvertArgs, context: &Context) -> Result<(), Failure> {
    let target = target(args)?;
    let place = place(args, target);
    match target {
        Target::SogFolder => RunFolder::check_model(place, args.overwrite.force)?,
        _ => args.overwrite.check(place)?,
    }
    let mut scene = args.reading.open(&args.file, context)?;
    args.order.sort(&mut scene.gaussians);
    let written = export::write(&scene.gaussians, target);
    let written = written.or_exit(Exit::Usage, place.display())?;
    match &written.files {
        Files::One(bytes) => write_atomically(place, |w| w.write_all(bytes))?,
        Files::Folder(files) => {
            let folder = RunFolder::model(place, args.overwrite.force)?;
            files.iter().try_for_each(|(name, bytes)| folder.write(name, bytes))?;
            folder.finish()?;
        }
    }
    say(&scene.gaussians, &written, target, place, context)
}

/// The format that is asked for, or that the name says. A name without an ending is that of a
/// folder; devices and pipes, whose names say nothing, get INRIA PLY.
fn target(args: &ConvertArgs) -> Result<Target, Failure> {
    let output = &args.output;
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    if let Some(target) = args.format.or_else(|| Target::of_file_name(&name)) {
        return Ok(target);
    }
    let is_slash = |byte: &u8| std::path::is_separator(char::from(*byte));
    if output.is_dir() || output.as_os_str().as_encoded_bytes().last().is_some_and(is_slash) {
        return Ok(Target::SogFolder);
    }
    if output.exists() && !output.is_file() {
        return Ok(Target::Ply);
    }
    if output.extension().is_none() {
        return Ok(Target::SogFolder);
    }
    let names = Target::ALL.map(Target::name).join(", ");
    let what = format!(
        "{}: the name says no format that is written; end it in .ply, .compressed.ply, .spz, \
         .gltf, .glb or .sog, or give --format ({names})",
        output.display()
    );
    Err(Failure::new(Exit::Usage, what))
}

/// The file or the folder to write.
fn place(args: &ConvertArgs, target: Target) -> &Path {
    let output = args.output.as_path();
    let is_index = output.file_name().is_some_and(|name| name.eq_ignore_ascii_case("meta.json"));
    match output.parent() {
        Some(parent) if target == Target::SogFolder && is_index => {
            if parent.as_os_str().is_empty() { Path::new(".") } else { parent }
        }
        _ => output,
    }
}

/// Says what was written and what was lost.
fn say(
    scene: &Gaussians,
    written: &Export,
    target: Target,
    place: &Path,
    context: &Context,
) -> Result<(), Failure> {
    let (points, degree, bytes) = (scene.len(), scene.sh_degree, written.files.bytes());
    let kept = &written.fidelity;
    if let Some(displaced) = written.displaced.filter(|_| !context.global.quiet) {
        out::complain(format_args!("warning: {}: {displaced}", place.display()));
    }
    if context.global.json {
        return out::json(&json!({
            "file": place.display().to_string(),
            "format": target.name(),
            "points": points,
            "sh_degree": degree,
            "bytes": bytes,
            "exact": kept.is_exact(),
            "kept": kept,
            "displaced": written.displaced,
        }));
    }
    if context.global.quiet {
        return Ok(());
    }
    let (name, place) = (target.name(), place.display());
    let size = bytes as f64 * 1e-6;
    let loss = if kept.is_exact() { ", nothing lost" } else { "" };
    out::text(&format!(
        "{place}: {points} Gaussians, SH degree {degree}, {name}, {size:.2} MB{loss}\n"
    ))?;
    if kept.is_exact() { Ok(()) } else { out::document(&losses(kept, degree)) }
}

/// The table of what was lost.
fn losses(kept: &Fidelity, degree: u8) -> Document {
    let error = |name: &str| Column::new(name, Kind::Real(short));
    let mut table = Table::new([
        Column::text("field"),
        Column::text("exact"),
        error("largest error"),
        error("rms error"),
        Column::count("clamped"),
    ]);
    for (name, kept) in kept.named() {
        if name == "colour_rest" && degree == 0 {
            continue;
        }
        table.row([
            Cell::from(title(name)),
            Cell::Flag(kept.exact),
            Cell::Real(kept.largest),
            Cell::Real(kept.rms),
            Cell::from(kept.clamped),
        ]);
    }
    let mut page = Document::new();
    page.table(table);
    page
}

/// A field and its unit, for people.
fn title(field: &str) -> &str {
    match field {
        "position" => "position, world units",
        "scale" => "scale, natural logarithm",
        "rotation" => "rotation, degrees",
        "opacity" => "opacity, 0 to 1",
        "colour_dc" => "colour, DC coefficients",
        "colour_rest" => "colour, other coefficients",
        other => other,
    }
}
