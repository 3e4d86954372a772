//! What a run was made from, compared with the files that are packed.

use std::collections::BTreeSet;
use std::fs::File;
use std::path::Path;

use super::reads::{PackReads, is_embedded};
use crate::cli::again::inputs::{RecordedContent, RecordedInputs, another};
use crate::cli::again::record as small_toml;
use crate::cli::{Context, Exit, Failure, OrExit};
use powergs_base::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES, SWEEPS, SYNTH, find};
use powergs_base::format::counted;
use powergs_core::run::Input;

/// What `run.toml` says of inputs.
pub(super) struct PackRecord {
    /// Inputs with a hash each; none in records that have one hash of all.
    pub inputs: RecordedInputs,
    /// Hashes of single files under keys of their own.
    others: Vec<(&'static str, String)>,
}

/// Keys with the hash of one file, and what that is.
const OTHERS: [(&str, &str); 1] = [("space-xxh3", "the space file")];

/// What came out.
#[derive(Debug, Default)]
pub(super) struct PackChecked {
    /// Files whose hash is that of the record.
    same: usize,
    /// Inputs of reports that are compared, as their own records have them.
    of_reports: usize,
    /// Whether the record has a hash of each input.
    each: bool,
    /// What else is to be said, a sentence each.
    pub notes: Vec<String>,
}

impl PackChecked {
    /// In words.
    pub(super) fn said(&self) -> String {
        let same = format!("{} as in the record", counted(self.same, "input"));
        match (self.each, self.of_reports) {
            (true, 0) => same,
            (true, n) => format!("{same}, {n} in records of the reports that it compares"),
            (false, _) => format!("{same}; it has no hash of the others, which `again` compares"),
        }
    }
}

impl PackRecord {
    /// What a `run.toml` says.
    pub(super) fn of(run: &toml::Table) -> PackRecord {
        let hash =
            |(key, what): (&str, &'static str)| Some((what, run.get(key)?.as_str()?.to_owned()));
        let others = OTHERS.into_iter().filter_map(hash).collect();
        PackRecord { inputs: RecordedInputs::of(run), others }
    }
}

/// A file that is packed.
struct PackedNow<'a> {
    path: &'a Path,
    name: String,
    content: RecordedContent,
}

/// Compares every recorded input with the files; `None` if the user stopped it.
///
/// # Errors
/// Exit code 3: an input that is another file now, or that is not found, by name.
pub(super) fn check(
    record: &PackRecord,
    reads: &PackReads,
    place: &Path,
    context: &Context,
) -> Result<Option<PackChecked>, Failure> {
    let mut now = Vec::new();
    for path in reads.files() {
        if context.is_cancelled() {
            return Ok(None);
        }
        let mut file = File::open(path).or_exit(Exit::BadInput, path.display())?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let input =
            Input::hash("input", &name, &mut file).or_exit(Exit::BadInput, path.display())?;
        let hash = format!("{:032x}", input.xxh3);
        let bytes = i64::try_from(input.bytes).unwrap_or(i64::MAX);
        now.push(PackedNow { path, name, content: RecordedContent { hash, bytes } });
    }
    // What a comparison of finished reports has of their runs is not read again.
    let mut of_reports = BTreeSet::new();
    for folder in &reads.reports {
        let inputs = RecordedInputs::of(&small_toml(&folder.join("run.toml"))?);
        for (role, name, contents) in inputs.all() {
            let of = |then: &RecordedContent| (role.to_owned(), name.to_owned(), then.clone());
            of_reports.extend(contents.iter().map(of));
        }
    }
    let mut checked = PackChecked { each: !record.inputs.is_empty(), ..PackChecked::default() };
    for (role, name, contents) in record.inputs.all() {
        for then in contents {
            if of_reports.contains(&(role.to_owned(), name.to_owned(), then.clone())) {
                checked.of_reports += 1;
                continue;
            }
            match of(role, name, then, &now, place)? {
                InputNow::Same => checked.same += 1,
                InputNow::Embedded => {}
                InputNow::OtherBuild(note) => checked.notes.push(note),
            }
        }
    }
    for (what, hash) in &record.others {
        if !now.iter().any(|file| file.content.hash == *hash) {
            let what = format!(
                "{what} is another one now; put back the one of then, or make the \
                                folder anew"
            );
            return Err(Failure::new(Exit::BadInput, what));
        }
        checked.same += 1;
    }
    // A record of somebody else may have a command that names files of this computer.
    let is_known = |file: &PackedNow| {
        let in_report = reads.reports.iter().any(|folder| file.path.starts_with(folder));
        in_report || record.inputs.has_name(&file.name)
    };
    let others = now.iter().filter(|file| checked.each && !is_known(file));
    let others: Vec<String> = others.map(|file| file.path.display().to_string()).collect();
    if !others.is_empty() {
        let what = format!("packed, and not in the record: {}", others.join(", "));
        checked.notes.push(what);
    }
    checked.notes.dedup();
    Ok(Some(checked))
}

/// What an input of then is now.
enum InputNow {
    Same,
    /// It comes with the program.
    Embedded,
    /// It came with another build of the program: a sentence.
    OtherBuild(String),
}

fn of(
    role: &str,
    name: &str,
    then: &RecordedContent,
    now: &[PackedNow],
    place: &Path,
) -> Result<InputNow, Failure> {
    let named: Vec<&PackedNow> = now.iter().filter(|file| file.name == name).collect();
    if named.iter().any(|file| file.content.hash == then.hash) {
        return Ok(InputNow::Same);
    }
    let refuse = |what: String| Err(Failure::new(Exit::BadInput, what));
    if let Some(other) = named.first() {
        let path = other.path.display();
        let what = another(&format!("{role} {name}"), then.bytes, other.content.bytes);
        return refuse(format!(
            "{path}: {what}; put back the one of then, or make the folder anew"
        ));
    }
    // Views of a workload and scenes that the program makes are no files.
    let is_made = role == "trace" && Path::new(name).extension().is_none();
    if is_made {
        return Ok(InputNow::Embedded);
    }
    if !is_embedded(name) {
        return refuse(format!(
            "{role} {name}: not among the files that the command reads in {}; put it back, or say \
             with --in where the command ran",
            place.display()
        ));
    }
    let kinds = [MACHINES, ENERGY, DRAM, DISPLAYS, SWEEPS, SYNTH];
    let texts = kinds.into_iter().filter_map(|files| find(files, name));
    let is_same = texts
        .map(|text| Input::of_text("input", name, text))
        .any(|input| format!("{:032x}", input.xxh3) == then.hash);
    Ok(match is_same {
        true => InputNow::Embedded,
        false => InputNow::OtherBuild(format!(
            "{role} {name} came with another build of the program, which `again` needs for the \
             same numbers"
        )),
    })
}
