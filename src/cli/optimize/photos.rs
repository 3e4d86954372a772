//! Photos as references: found by the names of views, checked, composited, averaged down.

use std::path::{Path, PathBuf};

use super::super::{Exit, Failure, OrExit, picture_file};
use powergs_base::picture::Picture;
use powergs_optimize::references::Reference;
use powergs_pixels::{Decoded, Limits};
use powergs_scene::Camera;

/// Endings that are tried where the name of a view has none.
const ENDINGS: [&str; 5] = ["", ".png", ".jpg", ".jpeg", ".webp"];
/// The largest photo that is read.
const LIMITS: Limits = Limits { side: u32::MAX, bytes: 1 << 30 };
/// How many missing photos an error names.
const NAMED: usize = 5;

/// The camera file that belongs to a folder of photos.
pub fn camera_file(folder: &Path) -> Option<PathBuf> {
    let names = ["cameras.json", "transforms.json"];
    let folders = [Some(folder), folder.parent()];
    folders
        .into_iter()
        .flatten()
        .flat_map(|f| names.map(|name| f.join(name)))
        .find(|path| path.is_file())
}

/// Gives `each` the photo of every view in turn, in the size of `cameras`. `full` are the same
/// views as the camera file has them: photos must have that size.
///
/// # Errors
/// Exit code 3: photos that are missing, unreadable, or of another size than the camera says.
pub fn load(
    folder: &Path,
    full: &[Camera],
    cameras: &[Camera],
    background: [f32; 3],
    mut each: impl FnMut(Reference) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let files: Vec<Option<PathBuf>> = full.iter().map(|c| file_of(folder, &c.name)).collect();
    let missing: Vec<&str> = full
        .iter()
        .zip(&files)
        .filter(|(_, f)| f.is_none())
        .map(|(c, _)| c.name.as_str())
        .collect();
    if !missing.is_empty() {
        let names = missing[..missing.len().min(NAMED)].join(", ");
        let more = if missing.len() > NAMED { ", …" } else { "" };
        let what = format!(
            "{}: {} of {} photos are missing: {names}{more}; views and photos go by their names",
            folder.display(),
            missing.len(),
            full.len()
        );
        return Err(Failure::new(Exit::BadInput, what));
    }
    for ((file, camera), wanted) in files.iter().flatten().zip(full).zip(cameras) {
        each(Reference::new(&photo(file, camera, wanted, background)?))?;
    }
    Ok(())
}

fn file_of(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = Path::new(name).file_name()?.to_string_lossy().into_owned();
    let folders = [folder.to_path_buf(), folder.join("images")];
    folders
        .iter()
        .flat_map(|folder| ENDINGS.iter().map(move |end| (folder, end)))
        .map(|(folder, end)| folder.join(format!("{name}{end}")))
        .find(|path| path.is_file())
}

fn photo(
    file: &Path,
    camera: &Camera,
    wanted: &Camera,
    background: [f32; 3],
) -> Result<Picture, Failure> {
    let bytes = picture_file::bytes(file).or_exit(Exit::BadInput, file.display())?;
    if is_cut_jpeg(&bytes) {
        let what = format!("{}: the JPEG ends too early; copy it anew", file.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    // The size is looked at first: cameras are of a believable size, pictures need not be.
    let size = powergs_pixels::size(&bytes).or_exit(Exit::BadInput, file.display())?;
    if size != (camera.width, camera.height) {
        let what = format!(
            "{}: is {}x{}, the camera says {}x{}; give the photos that the poses were made for",
            file.display(),
            size.0,
            size.1,
            camera.width,
            camera.height
        );
        return Err(Failure::new(Exit::BadInput, what));
    }
    let image = powergs_pixels::decode(&bytes, LIMITS).or_exit(Exit::BadInput, file.display())?;
    let picture = composited(&image, background);
    Ok(if size == (wanted.width, wanted.height) {
        picture
    } else {
        averaged(&picture, wanted.width, wanted.height)
    })
}

/// Whether a JPEG is cut off: the decoder would accept it and make the rest grey. Some cameras
/// write a few bytes after the end.
fn is_cut_jpeg(bytes: &[u8]) -> bool {
    let tail = &bytes[bytes.len().saturating_sub(4096)..];
    bytes.starts_with(&[0xff, 0xd8]) && !tail.windows(2).any(|w| w == [0xff, 0xd9])
}

/// The image over the background.
fn composited(image: &Decoded, background: [f32; 3]) -> Picture {
    let (width, height) = (image.width, image.height);
    let over = |p: [f32; 4]| {
        let mut out = [0.0; 3];
        for (c, value) in out.iter_mut().enumerate() {
            *value = p[c] * p[3] + background[c] * (1.0 - p[3]);
        }
        out
    };
    let pixels = image.rgba().map(over).collect();
    Picture { width, height, pixels }
}

/// A smaller picture: every pixel is the mean over the area that it covers.
pub fn averaged(picture: &Picture, width: u32, height: u32) -> Picture {
    let columns = weights(picture.width, width);
    let rows = weights(picture.height, height);
    let stride = picture.width as usize;
    let mut narrow = Vec::with_capacity(width as usize * picture.height as usize);
    for line in picture.pixels.chunks_exact(stride.max(1)) {
        narrow.extend(columns.iter().map(|(first, w)| mean(w, |i| line[first + i])));
    }
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for (first, w) in &rows {
        for x in 0..width as usize {
            pixels.push(mean(w, |i| narrow[(first + i) * width as usize + x]));
        }
    }
    Picture { width, height, pixels }
}

fn mean(weights: &[f32], at: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for (i, weight) in weights.iter().enumerate() {
        for (s, v) in sum.iter_mut().zip(at(i)) {
            *s += weight * v;
        }
    }
    sum
}

/// For each new pixel along a side: the first old one that it covers, and the share of each.
fn weights(old: u32, new: u32) -> Vec<(usize, Vec<f32>)> {
    let step = f64::from(old) / f64::from(new);
    (0..new)
        .map(|i| {
            let (from, to) = (f64::from(i) * step, f64::from(i + 1) * step);
            let first = from.floor() as u32;
            let last = (to.ceil() as u32).min(old).max(first + 1);
            let covered = |k: u32| (to.min(f64::from(k + 1)) - from.max(f64::from(k))).max(0.0);
            let shares: Vec<f64> = (first..last).map(covered).collect();
            let total: f64 = shares.iter().sum();
            (first as usize, shares.iter().map(|s| (s / total) as f32).collect())
        })
        .collect()
}
