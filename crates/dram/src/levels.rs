//! A memory device alone: one stream of requests through one or both levels of its model at once.

use super::drive::{Access, Drive, Mode, Run, WindowDrive};
use super::{Device, EnergyUse};

/// Requests between two questions whether the run was cancelled.
const BATCH: u64 = 4096;

/// A level of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Every command of every bank.
    Banked,
    /// Counts in windows of 128 KiB: fast, no queues.
    Window,
}

impl Level {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Level::Banked => "banked",
            Level::Window => "window",
        }
    }
}

/// What the stream took at one level, and what it cost.
#[derive(Debug, Clone)]
pub struct LevelRun {
    /// The level.
    pub level: Level,
    /// Time and counts.
    pub run: Run,
    /// Energy.
    pub energy: EnergyUse,
}

/// A level on its way through the stream.
enum Driven {
    Banked(Box<Drive>),
    Window(Box<WindowDrive>),
}

impl Driven {
    fn is_full(&self) -> bool {
        match self {
            Driven::Banked(drive) => drive.is_full(),
            Driven::Window(drive) => drive.is_full(),
        }
    }

    fn take(&mut self, access: Access) {
        match self {
            Driven::Banked(drive) => drive.take(access),
            Driven::Window(drive) => drive.take(access),
        }
    }

    fn finish(self, device: &Device) -> LevelRun {
        let (level, run) = match self {
            Driven::Banked(drive) => (Level::Banked, drive.finish().0),
            Driven::Window(drive) => (Level::Window, drive.finish()),
        };
        let energy = EnergyUse::new(device, &run.stats, run.cycles);
        LevelRun { level, run, energy }
    }
}

/// Takes a stream of requests through some levels, in the order of `levels`; `None` if it was
/// cancelled.
///
/// # Errors
/// The first error of the stream.
pub fn run_levels<E>(
    device: &Device,
    mode: Mode,
    levels: &[Level],
    requests: impl IntoIterator<Item = Result<Access, E>>,
    is_cancelled: impl Fn() -> bool,
) -> Result<Option<Vec<LevelRun>>, E> {
    let start = |level: &Level| match level {
        Level::Banked => Driven::Banked(Box::new(Drive::new(device, mode))),
        Level::Window => Driven::Window(Box::new(WindowDrive::new(device, mode))),
    };
    let mut driven: Vec<Driven> = levels.iter().map(start).collect();
    for (n, access) in (1_u64..).zip(requests) {
        let access = access?;
        if driven.iter().any(Driven::is_full) {
            break;
        }
        driven.iter_mut().for_each(|level| level.take(access));
        if n % BATCH == 0 && is_cancelled() {
            return Ok(None);
        }
    }
    Ok(Some(driven.into_iter().map(|level| level.finish(device)).collect()))
}
