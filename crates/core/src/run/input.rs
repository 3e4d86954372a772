//! Hashes of the files that a run was made of.

use std::io::{self, Read};
use std::path::Path;

use xxhash_rust::xxh3::Xxh3;

/// A file that results depend on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// What it is: `trace`, `machine`, `energy`, `dram`, `display`.
    pub role: &'static str,
    /// Its name without folders: the same file elsewhere gives the same report.
    pub name: String,
    /// Its length, bytes.
    pub bytes: u64,
    /// xxh3, 128 bits, of its contents.
    pub xxh3: u128,
}

impl Input {
    /// Hashes everything that `contents` gives; `name` may be a path.
    ///
    /// # Errors
    /// Those of reading.
    pub fn hash(role: &'static str, name: &str, contents: &mut impl Read) -> io::Result<Input> {
        let (mut hash, mut bytes) = (Xxh3::new(), 0u64);
        let mut buffer = vec![0u8; 1 << 18];
        loop {
            let n = contents.read(&mut buffer)?;
            if n == 0 {
                break;
            }
            hash.update(&buffer[..n]);
            bytes += n as u64;
        }
        Ok(Input { role, name: file_name(name), bytes, xxh3: hash.digest128() })
    }

    /// The hash of a text in memory.
    pub fn of_text(role: &'static str, name: &str, text: &str) -> Input {
        Input::hash(role, name, &mut text.as_bytes()).expect("memory can be read")
    }
}

fn file_name(path: &str) -> String {
    let path = Path::new(path);
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
