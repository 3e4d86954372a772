//! Address traces as text, one request a line.
//!
//! | form | meaning |
//! |---|---|
//! | `R 0x1f40 64`, `W 8000 32` | read or write of so many bytes |
//! | `LD 0x1f40`, `ST 0x1f40` | Ramulator 2, load-store trace: 64 bytes |
//! | `0x1f40 R`, `0x1f40 W` | Ramulator 1, DRAM trace: 64 bytes |
//! | `0x1f40 READ 10`, `0x1f40 WRITE 10` | DRAMsim3: 64 bytes; the cycle is left out |
//!
//! Addresses are hexadecimal with `0x` or decimal. Blank lines and everything from `#` or `//` are
//! ignored, words may be in small letters, lines may end in CR LF.

use std::io::{self, BufRead, Read, Write};

use super::drive::Access;

/// Bytes of requests in forms that do not say it.
const DEFAULT_BYTES: u32 = 64;

/// The largest request, bytes.
pub(crate) const BYTES_MAX: u32 = 1 << 20;

/// The longest line, bytes.
const LINE_MAX: usize = 1024;

/// What is wrong with an address trace, and in which line.
#[derive(Debug, thiserror::Error)]
pub enum AddressTraceError {
    /// It could not be read.
    #[error("line {line}: {source}")]
    Io {
        /// The line, from 1.
        line: u64,
        /// Why.
        source: io::Error,
    },
    /// A line is no request.
    #[error(
        "line {line}: {what}; write `R 0x1f40 64`, `LD 0x1f40`, `0x1f40 R` or `0x1f40 READ 10`"
    )]
    Line {
        /// The line, from 1.
        line: u64,
        /// What is wrong with it.
        what: String,
    },
    /// There is no request at all.
    #[error("no request in {lines} lines: this is not an address trace")]
    Empty {
        /// Lines that were read.
        lines: u64,
    },
}

/// Reads requests one by one; memory does not grow with the trace.
#[derive(Debug)]
pub struct Requests<R> {
    from: R,
    line: Vec<u8>,
    lines: u64,
    requests: u64,
    cycles: u64,
    failed: bool,
}

impl<R: BufRead> Requests<R> {
    /// The requests of a text.
    pub fn new(from: R) -> Self {
        Self { from, line: Vec::new(), lines: 0, requests: 0, cycles: 0, failed: false }
    }

    /// Requests so far whose lines said in which cycle they come, which is left out.
    pub fn with_cycles(&self) -> u64 {
        self.cycles
    }

    fn read(&mut self) -> Result<Option<Access>, AddressTraceError> {
        loop {
            self.line.clear();
            // One byte more tells a line that is too long from one that just fits.
            let mut part = self.from.by_ref().take(LINE_MAX as u64 + 1);
            let line = self.lines + 1;
            let n = part
                .read_until(b'\n', &mut self.line)
                .map_err(|source| AddressTraceError::Io { line, source })?;
            if n == 0 && self.requests == 0 {
                return Err(AddressTraceError::Empty { lines: self.lines });
            }
            if n == 0 {
                return Ok(None);
            }
            self.lines += 1;
            let wrong = |what: String| AddressTraceError::Line { line, what };
            if n > LINE_MAX {
                return Err(wrong(format!("longer than {LINE_MAX} bytes")));
            }
            let text = std::str::from_utf8(&self.line).map_err(|_| wrong("no text".to_owned()))?;
            // Some editors begin a file with a byte order mark.
            let text = if line == 1 { text.trim_start_matches('\u{feff}') } else { text };
            if let Some((access, has_cycle)) = parse(text).map_err(wrong)? {
                self.requests += 1;
                self.cycles += u64::from(has_cycle);
                return Ok(Some(access));
            }
        }
    }
}

impl<R: BufRead> Iterator for Requests<R> {
    type Item = Result<Access, AddressTraceError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let next = self.read().transpose();
        self.failed = matches!(next, Some(Err(_)));
        next
    }
}

