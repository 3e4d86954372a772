//! What the folder of a training run says of its model: the background that it was trained over.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The arguments of INRIA's trainer and its relatives, as Python prints them.
const ARGUMENTS: &str = "cfg_args";
/// Largest such file, bytes.
const MAX_ARGUMENTS: u64 = 1 << 20;
/// Folders above a file in which the run may be: `point_cloud/iteration_30000` and the run itself.
const ABOVE: usize = 3;

/// The background that a run was trained over.
#[derive(Debug, Clone, PartialEq)]
pub struct RunBackground {
    /// sRGB, 0 to 1.
    pub colour: [f32; 3],
    /// The file that says so.
    pub file: PathBuf,
}

/// The background of the training run that `path`, a model, a camera file or a folder, belongs to;
/// `None` where it is in none, or where that does not say.
pub fn background_of(path: &Path) -> Option<RunBackground> {
    let own = if path.is_dir() { Some(path) } else { path.parent() };
    // The parent of a bare name is empty, and that is the working folder.
    let folders = own.into_iter().flat_map(Path::ancestors).take(ABOVE);
    let mut files = folders.map(|folder| folder.join(ARGUMENTS));
    let file = files.find(|file| file.is_file())?;
    let mut text = Vec::new();
    File::open(&file).ok()?.take(MAX_ARGUMENTS).read_to_end(&mut text).ok()?;
    let colour = colour(&String::from_utf8_lossy(&text))?;
    Some(RunBackground { colour, file })
}

/// The colour that `Namespace(..., white_background=True, ...)` says.
fn colour(arguments: &str) -> Option<[f32; 3]> {
    let (before, value) = arguments.split_once("white_background=")?;
    // Another argument may end in the same words.
    if before.ends_with(|c: char| c.is_alphanumeric() || c == '_') {
        return None;
    }
    let word = value.split(|c: char| !c.is_alphanumeric()).next()?;
    match word {
        "True" => Some([1.0; 3]),
        "False" => Some([0.0; 3]),
        _ => None,
    }
}
