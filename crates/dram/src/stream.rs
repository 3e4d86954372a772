//! A memory device alone: a stream of requests and what it takes.

use super::drive::{Access, Drive, Mode, Run};
use super::{Device, EnergyUse};

/// Requests between two questions whether the run was cancelled.
const BATCH: u64 = 4096;

/// What a stream took, and what it cost.
#[derive(Debug, Clone)]
pub struct StreamRun {
    /// Time and counts.
    pub run: Run,
    /// Energy.
    pub energy: EnergyUse,
}

/// Takes a stream of requests through a device; `None` if it was cancelled.
///
/// # Errors
/// The first error of the stream.
pub fn run_stream<E>(
    device: &Device,
    mode: Mode,
    requests: impl IntoIterator<Item = Result<Access, E>>,
    is_cancelled: impl Fn() -> bool,
) -> Result<Option<StreamRun>, E> {
    let mut drive = Drive::new(device, mode);
    for (n, access) in (1_u64..).zip(requests) {
        let access = access?;
        if drive.is_full() {
            break;
        }
        drive.take(access);
        if n % BATCH == 0 && is_cancelled() {
            return Ok(None);
        }
    }
    let run = drive.finish().0;
    let energy = EnergyUse::new(device, &run.stats, run.cycles);
    Ok(Some(StreamRun { run, energy }))
}
