//! The images of SOG.

use super::super::convert::{degree_of, rest_of};
use super::super::error::{DAMAGED, REEXPORT, SceneError};
use super::super::input::clip;
use powergs_pixels::Limits;

/// Palette entries in a row of the centroids image.
pub(super) const ENTRIES_PER_ROW: usize = 64;
/// Rows of the largest palette: labels have 16 bits.
const MAX_PALETTE_ROWS: u32 = 1024;
/// Bytes that a decoder may take beside the pixels.
const DECODER_BYTES: u64 = 64 << 20;

/// An image of four bytes a pixel.
pub(super) struct Plane {
    name: String,
    width: usize,
    pixels: Vec<[u8; 4]>,
}

impl Plane {
    /// An image with a pixel for each of `count` Gaussians; trailing pixels are left out.
    pub(crate) fn per_gaussian(name: &str, bytes: &[u8], count: usize) -> Result<Self, SceneError> {
        let (width, height) = size(name, bytes)?;
        let pixels = u64::from(width) * u64::from(height);
        let count = count as u64;
        if pixels < count || pixels > 2 * count + (1 << 16) {
            let what = format!("{width}x{height} pixels for {count} Gaussians");
            return Err(wrong(name, what));
        }
        let mut plane = decode(name, bytes, pixels)?;
        plane.pixels.truncate(count as usize);
        Ok(plane)
    }

    /// The palette of SH coefficients: 64 entries a row.
    pub(crate) fn palette(name: &str, bytes: &[u8]) -> Result<Self, SceneError> {
        let (width, height) = size(name, bytes)?;
        if degree_of_width(width as usize).is_none() || height > MAX_PALETTE_ROWS {
            let what = format!("{width}x{height} pixels are not a palette");
            return Err(wrong(name, what));
        }
        decode(name, bytes, u64::from(width) * u64::from(height))
    }

    /// The SH degree of a palette.
    pub(crate) fn degree(&self) -> u8 {
        degree_of_width(self.width).expect("checked when it was read")
    }

    /// All pixels, row by row.
    pub(crate) fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// The coefficients of a palette's entry, one pixel each.
    pub(crate) fn entry(&self, label: usize) -> Result<&[[u8; 4]], SceneError> {
        let n = rest_of(self.degree());
        self.pixels.get(label * n..(label + 1) * n).ok_or_else(|| {
            let entries = self.pixels.len() / n;
            wrong(&self.name, format!("label {label} in a palette of {entries} entries"))
        })
    }
}

fn degree_of_width(width: usize) -> Option<u8> {
    let rest = width.is_multiple_of(ENTRIES_PER_ROW).then(|| degree_of(width / ENTRIES_PER_ROW));
    rest.flatten().filter(|degree| (1..=3).contains(degree))
}

/// PNG, or lossless WebP that is all there.
fn check_format(name: &str, bytes: &[u8]) -> Result<(), SceneError> {
    if bytes.starts_with(b"\x89PNG") {
        return Ok(());
    }
    if !bytes.starts_with(b"RIFF") || bytes.get(8..12) != Some(b"WEBP") {
        return Err(SceneError::malformed(clip(name), "neither WebP nor PNG", REEXPORT));
    }
    let promised = u32::from_le_bytes(bytes[4..8].try_into().expect("four bytes"));
    if u64::from(promised) + 8 > bytes.len() as u64 {
        let what = format!("{} of {} bytes", bytes.len(), u64::from(promised) + 8);
        return Err(SceneError::truncated(clip(name), what));
    }
    if bytes.get(12..16) == Some(b"VP8 ") {
        return Err(SceneError::malformed(clip(name), "lossy WebP", REEXPORT));
    }
    Ok(())
}

fn size(name: &str, bytes: &[u8]) -> Result<(u32, u32), SceneError> {
    check_format(name, bytes)?;
    powergs_pixels::size(bytes).map_err(|e| wrong(name, e.to_string()))
}

fn decode(name: &str, bytes: &[u8], pixels: u64) -> Result<Plane, SceneError> {
    let limits = Limits { side: u32::MAX, bytes: 8 * pixels + DECODER_BYTES };
    let image = powergs_pixels::decode(bytes, limits).map_err(|e| wrong(name, e.to_string()))?;
    Ok(Plane { name: clip(name), width: image.width as usize, pixels: image.rgba8() })
}

fn wrong(name: &str, what: impl Into<String>) -> SceneError {
    SceneError::malformed(clip(name), what, DAMAGED)
}
