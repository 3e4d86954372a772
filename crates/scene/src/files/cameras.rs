//! Camera files: JSON, or a folder of COLMAP.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use super::super::camera::check::MAX_SIZE;
use super::super::camera::{CameraError, CameraFile, colmap, json};
use super::{FileError, at, other};

/// Largest JSON camera file, bytes.
const MAX_JSON: u64 = 1 << 30;
/// Largest picture whose size is asked for, bytes.
const MAX_PICTURE: u64 = 2 << 30;

/// Reads a camera file or a COLMAP folder. `size` serves files that do not say the image size,
/// width and height in pixels; without it the first image beside the file is asked.
///
/// # Errors
/// [`FileError`]: it cannot be read, is no camera file or is damaged.
pub fn open_cameras(path: &Path, size: Option<(u32, u32)>) -> Result<CameraFile, FileError> {
    if path.is_dir() {
        return open_colmap(path);
    }
    let text = read_text(path)?;
    let file = match json::read(&text, size) {
        Err(CameraError::NoSize { view, file_path }) => match image_size_beside(path, &file_path) {
            Some(size) => json::read(&text, Some(size)),
            None => Err(CameraError::NoSize { view, file_path }),
        },
        other => other,
    };
    file.map_err(at(path.display()))
}

fn read_text(path: &Path) -> Result<String, FileError> {
    let mut bytes = Vec::new();
    open(path)?.take(MAX_JSON + 1).read_to_end(&mut bytes).map_err(at(path.display()))?;
    if bytes.len() as u64 > MAX_JSON {
        return Err(other(path.display(), "is over 1 GiB; this is not a camera file"));
    }
    String::from_utf8(bytes).map_err(|e| {
        let valid = e.utf8_error().valid_up_to();
        let todo = "give a JSON camera file or a COLMAP folder";
        other(path.display(), format!("byte {valid}: not UTF-8 text; {todo}"))
    })
}

fn open(path: &Path) -> Result<BufReader<File>, FileError> {
    Ok(BufReader::new(File::open(path).map_err(at(path.display()))?))
}

/// COLMAP in `folder`, or in the `sparse/0` under it.
fn open_colmap(folder: &Path) -> Result<CameraFile, FileError> {
    for folder in [folder.to_path_buf(), folder.join("sparse/0"), folder.join("sparse")] {
        for end in ["bin", "txt"] {
            let cameras = folder.join(format!("cameras.{end}"));
            if cameras.is_file() {
                let images = folder.join(format!("images.{end}"));
                let (cameras, images) = (open(&cameras)?, open(&images)?);
                let file = match end {
                    "bin" => colmap::read_binary(cameras, images),
                    _ => colmap::read_text(cameras, images),
                };
                return file.map_err(at(folder.display()));
            }
        }
    }
    let what = "no cameras.bin or cameras.txt here or in sparse/0; give the COLMAP model folder";
    Err(other(folder.display(), what))
}

/// The size of the image that a `transforms.json` names; Blender leaves its extension out.
fn image_size_beside(file: &Path, file_path: &str) -> Option<(u32, u32)> {
    let folder = file.parent()?;
    let candidates = ["", ".png", ".jpg"].map(|end| folder.join(format!("{file_path}{end}")));
    let size_of = |path: &Path| {
        let mut bytes = Vec::new();
        File::open(path).ok()?.take(MAX_PICTURE).read_to_end(&mut bytes).ok()?;
        powergs_pixels::size(&bytes).ok()
    };
    let size = candidates.iter().filter(|p| p.is_file()).find_map(|p| size_of(p))?;
    (1..=MAX_SIZE).contains(&size.0).then_some(size)
}
