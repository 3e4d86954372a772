//! `replay --dump-dram FILE`: the DRAM requests of a frame as text, one a line: `R 0x1f40 64`.
//!
//! The format of address traces: `R` or `W`, the first byte, how many bytes.

use std::io::{self, Write};
use std::path::Path;

use super::Failure;
use powergs_core::run::store::atomic::write_atomically;

/// Takes a request: whether it writes, its first byte, how many bytes.
pub type Sink<'a> = dyn FnMut(bool, u64, u64) + 'a;

/// Writes the requests that `requests` hands out; the file appears whole or not at all.
///
/// # Errors
/// Those of `requests`, or exit code 2: a file that cannot be written.
pub fn write(
    path: &Path,
    requests: &mut dyn FnMut(&mut Sink<'_>) -> Result<(), Failure>,
) -> Result<u64, Failure> {
    let mut lines = 0;
    let mut refused = None;
    let written = write_atomically(path, |out| {
        let mut failed = None;
        let outcome = requests(&mut |write, address, bytes| {
            lines += 1;
            if failed.is_none() {
                failed = line(out, write, address, bytes).err();
            }
        });
        refused = outcome.err();
        match (failed, &refused) {
            (Some(e), _) => Err(e),
            (None, Some(_)) => Err(io::Error::other("no requests")),
            (None, None) => Ok(()),
        }
    });
    match refused {
        Some(failure) => Err(failure),
        None => Ok(written.map(|()| lines)?),
    }
}

/// One request.
pub fn line(out: &mut dyn Write, write: bool, address: u64, bytes: u64) -> io::Result<()> {
    let kind = if write { 'W' } else { 'R' };
    writeln!(out, "{kind} {address:#x} {bytes}")
}
