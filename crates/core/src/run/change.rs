//! A change of one key of one file of a system.

use std::fmt;
use std::str::FromStr;

use powergs_base::config::assumptions::KnobFile;
use powergs_base::config::knob;
use toml::Value;

use super::files::FileKind;

/// A key with its new value. Written as `vru.cores=8` for the machine file, and with `energy:`,
/// `dram:` or `display:` in front of keys of the other files.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Which file has the key.
    pub file: FileKind,
    /// Dotted path; `*` is any name, `[]` behind a name is every item of a list.
    pub path: String,
    /// The new value.
    pub value: Value,
}

impl Change {
    /// A change of a key of the machine file.
    pub fn machine(path: impl Into<String>, value: impl Into<Value>) -> Change {
        Change { file: FileKind::Machine, path: path.into(), value: value.into() }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}={}", self.file.prefix(), self.path, knob::shown(&self.value))
    }
}

impl FromStr for Change {
    type Err = String;

    /// Reads `key=value`; the value is TOML, or else a text: `clock=1.2 GHz`.
    fn from_str(text: &str) -> Result<Change, String> {
        let wrong = || format!("`{text}`: write KEY=VALUE");
        let (key, value) = text.split_once('=').ok_or_else(wrong)?;
        let key = key.trim();
        let others = FileKind::ALL.into_iter().filter(|kind| !kind.prefix().is_empty());
        let (file, path) = others
            .filter_map(|kind| Some((kind, key.strip_prefix(kind.prefix())?)))
            .next()
            .unwrap_or((FileKind::Machine, key));
        if path.is_empty() {
            return Err(wrong());
        }
        Ok(Change { file, path: path.to_owned(), value: knob::written(value.trim()) })
    }
}

impl From<KnobFile> for FileKind {
    fn from(file: KnobFile) -> FileKind {
        match file {
            KnobFile::Machine => FileKind::Machine,
            KnobFile::Energy => FileKind::Energy,
            KnobFile::Dram => FileKind::Dram,
        }
    }
}
