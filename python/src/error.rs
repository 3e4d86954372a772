//! Errors of the library as exceptions of `powergs`.

use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;

use powergs_base::config::ConfigError;
use powergs_core::run::RunError;
use powergs_scene::SceneError;
use powergs_scene::files::{FileError, FileFault};

/// The exceptions of `powergs.errors`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// An invalid configuration, an unknown name or a request that cannot be met.
    Config,
    /// A file or an array that cannot be used.
    Input,
    /// It ran, and the goal was not met.
    GoalMissed,
    /// A defect of the simulator.
    Internal,
    /// Results cannot be written: Python's own `OSError`.
    Output,
}

impl Class {
    const fn name(self) -> &'static str {
        match self {
            Class::Config => "ConfigError",
            Class::Input => "InputError",
            Class::GoalMissed => "GoalMissed",
            Class::Internal => "InternalError",
            Class::Output => "OSError",
        }
    }
}

/// Why a call ended early, on whatever thread that was.
#[derive(Debug)]
pub struct Fault {
    class: Class,
    /// The file that it is about; empty where the message says it.
    place: String,
    message: String,
}

impl Fault {
    /// A fault without a file.
    pub fn new(class: Class, message: impl Into<String>) -> Fault {
        Fault { class, place: String::new(), message: message.into() }
    }

    /// A fault of a file.
    pub fn in_file(
        class: Class,
        place: impl std::fmt::Display,
        message: impl std::fmt::Display,
    ) -> Fault {
        Fault { class, place: place.to_string(), message: message.to_string() }
    }

    /// An invalid argument.
    pub fn config(message: impl Into<String>) -> Fault {
        Fault::new(Class::Config, message)
    }

    /// A configuration file that is invalid.
    pub fn config_file(place: impl std::fmt::Display, error: &ConfigError) -> Fault {
        Fault::in_file(Class::Config, place, error)
    }

    /// The same without lines of a text that nobody has seen.
    pub fn without_lines(self) -> Fault {
        let seen = self.message.lines().filter(|line| !line.contains('|'));
        let without = |line: &str| match line.strip_prefix("line ") {
            Some(rest) => rest.split_once(": ").map_or("", |(_, what)| what).to_owned(),
            None => line.to_owned(),
        };
        let message = seen.map(without).collect::<Vec<_>>().join("\n");
        Fault { message, ..self }
    }

    /// The exception.
    pub fn raise(self) -> PyErr {
        Python::attach(|py| self.exception(py).unwrap_or_else(|failed| failed))
    }

    fn exception(self, py: Python<'_>) -> PyResult<PyErr> {
        let message = in_python(&self.message);
        let place = in_python(&self.place);
        let text = if place.is_empty() { message } else { format!("{place}: {message}") };
        if self.class == Class::Output {
            return Ok(PyOSError::new_err(text));
        }
        let errors = py.import("powergs.errors")?;
        let is_missing = self.class == Class::Input && !place.is_empty() && !is_there(&place);
        let name = if is_missing { "MissingFileError" } else { self.class.name() };
        let class = errors.getattr(name)?;
        let file = Some(place).filter(|place| !place.is_empty());
        let raised = match self.class {
            Class::Config => class.call1((&text, file, line(&text), suggestion(&text)))?,
            Class::Input => class.call1((&text, file))?,
            Class::GoalMissed | Class::Internal | Class::Output => class.call1((&text,))?,
        };
        Ok(PyErr::from_value(raised))
    }
}

/// Whether something has this path.
fn is_there(path: &str) -> bool {
    std::path::Path::new(path).symlink_metadata().is_ok()
}

/// What flags of the command line are called here.
const FLAGS: [(&str, &str); 9] = [
    ("with --resume", "with the same store="),
    (
        "--resume (--store keeps what both share), or --force to begin anew",
        "the same call, or another store=",
    ),
    ("--force to begin anew", "another store= to begin anew"),
    ("(--store keeps what both share), or ", ""),
    ("--memory ", "memory="),
    ("in --set ", "in "),
    ("--set ", ""),
    ("--frames ", "frames "),
    ("--detail ", "detail="),
];

/// A message of the library in the words of Python.
fn in_python(message: &str) -> String {
    FLAGS.iter().fold(message.to_owned(), |text, (flag, word)| text.replace(flag, word))
}

/// The first line of a file that a message names.
fn line(message: &str) -> Option<usize> {
    let (_, rest) = message.split_once("line ")?;
    let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().ok()
}

/// What a message suggests: "did you mean `cores`?".
fn suggestion(message: &str) -> Option<String> {
    let (_, rest) = message.split_once("did you mean `")?;
    Some(rest.split_once('`')?.0.to_owned())
}

impl From<RunError> for Fault {
    fn from(error: RunError) -> Fault {
        match error {
            RunError::Config { place, message } => Fault { class: Class::Config, place, message },
            RunError::Input { place, message } => Fault { class: Class::Input, place, message },
            RunError::Output { place, message } => Fault { class: Class::Output, place, message },
            other @ (RunError::Request(_) | RunError::Incompatible { .. }) => {
                Fault::config(other.to_string())
            }
            other @ (RunError::Invariant { .. } | RunError::Internal(_)) => {
                Fault::new(Class::Internal, other.to_string())
            }
        }
    }
}

impl From<Fault> for PyErr {
    fn from(fault: Fault) -> PyErr {
        fault.raise()
    }
}

/// A defect of ours that no message of the library covers.
pub fn defect(what: impl std::fmt::Display) -> PyErr {
    Fault::new(Class::Internal, format!("internal error: {what}; please report this")).raise()
}

/// A panic of a worker, as the exception of a defect.
pub fn panicked(payload: &(dyn std::any::Any + Send)) -> PyErr {
    let words = payload.downcast_ref::<String>().map(String::as_str);
    let words = words.or_else(|| payload.downcast_ref::<&str>().copied());
    defect(words.unwrap_or("a panic without a message"))
}

/// An object that was used after `close`.
pub fn closed(what: &str) -> PyErr {
    pyo3::exceptions::PyValueError::new_err(format!("the {what} is closed; open it again"))
}

/// A worker thread that ended without an answer.
pub fn lost() -> PyErr {
    PyRuntimeError::new_err("the worker thread ended without an answer; please report this")
}

/// A model or a camera file that cannot be read.
pub fn in_file_error(error: FileError) -> Fault {
    let text = error.to_string();
    let message = text.strip_prefix(&format!("{}: ", error.place)).unwrap_or(&text);
    let class = match &error.what {
        FileFault::Model(SceneError::NoDetails { .. } | SceneError::NoSuchDetail { .. }) => {
            Class::Config
        }
        _ => Class::Input,
    };
    Fault::in_file(class, &error.place, message)
}
