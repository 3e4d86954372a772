//! Cameras: views of files, circles around scenes, paths.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, DVec4};
use numpy::PyArrayDyn;
use pyo3::exceptions::{PyIndexError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PySlice;

use crate::arrays::{array_of_rows, matrix, wrong};
use crate::error::{Fault, in_file_error};
use crate::machine::path_text;
use crate::scene::Scene;
use powergs_core::run::store::atomic::write_atomically;
use powergs_scene::camera::check::{MAX_SIZE, of_matrices};
use powergs_scene::camera::fov::FieldOfView;
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::camera::views::{OrbitRequest, ViewError, ViewSelection};
use powergs_scene::camera::{Lens, inria};
use powergs_scene::files::open_cameras;
use powergs_scene::{Camera as View, Eye, Split};

/// One view: a pinhole camera.
///
/// Parameters
/// ----------
/// intrinsics : array of shape (3, 3)
///     ``[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]``, pixels from the left and top edges, as gsplat's
///     ``Ks``.
/// world_to_camera : array of shape (4, 4)
///     The pose, as gsplat's ``viewmats``: x to the right, y down, z forward.
/// size : (int, int)
///     Width and height, pixels.
/// name : str
///     Name of the view.
///
/// Raises ``InputError`` for matrices of another shape, skew and poses that are no rotations.
#[pyclass(frozen, module = "powergs", name = "Camera")]
#[derive(Clone)]
pub struct Camera(pub View);

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (intrinsics, world_to_camera, size, *, name="view"))]
    fn new(
        intrinsics: &Bound<'_, PyAny>,
        world_to_camera: &Bound<'_, PyAny>,
        size: (u32, u32),
        name: &str,
    ) -> PyResult<Camera> {
        let [x, y, z] = matrix::<3, 3>(intrinsics, "K")?.map(DVec3::from_array);
        let intrinsics = DMat3::from_cols(x, y, z).transpose();
        let [a, b, c, d] =
            matrix::<4, 4>(world_to_camera, "world_to_camera")?.map(DVec4::from_array);
        let pose = DMat4::from_cols(a, b, c, d).transpose();
        let view = of_matrices(name, intrinsics, pose, [size.0, size.1]);
        Ok(Camera(view.map_err(|e| wrong(e.to_string()))?))
    }

    /// Focal lengths and principal point, pixels from the left and top edges: an array of shape
    /// (3, 3), float64.
    #[getter]
    fn intrinsics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let View { fx, fy, cx, cy, .. } = self.0;
        let rows = [vec![fx, 0.0, cx], vec![0.0, fy, cy], vec![0.0, 0.0, 1.0]];
        array_of_rows(py, &rows)
    }

    /// Pose: x to the right, y down, z forward; an array of shape (4, 4), float64.
    #[getter]
    fn world_to_camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let rotation = self.0.world_to_camera;
        let translation = -(rotation * self.0.centre);
        let row = |i: usize| {
            let row = rotation.row(i);
            vec![row.x, row.y, row.z, translation[i]]
        };
        array_of_rows(py, &[row(0), row(1), row(2), vec![0.0, 0.0, 0.0, 1.0]])
    }

    /// Name of the view, usually its photo.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Width and height, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.0.width, self.0.height)
    }

    /// Focal lengths in x and y, pixels.
    #[getter]
    fn focal(&self) -> (f64, f64) {
        (self.0.fx, self.0.fy)
    }

    /// Place of the camera, world units: x, y, z.
    #[getter]
    fn position(&self) -> [f64; 3] {
        self.0.centre.to_array()
    }

    /// ``"train"`` or ``"test"``, where the file says so.
    #[getter]
    fn split(&self) -> Option<&'static str> {
        self.0.split.map(Split::name)
    }

    /// The same view with another size of its picture; another aspect keeps the vertical field of
    /// view.
    fn resized(&self, width: u32, height: u32) -> PyResult<Camera> {
        let mut views = resized(vec![self.0.clone()], Some((width, height)))?;
        Ok(Camera(views.remove(0)))
    }

    fn __repr__(&self) -> String {
        let View { name, width, height, .. } = &self.0;
        format!("<Camera {name}: {width}x{height}>")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts)> {
        Ok((py.import("powergs._powergs")?.getattr("_camera")?, parts(&self.0)))
    }
}

/// What a camera is pickled as: name, size, focal lengths and principal point, rotation by columns,
/// centre, split, eye.
type Parts = (String, [u32; 2], [f64; 4], [f64; 9], [f64; 3], Option<String>, Option<String>);

