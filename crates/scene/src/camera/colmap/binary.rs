//! COLMAP's `cameras.bin` and `images.bin` (little-endian).

use std::collections::BTreeMap;
use std::io::{BufRead, ErrorKind, Read};

use glam::DVec3;

use super::super::{CameraError, CameraFile};
use super::models::{Intrinsics, MAX_PARAMETERS, intrinsics, parameters_of_id};
use super::{ColmapImage, views};

/// Longest name of an image, bytes.
const MAX_NAME: u64 = 4096;
/// Bytes of one 2D point in `images.bin`: x, y, id of its 3D point.
const POINT_BYTES: u64 = 24;

/// Reads the binary layout. Memory is in proportion to the views that are really there; the 2D
/// points of the images are skipped.
///
/// # Errors
/// [`CameraError`]: a damaged file, or a camera that cannot be used.
pub fn read_binary(cameras: impl BufRead, images: impl BufRead) -> Result<CameraFile, CameraError> {
    let cameras = read_cameras(BinarySource::new(cameras, "cameras.bin"))?;
    let images = read_images(BinarySource::new(images, "images.bin"))?;
    views("COLMAP binary", &cameras, images, Vec::new())
}

fn read_cameras<R: BufRead>(
    mut source: BinarySource<R>,
) -> Result<BTreeMap<u32, Intrinsics>, CameraError> {
    let count = source.u64("the number of cameras")?;
    let mut cameras = BTreeMap::new();
    for idx in 0..count {
        let start = source.offset;
        let fault = |what: String| CameraError::Binary {
            file: "cameras.bin",
            offset: start,
            what: format!("camera {idx} of {count}: {what}"),
        };
        let id = source.u32("a camera id")?;
        let model = source.u32("a camera model")? as i32;
        let (width, height) = (source.u64("a width")?, source.u64("a height")?);
        let n_parameters = parameters_of_id(model).map_err(fault)?;
        let mut parameters = [0.0; MAX_PARAMETERS];
        for slot in &mut parameters[..n_parameters] {
            *slot = source.f64("a camera parameter")?;
        }
        let camera =
            intrinsics(model, width, height, &parameters[..n_parameters]).map_err(fault)?;
        if cameras.insert(id, camera).is_some() {
            return Err(fault(format!("the camera id {id} occurs twice")));
        }
    }
    source.end("cameras")?;
    Ok(cameras)
}

fn read_images<R: BufRead>(mut source: BinarySource<R>) -> Result<Vec<ColmapImage>, CameraError> {
    let count = source.u64("the number of images")?;
    let mut images = Vec::new();
    for _ in 0..count {
        let id = source.u32("an image id")?;
        let mut pose = [0.0; 7];
        for slot in &mut pose {
            *slot = source.f64("a pose")?;
        }
        let [w, x, y, z, tx, ty, tz] = pose;
        let camera = source.u32("a camera id")?;
        let name = source.name()?;
        let points = source.u64("the number of 2D points")?;
        source.skip(points, POINT_BYTES, "2D points")?;
        let translation = DVec3::new(tx, ty, tz);
        images.push(ColmapImage { id, quaternion: [w, x, y, z], translation, camera, name });
    }
    source.end("images")?;
    Ok(images)
}

/// A reader that knows where it is.
pub(super) struct BinarySource<R> {
    reader: R,
    file: &'static str,
    offset: u64,
}

impl<R: BufRead> BinarySource<R> {
    /// At the beginning of a file of this name.
    pub fn new(reader: R, file: &'static str) -> BinarySource<R> {
        BinarySource { reader, file, offset: 0 }
    }

    pub fn fault(&self, what: impl Into<String>) -> CameraError {
        CameraError::Binary { file: self.file, offset: self.offset, what: what.into() }
    }

    fn failed(&self, error: &std::io::Error, item: &str) -> CameraError {
        if error.kind() == ErrorKind::UnexpectedEof {
            self.fault(format!("the file ends inside {item}; copy it again"))
        } else {
            self.fault(format!("reading {item} failed: {error}"))
        }
    }

    pub fn bytes<const N: usize>(&mut self, item: &str) -> Result<[u8; N], CameraError> {
        let mut bytes = [0; N];
        self.reader.read_exact(&mut bytes).map_err(|e| self.failed(&e, item))?;
        self.offset += N as u64;
        Ok(bytes)
    }

    fn u32(&mut self, item: &str) -> Result<u32, CameraError> {
        self.bytes(item).map(u32::from_le_bytes)
    }

    pub fn u64(&mut self, item: &str) -> Result<u64, CameraError> {
        self.bytes(item).map(u64::from_le_bytes)
    }

    pub fn f64(&mut self, item: &str) -> Result<f64, CameraError> {
        self.bytes(item).map(f64::from_le_bytes)
    }

    /// A name that ends with a zero byte.
    fn name(&mut self) -> Result<String, CameraError> {
        let mut bytes = Vec::new();
        let mut limited = (&mut self.reader).take(MAX_NAME);
        let read = limited.read_until(0, &mut bytes);
        let read = read.map_err(|e| self.failed(&e, "an image name"))?;
        if bytes.pop() != Some(0) {
            let what = if read as u64 == MAX_NAME { "is too long" } else { "has no end" };
            return Err(self.fault(format!("an image name {what}; the file is damaged")));
        }
        let name = String::from_utf8(bytes);
        let name = name.map_err(|_| self.fault("an image name is not UTF-8; rename the image"))?;
        self.offset += read as u64;
        Ok(name)
    }

    /// Skips `count` items of `each` bytes, which must be there.
    pub fn skip(&mut self, count: u64, each: u64, items: &str) -> Result<(), CameraError> {
        let promised = || self.fault(format!("{count} {items} are promised but not there"));
        let bytes = count.checked_mul(each).ok_or_else(promised)?;
        let mut limited = (&mut self.reader).take(bytes);
        let copied = std::io::copy(&mut limited, &mut std::io::sink());
        let copied = copied.map_err(|e| self.failed(&e, items))?;
        if copied < bytes {
            return Err(self.fault(format!("{count} {items} are promised but not there")));
        }
        self.offset += bytes;
        Ok(())
    }

    /// Nothing may follow.
    pub fn end(&mut self, items: &str) -> Result<(), CameraError> {
        let rest = self.reader.fill_buf().map(|b| b.len());
        let rest = rest.map_err(|e| self.failed(&e, "the end of the file"))?;
        if rest > 0 {
            return Err(self.fault(format!("bytes follow the last of the {items}")));
        }
        Ok(())
    }
}
