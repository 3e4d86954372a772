//! The words of a recorded command, written again so that it makes a new folder: read as the
//! program reads them, so that `-oDIR`, `-qo DIR` and `--out=DIR` are one.

use std::path::Path;

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, CommandFactory};

use crate::cli::{Cli, Exit, Failure};
use powergs_base::shell;

/// A command that makes a new folder.
#[derive(Debug, Default)]
pub(super) struct RepeatedCommand {
    /// Its words, without the program.
    pub words: Vec<String>,
    /// What was typed and may name a file.
    pub values: Vec<String>,
    /// What is otherwise than it was typed, a sentence each.
    pub notes: Vec<String>,
}

/// Commands that write a folder.
const FOLDERS: [&str; 6] = ["replay", "compare", "sensitivity", "sweep", "optimize", "codesign"];
/// Arguments that say where the folder is, what becomes of one that is there, and what is printed.
const OF_FOLDER: [&str; 5] = ["out", "force", "resume", "json", "quiet"];
/// Arguments that name a file which is written besides the folder.
const FILES: [&str; 2] = ["dump_dram", "csv"];
/// The argument that names results of other runs: with them nothing would be simulated.
const STORE: &str = "store";

/// The command of `folder` once more, with `fresh` as its folder and other files in `files`.
///
/// # Errors
/// Exit code 3: a command that this version does not know, or that writes no folder.
pub(super) fn repeated(
    folder: &Path,
    command: &[String],
    fresh: &Path,
    files: &Path,
) -> Result<RepeatedCommand, Failure> {
    let typed: Vec<&str> = command.iter().skip(1).map(String::as_str).collect();
    let refuse = |why: String| {
        let line = shell::line(&typed);
        Failure::new(Exit::BadInput, format!("{}: powergs-sim {line}: {why}", folder.display()))
    };
    let whole = ["powergs-sim"].into_iter().chain(typed.iter().copied());
    let matches = Cli::command().try_get_matches_from(whole).map_err(|why| {
        let why = why.to_string();
        let why = why.lines().next().unwrap_or_default().trim_start_matches("error: ");
        refuse(format!("this version refuses it: {why}"))
    })?;
    let mut root = Cli::command();
    // Flags that every command takes are among those of each.
    root.build();
    let named = matches.subcommand().filter(|(name, _)| FOLDERS.contains(name));
    let Some((name, matches)) = named else { return Err(refuse("it writes no folder".into())) };
    if let Some(part) = matches.subcommand_name() {
        let what = format!(
            "`{name} {part}` ends what other commands began; run the command that report.html shows"
        );
        return Err(refuse(what));
    }
    let Some(command) = root.find_subcommand(name) else {
        return Err(Failure::new(Exit::Internal, format!("no command {name}")));
    };
    let mut again = RepeatedCommand { words: vec![name.to_owned()], ..Default::default() };
    let mut places: Vec<(usize, Vec<String>)> = Vec::new();
    for arg in command.get_arguments() {
        let id = arg.get_id().as_str();
        if OF_FOLDER.contains(&id) || !is_typed(matches, id) {
            continue;
        }
        let occurrences = occurrences(matches, id);
        if id == STORE {
            let store = occurrences.concat().concat();
            again.notes.push(format!("--store {store} is left out: everything is simulated"));
        } else if FILES.contains(&id) {
            let file = files.join(id).display().to_string();
            again.words.extend(flag(arg).map(|flag| format!("{flag}={file}")));
        } else if let Some(place) = arg.get_index() {
            again.values.extend(occurrences.concat());
            places.push((place, occurrences.concat()));
        } else {
            again.values.extend(occurrences.concat());
            again.words.extend(written(arg, &occurrences));
        }
    }
    again.words.push("--quiet".to_owned());
    again.words.push(format!("--out={}", fresh.display()));
    if !places.is_empty() {
        // What follows are files, whatever they are called.
        again.words.push("--".to_owned());
        places.sort();
        again.words.extend(places.into_iter().flat_map(|(_, values)| values));
    }
    Ok(again)
}

/// Whether an argument stood in the command.
fn is_typed(matches: &ArgMatches, id: &str) -> bool {
    let is_known = matches.try_contains_id(id).unwrap_or(false);
    is_known && matches.value_source(id) == Some(ValueSource::CommandLine)
}

/// The values of an argument, for each time that it was given.
fn occurrences(matches: &ArgMatches, id: &str) -> Vec<Vec<String>> {
    let all = matches.get_raw_occurrences(id).into_iter().flatten();
    all.map(|values| values.map(|value| value.to_string_lossy().into_owned()).collect()).collect()
}

/// `--name`, or `-n` where it has no other.
fn flag(arg: &Arg) -> Option<String> {
    let long = arg.get_long().map(|long| format!("--{long}"));
    long.or_else(|| arg.get_short().map(|short| format!("-{short}")))
}

/// An argument with its values as words.
fn written(arg: &Arg, occurrences: &[Vec<String>]) -> Vec<String> {
    let Some(flag) = flag(arg) else { return Vec::new() };
    match arg.get_action() {
        ArgAction::SetTrue | ArgAction::SetFalse => vec![flag],
        ArgAction::Count => vec![flag; occurrences.len().max(1)],
        _ => occurrences.iter().flat_map(|values| valued(arg, &flag, values)).collect(),
    }
}

fn valued(arg: &Arg, flag: &str, values: &[String]) -> Vec<String> {
    let one = |value: &str| format!("{flag}={value}");
    match (arg.get_value_delimiter(), values) {
        (_, []) => vec![flag.to_owned()],
        (Some(comma), values) => vec![one(&values.join(&comma.to_string()))],
        (None, [value]) => vec![one(value)],
        // Lists may be given one by one.
        (None, values) if matches!(arg.get_action(), ArgAction::Append) => {
            values.iter().map(|value| one(value)).collect()
        }
        (None, values) => [flag.to_owned()].into_iter().chain(values.iter().cloned()).collect(),
    }
}
