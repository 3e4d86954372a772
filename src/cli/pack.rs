//! `pack`: one archive of a finished folder and of the files that its command reads, which `again`
//! runs wherever it is unpacked.

mod archive;
mod layout;
mod reads;
mod record;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::again::difference::PASSED_OVER;
use super::again::words::{Repeat, TypedValue, repeated};
use super::again::{INVOCATION, PACKED_INPUTS, TypedCommand, record as small_toml};
use super::output_file::Overwrite;
use super::{Context, Exit, Failure, OrExit, out};
use archive::{PackEntry, PackSource};
use layout::{PackLayout, lexical};
use powergs_base::format::counted;
use powergs_report::document::Document;

/// Shown under `pack --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim pack reports/demo
  powergs-sim pack reports/units -o artifact.zip
  powergs-sim pack reports/old --in ~/paper -o old.zip

After unpacking, anywhere: powergs-sim again FOLDER
The archive has the files of the folder, and in inputs/ what its command reads:
traces, machine files and what they name, scenes, cameras, photos. Each is
compared with its hash in run.toml. Files that come with the program, stores of
unfinished work (records, checkpoints, models) and hidden files stay out. The
same files give the same bytes of archive, without times or owners.";

/// Arguments of `pack`.
#[derive(Debug, clap::Args)]
pub struct PackArgs {
    /// A finished folder of replay, compare, sensitivity, sweep, optimize or codesign
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The archive, a .zip file [default: DIR.zip in the working folder]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// The command ran here [default: the folder where it ran]
    #[arg(long = "in", value_name = "DIR")]
    pub place: Option<PathBuf>,
    /// Whether an archive that is there is replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
}

/// Packs a folder.
pub fn run(args: &PackArgs, context: &Context) -> Result<Exit, Failure> {
    let folder = args.folder.as_path();
    let refuse = |what: &str| Failure::new(Exit::BadInput, format!("{}: {what}", folder.display()));
    let is_there = |name: &str| folder.join(name).is_file();
    if !folder.is_dir() {
        return Err(refuse(
            "no such folder; name one that replay, compare or another command wrote",
        ));
    }
    if !is_there(INVOCATION) || !is_there("run.toml") {
        let what = "has no invocation.toml and run.toml, which say what made it; pack a folder \
                    that replay, compare, sensitivity, sweep, optimize or codesign wrote";
        return Err(refuse(what));
    }
    let name = folder_name(folder)?;
    let target = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.zip")));
    check_target(&target, folder)?;
    args.overwrite.check(&target)?;

    let invocation: TypedCommand = small_toml(&folder.join(INVOCATION))?;
    let run: toml::Table = small_toml(&folder.join("run.toml"))?;
    if run.get("incomplete").and_then(toml::Value::as_bool) == Some(true) {
        return Err(refuse("is of a run that was interrupted; finish it, then pack its folder"));
    }
    let place = lexical(&invocation.place(folder, args.place.as_deref())?)?;
    let as_typed = |value: &TypedValue| value.text.clone();
    let command = repeated(folder, &invocation.command, &Repeat::Written(&as_typed))?;
    if command.values.iter().any(|value| value.of == "reprice") {
        let what = "prices another run anew (--reprice); pack the folder of that run";
        return Err(refuse(what));
    }
    let own = record::PackRecord::of(&run);
    let has_each = !reads::trains(&command);
    if has_each && own.inputs.is_empty() {
        return Err(refuse("has no inputs in its run.toml: it is no record of a run"));
    }
    let reads = reads::of(&command, &place, &lexical(folder)?, &own)?;
    let Some(checked) = record::check(&own, &reads, &place, context)? else {
        return Ok(Exit::Interrupted);
    };
    let layout = PackLayout::of(&place, &reads);
    let (mut entries, left_out) = own_files(folder)?;
    let own_count = entries.len();
    entries.push(PackEntry {
        name: INVOCATION.to_owned(),
        source: PackSource::Bytes(layout.invocation(folder, &invocation)?),
    });
    entries.extend(layout.entries()?);
    let Some(written) = archive::write(&target, &name, entries, context)? else {
        return Ok(Exit::Interrupted);
    };
    let inputs = reads.files().count();
    let notes = || command.notes.iter().chain(&checked.notes);
    if context.global.json {
        out::json(&json!({
            "archive": target,
            "bytes": written.archive,
            "files": own_count + 1,
            "files_bytes": written.own,
            "inputs": inputs,
            "inputs_bytes": written.inputs,
            "left_out": left_out,
            "notes": notes().collect::<Vec<_>>(),
        }))?;
    } else if !context.global.quiet {
        let mut page = Document::new();
        let sized = |count, name, bytes| format!("{}, {}", counted(count, name), size(bytes));
        let mut facts = vec![
            ("archive", format!("{}, {}", target.display(), size(written.archive))),
            ("files of the folder", sized(own_count + 1, "file", written.own)),
            ("inputs", sized(inputs, "file", written.inputs)),
            ("checked", checked.said()),
        ];
        if !left_out.is_empty() {
            facts.push(("left out", left_out.join(", ")));
        }
        facts.extend(notes().map(|note| ("note", note.clone())));
        page.facts(facts);
        page.paragraph(format!("After unpacking, anywhere: powergs-sim again {name}"));
        out::document(&page)?;
    }
    Ok(Exit::Done)
}

