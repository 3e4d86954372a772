//! The lines of a journal: one per record, appended when it is known, found by key.
//!
//! A line is `CRC KEY RECORD`: eight hex digits of the CRC-32 of what follows, the 32 hex digits of
//! the key, and the record, usually JSON. A line that a killed run left half written fails its
//! checksum and is skipped; nothing is ever changed in place.

use std::collections::HashMap;
use std::io::{self, BufRead, Write};

/// The longest line that is read. A result of 100,000 frames is shorter.
const LINE_MAX: u64 = 1 << 24;

/// Writes a line.
///
/// # Errors
/// Those of `out`.
pub fn append(out: &mut impl Write, key: u128, record: &str) -> io::Result<()> {
    debug_assert!(!record.contains('\n'), "a record is one line");
    let body = format!("{key:032x} {record}");
    // One call: lines of several writers do not mix, and a full disk cuts at most one line.
    out.write_all(format!("{:08x} {body}\n", crc32fast::hash(body.as_bytes())).as_bytes())
}

/// Where the record of a key lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JournalPlace {
    /// Which journal.
    pub journal: u32,
    /// First byte of its line.
    pub offset: u64,
    /// Bytes of its line.
    pub length: u32,
}

/// The keys of some journals.
#[derive(Debug, Default)]
pub struct Index {
    places: HashMap<u128, JournalPlace>,
    /// Lines whose checksum is wrong: cut off or damaged.
    pub damaged: u64,
}

impl Index {
    /// Adds the lines of a journal from byte `offset`; returns the end of its last whole line.
    /// The first of two records of a key stays.
    ///
    /// # Errors
    /// Those of `journal`.
    pub fn read(&mut self, number: u32, mut journal: impl BufRead, offset: u64) -> io::Result<u64> {
        let mut line = Vec::new();
        let (mut at, mut whole) = (offset, offset);
        loop {
            line.clear();
            let n = io::Read::take(&mut journal, LINE_MAX).read_until(b'\n', &mut line)? as u64;
            if n == 0 {
                return Ok(whole);
            }
            match key_of(&line) {
                Some(key) => {
                    let place = JournalPlace { journal: number, offset: at, length: n as u32 };
                    self.places.entry(key).or_insert(place);
                    whole = at + n;
                }
                None => self.damaged += 1,
            }
            at += n;
        }
    }

    /// Notes a line that was just written.
    pub(crate) fn note(&mut self, key: u128, place: JournalPlace) {
        self.places.entry(key).or_insert(place);
    }

    /// Where the record of `key` lies.
    pub fn place(&self, key: u128) -> Option<JournalPlace> {
        self.places.get(&key).copied()
    }

    /// All keys, ascending.
    pub(crate) fn sorted_keys(&self) -> Vec<u128> {
        let mut keys: Vec<u128> = self.places.keys().copied().collect();
        keys.sort_unstable();
        keys
    }

    /// Number of keys.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is no key.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }
}

/// The key of a whole line.
fn key_of(line: &[u8]) -> Option<u128> {
    let line = std::str::from_utf8(line.strip_suffix(b"\n")?).ok()?;
    let (crc, body) = line.split_once(' ')?;
    if crc != format!("{:08x}", crc32fast::hash(body.as_bytes())) {
        return None;
    }
    let (key, _) = body.split_once(' ')?;
    u128::from_str_radix(key, 16).ok()
}

/// The record of a line that an [`Index`] has found; `None` if it is damaged.
pub fn parse(line: &[u8]) -> Option<(u128, &str)> {
    let key = key_of(line)?;
    let line = std::str::from_utf8(line).ok()?;
    Some((key, line.splitn(3, ' ').nth(2)?.trim_end()))
}
