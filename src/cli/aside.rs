//! Files that appear whole or not at all: written under a temporary name beside their place, then
//! renamed.

use std::fs::Permissions;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use tempfile::NamedTempFile;

use super::{Exit, Failure, OrExit};

/// A temporary file in the folder of `path`, with the permissions of an ordinary new file.
pub fn temporary(path: &Path) -> io::Result<NamedTempFile> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    let permissions = ordinary();
    if let Some(permissions) = permissions {
        builder.permissions(permissions);
    }
    builder.prefix(".powergs-sim-").tempfile_in(folder)
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

/// Writes a file aside and renames it when it is whole.
pub fn write_aside(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    let written = temporary(path).and_then(|file| {
        let mut writer = BufWriter::new(file);
        write(&mut writer)?;
        writer.into_inner().map_err(|e| e.into_error())?.persist(path)?;
        Ok(())
    });
    written.or_exit(Exit::Usage, format_args!("{}: cannot be written", path.display()))
}

#[cfg(test)]
mod tests {
    use super::write_aside;

    #[test]
    fn a_failed_write_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_aside(&path, |w| w.write_all(b"first")).unwrap();
        let broken = write_aside(&path, |w| {
            w.write_all(b"second")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(broken.unwrap_err().to_string().contains("disk full"));
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing left behind");
    }
}
