//! Camera files of other programs: what they are, and what to export instead.

use serde_json::{Map, Value};

use super::CameraError;

/// Bytes in which an XML file says what it is.
const HEAD: usize = 64 << 10;

/// What a camera file is, and what to do.
#[derive(Clone, Copy)]
struct ForeignCameras {
    format: &'static str,
    todo: &'static str,
}

const fn kind(format: &'static str, todo: &'static str) -> ForeignCameras {
    ForeignCameras { format, todo }
}

const COLMAP_EXPORT: &str =
    "export COLMAP's files with the program that made it, and give their folder";

const METASHAPE: ForeignCameras = kind(
    "the cameras of Metashape (Agisoft)",
    "export them as COLMAP (File, Export, Export Cameras, type Colmap), and give the folder",
);
const XML: ForeignCameras = kind("an XML document", COLMAP_EXPORT);
const PAGE: ForeignCameras = kind(
    "a web page (HTML)",
    "it was saved in place of the cameras: the address needs a login, or is that of a page about \
     them; download the file itself",
);
const LLFF: ForeignCameras = kind(
    "an array of NumPy, as poses_bounds.npy of LLFF",
    "such data sets have COLMAP's files next to it (sparse/0): give that folder, or convert it \
     to a transforms.json",
);
const DATABASE: ForeignCameras =
    kind("a database, as COLMAP keeps its matches in", "give the folder of the model, sparse/0");
const BUNDLER: ForeignCameras = kind("the cameras of Bundler", COLMAP_EXPORT);
const NVM: ForeignCameras = kind("the cameras of VisualSFM", COLMAP_EXPORT);
const OPENSFM: ForeignCameras = kind(
    "a reconstruction of OpenSfM",
    "export COLMAP's files (opensfm export_colmap DATASET), and give their folder",
);
const OPENMVG: ForeignCameras = kind(
    "the sfm_data of OpenMVG",
    "export COLMAP's files (openMVG_main_openMVG2Colmap), and give their folder",
);
const ALICEVISION: ForeignCameras = kind(
    "the cameras of Meshroom (AliceVision)",
    "export COLMAP's files (aliceVision_exportColmap), and give their folder",
);

/// How files of other programs begin.
const STARTS: [(&[u8], ForeignCameras); 4] = [
    (b"\x93NUMPY", LLFF),
    (b"SQLite format 3\0", DATABASE),
    (b"# Bundle file", BUNDLER),
    (b"NVM_V3", NVM),
];

impl ForeignCameras {
    fn error(self) -> CameraError {
        CameraError::Foreign { format: self.format, todo: self.todo }
    }
}

/// What a file with these bytes is, if another program made it.
pub(crate) fn by_content(bytes: &[u8]) -> Option<CameraError> {
    if let Some((_, known)) = STARTS.into_iter().find(|(start, _)| bytes.starts_with(start)) {
        return Some(known.error());
    }
    let head = &bytes[..bytes.len().min(HEAD)];
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    if !head.starts_with(b"<") {
        return None;
    }
    let has = |word: &[u8]| head.windows(word.len()).any(|w| w.eq_ignore_ascii_case(word));
    if has(b"<!doctype html") || has(b"<html") {
        return Some(PAGE.error());
    }
    let is_metashape = has(b"<document") && has(b"<chunk");
    Some(if is_metashape { METASHAPE } else { XML }.error())
}

/// What a list is whose first entry is no view.
pub(super) fn by_first(list: &[Value]) -> Option<CameraError> {
    let first = list.first()?;
    let has = |key: &str| first.get(key).is_some();
    (has("shots") && has("cameras")).then(|| OPENSFM.error())
}

/// What an object with these keys is.
pub(super) fn by_keys(keys: &Map<String, Value>) -> Option<CameraError> {
    let has = |key: &str| keys.contains_key(key);
    if has("sfm_data_version") {
        return Some(OPENMVG.error());
    }
    if has("views") && has("poses") && has("intrinsics") {
        return Some(ALICEVISION.error());
    }
    (has("shots") && has("cameras")).then(|| OPENSFM.error())
}
