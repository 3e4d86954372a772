//! Arguments from the command line, and words of ours where the parser has those of a programmer.

use std::io::IsTerminal;
use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory, Error, FromArgMatches};

use super::{Cli, invocation};

/// The arguments of this process. On a mistake the message is printed and the process ends with
/// exit code 2, after `--help` and `--version` with 0.
pub fn parse<C: CommandFactory + FromArgMatches>() -> C {
    let matches = negatives(C::command()).try_get_matches_from(invocation::words());
    let parsed = matches.and_then(|matches| C::from_arg_matches(&matches));
    parsed.unwrap_or_else(|error| complain(&error))
}

/// The definition of the command line. `--fps -5` is a number that is out of range, and not an
/// unknown flag: every flag with a value takes negative numbers, and says itself what is wrong.
pub fn command() -> Command {
    negatives(Cli::command())
}

fn negatives(command: Command) -> Command {
    let takes = |arg: &clap::Arg| !arg.is_positional() && arg.get_action().takes_values();
    command
        .mut_args(|arg| {
            let negatives = takes(&arg) && !arg.is_allow_hyphen_values_set();
            if negatives { arg.allow_negative_numbers(true) } else { arg }
        })
        .mut_subcommands(negatives)
}

/// What the parsers of the standard library say, and what a user should read.
const WORDS: [(&str, &str); 6] = [
    ("number would be zero for non-zero type", "must be at least 1"),
    ("invalid digit found in string", "must be a whole number, 0 or more"),
    ("invalid float literal", "must be a number"),
    ("number too large to fit in target type", "the number is too large"),
    ("cannot parse integer from empty string", "a number is missing"),
    ("cannot parse float from empty string", "a number is missing"),
];

/// The message of a mistake, in plain words.
pub fn message(error: &Error, coloured: bool) -> String {
    let text = error.render();
    let text = if coloured { text.ansi().to_string() } else { text.to_string() };
    WORDS.iter().fold(text, |text, (theirs, ours)| text.replace(theirs, ours))
}

/// A file that the parser took for an option because its name begins with a dash.
fn dashed_file() -> Option<String> {
    let files = invocation::shown_words().into_iter().skip(1).take_while(|word| word != "--");
    let mut files = files.filter(|word| word.starts_with('-') && Path::new(word).is_file());
    files.next()
}

/// Commands and flags that went to the laboratory with version 0.2, and its command for each. To be
/// deleted with version 0.3.
const MOVED: [(&str, &str); 4] = [
    ("characterise", "characterise"),
    ("vectors", "vectors"),
    ("claims", "claims"),
    ("--datapath", "render"),
];

/// Where a command or a flag went.
fn moved(error: &Error) -> Option<String> {
    let mut kinds = [ContextKind::InvalidSubcommand, ContextKind::InvalidArg].into_iter();
    let ContextValue::String(word) = kinds.find_map(|kind| error.get(kind))? else { return None };
    let (word, command) = MOVED.iter().find(|(name, _)| word.split(' ').next() == Some(*name))?;
    Some(format!(
        "error: {word}: the laboratory, a program of its own in this repository, has it now:\n  \
         cargo run --release -p powergs-lab -- {command} --help"
    ))
}

fn complain(error: &Error) -> ! {
    if matches!(error.kind(), ErrorKind::InvalidSubcommand | ErrorKind::UnknownArgument)
        && let Some(told) = moved(error)
    {
        super::out::complain(told);
        std::process::exit(error.exit_code())
    }
    if error.kind() == ErrorKind::UnknownArgument
        && let Some(file) = dashed_file()
    {
        super::out::complain(format_args!(
            "error: {file}: looks like an option; for the file of this name write ./{file}"
        ));
        std::process::exit(error.exit_code())
    }
    // Of the commands with subcommands, sweep alone has an argument of its own.
    if error.kind() == ErrorKind::ArgumentConflict
        && let Some(ContextValue::String(second)) = error.get(ContextKind::InvalidSubcommand)
    {
        super::out::complain(format_args!(
            "error: {second}: one sweep at a time; traces are given with --traces {second}"
        ));
        std::process::exit(error.exit_code())
    }
    if error.kind() != ErrorKind::ValueValidation {
        error.exit();
    }
    let coloured = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    match message(error, coloured).trim_end() {
        text if coloured => super::out::complain_in_colour(text),
        text => super::out::complain(text),
    }
    std::process::exit(error.exit_code())
}
