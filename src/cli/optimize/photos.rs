//! Photo files: found by the names of views, checked, composited.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::super::{Context, Exit, Failure, OrExit, out, picture_file};
use powergs_base::picture::Picture;
use powergs_optimize::photos::{Photo, PhotoError};
use powergs_optimize::references::Reference;
use powergs_pixels::{Decoded, Limits};
use powergs_scene::Camera;
use powergs_scene::camera::Lens;
use powergs_scene::files::has_cameras;

/// Endings of photo files, lower-case.
const ENDINGS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];
/// Those of pictures that cameras and phones make and that are not read.
const OTHER_ENDINGS: [&str; 12] =
    ["tif", "tiff", "heic", "heif", "avif", "jxl", "exr", "bmp", "dng", "cr2", "nef", "arw"];
/// The largest photo that is read.
const LIMITS: Limits = Limits { side: u32::MAX, bytes: 1 << 30 };
/// How many photos or views an error names.
const NAMED: usize = 5;

/// The folder whose cameras belong to a folder of photos.
pub fn camera_file(folder: &Path) -> Option<PathBuf> {
    let mut folders = [Some(folder), folder.parent()].into_iter().flatten();
    folders.find(|folder| has_cameras(folder)).map(Path::to_path_buf)
}

/// The photos of a folder, by name.
pub struct PhotoFolder {
    folder: PathBuf,
    /// Files with the ending of a photo in the folder or its `images`.
    files: BTreeMap<String, PathBuf>,
    /// Endings of pictures that are not read, and how many there are.
    others: BTreeMap<String, usize>,
}

impl PhotoFolder {
    /// Lists a folder.
    ///
    /// # Errors
    /// Exit code 3: it cannot be read.
    pub fn open(folder: &Path) -> Result<PhotoFolder, Failure> {
        let (mut files, mut others) = (BTreeMap::new(), BTreeMap::new());
        for place in [folder.to_path_buf(), folder.join("images")] {
            if place != folder && !place.is_dir() {
                continue;
            }
            let entries = fs::read_dir(&place).or_exit(Exit::BadInput, place.display())?;
            for entry in entries {
                let path = entry.or_exit(Exit::BadInput, place.display())?.path();
                let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
                let Some(name) = name else { continue };
                if ends_as_photo(&name) {
                    files.entry(name).or_insert(path);
                } else if let Some(end) = ending(&name, &OTHER_ENDINGS) {
                    *others.entry(end).or_insert(0) += 1;
                }
            }
        }
        Ok(PhotoFolder { folder: folder.to_owned(), files, others })
    }

    /// The file of each view, in order.
    ///
    /// # Errors
    /// Exit code 3: views without a photo, or two with one.
    pub fn of_views(&self, cameras: &[Camera]) -> Result<Vec<PathBuf>, Failure> {
        let found: Vec<Option<PathBuf>> = cameras.iter().map(|c| self.of_view(&c.name)).collect();
        let missing = cameras.iter().zip(&found).filter(|(_, file)| file.is_none());
        let missing: Vec<&str> = missing.map(|(camera, _)| camera.name.as_str()).collect();
        if !missing.is_empty() {
            return Err(self.missing(&missing, cameras.len()));
        }
        let files: Vec<PathBuf> = found.into_iter().flatten().collect();
        let mut taken: BTreeMap<&Path, &str> = BTreeMap::new();
        for (file, camera) in files.iter().zip(cameras) {
            if let Some(other) = taken.insert(file, &camera.name) {
                let what = format!(
                    "{}: two cameras have this photo, {other} and {}; take one of them out of the \
                     camera file, or give each view a photo of its name",
                    file.display(),
                    camera.name
                );
                return Err(Failure::new(Exit::BadInput, what));
            }
        }
        Ok(files)
    }

    fn missing(&self, missing: &[&str], all: usize) -> Failure {
        let have: Vec<&str> = self.files.keys().map(String::as_str).collect();
        let there = match have.as_slice() {
            [] if !self.others.is_empty() => {
                let kinds = self.others.iter().map(|(end, n)| format!("{n} .{end}"));
                let kinds = kinds.collect::<Vec<_>>().join(" and ");
                format!("there are {kinds}, which are not read: convert them to PNG or JPEG")
            }
            [] => "there is none".to_owned(),
            have => format!("there are {}: {}", have.len(), listed(have)),
        };
        let what = format!(
            "{}: {} of {all} photos are missing: {}; {there}; views and photos go by their names",
            self.folder.display(),
            missing.len(),
            listed(missing),
        );
        Failure::new(Exit::BadInput, what)
    }

