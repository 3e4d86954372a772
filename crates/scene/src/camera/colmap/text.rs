//! COLMAP's `cameras.txt` and `images.txt`.

use std::collections::BTreeMap;
use std::io::BufRead;
use std::str::FromStr;

use glam::DVec3;

use super::super::{CameraError, CameraFile};
use super::models::{Intrinsics, id_of_name, intrinsics};
use super::{ColmapImage, views};

/// Reads the text layout. Memory is in proportion to the views and the longest line.
///
/// # Errors
/// [`CameraError`]: a line that cannot be read, or a camera that cannot be used.
pub fn read_text(cameras: impl BufRead, images: impl BufRead) -> Result<CameraFile, CameraError> {
    let mut warnings = Vec::new();
    let cameras = read_cameras(ColmapLines::new(cameras, "cameras.txt"), &mut warnings)?;
    let images = read_images(ColmapLines::new(images, "images.txt"), &mut warnings)?;
    views("COLMAP text", &cameras, images, warnings)
}

fn read_cameras<R: BufRead>(
    mut lines: ColmapLines<R>,
    warnings: &mut Vec<String>,
) -> Result<BTreeMap<u32, Intrinsics>, CameraError> {
    let mut cameras = BTreeMap::new();
    while let Some(line) = lines.next_entry()? {
        let mut words = line.split_whitespace();
        let id: u32 = lines.parse(words.next(), "a camera id")?;
        let name = words.next().ok_or_else(|| lines.fault("the camera model is missing"))?;
        let model = id_of_name(name).map_err(|what| lines.fault(what))?;
        let width = lines.parse(words.next(), "a width")?;
        let height = lines.parse(words.next(), "a height")?;
        let parameters: Vec<f64> = words
            .map(|word| lines.parse(Some(word), "a camera parameter"))
            .collect::<Result<_, _>>()?;
        let camera = intrinsics(model, width, height, &parameters);
        if cameras.insert(id, camera.map_err(|what| lines.fault(what))?).is_some() {
            return Err(lines.fault(format!("the camera id {id} occurs twice")));
        }
    }
    lines.compare_count(cameras.len(), warnings);
    Ok(cameras)
}

fn read_images<R: BufRead>(
    mut lines: ColmapLines<R>,
    warnings: &mut Vec<String>,
) -> Result<Vec<ColmapImage>, CameraError> {
    let mut images = Vec::new();
    while let Some(line) = lines.next_entry()? {
        let mut words = line.split_whitespace();
        let id = lines.parse(words.next(), "an image id")?;
        let mut pose = [0.0; 7];
        for slot in &mut pose {
            *slot = lines.parse(words.next(), "seven numbers of a pose")?;
        }
        let [w, x, y, z, tx, ty, tz] = pose;
        let camera = lines.parse(words.next(), "a camera id")?;
        let name = words.collect::<Vec<_>>().join(" ");
        if name.is_empty() {
            return Err(lines.fault("the image name is missing"));
        }
        // The second line of an image lists its 2D points; it may be empty, and it may be absent
        // at the end of the file.
        if lines.next_line()?.is_some_and(|line| !is_list_of_points(&line)) {
            let what = "this is no list of 2D points (X Y POINT3D_ID ...), which every image has \
                        on its second line; where there are none, leave an empty line";
            return Err(lines.fault(what));
        }
        let translation = DVec3::new(tx, ty, tz);
        images.push(ColmapImage { id, quaternion: [w, x, y, z], translation, camera, name });
    }
    lines.compare_count(images.len(), warnings);
    Ok(images)
}

/// Whether a line is that of the 2D points of an image: numbers in threes.
fn is_list_of_points(line: &str) -> bool {
    let words = line.split_whitespace();
    words.clone().count().is_multiple_of(3) && words.into_iter().all(|w| w.parse::<f64>().is_ok())
}

/// Lines with their numbers.
pub(super) struct ColmapLines<R> {
    reader: R,
    file: &'static str,
    number: usize,
    /// `# Number of images: 12, ...`, where the file says so.
    promised: Option<usize>,
}

impl<R: BufRead> ColmapLines<R> {
    pub fn new(reader: R, file: &'static str) -> Self {
        Self { reader, file, number: 0, promised: None }
    }

    pub fn fault(&self, what: impl Into<String>) -> CameraError {
        CameraError::Text { file: self.file, line: self.number, what: what.into() }
    }

    fn next_line(&mut self) -> Result<Option<String>, CameraError> {
        let mut bytes = Vec::new();
        let read = self.reader.read_until(b'\n', &mut bytes);
        self.number += 1;
        if read.map_err(|e| self.fault(format!("reading failed: {e}")))? == 0 {
            return Ok(None);
        }
        let line = String::from_utf8(bytes).map_err(|_| self.fault("is not UTF-8 text"))?;
        Ok(Some(line))
    }

    /// The next line that is neither empty nor a comment.
    pub fn next_entry(&mut self) -> Result<Option<String>, CameraError> {
        while let Some(line) = self.next_line()? {
            let trimmed = line.trim();
            if let Some(comment) = trimmed.strip_prefix('#') {
                self.note_count(comment);
            } else if !trimmed.is_empty() {
                return Ok(Some(trimmed.to_string()));
            }
        }
        Ok(None)
    }

    fn note_count(&mut self, comment: &str) {
        let Some((_, rest)) = comment.split_once("Number of ") else { return };
        let digits = rest.split_once(": ").map_or("", |(_, n)| n);
        let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
        self.promised = digits[..end].parse().ok();
    }

    /// The count is in a comment, which nobody corrects who takes entries out by hand.
    fn compare_count(&self, found: usize, warnings: &mut Vec<String>) {
        if let Some(promised) = self.promised.filter(|promised| *promised != found) {
            warnings.push(format!(
                "{}: a comment promises {promised} entries, the file has {found}; was it copied \
                 completely?",
                self.file
            ));
        }
    }

    pub fn parse<T: FromStr>(&self, word: Option<&str>, item: &str) -> Result<T, CameraError> {
        let word = word.ok_or_else(|| self.fault(format!("the line ends before {item}")))?;
        word.parse().map_err(|_| self.fault(format!("`{word}` is not {item}")))
    }
}
