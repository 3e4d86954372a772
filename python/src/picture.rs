//! Pictures: arrays in, numbers out.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray3};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString};

use crate::error::{Class, Fault, defect};
use crate::machine::path_text;
use crate::watch::{self, Counts};
use powergs_base::budget::Budget;
use powergs_base::picture::Picture;
use powergs_core::run::RunError;
use powergs_core::run::files::{DiskFiles, FileKind, Files};
use powergs_frame::display::Display;
use powergs_pixels::{Limits, decode, write_png};
use powergs_quality::{flip, likeness};

/// The longest side of a picture, pixels.
const SIDE: u32 = 32_768;
/// The longest file that is read, bytes.
const FILE_MAX: u64 = 2 << 30;

/// A picture as an array of shape (height, width, 3), float32, without a copy of its pixels.
pub fn array<'py>(py: Python<'py>, picture: Picture) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let shape = [picture.height as usize, picture.width as usize, 3];
    PyArray1::from_vec(py, picture.pixels.into_flattened()).reshape(shape)
}

fn wrong(message: impl Into<String>) -> PyErr {
    Fault::new(Class::Input, message).raise()
}

/// The picture of an argument: an array of shape (height, width, 3) with values from 0 to 1, or
/// bytes from 0 to 255, of any strides; or the path of a PNG, JPEG or WebP file.
pub fn picture(given: &Bound<'_, PyAny>) -> PyResult<Picture> {
    let py = given.py();
    if given.is_instance_of::<PyString>() || given.hasattr("__fspath__")? {
        let path = path_text(given)?;
        return py.detach(|| read(Path::new(&path))).map_err(Fault::raise);
    }
    if !given.hasattr("__array__")? {
        let kind = given.get_type().name()?.to_string();
        let what = "a picture is an array of shape (height, width, 3) or the path of one";
        return Err(PyTypeError::new_err(format!("{what}, not {kind}")));
    }
    let numpy = py.import("numpy")?;
    let values = numpy.call_method1("asarray", (given,))?;
    let dtype = values.getattr("dtype")?;
    let (kind, bytes): (String, usize) =
        (dtype.getattr("kind")?.extract()?, dtype.getattr("itemsize")?.extract()?);
    let is_bytes = kind == "u" && bytes == 1;
    if !is_bytes && kind != "f" {
        let what = "values are floats from 0 to 1 or uint8";
        return Err(wrong(format!("a picture of {dtype}: {what}")));
    }
    let shape: Vec<usize> = values.getattr("shape")?.extract()?;
    let [height, width, 3] = shape[..] else {
        let what = "a picture has the shape (height, width, 3)";
        return Err(wrong(format!("{what}, this array has {shape:?}")));
    };
    let side = 1..=SIDE as usize;
    if !side.contains(&height) || !side.contains(&width) {
        return Err(wrong(format!("{width} x {height} pixels: each side has 1 to {SIDE}")));
    }
    let options = PyDict::new(py);
    options.set_item("dtype", numpy.getattr("float32")?)?;
    let values = numpy.call_method("ascontiguousarray", (values,), Some(&options))?;
    let values: PyReadonlyArray3<'_, f32> = values.extract()?;
    let flat = values.as_slice().map_err(|e| wrong(e.to_string()))?;
    if !flat.iter().all(|value| value.is_finite()) {
        return Err(wrong("a picture with values that are no numbers (NaN or infinite)"));
    }
    let full = if is_bytes { 255.0 } else { 1.0 };
    let (pixels, _) = flat.as_chunks::<3>();
    let pixels = pixels.iter().map(|rgb| rgb.map(|value| value / full)).collect();
    Ok(Picture { width: width as u32, height: height as u32, pixels })
}

/// A picture file; transparent pixels show black.
fn read(path: &Path) -> Result<Picture, Fault> {
    let wrong = |e: &dyn std::fmt::Display| Fault::in_file(Class::Input, path.display(), e);
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|e| wrong(&e))?;
    file.take(FILE_MAX + 1).read_to_end(&mut bytes).map_err(|e| wrong(&e))?;
    if bytes.len() as u64 > FILE_MAX {
        return Err(wrong(&"longer than any picture"));
    }
    let limits = Limits { side: SIDE, bytes: Budget::DEFAULT.0.0 };
    let image = decode(&bytes, limits).map_err(|e| wrong(&e))?;
    let pixels = image.rgba().map(|[r, g, b, a]| [r * a, g * a, b * a]).collect();
    Ok(Picture { width: image.width, height: image.height, pixels })
}

