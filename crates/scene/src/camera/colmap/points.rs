//! COLMAP's `points3D`, binary and text: the points that a training starts from.

use std::io::BufRead;

use super::super::CameraError;
use super::binary::BinarySource;
use super::text::ColmapLines;
use crate::PointCloud;

/// Bytes of an element of a track in `points3D.bin`: an image id and the index of a 2D point.
const TRACK_BYTES: u64 = 8;

/// Reads `points3D.bin`. Memory is in proportion to the points that are really there; tracks are
/// skipped.
///
/// # Errors
/// [`CameraError::Binary`]: a damaged file, or a point that is not finite.
pub fn read_points_binary(points: impl BufRead) -> Result<PointCloud, CameraError> {
    let mut source = BinarySource::new(points, "points3D.bin");
    let count = source.u64("the number of points")?;
    let mut cloud = PointCloud::default();
    for _ in 0..count {
        source.u64("a point id")?;
        let mut place = [0.0; 3];
        for slot in &mut place {
            *slot = source.f64("a point")?;
        }
        let colour = source.bytes::<3>("a colour")?;
        source.f64("the error of a point")?;
        let track = source.u64("the length of a track")?;
        source.skip(track, TRACK_BYTES, "elements of a track")?;
        if !is_usable(&place) {
            return Err(source.fault(format!("point {place:?} is not a place; leave it out")));
        }
        cloud.push(place, colour);
    }
    source.end("points")?;
    Ok(cloud)
}

/// Reads `points3D.txt`.
///
/// # Errors
/// [`CameraError::Text`]: a line that cannot be read, or a point that is not finite.
pub fn read_points_text(points: impl BufRead) -> Result<PointCloud, CameraError> {
    let mut lines = ColmapLines::new(points, "points3D.txt");
    let mut cloud = PointCloud::default();
    while let Some(line) = lines.next_entry()? {
        let mut words = line.split_whitespace();
        let _id: u64 = lines.parse(words.next(), "a point id")?;
        let mut place = [0.0; 3];
        for slot in &mut place {
            *slot = lines.parse(words.next(), "three coordinates")?;
        }
        let mut colour = [0; 3];
        for slot in &mut colour {
            *slot = lines.parse(words.next(), "a colour of three numbers from 0 to 255")?;
        }
        if !is_usable(&place) {
            return Err(lines.fault(format!("point {place:?} is not a place; leave it out")));
        }
        cloud.push(place, colour);
    }
    Ok(cloud)
}

/// Whether a place is finite in the numbers of a model too.
fn is_usable(place: &[f64; 3]) -> bool {
    place.iter().all(|v| (*v as f32).is_finite())
}
