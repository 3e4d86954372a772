//! Standard output: results only, through a lock, and a reader that went away is no error.

use std::io::{self, BufWriter, Write};

use super::{Exit, Failure};
use powergs_report::document::Document;

/// Runs `write` on the locked, buffered standard output. A closed pipe (`| head`) ends the writing
/// early and is success; a full disk is a failure.
pub fn write(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    forgive(write_to(&mut io::stdout().lock(), write))
}

/// Prints text. Control characters, which names from files may have, become `?`.
pub fn text(text: &str) -> Result<(), Failure> {
    write(|out| out.write_all(harmless(text).as_bytes()))
}

/// Text that cannot steer a terminal.
fn harmless(text: &str) -> String {
    text.replace(|c: char| c.is_control() && !matches!(c, '\n' | '\t'), "?")
}

/// Prints a document, as wide as `COLUMNS` says, else as the terminal, or 80 columns where there is
/// none.
pub fn document(document: &Document) -> Result<(), Failure> {
    text(&document.terminal(width()))
}

/// Columns that are printed.
fn width() -> usize {
    const NARROWEST: u16 = 40;
    const WIDEST: u16 = 160;
    let asked = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let terminal = || terminal_size::terminal_size_of(io::stdout()).map(|(width, _)| width.0);
    asked.or_else(terminal).map_or(80, |width| width.clamp(NARROWEST, WIDEST).into())
}

/// Prints one JSON document, indented, with a final newline.
pub fn json(value: &impl serde::Serialize) -> Result<(), Failure> {
    write(|out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        writeln!(out)
    })
}

/// Prints a line of ours, with its colours, on standard error.
pub fn complain_in_colour(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{message}");
}

/// Prints a line on standard error, without control characters. If that is closed the line is lost.
pub fn complain(message: impl std::fmt::Display) {
    let _ = writeln!(io::stderr().lock(), "{}", harmless(&message.to_string()));
}

fn write_to(
    out: &mut dyn Write,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    write(&mut out)?;
    out.flush()
}

/// A reader that closed the pipe had enough; every other failure is reported.
pub fn forgive(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(Failure::new(Exit::Usage, format!("standard output: {e}"))),
        Ok(()) => Ok(()),
    }
}