/// What the folder of the archive is called: the last name of the packed one.
fn folder_name(folder: &Path) -> Result<String, Failure> {
    let whole = lexical(folder)?;
    let name = whole.file_name().and_then(|name| name.to_str());
    let what = || format!("{}: needs a name in UTF-8; rename the folder", folder.display());
    name.map(str::to_owned).ok_or_else(|| Failure::new(Exit::Usage, what()))
}

/// Refuses archives that no program would open by their name, and those inside of what is packed.
fn check_target(target: &Path, folder: &Path) -> Result<(), Failure> {
    let refuse =
        |what: &str| Err(Failure::new(Exit::Usage, format!("{}: {what}", target.display())));
    if !target.extension().is_some_and(|end| end.eq_ignore_ascii_case("zip")) {
        return refuse("the archive is a .zip file; give it that ending");
    }
    let canonical = |path: &Path| fs::canonicalize(path).ok();
    let parent = lexical(target)?.parent().and_then(canonical);
    if parent.zip(canonical(folder)).is_some_and(|(parent, folder)| parent.starts_with(folder)) {
        return refuse("is in the folder that is packed; put the archive somewhere else");
    }
    Ok(())
}

/// The files of the folder that are packed as they are, and the names of what is left out.
fn own_files(folder: &Path) -> Result<(Vec<PackEntry>, Vec<String>), Failure> {
    let (mut entries, mut left_out) = (Vec::new(), Vec::new());
    let mut open = vec![(folder.to_owned(), String::new())];
    while let Some((place, inside)) = open.pop() {
        for entry in fs::read_dir(&place).or_exit(Exit::BadInput, place.display())? {
            let entry = entry.or_exit(Exit::BadInput, place.display())?;
            let path = entry.path();
            let refuse = |what: &str| {
                Err(Failure::new(Exit::BadInput, format!("{}: {what}", path.display())))
            };
            let Ok(name) = entry.file_name().into_string() else {
                return refuse("a name that is not UTF-8 cannot be packed; rename it");
            };
            if PASSED_OVER.contains(&name.as_str()) || name.starts_with('.') {
                // Both are written anew.
                if ![INVOCATION, PACKED_INPUTS].contains(&name.as_str()) {
                    left_out.push(format!("{inside}{name}"));
                }
                continue;
            }
            let kind = entry.file_type().or_exit(Exit::BadInput, path.display())?;
            if kind.is_dir() {
                open.push((path, format!("{inside}{name}/")));
            } else if kind.is_file() {
                let name = format!("{inside}{name}");
                entries.push(PackEntry { name, source: PackSource::File(path) });
            } else if kind.is_symlink() {
                return refuse("a link is not packed; put the file in its place, or remove it");
            } else {
                return refuse("neither a file nor a folder; remove it");
            }
        }
    }
    left_out.sort();
    Ok((entries, left_out))
}

/// Bytes for people.
fn size(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 * 1e-3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 * 1e-6),
        _ => format!("{:.2} GB", bytes as f64 * 1e-9),
    }
}
