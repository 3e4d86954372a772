//! Exit codes and errors that know theirs.

use std::fmt;

use powergs_base::config::ConfigError;
use powergs_core::run::RunError;
use powergs_scene::SceneError;
use powergs_scene::files::{FileError, FileFault};

/// The exit codes of every command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// Done.
    Done = 0,
    /// It ran, but the goal was not met (comparison, validation, quality target).
    GoalMissed = 1,
    /// Usage or configuration.
    Usage = 2,
    /// A bad or incomplete input file.
    BadInput = 3,
    /// An internal invariant broke.
    Internal = 4,
    /// Ctrl-C.
    Interrupted = 130,
}

/// An error and the exit code that it ends the program with.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// What happened, in which file, at which place, and what to do.
    pub error: anyhow::Error,
}

impl Failure {
    /// A failure with a message.
    pub fn new(
        exit: Exit,
        message: impl fmt::Display + fmt::Debug + Send + Sync + 'static,
    ) -> Self {
        Self { exit, error: anyhow::Error::msg(message) }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#}", self.error)
    }
}

/// Gives errors an exit code and says which file they are about.
pub trait OrExit<T> {
    /// `what` is usually the path; the message reads `what: error`.
    fn or_exit(self, exit: Exit, what: impl fmt::Display) -> Result<T, Failure>;
}

impl<T, E: Into<anyhow::Error>> OrExit<T> for Result<T, E> {
    fn or_exit(self, exit: Exit, what: impl fmt::Display) -> Result<T, Failure> {
        self.map_err(|e| {
            let error = e.into();
            Failure { exit, error: error.context(what.to_string()) }
        })
    }
}

/// The one place where errors of the engine get their exit codes.
impl From<RunError> for Failure {
    fn from(error: RunError) -> Failure {
        let exit = match &error {
            RunError::Config { .. }
            | RunError::Request(_)
            | RunError::Incompatible { .. }
            | RunError::Output { .. } => Exit::Usage,
            RunError::Input { .. } => Exit::BadInput,
            RunError::Invariant { .. } | RunError::Internal(_) => Exit::Internal,
        };
        Failure { exit, error: error.into() }
    }
}

/// A detail that a model does not have was asked for with `--detail`.
impl From<FileError> for Failure {
    fn from(error: FileError) -> Failure {
        let fault = match &error.what {
            FileFault::Model(
                fault @ (SceneError::NoDetails { .. } | SceneError::NoSuchDetail { .. }),
            ) => fault,
            _ => return Failure { exit: Exit::BadInput, error: error.into() },
        };
        Failure::new(Exit::Usage, format!("{}: --detail: {fault}", error.place))
    }
}

/// Names the file that a configuration error is about.
pub trait ConfigUsage<T> {
    /// Exit code 2, and `origin: error`.
    fn usage(self, origin: &str) -> Result<T, Failure>;
}

impl<T> ConfigUsage<T> for Result<T, ConfigError> {
    fn usage(self, origin: &str) -> Result<T, Failure> {
        self.map_err(|e| Failure::new(Exit::Usage, format!("{origin}: {e}")))
    }
}
