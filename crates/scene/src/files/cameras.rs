//! Camera files: JSON, or a folder as COLMAP, trainers and renderers leave it.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use super::super::camera::check::{MAX_SIZE, principal_doubt};
use super::super::camera::nerfstudio::PLACEMENT_FILE;
use super::super::camera::{CameraFile, Frame, Lens, Placement, Split, colmap, foreign, json};
use super::colmap::{ColmapChoice, ColmapFiles, files_in, model_below};
use super::{FileError, at, other};

/// Largest JSON camera file, bytes.
const MAX_JSON: u64 = 1 << 30;
/// Largest picture whose size is asked for, bytes.
const MAX_PICTURE: u64 = 2 << 30;
/// Bytes in which nearly every picture says its size.
const PICTURE_HEAD: u64 = 64 << 10;
/// Camera files of one list that a folder may have, in the order in which they are looked for.
const LISTS: [&str; 2] = ["cameras.json", "transforms.json"];
/// Those of a set in parts, as Blender's scenes have it, and the name of each part's folder.
const PARTS: [(&str, Split); 2] =
    [("transforms_train.json", Split::Train), ("transforms_test.json", Split::Test)];
/// COLMAP's files, of which the folder is to be given.
const COLMAP_FILES: [&str; 5] = ["cameras", "images", "points3D", "frames", "rigs"];

/// Reads a camera file or a folder with one. `size` serves files that do not say the image size,
/// width and height in pixels; without it the image of each view is asked.
///
/// Where nerfstudio's `dataparser_transforms.json` is beside the cameras or beside `model`, the
/// trained model that they are for, cameras of the data set are put into the frame of the model.
///
/// # Errors
/// [`FileError`]: it cannot be read, is no camera file or is damaged.
pub fn open_cameras(
    path: &Path,
    size: Option<(u32, u32)>,
    model: Option<&Path>,
) -> Result<CameraFile, FileError> {
    let (mut file, folder) = if path.is_dir() {
        (open_folder(path, size)?, path)
    } else {
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
        let folder = parent.unwrap_or(Path::new("."));
        refuse_part(path, folder)?;
        (open_json(path, size)?, folder)
    };
    file.doubts.extend(principal_doubt(&file.cameras));
    place(&mut file, folder, model)?;
    Ok(file)
}

/// Whether a folder has cameras that [`open_cameras`] finds.
pub fn has_cameras(folder: &Path) -> bool {
    let has = |name: &str| folder.join(name).is_file();
    LISTS.iter().any(|name| has(name))
        || has(PARTS[0].0)
        || files_in(folder).is_some()
        || model_below(folder).is_some()
}

/// Refuses one of COLMAP's files, whose folder is a camera file.
fn refuse_part(path: &Path, folder: &Path) -> Result<(), FileError> {
    let part = |of: &Path| Some((of.file_stem()?.to_str()?.to_owned(), of.extension()?.to_owned()));
    let is_part = part(path).is_some_and(|(stem, end)| {
        COLMAP_FILES.contains(&stem.as_str()) && (end == "bin" || end == "txt")
    });
    if is_part && path.is_file() {
        let what = format!("one of COLMAP's files; give their folder, {}", folder.display());
        return Err(other(path.display(), what));
    }
    Ok(())
}

/// What a folder has: COLMAP's files, one list, a list in parts, or COLMAP's files further down.
fn open_folder(folder: &Path, size: Option<(u32, u32)>) -> Result<CameraFile, FileError> {
    if let Some(files) = files_in(folder) {
        return open_colmap(&files);
    }
    let lists = LISTS.iter().map(|name| folder.join(name));
    if let Some(list) = lists.into_iter().find(|path| path.is_file()) {
        return open_json(&list, size);
    }
    if let Some(file) = open_parts(folder, size)? {
        return Ok(file);
    }
    if let Some(ColmapChoice { files, doubt }) = model_below(folder) {
        let mut file = open_colmap(&files)?;
        file.doubts.extend(doubt);
        return Ok(file);
    }
    let what = "no cameras.bin or cameras.txt here or in sparse/0 (COLMAP), no cameras.json, \
                transforms.json or transforms_train.json; give the camera file or its folder";
    Err(other(folder.display(), what))
}

