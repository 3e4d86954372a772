//! The program in the package: `powergs-sim` itself, what its commands take, and tables of folders.

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use serde_json::{Value as Json, json};

use crate::error::{Class, Fault};
use crate::sweep::known;
use crate::table::{Column, Table};
use powergs_core::run::RunError;
use powergs_sim::cli;

/// Runs the program in this process and returns its exit code; ``words`` are a file that starts it
/// again, and its arguments.
#[pyfunction]
pub fn _main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| cli::main_of(words))
}

/// What every command takes, as JSON: ``path``, ``help``, and ``arguments``.
#[pyfunction]
pub fn _commands() -> String {
    let mut all = Vec::new();
    let mut program = cli::usage::command();
    program.build();
    let mut open = vec![(Vec::new(), &program)];
    while let Some((path, command)) = open.pop() {
        let runs = !command.is_subcommand_required_set();
        if runs && !path.is_empty() {
            let arguments: Vec<Json> = command
                .get_arguments()
                .filter(|argument| !argument.is_hide_set())
                .map(|argument| {
                    let values = argument.get_num_args().unwrap_or_else(|| 0.into());
                    let choices = argument.get_possible_values();
                    let choices = choices.iter().filter(|choice| !choice.is_hide_set());
                    let choices = choices.map(|choice| choice.get_name().to_owned());
                    let lists = argument.get_value_delimiter().is_some();
                    // Said by its name: the type is not one that this crate depends on.
                    let repeats = format!("{:?}", argument.get_action()) == "Append";
                    let help = argument.get_help().map(ToString::to_string);
                    let names = argument.get_value_names().unwrap_or_default();
                    let folder = names.first().is_some_and(|name| name.as_str() == "DIR");
                    json!({
                        "name": argument.get_long().unwrap_or(argument.get_id().as_str()),
                        "is_flag": argument.get_long().is_some(),
                        "takes": values.max_values(),
                        "at_least": values.min_values(),
                        "is_list": lists || repeats || values.max_values() > 1,
                        "is_folder": folder,
                        "is_required": argument.is_required_set(),
                        "choices": choices.collect::<Vec<_>>(),
                        "help": help.unwrap_or_default(),
                    })
                })
                .collect();
            let about = command.get_about().map(ToString::to_string);
            let help = about.unwrap_or_default();
            all.push(json!({ "path": path, "help": help, "arguments": arguments }));
        }
        for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
            let path = path.iter().copied().chain([inner.get_name()]).collect();
            open.push((path, inner));
        }
    }
    all.sort_by_key(|command| command["path"].to_string());
    Json::Array(all).to_string()
}

/// A table of numbers and words in a CSV file of the program, with what is known of its columns.
#[pyfunction]
pub fn _csv(path: PathBuf) -> PyResult<Table> {
    let place = path.display().to_string();
    let file = std::fs::File::open(&path);
    of_csv(file.map_err(|e| Fault::from(RunError::input(&place, e)).raise())?, &place)
}

/// A table of a CSV text of the program; `place` is what messages call it.
pub fn of_csv(input: impl std::io::Read, place: &str) -> PyResult<Table> {
    let wrong = |e: csv::Error| Fault::in_file(Class::Input, place, e).raise();
    let mut reader = csv::Reader::from_reader(input);
    let names: Vec<String> = reader.headers().map_err(wrong)?.iter().map(str::to_owned).collect();
    let mut columns: Vec<Vec<Option<String>>> = vec![Vec::new(); names.len()];
    for record in reader.records() {
        let record = record.map_err(wrong)?;
        for (column, cell) in columns.iter_mut().zip(record.iter()) {
            column.push(Some(cell.to_owned()).filter(|cell| !cell.is_empty()));
        }
    }
    Table::new(names.iter().zip(&columns).map(|(name, cells)| guessed(name, cells)))
}

/// Whole numbers, numbers, truths or words: whatever all cells of a column are.
fn guessed(name: &str, cells: &[Option<String>]) -> Column {
    let (unit, definition) = known(name).unwrap_or_default();
    let is_measured = cells.iter().any(Option::is_some);
    fn all<T: std::str::FromStr>(cells: &[Option<String>]) -> Option<Vec<Option<T>>> {
        let read = |cell: &Option<String>| cell.as_ref().map(|text| text.parse()).transpose().ok();
        cells.iter().map(read).collect()
    }
    if let Some(values) = all::<i64>(cells).filter(|_| is_measured) {
        return Column::integer(name, unit, &definition, values);
    }
    if let Some(values) = all::<f64>(cells).filter(|_| is_measured) {
        return Column::real(name, unit, &definition, values);
    }
    if let Some(values) = all::<bool>(cells).filter(|_| is_measured) {
        return Column::flag(name, &definition, values);
    }
    Column::text(name, &definition, cells.iter().map(Option::as_ref))
}
