//! antimatter15's `.splat`: rows of 32 bytes, no header.
//!
//! A row is `mean: 3 f32, scale: 3 f32 (linear), colour: 3 u8, opacity: u8, rotation: 4 u8`, with
//! the quaternion (w, x, y, z) stored as `128 + 128 q`. There is no magic: rows are recognised by
//! being plausible.

use std::io::Read;

use super::Gaussians;
use super::convert::{dc, log_scale, logit};
use super::error::{DAMAGED, SceneError};
use super::input::{Input, check_count};
use super::read::{Format, Model};

const ROW: usize = 32;
/// Rows that are read at a time.
const BLOCK: usize = 4096;
/// Coordinates and scales of the first rows are below this in every real file.
const FAR: f32 = 1e7;

/// Whether `head`, the first bytes of a file of `len`, looks like rows: whole ones, with finite
/// means, scales that are not negative, and rotations of length 1 within their quantisation.
pub(super) fn plausible(head: &[u8], len: u64) -> bool {
    let sane = |row: &[u8]| {
        let v = floats(row);
        v.iter().all(|x| x.abs() < FAR && (*x == 0.0 || x.abs() > 1e-30))
            && v[3..].iter().all(|s| *s >= 0.0)
            && (0.8..1.2).contains(&rotation(row).iter().map(|c| c * c).sum::<f32>().sqrt())
    };
    len >= ROW as u64 && len.is_multiple_of(ROW as u64) && {
        let rows = head.chunks_exact(ROW);
        let n = rows.len();
        // A trained model may hold a few broken rows; a file of another kind holds no sane ones.
        rows.filter(|row| sane(row)).count() * 8 >= n * 7
    }
}

/// Reads the rows.
pub(super) fn read(mut input: Input<'_>) -> Result<Model, SceneError> {
    if !input.len.is_multiple_of(ROW as u64) {
        let what = format!("{} bytes are not a whole number of 32-byte rows", input.len);
        return Err(SceneError::truncated("rows", what));
    }
    let count = check_count("rows", input.len / ROW as u64, u64::MAX)?;
    let mut scene = Gaussians::with_capacity(count, 0);
    let mut block = vec![0; BLOCK.min(count) * ROW];
    while scene.len() < count {
        let rows = BLOCK.min(count - scene.len());
        let bytes = &mut block[..rows * ROW];
        let place = format!("row {}", scene.len());
        input.reader.read_exact(bytes).map_err(|e| SceneError::reading(&place, e))?;
        bytes.chunks_exact(ROW).for_each(|row| push(&mut scene, row));
    }
    if input.reader.read(&mut [0]).map_err(|e| SceneError::reading("rows", e))? != 0 {
        return Err(SceneError::malformed("rows", "the file grew while it was read", DAMAGED));
    }
    Ok(Model { gaussians: scene, format: Format::Splat, warnings: Vec::new() })
}

/// Decodes one row.
fn push(scene: &mut Gaussians, row: &[u8]) {
    let v = floats(row);
    scene.means.push([v[0], v[1], v[2]]);
    scene.log_scales.push([v[3], v[4], v[5]].map(log_scale));
    scene.sh.extend(row[24..27].iter().map(|&c| dc(f64::from(c) / 255.0)));
    scene.logit_opacities.push(logit(f64::from(row[27]) / 255.0));
    scene.rotations.push(rotation(row));
}

fn rotation(row: &[u8]) -> [f32; 4] {
    std::array::from_fn(|i| (f32::from(row[28 + i]) - 128.0) / 128.0)
}

fn floats(row: &[u8]) -> [f32; 6] {
    std::array::from_fn(|i| {
        f32::from_le_bytes(row[4 * i..4 * i + 4].try_into().expect("four bytes"))
    })
}
