//! Why a run ended early.

use std::error::Error;
use std::fmt;

use crate::sim::{Incompatible, InvariantViolated, SimError};

/// Why a run ended early. Requests that cannot be met, faulty inputs and defects of the simulator
/// are different variants.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A configuration file, a name of one, or a key is invalid.
    #[error("{}", PlacedError(place, message))]
    Config {
        /// The file, by path or name; empty where the message says it.
        place: String,
        /// Everything that is wrong, with lines and suggestions.
        message: String,
    },
    /// The request cannot be fulfilled: frames that a trace does not have, for instance.
    #[error("{0}")]
    Request(String),
    /// The machine cannot run the frame.
    #[error("frame {frame}: {reason}")]
    Incompatible {
        /// Name of the view.
        frame: String,
        /// Why, and what to do.
        reason: Incompatible,
    },
    /// An input cannot be read or is damaged.
    #[error("{}", PlacedError(place, message))]
    Input {
        /// The file.
        place: String,
        /// What is wrong with it.
        message: String,
    },
    /// Results cannot be written.
    #[error("{}", PlacedError(place, message))]
    Output {
        /// The file or folder.
        place: String,
        /// What happened, and what is safe.
        message: String,
    },
    /// An account of the simulator did not close. Always a defect of the program.
    #[error("internal error in frame {frame}: {broken}")]
    Invariant {
        /// Name of the view.
        frame: String,
        /// The account.
        broken: InvariantViolated,
    },
    /// Something that cannot happen did. Always a defect of the program.
    #[error("internal error: {0}")]
    Internal(String),
}

/// `place: message`, or the message alone.
struct PlacedError<'a>(&'a str, &'a str);

impl fmt::Display for PlacedError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            "" => f.write_str(self.1),
            place => write!(f, "{place}: {}", self.1),
        }
    }
}

impl RunError {
    /// A configuration problem in `place`.
    pub fn config(place: impl fmt::Display, error: impl fmt::Display) -> RunError {
        RunError::Config { place: place.to_string(), message: error.to_string() }
    }

    /// An input problem in `place`, with the causes of `error`.
    pub fn input(place: impl fmt::Display, error: impl Error) -> RunError {
        RunError::Input { place: place.to_string(), message: causes(&error) }
    }

    /// The error of a frame.
    pub fn in_frame(frame: &str, error: SimError) -> RunError {
        let frame = frame.to_owned();
        match error {
            SimError::Incompatible(reason) => RunError::Incompatible { frame, reason },
            SimError::Unbinnable(error) => RunError::input(format_args!("frame {frame}"), error),
            SimError::Invariant(broken) => RunError::Invariant { frame, broken },
        }
    }

    /// The message without the place.
    pub fn message(&self) -> String {
        match self {
            RunError::Config { message, .. }
            | RunError::Input { message, .. }
            | RunError::Output { message, .. } => message.clone(),
            other => other.to_string(),
        }
    }
}

/// An error and its causes, joined with colons.
pub fn causes(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(": ");
        text.push_str(&error.to_string());
        cause = error.source();
    }
    text
}
