//! A zipped SOG as a folder, with bounds on what its members inflate to.

use std::cell::RefCell;
use std::io::{self, Cursor, Read};

use zip::ZipArchive;

use super::super::error::{DAMAGED, SceneError};
use super::super::foreign;
use super::super::input::{Folder, Input};

/// Members hold images that do not deflate any further, and one JSON file.
const MAX_RATIO: u64 = 16;
/// Every member may inflate to this size, bytes.
const FREE: u64 = 1 << 20;

/// An archive in memory.
pub(super) struct Bundle<'a> {
    archive: RefCell<ZipArchive<Cursor<&'a [u8]>>>,
    index: String,
}

impl<'a> Bundle<'a> {
    /// Reads the directory and finds `meta.json`, at the root or in the first folder with one.
    pub(crate) fn new(bytes: &'a [u8]) -> Result<Self, SceneError> {
        let wrong = |what: String| SceneError::malformed("zip archive", what, DAMAGED);
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| wrong(e.to_string()))?;
        let names: Vec<String> = (0..archive.len())
            .filter_map(|i| archive.name_for_index(i).and_then(Result::ok))
            .map(|name| name.into_owned())
            .collect();
        let mut indices: Vec<&String> = names
            .iter()
            .filter(|name| *name == "meta.json" || name.ends_with("/meta.json"))
            .collect();
        indices.sort_by_key(|name| (name.matches('/').count(), *name));
        match indices.into_iter().next() {
            Some(index) => Ok(Self { archive: RefCell::new(archive), index: index.clone() }),
            None => Err(foreign::by_members(names.iter().map(String::as_str))
                .unwrap_or_else(|| wrong("no meta.json inside; this is not a SOG bundle".into()))),
        }
    }

    /// The name of `meta.json`.
    pub(crate) fn index(&self) -> &str {
        &self.index
    }

    /// The folder of `meta.json`, with its slash.
    pub(crate) fn prefix(&self) -> &str {
        self.index.rfind('/').map_or("", |slash| &self.index[..=slash])
    }
}

impl Folder for Bundle<'_> {
    fn open(&self, name: &str) -> io::Result<Input<'_>> {
        let mut archive = self.archive.borrow_mut();
        let member = archive.by_name(name)?;
        let limit = FREE + MAX_RATIO * member.compressed_size();
        let mut bytes = Vec::new();
        member.take(limit + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > limit {
            let what = format!("inflates to more than {limit} bytes");
            return Err(io::Error::new(io::ErrorKind::InvalidData, what));
        }
        let len = bytes.len() as u64;
        Ok(Input { reader: Box::new(Cursor::new(bytes)), len })
    }
}
