//! COLMAP's files in a folder, or several of its models in numbered folders: parts of a scene that
//! it could not join, each in a frame of its own.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Where models are, numbered or not, below the folder of a data set.
const PARENTS: [&str; 3] = ["sparse", "colmap/sparse", "."];

/// The files of a model.
#[derive(Debug, Clone)]
pub(super) struct ColmapFiles {
    /// Their folder.
    pub folder: PathBuf,
    /// Their ending.
    pub end: &'static str,
}

/// A model, and what to know where there are others.
pub(super) struct ColmapChoice {
    pub files: ColmapFiles,
    /// Which one it is of which, one sentence.
    pub doubt: Option<String>,
}

/// COLMAP's files in a folder itself, if they are there.
pub(super) fn files_in(folder: &Path) -> Option<ColmapFiles> {
    let has = |end: &&str| folder.join(format!("cameras.{end}")).is_file();
    let end = ["bin", "txt"].into_iter().find(has)?;
    Some(ColmapFiles { folder: folder.to_owned(), end })
}

/// The model below a folder that has none itself: of several that with most images.
pub(super) fn model_below(folder: &Path) -> Option<ColmapChoice> {
    PARENTS.iter().find_map(|parent| {
        let parent = if *parent == "." { folder.to_owned() } else { folder.join(parent) };
        match numbered(&parent).as_slice() {
            [] => {
                let files = files_in(&parent)?;
                Some(ColmapChoice { files, doubt: None })
            }
            [NumberedModel { files, .. }] => {
                Some(ColmapChoice { files: files.clone(), doubt: None })
            }
            models => Some(largest(&parent, models)),
        }
    })
}

/// A model in a folder whose name is a number.
struct NumberedModel {
    number: u32,
    files: ColmapFiles,
}

/// The numbered models in a folder, in order.
fn numbered(parent: &Path) -> Vec<NumberedModel> {
    let Ok(entries) = fs::read_dir(parent) else { return Vec::new() };
    let model = |path: PathBuf| {
        let number = path.file_name()?.to_str()?.parse().ok()?;
        Some(NumberedModel { number, files: files_in(&path)? })
    };
    let mut models: Vec<_> = entries.filter_map(|entry| model(entry.ok()?.path())).collect();
    models.sort_by_key(|model| model.number);
    models
}

/// That with most images, of several the first. One whose images cannot be counted has none.
fn largest(parent: &Path, models: &[NumberedModel]) -> ColmapChoice {
    let counts: Vec<u64> = models.iter().map(|m| m.files.images().unwrap_or(0)).collect();
    let most = counts.iter().copied().max().unwrap_or(0);
    let at = counts.iter().position(|count| *count == most).unwrap_or(0);
    let each = models.iter().zip(&counts).map(|(m, count)| format!("{}: {count}", m.number));
    let each = each.collect::<Vec<_>>().join(", ");
    let doubt = format!(
        "{} holds {} models of COLMAP, each in a frame of its own (views of {each}): {} is read, \
         which has most; give the folder of another to read that",
        parent.display(),
        models.len(),
        models[at].number
    );
    ColmapChoice { files: models[at].files.clone(), doubt: Some(doubt) }
}

impl ColmapFiles {
    /// Images, as their file says; of text its lines are counted, two for each image.
    fn images(&self) -> Option<u64> {
        let mut file =
            BufReader::new(File::open(self.folder.join(format!("images.{}", self.end))).ok()?);
        if self.end == "bin" {
            let mut count = [0; 8];
            file.read_exact(&mut count).ok()?;
            return Some(u64::from_le_bytes(count));
        }
        let (mut lines, mut line) = (0_u64, Vec::new());
        while file.read_until(b'\n', &mut line).ok()? > 0 {
            lines += u64::from(!line.starts_with(b"#"));
            line.clear();
        }
        Some(lines.div_ceil(2))
    }
}
