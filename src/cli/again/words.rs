//! The words of a recorded command, written again so that it makes a new folder: read as the
//! program reads them, so that `-oDIR`, `-qo DIR` and `--out=DIR` are one.

use std::path::Path;

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, CommandFactory, ValueHint};

use crate::cli::{Cli, Exit, Failure};
use powergs_base::shell;

/// A command that makes a new folder.
#[derive(Debug, Default)]
pub(in crate::cli) struct RepeatedCommand {
    /// Its words, without the program.
    pub words: Vec<String>,
    /// What was typed and may name a file.
    pub values: Vec<TypedValue>,
    /// What is otherwise than it was typed, a sentence each.
    pub notes: Vec<String>,
}

/// A value that was typed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::cli) struct TypedValue {
    /// The argument that it is of, as the program calls it.
    pub of: String,
    /// As it was typed.
    pub text: String,
    /// Whether the argument takes paths alone.
    pub is_path: bool,
}

/// What becomes of the words of a command.
pub(in crate::cli) enum Repeat<'a> {
    /// It makes the folder `fresh`, and other files in `files`.
    Into {
        /// The new folder.
        fresh: &'a Path,
        /// Where other files go.
        files: &'a Path,
    },
    /// It is written down, with other texts for what was typed.
    Written(&'a dyn Fn(&TypedValue) -> String),
}

/// Commands that write a folder.
const FOLDERS: [&str; 6] = ["replay", "compare", "sensitivity", "sweep", "optimize", "codesign"];
/// Arguments that say where the folder is, what becomes of one that is there, and what is printed.
const OF_FOLDER: [&str; 5] = ["out", "force", "resume", "json", "quiet"];
/// Arguments that name a file which is written besides the folder.
const FILES: [&str; 2] = ["dump_dram", "csv"];
/// The argument that names results of other runs: with them nothing would be simulated.
const STORE: &str = "store";

/// The command of `folder` once more.
///
/// # Errors
/// Exit code 3: a command that this version does not know, or that writes no folder.
pub(in crate::cli) fn repeated(
    folder: &Path,
    command: &[String],
    how: &Repeat,
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
        let is_path = matches!(arg.get_value_hint(), ValueHint::AnyPath);
        let typed = |text: &String| TypedValue { of: id.to_owned(), text: text.clone(), is_path };
        let mut occurrences = occurrences(matches, id);
        let values: Vec<TypedValue> = occurrences.iter().flatten().map(typed).collect();
        if id == STORE {
            let store = occurrences.concat().concat();
            again.notes.push(format!("--store {store} is left out: everything is simulated"));
            continue;
        } else if FILES.contains(&id) {
            let file = match how {
                Repeat::Into { files, .. } => files.join(id).display().to_string(),
                // Whoever repeats what is written gives the file another place.
                Repeat::Written(_) => id.to_owned(),
            };
            again.words.extend(flag(arg).map(|flag| format!("{flag}={file}")));
            continue;
        }
        if let Repeat::Written(renamed) = how {
            let other = |text: &mut String| *text = renamed(&typed(text));
            occurrences.iter_mut().flatten().for_each(other);
        }
        again.values.extend(values);
        if let Some(place) = arg.get_index() {
            places.push((place, occurrences.concat()));
        } else {
            again.words.extend(written(arg, &occurrences));
        }
    }
    if let Repeat::Into { fresh, .. } = how {
        again.words.push("--quiet".to_owned());
        again.words.push(format!("--out={}", fresh.display()));
    }
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
