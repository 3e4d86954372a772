//! What a sweep says of its results, in words.

use std::path::Path;

use super::finish::tally_text;
use super::opened::Opened;
use super::output::Tally;
use super::plan::Plan;
use crate::cli::Failure;
use crate::cli::aside::write_aside;
use powergs_report::format::wrapped;

/// The summary for a terminal, kept so that a finished sweep says the same again.
pub const TERMINAL: &str = "summary.txt";

/// Writes the summary.
///
/// # Errors
/// Exit code 2: the folder cannot be written.
pub fn write(folder: &Path, opened: &Opened, plan: &Plan, tally: Tally) -> Result<(), Failure> {
    let excluded = plan.excluded.values().sum();
    let mut text = format!(
        "{}\n\n{}\n",
        wrapped(opened.file.question.trim(), 80),
        tally_text(tally, excluded)
    );
    for (cause, count) in &plan.excluded {
        text += &format!("  {count} left out: {cause}\n");
    }
    for (point, reason) in plan.invalid.iter().take(3) {
        text += &format!("  failed: point {point}: {reason}\n");
    }
    write_aside(&folder.join(TERMINAL), |w| w.write_all(text.as_bytes()))
}
