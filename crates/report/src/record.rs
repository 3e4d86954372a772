//! `run.toml`: what a report folder was made from.

use super::ReportError;
use powergs_study::run_record::{Run, record};

/// The file: versions, run, inputs with checksums, configuration as resolved.
///
/// # Errors
/// [`ReportError::Toml`], which would be a mistake of ours.
pub fn run_toml(run: &Run) -> Result<String, ReportError> {
    let head = "# What this report was made from. The command that was typed: invocation.toml.\n";
    Ok(format!("{head}{}", toml::to_string_pretty(&record(run))?))
}