/// A set in parts: every view is of the split that the name of its file says.
fn open_parts(folder: &Path, size: Option<(u32, u32)>) -> Result<Option<CameraFile>, FileError> {
    let mut all: Option<CameraFile> = None;
    for (name, split) in PARTS {
        let path = folder.join(name);
        if !path.is_file() {
            continue;
        }
        let mut part = open_json(&path, size)?;
        for camera in &mut part.cameras {
            camera.split.get_or_insert(split);
        }
        let Some(all) = &mut all else {
            all = Some(part);
            continue;
        };
        let taken: BTreeSet<&str> = all.cameras.iter().map(|c| c.name.as_str()).collect();
        if part.cameras.iter().any(|camera| taken.contains(camera.name.as_str())) {
            // Blender numbers the pictures of every part anew.
            let [(_, first), _] = PARTS;
            rename(all, folder, first);
            rename(&mut part, folder, split);
        }
        all.cameras.append(&mut part.cameras);
        all.lenses.append(&mut part.lenses);
        for warning in part.warnings {
            if !all.warnings.contains(&warning) {
                all.warnings.push(warning);
            }
        }
    }
    Ok(all)
}

/// Puts the folder of its part in front of the name of every view: that of its picture, where it
/// is there.
fn rename(file: &mut CameraFile, folder: &Path, split: Split) {
    for camera in &mut file.cameras {
        let mut name = format!("{}/{}", split.name(), camera.name);
        let with_ending = format!("{name}.png");
        if folder.join(&with_ending).is_file() {
            name = with_ending;
        }
        if let Some(lens) = file.lenses.remove(&camera.name) {
            let _: Option<Lens> = file.lenses.insert(name.clone(), lens);
        }
        camera.name = name;
    }
}

/// A JSON camera file. Sizes that it does not say are those of its images.
fn open_json(path: &Path, size: Option<(u32, u32)>) -> Result<CameraFile, FileError> {
    let text = read_text(path)?;
    let size_of = |file_path: &str| size.or_else(|| image_size_beside(path, file_path));
    json::read_sized(&text, &size_of).map_err(at(path.display()))
}

/// Puts cameras of a data set into the frame of the model that nerfstudio trained.
fn place(file: &mut CameraFile, folder: &Path, model: Option<&Path>) -> Result<(), FileError> {
    let Frame::Data(applied) = file.frame else { return Ok(()) };
    let beside_model = model.and_then(|path| {
        if path.is_dir() { Some(path) } else { path.parent() }.map(|p| p.join(PLACEMENT_FILE))
    });
    let places = [beside_model, Some(folder.join(PLACEMENT_FILE))];
    let Some(path) = places.into_iter().flatten().find(|path| path.is_file()) else {
        return Ok(());
    };
    let placement = Placement::read(&read_text(&path)?).map_err(at(path.display()))?;
    let placement = placement.after(&applied);
    file.cameras.iter_mut().for_each(|camera| *camera = placement.of(camera));
    file.frame = Frame::Model;
    file.warnings.push(format!(
        "cameras are turned, moved and scaled into the frame of the model, as {} says; take it \
         away if the model is in that of the cameras",
        path.display()
    ));
    Ok(())
}

fn read_text(path: &Path) -> Result<String, FileError> {
    let mut bytes = Vec::new();
    open(path)?.take(MAX_JSON + 1).read_to_end(&mut bytes).map_err(at(path.display()))?;
    if bytes.len() as u64 > MAX_JSON {
        return Err(other(path.display(), "is over 1 GiB; this is not a camera file"));
    }
    if let Some(error) = foreign::by_content(&bytes) {
        return Err(at(path.display())(error));
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

fn open_colmap(files: &ColmapFiles) -> Result<CameraFile, FileError> {
    let ColmapFiles { folder, end } = files;
    let part = |name: &str| open(&folder.join(format!("{name}.{end}")));
    let (cameras, images) = (part("cameras")?, part("images")?);
    let file = match *end {
        "bin" => colmap::read_binary(cameras, images),
        _ => colmap::read_text(cameras, images),
    };
    file.map_err(at(folder.display()))
}

/// The size of the image that a `transforms.json` names; Blender leaves its extension out.
fn image_size_beside(file: &Path, file_path: &str) -> Option<(u32, u32)> {
    let folder = file.parent()?;
    let candidates = ["", ".png", ".jpg"].map(|end| folder.join(format!("{file_path}{end}")));
    let size = candidates.into_iter().filter(|p| p.is_file()).find_map(|p| picture_size(&p))?;
    (1..=MAX_SIZE).contains(&size.0).then_some(size)
}

fn picture_size(path: &PathBuf) -> Option<(u32, u32)> {
    let mut file = File::open(path).ok()?;
    let mut bytes = Vec::new();
    (&mut file).take(PICTURE_HEAD).read_to_end(&mut bytes).ok()?;
    if let Ok(size) = powergs_pixels::size(&bytes) {
        return Some(size);
    }
    file.take(MAX_PICTURE).read_to_end(&mut bytes).ok()?;
    powergs_pixels::size(&bytes).ok()
}