fn parts(view: &View) -> Parts {
    (
        view.name.clone(),
        [view.width, view.height],
        [view.fx, view.fy, view.cx, view.cy],
        view.world_to_camera.to_cols_array(),
        view.centre.to_array(),
        view.split.map(|split| split.name().to_owned()),
        view.eye.map(|eye| eye.name().to_owned()),
    )
}

/// A pickled camera.
#[pyfunction]
pub fn _camera(
    name: String,
    size: [u32; 2],
    intrinsics: [f64; 4],
    rotation: [f64; 9],
    centre: [f64; 3],
    split: Option<&str>,
    eye: Option<&str>,
) -> PyResult<Camera> {
    checked_size(Some((size[0], size[1])))?;
    let [fx, fy, cx, cy] = intrinsics;
    Ok(Camera(View {
        name,
        width: size[0],
        height: size[1],
        fx,
        fy,
        cx,
        cy,
        world_to_camera: DMat3::from_cols_array(&rotation),
        centre: DVec3::from_array(centre),
        split: split.and_then(Split::from_name),
        eye: eye.and_then(Eye::from_name),
    }))
}

/// Views of a scene, at least one: a list of ``Camera``, or from a file, a circle, or a path.
#[pyclass(frozen, module = "powergs", name = "Cameras", sequence)]
pub struct Cameras {
    views: Arc<Vec<View>>,
    /// By the name of its view, the lens of each photo that was bent by one.
    lenses: Arc<BTreeMap<String, Lens>>,
    /// What was left out or taken on trust, one sentence each.
    #[pyo3(get)]
    warnings: Vec<String>,
}

impl Cameras {
    /// Some views.
    pub fn of(views: Vec<View>) -> Cameras {
        Cameras { views: Arc::new(views), lenses: Arc::default(), warnings: Vec::new() }
    }

    /// The lens that the photo of a view was taken through.
    pub fn lens(&self, view: &View) -> Option<&Lens> {
        self.lenses.get(&view.name)
    }

    /// The views.
    pub fn views(&self) -> &[View] {
        &self.views
    }
}

/// A size of pictures.
pub fn checked_size(size: Option<(u32, u32)>) -> PyResult<Option<(u32, u32)>> {
    let good = |side: u32| (1..=MAX_SIZE).contains(&side);
    if size.is_none_or(|(width, height)| good(width) && good(height)) {
        return Ok(size);
    }
    Err(Fault::config(format!("size: width and height, each 1 to {MAX_SIZE} pixels")).raise())
}

/// Views with another size.
pub fn resized(views: Vec<View>, size: Option<(u32, u32)>) -> PyResult<Vec<View>> {
    let selection = ViewSelection { size: checked_size(size)?, ..ViewSelection::default() };
    Ok(selection.of(views).map_err(named)?.0)
}

/// The options are keywords here.
fn named(error: ViewError) -> Fault {
    let words = [("path-frames", "frames"), ("orbit-", ""), ("orbit ", "views ")];
    let text = error.to_string();
    Fault::config(words.iter().fold(text, |text, (from, to)| text.replace(from, to)))
}

fn up(axis: &str) -> PyResult<DVec3> {
    Ok(match axis {
        "x" => DVec3::X,
        "y" => DVec3::Y,
        "z" => DVec3::Z,
        "-x" => DVec3::NEG_X,
        "-y" => DVec3::NEG_Y,
        "-z" => DVec3::NEG_Z,
        _ => return Err(Fault::config("up: one of x, y, z, -x, -y, -z").raise()),
    })
}

#[pymethods]
impl Cameras {
    #[new]
    #[pyo3(signature = (views, /))]
    fn new(views: Vec<PyRef<'_, Camera>>) -> PyResult<Cameras> {
        if views.is_empty() {
            return Err(Fault::config("views: at least one").raise());
        }
        Ok(Cameras::of(views.iter().map(|view| view.0.clone()).collect()))
    }

    /// Opens a camera file: INRIA ``cameras.json``, NeRF ``transforms.json``, or a folder of
    /// COLMAP. ``size`` is for files that do not say it, pixels.
    ///
    /// Raises ``InputError``.
    #[staticmethod]
    #[pyo3(signature = (path, /, *, size=None))]
    fn open(
        py: Python<'_>,
        path: &Bound<'_, PyAny>,
        size: Option<(u32, u32)>,
    ) -> PyResult<Cameras> {
        let path = PathBuf::from(path_text(path)?);
        let size = checked_size(size)?;
        let file = py.detach(|| open_cameras(&path, size, None)).map_err(in_file_error)?;
        let (views, lenses) = (Arc::new(file.cameras), Arc::new(file.lenses));
        let warnings = file.warnings.into_iter().chain(file.doubts).collect();
        Ok(Cameras { views, lenses, warnings })
    }

