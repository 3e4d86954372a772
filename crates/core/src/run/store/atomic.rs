//! Atomic writes: a file is written under a temporary name beside its place and renamed when it is
//! whole.

use std::ffi::OsStr;
use std::fs::{self, OpenOptions, Permissions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use tempfile::NamedTempFile;

use super::{RunError, cannot_write};

/// A temporary file in the folder of `path`, with the permissions of an ordinary new file.
///
/// # Errors
/// Those of the folder; a `path` that is a device or a pipe, which a rename would replace.
pub fn temporary(path: &Path) -> io::Result<NamedTempFile> {
    if is_special(path) {
        return Err(io::Error::other("this is a device or a pipe; name an ordinary file"));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    let permissions = ordinary();
    if let Some(permissions) = permissions {
        builder.permissions(permissions);
    }
    builder.prefix(PREFIX).tempfile_in(folder)
}

const PREFIX: &str = ".powergs-sim-";

/// Whether a file of this name is one of [`temporary`].
pub(crate) fn is_temporary(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(PREFIX.as_bytes())
}

/// Removes what a killed process left in a folder. No other process may write there meanwhile.
///
/// # Errors
/// Those of the folder.
pub fn remove_leftovers(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if is_temporary(&entry.file_name()) && entry.file_type()?.is_file() {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Whether something is there that is neither a file nor a folder.
fn is_special(path: &Path) -> bool {
    path.exists() && !path.is_file() && !path.is_dir()
}

/// Read and write for all; the user's mask takes away from it.
#[cfg(unix)]
fn ordinary() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn ordinary() -> Option<Permissions> {
    None
}

/// Writes a file under a temporary name and renames it when it is whole. A device or a pipe is
/// written as it is: it must not be replaced.
///
/// # Errors
/// [`RunError::Output`]: the file cannot be written; the previous one is kept.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), RunError> {
    let written = if is_special(path) {
        OpenOptions::new().write(true).open(path).and_then(|file| {
            let mut writer = BufWriter::new(file);
            write(&mut writer)?;
            writer.flush()
        })
    } else {
        temporary(path).and_then(|file| {
            let mut writer = BufWriter::new(file);
            write(&mut writer)?;
            writer.into_inner().map_err(|e| e.into_error())?.persist(path)?;
            Ok(())
        })
    };
    written.map_err(|e| cannot_write(path.display().to_string(), &e))
}
