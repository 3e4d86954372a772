//! Little-endian numbers, in and out.

use std::io::{self, Read, Write};

use xxhash_rust::xxh3::Xxh3;

use super::CheckpointError;

/// Longest text: names of jobs.
const TEXT_MAX: usize = 4096;

/// Floats that are written or read at a time.
const BLOCK: usize = 4096;

/// A stream being written, and the hash of what went into it. The first failure is kept, and what
/// follows it is not written.
pub(super) struct Out<'a> {
    to: &'a mut dyn Write,
    hash: Xxh3,
    failed: io::Result<()>,
}

impl<'a> Out<'a> {
    pub fn new(to: &'a mut dyn Write) -> Out<'a> {
        Out { to, hash: Xxh3::new(), failed: Ok(()) }
    }

    pub fn raw(&mut self, bytes: &[u8]) {
        if self.failed.is_ok() {
            self.hash.update(bytes);
            self.failed = self.to.write_all(bytes);
        }
    }

    /// Writes the hash of everything so far, and says whether all went well.
    pub fn finish(mut self) -> io::Result<()> {
        let sum = self.hash.digest();
        self.u64(sum);
        self.failed
    }

    pub fn u32(&mut self, v: u32) {
        self.raw(&v.to_le_bytes());
    }

    pub fn u64(&mut self, v: u64) {
        self.raw(&v.to_le_bytes());
    }

    pub fn f64(&mut self, v: f64) {
        self.raw(&v.to_le_bytes());
    }

    pub fn flag(&mut self, v: bool) {
        self.u32(u32::from(v));
    }

    pub fn text(&mut self, text: &str) {
        self.u32(text.len() as u32);
        self.raw(text.as_bytes());
    }

    pub fn option<T: ?Sized>(&mut self, value: Option<&T>, write: impl FnOnce(&mut Self, &T)) {
        self.flag(value.is_some());
        if let Some(value) = value {
            write(self, value);
        }
    }

    pub fn floats(&mut self, values: &[f32]) {
        let mut bytes = Vec::with_capacity(4 * BLOCK.min(values.len()));
        for block in values.chunks(BLOCK) {
            bytes.clear();
            block.iter().for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
            self.raw(&bytes);
        }
    }
}

/// A stream being read, of which `left` bytes are still to come.
pub(super) struct In<'a> {
    from: &'a mut dyn Read,
    at: usize,
    left: usize,
}

impl<'a> In<'a> {
    pub fn new(from: &'a mut dyn Read, len: usize) -> In<'a> {
        In { from, at: 0, left: len }
    }

    /// An error at the current place.
    pub fn wrong(&self, what: &'static str) -> CheckpointError {
        CheckpointError::Damaged { at: self.at, what }
    }

    fn take(&mut self, bytes: &mut [u8]) -> Result<(), CheckpointError> {
        let left = self.left.checked_sub(bytes.len());
        let left = left.ok_or_else(|| self.wrong("it ends too early"))?;
        self.from.read_exact(bytes)?;
        self.at += bytes.len();
        self.left = left;
        Ok(())
    }

    /// Passes over bytes.
    pub fn skip(&mut self, count: usize) -> Result<(), CheckpointError> {
        (0..count).try_for_each(|_| self.take(&mut [0]))
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], CheckpointError> {
        let mut array = [0; N];
        self.take(&mut array)?;
        Ok(array)
    }

    pub fn u32(&mut self) -> Result<u32, CheckpointError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    pub fn u64(&mut self) -> Result<u64, CheckpointError> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    pub fn f64(&mut self) -> Result<f64, CheckpointError> {
        Ok(f64::from_le_bytes(self.array()?))
    }

    pub fn flag(&mut self) -> Result<bool, CheckpointError> {
        match self.u32()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(self.wrong("neither yes nor no")),
        }
    }

    /// A number of things of at least `bytes` bytes each, which must still be there.
    pub fn count(&mut self, bytes: usize) -> Result<usize, CheckpointError> {
        let count = self.u64()?;
        match count.checked_mul(bytes as u64) {
            Some(needed) if needed <= self.left as u64 => Ok(count as usize),
            _ => Err(self.wrong("it promises more than it holds")),
        }
    }

    pub fn text(&mut self) -> Result<String, CheckpointError> {
        let len = self.u32()? as usize;
        if len > TEXT_MAX {
            return Err(self.wrong("a name is too long"));
        }
        let mut bytes = vec![0; len];
        self.take(&mut bytes)?;
        String::from_utf8(bytes).map_err(|_| self.wrong("a name is not UTF-8"))
    }

    pub fn option<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, CheckpointError>,
    ) -> Result<Option<T>, CheckpointError> {
        if self.flag()? { read(self).map(Some) } else { Ok(None) }
    }

    pub fn floats(&mut self, count: usize) -> Result<Vec<f32>, CheckpointError> {
        if count.checked_mul(4).is_none_or(|bytes| bytes > self.left) {
            return Err(self.wrong("it ends too early"));
        }
        let mut values = Vec::with_capacity(count);
        let mut bytes = [0; 4 * BLOCK];
        while values.len() < count {
            let block = &mut bytes[..4 * BLOCK.min(count - values.len())];
            self.take(block)?;
            values.extend(block.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)));
        }
        Ok(values)
    }

    pub fn finish(&self) -> Result<(), CheckpointError> {
        if self.left == 0 { Ok(()) } else { Err(self.wrong("bytes are left over")) }
    }
}

/// Hashes `len` bytes.
pub(super) fn hash(from: &mut dyn Read, mut len: usize) -> io::Result<u64> {
    let mut hash = Xxh3::new();
    let mut bytes = [0; 4 * BLOCK];
    while len > 0 {
        let block = &mut bytes[..len.min(4 * BLOCK)];
        from.read_exact(block)?;
        hash.update(block);
        len -= block.len();
    }
    Ok(hash.digest())
}
