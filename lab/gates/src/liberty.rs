//! Liberty (`.lib`): cells of a standard-cell library, as far as gates and energy need them.
//!
//! [`unpack`] takes the bytes of a file, plain or gzip; [`tree`] knows the syntax, [`library`] the
//! meaning, and [`table`] the look-up. Nothing of a library is ever written out again but names of
//! cells and numbers for circuits of our own.

pub mod library;
pub mod table;
pub mod tree;

use std::io::Read;

use thiserror::Error;

/// Bytes of a library that are read at most, unpacked.
const MAX_BYTES: u64 = 256 << 20;

/// A Liberty file that cannot be used.
#[derive(Debug, Error)]
#[error("{file}:{line}: {reason}")]
pub struct LibertyError {
    /// Name of the file as it was given.
    pub file: String,
    /// Line, from 1; 0 where it concerns the file.
    pub line: usize,
    /// What is wrong, and what to do about it.
    pub reason: String,
}

/// The text of a file, which may be packed with gzip.
///
/// # Errors
/// When it is larger than 256 MiB unpacked, damaged, or not UTF-8.
pub fn unpack(file: &str, bytes: &[u8]) -> Result<String, LibertyError> {
    let refuse = |reason: String| LibertyError { file: file.to_owned(), line: 0, reason };
    let too_large = || refuse("larger than 256 MiB unpacked: no library of standard cells".into());
    let unpacked = if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut unpacked = Vec::new();
        let mut reader = flate2::read::MultiGzDecoder::new(bytes).take(MAX_BYTES + 1);
        let read = reader.read_to_end(&mut unpacked);
        read.map_err(|error| refuse(format!("damaged gzip stream ({error}); fetch it again")))?;
        unpacked
    } else {
        if bytes.len() as u64 > MAX_BYTES {
            return Err(too_large());
        }
        bytes.to_vec()
    };
    if unpacked.len() as u64 > MAX_BYTES {
        return Err(too_large());
    }
    String::from_utf8(unpacked).map_err(|_| refuse("not UTF-8 text: no Liberty file".into()))
}
