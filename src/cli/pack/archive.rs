//! The archive itself: the same files give the same bytes.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::{PACKED_INPUTS, lexical};
use crate::cli::{Context, Exit, Failure, OrExit};
use powergs_core::run::store::atomic::{persist, temporary};

/// One file or folder of the archive.
pub(super) struct PackEntry {
    /// Its path in the folder that is packed, with slashes.
    pub name: String,
    pub source: PackSource,
}

/// Where its contents are from.
pub(super) enum PackSource {
    /// A file.
    File(PathBuf),
    /// From here.
    Bytes(Vec<u8>),
    /// A folder that may be empty.
    Folder,
}

/// How much was written.
#[derive(Debug, Default)]
pub(super) struct PackWritten {
    /// Bytes of the archive.
    pub archive: u64,
    /// Bytes of the files of the folder.
    pub own: u64,
    /// Bytes of the inputs.
    pub inputs: u64,
}

/// Larger files have sizes of 64 bits in a zip file.
const LARGE: u64 = u32::MAX as u64;

/// Writes the archive beside its place and then there; `None` if the user stopped it, and then
/// nothing is left.
pub(super) fn write(
    target: &Path,
    folder: &str,
    mut entries: Vec<PackEntry>,
    context: &Context,
) -> Result<Option<PackWritten>, Failure> {
    let cannot = |e: io::Error| {
        Failure::new(Exit::Usage, format!("{}: cannot be written: {e}", target.display()))
    };
    entries.sort_by(|a, b| a.name.cmp(&b.name));
    let file = temporary(&lexical(target)?).map_err(cannot)?;
    let mut zip = ZipWriter::new(BufWriter::new(file));
    let zipped = |e: zip::result::ZipError| cannot(io::Error::from(e));
    let mut written = PackWritten::default();
    for PackEntry { name, source } in entries {
        let is_input = name.split('/').next() == Some(PACKED_INPUTS);
        let whole = format!("{folder}/{name}");
        let bytes = match source {
            PackSource::Folder => {
                zip.add_directory(whole, options(0).unix_permissions(0o755)).map_err(zipped)?;
                0
            }
            PackSource::Bytes(bytes) => {
                zip.start_file(whole, options(0)).map_err(zipped)?;
                zip.write_all(&bytes).map_err(cannot)?;
                bytes.len() as u64
            }
            PackSource::File(path) => {
                let length = path.metadata().or_exit(Exit::BadInput, path.display())?.len();
                let from = File::open(&path).or_exit(Exit::BadInput, path.display())?;
                zip.start_file(whole, options(length)).map_err(zipped)?;
                let mut from = BufReader::new(from);
                let Some(bytes) = copied(&mut from, &mut zip, &path, context, &cannot)? else {
                    return Ok(None);
                };
                bytes
            }
        };
        *(if is_input { &mut written.inputs } else { &mut written.own }) += bytes;
    }
    let file = zip.finish().map_err(zipped)?.into_inner().map_err(|e| cannot(e.into_error()))?;
    written.archive = file.as_file().metadata().map_err(cannot)?.len();
    if context.is_cancelled() {
        return Ok(None);
    }
    persist(file, &lexical(target)?).map_err(cannot)?;
    Ok(Some(written))
}

/// No time, no owner, and the same permissions for every file.
fn options(length: u64) -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644)
        .large_file(length >= LARGE)
}

/// Copies a file piece by piece; `None` if the user stopped it.
fn copied(
    from: &mut impl Read,
    to: &mut impl Write,
    path: &Path,
    context: &Context,
    cannot: &dyn Fn(io::Error) -> Failure,
) -> Result<Option<u64>, Failure> {
    let (mut buffer, mut bytes) = (vec![0; 1 << 18], 0);
    loop {
        if context.is_cancelled() {
            return Ok(None);
        }
        let n = from.read(&mut buffer).or_exit(Exit::BadInput, path.display())?;
        if n == 0 {
            return Ok(Some(bytes));
        }
        to.write_all(&buffer[..n]).map_err(cannot)?;
        bytes += n as u64;
    }
}