    /// Views on a circle around a scene, evenly spaced.
    ///
    /// ``elevation`` (20) and the vertical ``fov`` (50) are degrees; ``radius`` is world units, by
    /// default such that the scene fills the picture; ``up`` is an axis such as ``"-y"``.
    #[staticmethod]
    #[pyo3(signature = (scene, views, *, elevation=None, radius=None, fov=None, up="-y",
                        size=None))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn orbit(
        py: Python<'_>,
        scene: &Scene,
        views: usize,
        elevation: Option<f64>,
        radius: Option<f64>,
        fov: Option<f64>,
        up: &str,
        size: Option<(u32, u32)>,
    ) -> PyResult<Cameras> {
        let request = OrbitRequest {
            views,
            elevation_deg: elevation,
            radius,
            fov_deg: fov,
            up: self::up(up)?,
            size: checked_size(size)?,
        };
        let gaussians = scene.gaussians()?;
        let views = py.detach(|| request.cameras(|| SceneBounds::of(&gaussians)));
        Ok(Cameras::of(views.map_err(named)?))
    }

    /// A smooth path of so many frames through the views.
    fn path(&self, frames: usize) -> PyResult<Cameras> {
        let path = ViewSelection { path_frames: Some(frames), ..ViewSelection::default() };
        Ok(Cameras::of(path.of(self.views.to_vec()).map_err(named)?.0))
    }

    /// A part of the views, in this order: those of a ``split`` (``"train"``, ``"test"``), every
    /// K-th, with another ``size`` (pixels), in pairs ``stereo`` world units apart, with another
    /// field of view ``fov`` (degrees: ``"90x96"``, or ``"52+45x48+50"`` for the outer, inner,
    /// upper and lower edge of each eye).
    #[pyo3(signature = (*, split=None, every=None, size=None, stereo=None, fov=None))]
    fn select(
        &self,
        split: Option<&str>,
        every: Option<usize>,
        size: Option<(u32, u32)>,
        stereo: Option<f64>,
        fov: Option<&str>,
    ) -> PyResult<Cameras> {
        let unknown = || Fault::config("split: train or test");
        let split = split.map(|name| Split::from_name(name).ok_or_else(unknown)).transpose()?;
        let none = || Fault::config("every: at least 1");
        let every = every.map(|n| NonZeroUsize::new(n).ok_or_else(none)).transpose()?;
        let size = checked_size(size)?;
        let fov = fov.map(str::parse::<FieldOfView>).transpose();
        let fov = fov.map_err(|what| Fault::config(format!("fov: {what}")))?;
        let selection =
            ViewSelection { split, every, size, stereo, fov, ..ViewSelection::default() };
        let (views, warnings) = selection.of(self.views.to_vec()).map_err(named)?;
        Ok(Cameras { views: Arc::new(views), lenses: self.lenses.clone(), warnings })
    }

    /// Writes the views as an INRIA ``cameras.json``.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let text = inria::write(&self.views);
        let written = write_atomically(&path, |out| out.write_all(text.as_bytes()));
        Ok(written.map_err(Fault::from)?)
    }

    fn __len__(&self) -> usize {
        self.views.len()
    }

    /// A view, or some views: ``cameras[0]``, ``cameras[::8]``.
    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        which: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let count = self.views.len() as isize;
        if let Ok(slice) = which.cast::<PySlice>() {
            let at = slice.indices(count)?;
            let mut views = Vec::new();
            let mut i = at.start;
            for _ in 0..at.slicelength {
                views.push(self.views[i as usize].clone());
                i += at.step;
            }
            if views.is_empty() {
                return Err(Fault::config("no view is in that range").raise());
            }
            let some = Cameras { lenses: self.lenses.clone(), ..Cameras::of(views) };
            return Ok(Bound::new(py, some)?.into_any());
        }
        let at: isize = which.extract()?;
        let from_start = if at < 0 { at + count } else { at };
        if !(0..count).contains(&from_start) {
            return Err(PyIndexError::new_err(format!("view {at} of {count}")));
        }
        Ok(Bound::new(py, Camera(self.views[from_start as usize].clone()))?.into_any())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Vec<Camera>,))> {
        if !self.lenses.is_empty() {
            let what = "views with lenses are not pickled: pickle the path, and open it again";
            return Err(PyTypeError::new_err(what));
        }
        let of = py.import("powergs._powergs")?.getattr("Cameras")?;
        Ok((of, (self.views.iter().cloned().map(Camera).collect(),)))
    }

    fn __repr__(&self) -> String {
        let View { width, height, .. } = &self.views[0];
        format!("<Cameras: {} views, {width}x{height}>", self.views.len())
    }
}