    /// The photo of a view: the file that it names, else one of its name in another format.
    fn of_view(&self, name: &str) -> Option<PathBuf> {
        let path = Path::new(name);
        // COLMAP names photos of several cameras by folders.
        let is_inside = path.components().all(|part| matches!(part, Component::Normal(_)));
        let places = [self.folder.join(name), self.folder.join("images").join(name)];
        let exact = || places.into_iter().find(|path| path.is_file());
        if let Some(path) = is_inside.then(exact).flatten() {
            return Some(path);
        }
        let name = path.file_name()?.to_string_lossy();
        let stem = stem(&name);
        let listed = self.files.get(&*name);
        listed
            .or_else(|| self.files.iter().find(|(n, _)| self::stem(n) == stem).map(|f| f.1))
            .cloned()
    }

    /// Says which photos have no camera.
    pub fn note_unused(&self, used: &[PathBuf], context: &Context) {
        let is_unused = |(_, path): &(&String, &PathBuf)| !used.contains(path);
        let unused = self.files.iter().filter(is_unused);
        let unused: Vec<&str> = unused.map(|(name, _)| name.as_str()).collect();
        if !unused.is_empty() && !context.global.quiet {
            let (n, all) = (unused.len(), self.files.len());
            let what = format!("warning: {n} of {all} photos have no camera and are not used");
            out::complain(format!("{what}: {}", listed(&unused)));
        }
    }
}

fn ends_as_photo(name: &str) -> bool {
    ending(name, &ENDINGS).is_some()
}

/// The ending of a name, in small letters, if it is one of these.
fn ending(name: &str, of: &[&str]) -> Option<String> {
    let end = name.rsplit_once('.')?.1.to_lowercase();
    of.contains(&end.as_str()).then_some(end)
}

/// A name without the ending of a photo.
fn stem(name: &str) -> &str {
    if ends_as_photo(name) { name.rsplit_once('.').map_or(name, |(stem, _)| stem) } else { name }
}

fn listed(names: &[&str]) -> String {
    let more = if names.len() > NAMED { ", …" } else { "" };
    format!("{}{more}", names[..names.len().min(NAMED)].join(", "))
}

/// The photos of views: `files` were taken with `cameras`, through `lenses` by the names of the
/// views; `wanted` is the size of the views, where it is asked for.
///
/// # Errors
/// Exit code 2: a size that the photos do not have; 3: a file that is no photo, or not that of its
/// camera.
pub fn measured(
    files: &[PathBuf],
    cameras: &[Camera],
    lenses: &BTreeMap<String, Lens>,
    wanted: Option<(u32, u32)>,
) -> Result<Vec<Photo>, Failure> {
    let of = |(file, camera): (&PathBuf, &Camera)| {
        // The size is looked at first: cameras are of a believable size, pictures need not be.
        let bytes = bytes(file)?;
        let size = powergs_pixels::size(&bytes).or_exit(Exit::BadInput, file.display())?;
        let photo = Photo::new(size, camera, lenses.get(&camera.name), wanted);
        photo.map_err(|error| {
            let place = file.display();
            match error {
                PhotoError::Size { wanted: (width, height), .. } => {
                    Failure::new(Exit::Usage, format!("--size {width}x{height}: {place}: {error}"))
                }
                PhotoError::Aspect { .. } | PhotoError::Lens => {
                    Failure::new(Exit::BadInput, format!("{place}: {error}"))
                }
            }
        })
    };
    files.iter().zip(cameras).map(of).collect()
}

fn bytes(file: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = picture_file::bytes(file).or_exit(Exit::BadInput, file.display())?;
    if is_cut_jpeg(&bytes) {
        let what = format!("{}: the JPEG ends too early; copy it anew", file.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    Ok(bytes)
}

/// The reference image that a photo is.
///
/// # Errors
/// Exit code 3: a file that cannot be read.
pub fn reference(file: &Path, photo: &Photo, background: [f32; 3]) -> Result<Reference, Failure> {
    let image = powergs_pixels::decode(&bytes(file)?, LIMITS);
    let image = image.or_exit(Exit::BadInput, file.display())?;
    if (image.width, image.height) != photo.size {
        let what = format!("{}: was changed while it was read; start again", file.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    Ok(photo.reference(&composited(&image, background)))
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
