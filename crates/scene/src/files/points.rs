//! Point clouds by path.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::super::camera::colmap;
use super::super::{Input, PointCloud, ply};
use super::colmap::{ColmapFiles, files_in, model_below};
use super::{FileError, at};

/// The points of the COLMAP model whose cameras [`open_cameras`](super::open_cameras) finds in a
/// folder; `None` where there is no such model, or none with points.
///
/// # Errors
/// [`FileError`]: the points cannot be read.
pub fn open_colmap_points(folder: &Path) -> Result<Option<PointCloud>, FileError> {
    let files = files_in(folder).or_else(|| model_below(folder).map(|choice| choice.files));
    let Some(ColmapFiles { folder, end }) = files else { return Ok(None) };
    let path = folder.join(format!("points3D.{end}"));
    if !path.is_file() {
        return Ok(None);
    }
    let file = BufReader::new(File::open(&path).map_err(at(path.display()))?);
    let points = match end {
        "bin" => colmap::read_points_binary(file),
        _ => colmap::read_points_text(file),
    };
    points.map(Some).map_err(at(folder.display()))
}

/// The points of a PLY: columns x, y, z, and red, green, blue where it has them.
///
/// # Errors
/// [`FileError`]: it cannot be read, or is no such PLY.
pub fn open_point_ply(path: &Path) -> Result<PointCloud, FileError> {
    let file = File::open(path).map_err(at(path.display()))?;
    let len = file.metadata().map_err(at(path.display()))?.len();
    let input = Input { reader: Box::new(BufReader::new(file)), len };
    ply::read_points(input).map_err(at(path.display()))
}
