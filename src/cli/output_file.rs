//! Files that commands write where the user says: nothing that is there is replaced without
//! `--force`, and that is said before any work is done.

use std::path::{Path, PathBuf};

use super::{Context, Exit, Failure, out};

/// The flag of commands that write a file.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Overwrite {
    /// Replace files that are there already
    #[arg(long)]
    pub force: bool,
}

impl Overwrite {
    /// See [`check`].
    ///
    /// # Errors
    /// As [`check`].
    pub fn check(self, path: &Path) -> Result<(), Failure> {
        check(path, self.force)
    }
}

/// The flags of commands that write one file, and do nothing else.
#[derive(Debug, clap::Args)]
pub struct OutputArgs {
    /// The file to write
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Whether it is replaced.
    #[command(flatten)]
    overwrite: Overwrite,
}

impl OutputArgs {
    /// The file, which may be written.
    ///
    /// # Errors
    /// As [`check`].
    pub fn file(&self) -> Result<&Path, Failure> {
        self.overwrite.check(&self.output)?;
        Ok(&self.output)
    }
}

/// Refuses a file that is there already, unless with `force`, and a folder always. Devices and
/// pipes are written as they are.
///
/// # Errors
/// Exit code 2.
pub fn check(path: &Path, force: bool) -> Result<(), Failure> {
    let refuse = |what: &str| Err(Failure::new(Exit::Usage, format!("{}: {what}", path.display())));
    match path.metadata() {
        Ok(facts) if facts.is_dir() => refuse("is a folder; name a file"),
        Ok(facts) if facts.is_file() && !force => {
            refuse("exists already; replace it with --force, or give another name")
        }
        _ => Ok(()),
    }
}

/// Says which file was written, on standard output, unless that is for JSON or silenced.
///
/// # Errors
/// Those of standard output.
pub fn say(path: &Path, what: impl std::fmt::Display, context: &Context) -> Result<(), Failure> {
    if context.global.json || context.global.quiet {
        return Ok(());
    }
    out::text(&format!("{}: {what}\n", path.display()))
}