/// How like two pictures of one size are.
///
/// ``a`` is compared with the reference ``b``: arrays of shape (height, width, 3), sRGB values from
/// 0 to 1 or uint8, or paths of pictures. Returns ``psnr_db`` (``None`` for equal pictures),
/// ``ssim``, ``flip``, ``l1`` and ``mse``; ``docs/metrics.md`` defines them. ``pixels_per_degree``
/// of sight is for FLIP.
///
/// Raises ``InputError`` for arrays of another shape or type and for values that are no numbers.
#[pyfunction]
#[pyo3(signature = (a, b, *, pixels_per_degree=None))]
pub fn quality<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
    pixels_per_degree: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let density = pixels_per_degree.unwrap_or(flip::PIXELS_PER_DEGREE);
    if !(1.0..=1000.0).contains(&density) {
        return Err(Fault::config("pixels_per_degree: a number from 1 to 1000").raise());
    }
    let (a, b) = (picture(a)?, picture(b)?);
    if (a.width, a.height) != (b.width, b.height) {
        let sizes = [&a, &b].map(|p| format!("{} x {}", p.width, p.height));
        let what = format!("pictures of {} and {} pixels: they have one size", sizes[0], sizes[1]);
        return Err(wrong(what));
    }
    let work = move |_: &watch::Shared| Ok((likeness(&a, &b), flip::flip(&b, &a, density)));
    let (like, flip) = watch::run(py, None, (Counts::Steps, "pictures"), work)?;
    let values = PyDict::new(py);
    values.set_item("psnr_db", Some(like.psnr_db).filter(|db| db.is_finite()))?;
    values.set_item("ssim", like.ssim)?;
    values.set_item("flip", flip)?;
    values.set_item("l1", like.l1)?;
    values.set_item("mse", like.mse)?;
    Ok(values)
}

/// What a picture costs to show: ``power_w`` and its parts ``red_w``, ``green_w``, ``blue_w``,
/// ``static_w``, and ``mean_linear_rgb``.
///
/// ``image`` is an array of shape (height, width, 3), sRGB values from 0 to 1 or uint8, or a path;
/// ``display`` the name or path of a panel.
#[pyfunction]
#[pyo3(signature = (image, display=None))]
pub fn display_power<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    display: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let name = display.map(path_text).transpose()?;
    let name = name.as_deref().unwrap_or(crate::machine::DISPLAY);
    let file = DiskFiles.read(FileKind::Display, name, None).map_err(Fault::from)?;
    let panel = Display::parse(&file.text).map_err(|e| RunError::config(&file.origin, e));
    let panel = panel.map_err(Fault::from)?;
    let picture = picture(image)?;
    let mean = py.detach(|| picture.mean_linear_rgb());
    let coefficients = panel.coefficients();
    let values = PyDict::new(py);
    values.set_item("power_w", panel.power(mean).0)?;
    for (i, part) in ["red_w", "green_w", "blue_w"].into_iter().enumerate() {
        values.set_item(part, coefficients[i] * mean[i])?;
    }
    values.set_item("static_w", panel.static_power.0)?;
    values.set_item("mean_linear_rgb", mean)?;
    Ok(values)
}

/// A picture as PNG of 8 bits a channel, as a display gets it: values are clamped to 0..1.
///
/// ``image`` is an array of shape (height, width, 3), sRGB values from 0 to 1 or uint8, or a path.
#[pyfunction]
pub fn png<'py>(py: Python<'py>, image: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyBytes>> {
    let picture = picture(image)?;
    let mut bytes = Vec::new();
    let written = write_png(&mut bytes, picture.width, picture.height, &picture.to_rgb8());
    written.map_err(defect)?;
    Ok(PyBytes::new(py, &bytes))
}
