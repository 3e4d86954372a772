//! Atomic writes: a file is written under a temporary name beside its place and renamed when it is
//! whole.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, Permissions};
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
    builder.prefix(PREFIX).tempfile_in(folder).map_err(nameless)
}

/// An error without the name of a temporary file, which says nothing to anybody.
pub fn nameless(error: io::Error) -> io::Error {
    let text = error.to_string();
    match text.split_once(" at path ") {
        Some((what, _)) => io::Error::new(error.kind(), what.to_owned()),
        None => error,
    }
}

const PREFIX: &str = ".powergs-sim-";

/// Whether a file of this name is one of [`temporary`].
pub fn is_temporary(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(PREFIX.as_bytes())
}

/// Removes what a killed process left in a folder and in those that are in it. No other process may
/// write there meanwhile.
///
/// # Errors
/// Those of the folder.
pub fn remove_leftovers(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let kind = entry.file_type()?;
        if is_temporary(&entry.file_name()) && kind.is_file() {
            fs::remove_file(entry.path())?;
        } else if kind.is_dir() {
            for inner in fs::read_dir(entry.path())? {
                let inner = inner?;
                if is_temporary(&inner.file_name()) && inner.file_type()?.is_file() {
                    fs::remove_file(inner.path())?;
                }
            }
        }
    }
    Ok(())
}

/// Puts a whole temporary file in its place, so that a power cut leaves the old or the new one.
///
/// # Errors
/// Those of the file system; the previous file is kept.
pub fn persist(file: NamedTempFile, path: &Path) -> io::Result<()> {
    file.as_file().sync_data()?;
    file.persist(path).map_err(|e| nameless(e.error))?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    sync_folder(folder);
    Ok(())
}

/// Makes sure that the names in a folder survive a power cut, where the system can do that.
pub fn sync_folder(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Exchanges two names of one file system in one step.
///
/// # Errors
/// Those of the file system, which may not be able to; then nothing is changed.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
pub fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

/// Exchanges two names of one file system in one step; not on this system.
///
/// # Errors
/// Always.
#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
pub fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
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
            persist(writer.into_inner().map_err(|e| e.into_error())?, path)
        })
    };
    written.map_err(|e| cannot_write(path.display().to_string(), &nameless(e)))
}
