//! The files of a scene: one, or several that name each other.

use std::collections::BTreeMap;
use std::io::{self, BufRead, Read};

use super::error::{DAMAGED, SceneError};

/// An opened file.
pub struct Input<'a> {
    /// Its bytes.
    pub reader: Box<dyn BufRead + 'a>,
    /// Its length, bytes: a bound on the counts that its header may claim.
    pub len: u64,
}

impl<'a> From<&'a [u8]> for Input<'a> {
    fn from(bytes: &'a [u8]) -> Self {
        Self { reader: Box::new(bytes), len: bytes.len() as u64 }
    }
}

/// Opens the files of a scene by their names relative to its folder.
pub trait Folder {
    /// Opens `name`; the parts of a path are separated by `/`, and none is `..`.
    ///
    /// # Errors
    /// The file is not there or cannot be opened.
    fn open(&self, name: &str) -> io::Result<Input<'_>>;
}

/// A scene in one piece of memory: every name opens it.
#[derive(Debug, Clone, Copy)]
pub struct OneFile<'a>(pub &'a [u8]);

impl Folder for OneFile<'_> {
    fn open(&self, _name: &str) -> io::Result<Input<'_>> {
        Ok(self.0.into())
    }
}

/// Files in memory, by name.
impl Folder for BTreeMap<String, Vec<u8>> {
    fn open(&self, name: &str) -> io::Result<Input<'_>> {
        match self.get(name) {
            Some(bytes) => Ok(bytes.as_slice().into()),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    }
}

/// Opens `name`, which a file of the scene mentions: it must stay inside the folder.
pub(super) fn open<'a>(folder: &'a dyn Folder, name: &str) -> Result<Input<'a>, SceneError> {
    let plain = |part: &str| !part.is_empty() && part != "." && part != "..";
    if !name.split('/').all(plain) || name.contains(['\\', ':', '\0']) {
        let what = format!("the file name {:?} leaves the folder of the scene", clip(name));
        return Err(SceneError::malformed("file names", what, DAMAGED));
    }
    folder.open(name).map_err(|e| SceneError::reading(&clip(name), e))
}

/// The whole of a small file. A file larger than `limit` bytes is refused.
pub(super) fn slurp(folder: &dyn Folder, name: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
    let input = open(folder, name)?;
    let mut bytes = Vec::with_capacity(input.len.min(limit) as usize);
    let read = input.reader.take(limit + 1).read_to_end(&mut bytes);
    read.map_err(|e| SceneError::reading(name, e))?;
    if bytes.len() as u64 > limit {
        let what = format!("larger than {limit} bytes");
        return Err(SceneError::malformed(name, what, DAMAGED));
    }
    Ok(bytes)
}

/// Text from a file, short enough for an error message.
pub(super) fn clip(text: &str) -> String {
    text.chars().take(80).collect()
}

/// Gaussians that a compressed file of `len` bytes can hold. Real files need 4 bytes and more for
/// each; a file that promises sixteen times as many is a bomb. Small files are left alone.
pub(super) fn plausible(len: u64) -> u64 {
    (4 * len).max(1 << 16)
}

/// Gaussians that any scene may have: indices are 32 bits and one is a sign.
pub(super) const MAX_GAUSSIANS: u64 = 1 << 31;

/// Refuses a count above `bound` and above [`MAX_GAUSSIANS`].
pub(super) fn check_count(place: &str, count: u64, bound: u64) -> Result<usize, SceneError> {
    if count > MAX_GAUSSIANS {
        let what = format!("{count} Gaussians, and at most {MAX_GAUSSIANS} are supported");
        return Err(SceneError::malformed(place, what, "split the scene"));
    }
    if count > bound {
        let what = format!("promises {count} Gaussians, and the file is too small for them");
        return Err(SceneError::truncated(place, what));
    }
    if count == 0 {
        return Err(SceneError::malformed(place, "no Gaussians", "train or export a model first"));
    }
    Ok(count as usize)
}