/// Writes a request as a line: `R 0x1f40 64`.
///
/// # Errors
/// Those of `out`.
pub fn write_request(
    out: &mut dyn Write,
    is_write: bool,
    address: u64,
    bytes: u64,
) -> io::Result<()> {
    let direction = if is_write { 'W' } else { 'R' };
    writeln!(out, "{direction} {address:#x} {bytes}")
}

/// The request of a line, if it has one, and whether the line says its cycle.
fn parse(line: &str) -> Result<Option<(Access, bool)>, String> {
    let text = line.split('#').next().unwrap_or("");
    let text = text.split("//").next().unwrap_or("");
    let mut words = text.split_whitespace();
    let Some(first) = words.next() else { return Ok(None) };
    let second = words.next();
    let mut has_cycle = false;
    let access = match (direction(first), second) {
        (Some((write, sized)), Some(at)) => {
            let bytes = match words.next() {
                Some(text) => size(text)?,
                None if sized => return Err(format!("no size after the address `{}`", cut(at))),
                None => DEFAULT_BYTES,
            };
            Access { write, address: address(at)?, bytes }
        }
        (Some(_), None) => return Err(format!("no address after `{first}`")),
        (None, Some(word)) => {
            let address = address(first)?;
            let is = |name: &str| word.eq_ignore_ascii_case(name);
            let write = match direction(word) {
                Some((write, true)) => write,
                _ if is("READ") || is("WRITE") => {
                    let Some(cycle) = words.next() else {
                        return Err(format!("no cycle after `{word}`"));
                    };
                    if !cycle.bytes().all(|b| b.is_ascii_digit()) {
                        return Err(format!("`{}` is not a cycle", cut(cycle)));
                    }
                    has_cycle = true;
                    is("WRITE")
                }
                _ => return Err(format!("`{}` is neither R nor W", cut(word))),
            };
            Access { write, address, bytes: DEFAULT_BYTES }
        }
        (None, None) => {
            return Err(format!("`{}` alone is not a request", cut(first)));
        }
    };
    match words.next() {
        Some(extra) => Err(format!("`{}` is too much", cut(extra))),
        None => Ok(Some((access, has_cycle))),
    }
}

/// Whether a word says write, and whether a size must follow the address.
fn direction(word: &str) -> Option<(bool, bool)> {
    let is = |name: &str| word.eq_ignore_ascii_case(name);
    match () {
        () if is("R") => Some((false, true)),
        () if is("W") => Some((true, true)),
        () if is("LD") => Some((false, false)),
        () if is("ST") => Some((true, false)),
        () => None,
    }
}

fn address(text: &str) -> Result<u64, String> {
    let hex = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    let digits = |t: &str, radix: u32| !t.is_empty() && t.chars().all(|c| c.is_digit(radix));
    let parsed = match hex {
        Some(hex) if digits(hex, 16) => u64::from_str_radix(hex, 16).ok(),
        None if digits(text, 10) => text.parse().ok(),
        Some(_) | None => return Err(format!("`{}` is not an address", cut(text))),
    };
    parsed.ok_or_else(|| format!("the address `{}` has more than 64 bits", cut(text)))
}

fn size(text: &str) -> Result<u32, String> {
    if text.is_empty() || !text.chars().all(|c| c.is_ascii_digit()) {
        return Err(format!("`{}` is not a size in bytes", cut(text)));
    }
    match text.parse() {
        Ok(0) => Err("a request of 0 bytes".to_owned()),
        Ok(bytes) if bytes <= BYTES_MAX => Ok(bytes),
        _ => Err(format!("a request of {} bytes; at most {BYTES_MAX}", cut(text))),
    }
}

/// At most so much of a word that it can be shown.
fn cut(text: &str) -> String {
    let shown: String = text.chars().take(40).collect();
    if shown.len() < text.len() { format!("{shown}...") } else { shown }
}
