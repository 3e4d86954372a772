//! Weights of LPIPS from the user's file.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{Exit, Failure, OrExit};
use powergs_quality::Lpips;

/// The largest file; the whole of VGG16 takes 528 MiB.
const BYTES_MAX: u64 = 1 << 30;

/// Reads the weights; also a hash of the file.
///
/// # Errors
/// Exit code 3: the file cannot be read, or holds no weights that can be used.
pub fn read(path: &Path) -> Result<(Lpips, u128), Failure> {
    let name = path.display();
    let file = File::open(path).or_exit(Exit::BadInput, &name)?;
    let mut bytes = Vec::new();
    file.take(BYTES_MAX + 1).read_to_end(&mut bytes).or_exit(Exit::BadInput, &name)?;
    if bytes.len() as u64 > BYTES_MAX {
        let what = format!("{name}: more than 1 GiB; weights of LPIPS take 10 to 60 MB");
        return Err(Failure::new(Exit::BadInput, what));
    }
    let lpips = Lpips::from_safetensors(&bytes).or_exit(Exit::BadInput, &name)?;
    Ok((lpips, xxhash_rust::xxh3::xxh3_128(&bytes)))
}
