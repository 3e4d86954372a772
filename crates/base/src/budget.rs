//! How much memory a single frame, picture or list of frames may take. Sizes come from files and
//! flags; they are compared with this before anything is allocated.

use std::fmt;

use crate::quantity::Bytes;

/// Memory for what is worked on at a time, bytes. Not the memory of the whole process: models are
/// as large as their files, and a few results stay beside what is worked on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget(pub Bytes);

impl Budget {
    /// What is allowed unless the user says more: a process then stays below 1 GiB.
    pub const DEFAULT: Budget = Budget(Bytes(768 << 20));

    /// Refuses what takes more.
    ///
    /// # Errors
    /// [`OverBudget`].
    pub fn check(self, needed: u64) -> Result<(), OverBudget> {
        if needed <= self.0.0 { Ok(()) } else { Err(OverBudget { needed, budget: self }) }
    }
}

impl Default for Budget {
    fn default() -> Budget {
        Budget::DEFAULT
    }
}

impl std::str::FromStr for Budget {
    type Err = String;

    fn from_str(text: &str) -> Result<Budget, String> {
        let bytes: Bytes = text.parse().map_err(|e| format!("{e}"))?;
        if bytes.0 == 0 { Err("must be above zero".into()) } else { Ok(Budget(bytes)) }
    }
}

impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Something that would take more memory than is allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "takes about {} of memory, and {budget} are allowed; allow more with --memory \"{}\"",
    rounded(*needed),
    enough(*needed)
)]
pub struct OverBudget {
    /// What it would take, bytes, about.
    pub needed: u64,
    /// What is allowed.
    pub budget: Budget,
}

/// Bytes for people.
fn rounded(bytes: u64) -> String {
    let mib = bytes as f64 / f64::from(1 << 20);
    if mib < 1024.0 { format!("{mib:.0} MiB") } else { format!("{:.1} GiB", mib / 1024.0) }
}

/// A round number of GiB that is enough.
fn enough(bytes: u64) -> Bytes {
    Bytes(bytes.div_ceil(1 << 30).saturating_mul(1 << 30))
}
