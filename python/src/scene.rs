//! Scenes: trained models, rendered and extracted.

use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use numpy::PyArray3;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use crate::arrays::{array, of_each, wrong};
use crate::cameras::{Camera, Cameras, checked_size, resized};
use crate::error::{Class, Fault, closed, defect, in_file_error};
use crate::frames::SharedFrames;
use crate::machine::path_text;
use crate::picture;
use crate::trace::{Trace, budget};
use crate::watch::{self, Counts, Shared};
use powergs_base::budget::Budget;
use powergs_base::config::embedded::SYNTH;
use powergs_core::run::files::read;
use powergs_core::run::store::atomic::{persist, temporary, write_atomically};
use powergs_core::run::{Frames, MemoryFrames, RunError, TraceFile, Watch};
use powergs_frame::trace::TraceHeader;
use powergs_optimize::train::start::around;
use powergs_raster::{Detail, Options, render};
use powergs_scene::export::{self, Files, Target};
use powergs_scene::files::{open_foveated, open_model_as};
use powergs_scene::synth::{Preset, cameras, generate};
use powergs_scene::{Foveated, Gaussians, ReadAs, SceneStats, StorageOrder, StoredAxes};
use powergs_study::extract::extract;
use powergs_views::RenderedViews;

/// Most Gaussians of a synthetic scene: 24 GB in memory.
const MAX_POINTS: usize = 100_000_000;

/// Memory for a pixel while a picture is rendered, bytes.
const PIXEL: u64 = 40;

/// A trained model: Gaussians in memory.
///
/// ``Scene.open(path)`` reads every known format; ``powergs.synth`` makes one.
#[pyclass(frozen, module = "powergs", name = "Scene")]
pub struct Scene {
    gaussians: Mutex<Option<Arc<Gaussians>>>,
    name: String,
    /// Format of the file, such as ``"ply"`` or ``"spz v4"``.
    #[pyo3(get)]
    format: String,
    /// Oddities of the file that do not prevent its use, one sentence each.
    #[pyo3(get)]
    warnings: Vec<String>,
}

impl Scene {
    /// A model that is in no file.
    pub fn of(name: &str, format: &str, gaussians: Gaussians) -> Scene {
        Scene {
            gaussians: Mutex::new(Some(Arc::new(gaussians))),
            name: name.to_owned(),
            format: format.to_owned(),
            warnings: Vec::new(),
        }
    }

    /// Name of the scene.
    pub fn label(&self) -> &str {
        &self.name
    }

    /// The model, where it is not closed.
    pub fn gaussians(&self) -> PyResult<Arc<Gaussians>> {
        let held = self.gaussians.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        held.clone().ok_or_else(|| closed("scene"))
    }
}

/// A background colour, sRGB: a word or three numbers from 0 to 1.
fn background(given: Option<&Bound<'_, PyAny>>) -> PyResult<[f32; 3]> {
    let Some(given) = given else { return Ok([0.0; 3]) };
    let what = "background: \"black\", \"white\" or three numbers from 0 to 1";
    if let Ok(word) = given.cast::<PyString>() {
        return match word.to_str()? {
            "black" => Ok([0.0; 3]),
            "white" => Ok([1.0; 3]),
            _ => Err(Fault::config(what).raise()),
        };
    }
    let colour: [f32; 3] = given.extract()?;
    if colour.iter().all(|value| (0.0..=1.0).contains(value)) {
        return Ok(colour);
    }
    Err(Fault::config(what).raise())
}

/// What a model is saved as: one file, in the format that is asked for or that the name says.
fn target(path: &Path, format: Option<&str>) -> PyResult<Target> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let found = match format {
        Some(format) => Target::from_name(format),
        None => Target::of_file_name(&name),
    };
    found.filter(|target| *target != Target::SogFolder).ok_or_else(|| {
        let files = Target::ALL.into_iter().filter(|target| *target != Target::SogFolder);
        let names = files.map(Target::name).collect::<Vec<_>>().join(", ");
        let what = match format {
            Some(format) => format!("format={format:?}: one of {names}"),
            None => format!(
                "{}: the name says no format that is written; end it in .ply, .compressed.ply, \
                 .spz, .gltf, .glb or .sog, or give a format ({names})",
                path.display()
            ),
        };
        Fault::config(what).raise()
    })
}

/// Before the logistic function: of 0 and 1 what the next numbers of single precision have.
fn logit(opacity: f32) -> f32 {
    let within = f64::from(opacity).clamp(f64::from(f32::MIN_POSITIVE), 1.0 - f64::EPSILON);
    (within / (1.0 - within)).ln() as f32
}

/// A number of Gaussians that is taken.
fn counted(count: usize) -> PyResult<usize> {
    if count == 0 || count > MAX_POINTS {
        return Err(wrong(format!("{count} Gaussians; must be 1 to {MAX_POINTS}")));
    }
    Ok(count)
}

/// Quaternions, none of which is zero.
fn turning(quats: &[f32]) -> PyResult<Vec<[f32; 4]>> {
    let (quats, _) = quats.as_chunks::<4>();
    if let Some(place) = quats.iter().position(|q| q.iter().all(|x| *x == 0.0)) {
        return Err(wrong(format!("quats: that of #{place} is zero and turns nothing")));
    }
    Ok(quats.to_vec())
}

/// The SH degree of this number of coefficients of a channel.
fn degree_of(coefficients: usize) -> u8 {
    [1, 4, 9, 16].iter().position(|k| *k == coefficients).unwrap_or(0) as u8
}

/// The name of a scene: its file or folder without ending.
fn stem(path: &Path) -> String {
    let name = path.file_stem().or(path.file_name()).unwrap_or(path.as_os_str());
    let name = name.to_string_lossy().into_owned();
    let folder = path.parent().and_then(Path::file_name);
    match folder.filter(|_| matches!(name.as_str(), "meta" | "lod-meta")) {
        Some(folder) => folder.to_string_lossy().into_owned(),
        None => name,
    }
}

/// A level of a foveated model.
fn open_level(
    py: Python<'_>,
    path: PathBuf,
    name: String,
    detail: Option<u32>,
    level: u8,
) -> PyResult<Scene> {
    if detail.is_some() || !(1..=Foveated::LEVELS as u8).contains(&level) {
        let what = "level: 1 to 4 of a foveated model, without a detail of streamed scenes";
        return Err(Fault::config(what).raise());
    }
    let work = move |_: &Shared| open_foveated(&path).map_err(in_file_error);
    let model = watch::run(py, None, (Counts::Steps, "bytes"), work)?;
    let gaussians = model.level(usize::from(level - 1));
    Ok(Scene::of(&name, "foveated model", gaussians))
}

#[pymethods]
impl Scene {
    /// Opens a model: INRIA PLY, compressed PLY, ``.splat``, ``.spz``, glTF, SOG, streamed SOG
    /// (with its ``detail``, 0 is the finest), the folder of a training run, or a foveated model
    /// (its ``level``, 1 to 4; 1 by default). ``axes`` are those of the file where they are not
    /// those of its format: ``"ply"`` for SPZ and glTF files with the axes of a PLY, or three
    /// letters for where x, y and z point to (``"rdf"``, ``"rub"``).
    ///
    /// Raises ``InputError``.
    #[staticmethod]
    #[pyo3(signature = (path, /, *, detail=None, level=None, axes=None))]
    fn open(
        py: Python<'_>,
        path: &Bound<'_, PyAny>,
        detail: Option<u32>,
        level: Option<u8>,
        axes: Option<&str>,
    ) -> PyResult<Scene> {
        let path = PathBuf::from(path_text(path)?);
        let name = stem(&path);
        let axes = axes.map(str::parse::<StoredAxes>).transpose();
        let axes = axes.map_err(|e| Fault::config(format!("axes: {e}")).raise())?;
        if let Some(level) = level {
            if axes.is_some() {
                let what = "axes: a foveated model has those that it was made with; leave them out";
                return Err(Fault::config(what).raise());
            }
            return open_level(py, path, name, detail, level);
        }
        let known = ReadAs { detail, axes };
        let work = move |_: &Shared| open_model_as(&path, known).map_err(in_file_error);
        let model = watch::run(py, None, (Counts::Steps, "bytes"), work)?;
        let warnings = model.warnings.iter().map(ToString::to_string).collect();
        let gaussians = Mutex::new(Some(Arc::new(model.gaussians)));
        Ok(Scene { gaussians, name, format: model.format.to_owned(), warnings })
    }

    /// A model of arrays, in the layout of ``gsplat.rasterization``.
    ///
    /// Parameters
    /// ----------
    /// means : array of shape (N, 3)
    ///     Centres, world units.
    /// quats : array of shape (N, 4)
    ///     Rotations (w, x, y, z), of any length but zero.
    /// scales : array of shape (N, 3)
    ///     Standard deviations along the axes, world units, above 0: after ``exp``.
    /// opacities : array of shape (N,)
    ///     0 to 1: after ``sigmoid``.
    /// sh : array of shape (N, K, 3)
    ///     Spherical harmonics, K = 1, 4, 9 or 16.
    /// name : str
    ///     Name of the scene.
    /// antialiased : bool
    ///     Whether it was trained with the 2D filter of Mip-Splatting.
    ///
    /// Arrays are of NumPy or PyTorch, with any strides. Raises ``InputError`` for other shapes and
    /// for values that are no numbers.
    #[staticmethod]
    #[pyo3(signature = (*, means, quats, scales, opacities, sh, name="arrays", antialiased=false))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn from_arrays(
        means: &Bound<'_, PyAny>,
        quats: &Bound<'_, PyAny>,
        scales: &Bound<'_, PyAny>,
        opacities: &Bound<'_, PyAny>,
        sh: &Bound<'_, PyAny>,
        name: &str,
        antialiased: bool,
    ) -> PyResult<Scene> {
        let (shape, means) = of_each(means, "means", None, |rest| rest == [3], "(N, 3)")?;
        let some = Some(counted(shape[0])?);
        let (_, quats) = of_each(quats, "quats", some, |rest| rest == [4], "(N, 4)")?;
        let (_, scales) = of_each(scales, "scales", some, |rest| rest == [3], "(N, 3)")?;
        let flat = |rest: &[usize]| rest.iter().product::<usize>() == 1;
        let (_, opacities) = of_each(opacities, "opacities", some, flat, "(N,)")?;
        let known = |rest: &[usize]| matches!(rest, [1 | 4 | 9 | 16, 3]);
        let (shape, sh) = of_each(sh, "sh", some, known, "(N, 1, 4, 9 or 16, 3)")?;
        let first = |values: &[f32], bad: fn(f32) -> bool| values.iter().position(|v| bad(*v));
        if let Some(place) = first(&scales, |v| v <= 0.0) {
            let what = "scales are above 0, after `exp`";
            return Err(wrong(format!("{what}; that of #{} is {}", place / 3, scales[place])));
        }
        if let Some(place) = first(&opacities, |v| !(0.0..=1.0).contains(&v)) {
            let what = "opacities are 0 to 1, after `sigmoid`";
            return Err(wrong(format!("{what}; that of #{place} is {}", opacities[place])));
        }
        let each = shape[1] * 3;
        // A file has all coefficients of a channel together; an array has those of a coefficient.
        let by_channel = sh.chunks_exact(each).flat_map(|own| {
            (0..3).flat_map(move |channel| own.iter().skip(channel).step_by(3).copied())
        });
        let gaussians = Gaussians {
            means: means.as_chunks().0.to_vec(),
            log_scales: scales.as_chunks().0.iter().map(|s: &[f32; 3]| s.map(f32::ln)).collect(),
            rotations: turning(&quats)?,
            logit_opacities: opacities.iter().map(|opacity| logit(*opacity)).collect(),
            sh_degree: degree_of(shape[1]),
            sh: by_channel.collect(),
            antialiased,
        };
        Ok(Scene::of(name, "arrays", gaussians))
    }

    /// The parameters of a model in training with gsplat: its ``splats``, or the ``splats`` of a
    /// checkpoint of ``simple_trainer.py``.
    ///
    /// Parameters
    /// ----------
    /// splats : dict
    ///     ``means`` (N, 3), ``scales`` (N, 3) before ``exp``, ``quats`` (N, 4) as w, x, y, z,
    ///     ``opacities`` (N,) before ``sigmoid``, ``sh0`` (N, 1, 3), and ``shN`` (N, K, 3) with
    ///     K = 0, 3, 8 or 15 if it is there. Other keys are left alone.
    /// name : str
    ///     Name of the scene.
    /// antialiased : bool
    ///     Whether it was trained with ``rasterize_mode="antialiased"``.
    ///
    /// Raises ``InputError`` for missing keys, other shapes and values that are no numbers.
    #[staticmethod]
    #[pyo3(signature = (splats, /, *, name="gsplat", antialiased=false))]
    fn from_gsplat(splats: &Bound<'_, PyAny>, name: &str, antialiased: bool) -> PyResult<Scene> {
        let of = |key: &str| {
            let missing = |_| {
                let keys = "means, scales, quats, opacities and sh0";
                wrong(format!("no `{key}`: splats have {keys}, and mostly shN"))
            };
            splats.get_item(key).map_err(missing)
        };
        let (shape, means) = of_each(&of("means")?, "means", None, |rest| rest == [3], "(N, 3)")?;
        let some = Some(counted(shape[0])?);
        let (_, quats) = of_each(&of("quats")?, "quats", some, |rest| rest == [4], "(N, 4)")?;
        let (_, scales) = of_each(&of("scales")?, "scales", some, |rest| rest == [3], "(N, 3)")?;
        let flat = |rest: &[usize]| rest.iter().product::<usize>() == 1;
        let (_, opacities) = of_each(&of("opacities")?, "opacities", some, flat, "(N,)")?;
        let (_, sh0) = of_each(&of("sh0")?, "sh0", some, |rest| rest == [1, 3], "(N, 1, 3)")?;
        let known = |rest: &[usize]| matches!(rest, [0 | 3 | 8 | 15, 3]);
        let (rest, sh_rest) = match splats.contains("shN")? {
            true => of_each(&of("shN")?, "shN", some, known, "(N, 0, 3, 8 or 15, 3)")?,
            false => (vec![shape[0], 0, 3], Vec::new()),
        };
        let rest = rest[1];
        let mut sh = Vec::with_capacity(sh0.len() + sh_rest.len());
        for (i, own) in sh0.as_chunks::<3>().0.iter().enumerate() {
            let others = &sh_rest[3 * rest * i..3 * rest * (i + 1)];
            for (channel, constant) in own.iter().enumerate() {
                sh.push(*constant);
                sh.extend(others.iter().skip(channel).step_by(3));
            }
        }
        let gaussians = Gaussians {
            means: means.as_chunks().0.to_vec(),
            log_scales: scales.as_chunks().0.to_vec(),
            rotations: turning(&quats)?,
            logit_opacities: opacities,
            sh_degree: degree_of(rest + 1),
            sh,
            antialiased,
        };
        Ok(Scene::of(name, "arrays", gaussians))
    }

    /// Gaussians around points, as the published training of 3DGS begins: round, as large as the
    /// root of the mean squared distance to the three nearest neighbours, of opacity 0.1 and SH
    /// degree 0.
    ///
    /// Parameters
    /// ----------
    /// positions : array of shape (N, 3)
    ///     Places, world units.
    /// colours : array of shape (N, 3), optional
    ///     sRGB, 0 to 1; middle grey without.
    /// name : str
    ///     Name of the scene.
    ///
    /// Raises ``InputError`` for other shapes and for values that are no numbers.
    #[staticmethod]
    #[pyo3(signature = (positions, /, colours=None, *, name="points"))]
    fn from_points(
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        colours: Option<&Bound<'_, PyAny>>,
        name: &str,
    ) -> PyResult<Scene> {
        let (shape, positions) =
            of_each(positions, "positions", None, |rest| rest == [3], "(N, 3)")?;
        let count = counted(shape[0])?;
        let colours = match colours {
            Some(given) => of_each(given, "colours", Some(count), |rest| rest == [3], "(N, 3)")?.1,
            None => vec![0.5; 3 * count],
        };
        if let Some(place) = colours.iter().position(|v| !(0.0..=1.0).contains(v)) {
            let what = "colours are sRGB, 0 to 1";
            return Err(wrong(format!("{what}; that of #{} is {}", place / 3, colours[place])));
        }
        let (positions, colours) = (positions.as_chunks().0, colours.as_chunks().0);
        let gaussians = py.detach(|| around(positions, colours));
        Ok(Scene::of(name, "points", gaussians))
    }

    /// The model as arrays: a dictionary with the names of ``from_arrays``, each float32 and owned
    /// by Python.
    fn to_arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let model = self.gaussians()?;
        let (count, coefficients) = (model.len(), (usize::from(model.sh_degree) + 1).pow(2));
        let sigmoid = |logit: &f32| 1.0 / (1.0 + (-logit).exp());
        let sh = model.sh.chunks_exact((coefficients * 3).max(1)).flat_map(|own| {
            (0..coefficients).flat_map(move |k| own.iter().skip(k).step_by(coefficients).copied())
        });
        let scales = model.log_scales.iter().flatten().map(|scale| scale.exp()).collect();
        let opacities = model.logit_opacities.iter().map(sigmoid).collect();
        let all = PyDict::new(py);
        all.set_item("means", array(py, model.means.as_flattened().to_vec(), &[count, 3])?)?;
        all.set_item("quats", array(py, model.rotations.as_flattened().to_vec(), &[count, 4])?)?;
        all.set_item("scales", array(py, scales, &[count, 3])?)?;
        all.set_item("opacities", array(py, opacities, &[count])?)?;
        all.set_item("sh", array(py, sh.collect(), &[count, coefficients, 3])?)?;
        Ok(all)
    }

    /// Name of the scene: its file without ending.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Degree of its spherical harmonics, 0 to 3.
    #[getter]
    fn sh_degree(&self) -> PyResult<u8> {
        Ok(self.gaussians()?.sh_degree)
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(self.gaussians()?.len())
    }

    /// Count, bounds, percentiles of position, opacity, scale (world units) and axis ratio, as a
    /// dictionary with the names of ``powergs-sim scene info --json``.
    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let gaussians = self.gaussians()?;
        let work = move |_: &Shared| Ok(SceneStats::of(&gaussians));
        let (stats, oddities) = watch::run(py, None, (Counts::Steps, "points"), work)?;
        let text = serde_json::to_value(&stats).map_err(defect)?.to_string();
        let dict = py.import("json")?.call_method1("loads", (text,))?;
        let oddities = oddities.iter().map(ToString::to_string);
        let warnings: Vec<String> = self.warnings.iter().cloned().chain(oddities).collect();
        dict.set_item("warnings", warnings)?;
        Ok(dict)
    }

    /// The picture of a view: an array of shape (height, width, 3), float32, sRGB. Values may
    /// exceed 1, where a display clamps them. The array owns the memory that was rendered to.
    ///
    /// ``size`` is (width, height) in pixels, in place of the view's; ``background`` is
    /// ``"black"``, ``"white"`` or three numbers.
    #[pyo3(signature = (camera, *, size=None, background=None, memory=None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: &Camera,
        size: Option<(u32, u32)>,
        background: Option<&Bound<'py, PyAny>>,
        memory: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let view = resized(vec![camera.0.clone()], size)?.remove(0);
        let budget = budget(memory)?.unwrap_or(Budget::DEFAULT);
        let bytes = u64::from(view.width) * u64::from(view.height) * PIXEL;
        budget.check(bytes).map_err(|over| {
            let what = format!("a picture of {}x{} pixels {over}", view.width, view.height);
            Fault::config(what)
        })?;
        let background = self::background(background)?;
        let options = Options { background, ..Options::reference(Detail::Image) };
        let gaussians = self.gaussians()?;
        let work = move |_: &Shared| Ok(render(&gaussians, &view, &options).picture);
        picture::array(py, watch::run(py, None, (Counts::Steps, "views"), work)?)
    }

    /// Renders the views with all counters: a trace, in memory or, with ``path``, in a file.
    ///
    /// Parameters
    /// ----------
    /// cameras : Cameras
    ///     The views.
    /// size : (int, int), optional
    ///     Width and height in pixels, in place of the views' own.
    /// background : str or (float, float, float)
    ///     ``"black"``, ``"white"``, or sRGB values from 0 to 1.
    /// path : str or path, optional
    ///     The trace file; it appears whole or not at all, with the bytes of ``powergs-sim
    ///     extract``.
    /// memory : int or str, optional
    ///     What a frame (in memory: all frames) may take, such as ``"2 GiB"``.
    /// progress : bool, function or bar, optional
    ///     As for ``Trace.replay``.
    /// order : str
    ///     How the Gaussians are sorted first: ``"storage"`` (not), ``"morton"``, ``"hilbert"`` or
    ///     ``"opacity"``. Pictures stay, addresses follow.
    #[pyo3(signature = (cameras, *, size=None, background=None, path=None, memory=None,
                        progress=None, order="storage"))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn extract(
        &self,
        py: Python<'_>,
        cameras: &Cameras,
        size: Option<(u32, u32)>,
        background: Option<&Bound<'_, PyAny>>,
        path: Option<&Bound<'_, PyAny>>,
        memory: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
        order: &str,
    ) -> PyResult<Trace> {
        let order = StorageOrder::from_name(order).ok_or_else(|| {
            let names = StorageOrder::ALL.map(StorageOrder::name).join(", ");
            Fault::config(format!("order {order:?}: there are {names}"))
        })?;
        let mut gaussians = self.gaussians()?;
        if let Some(places) = order.of(&gaussians) {
            gaussians = Arc::new(gaussians.permuted(&places));
        }
        let views = resized(cameras.views().to_vec(), checked_size(size)?)?;
        let path = path.map(path_text).transpose()?;
        let points = gaussians.len() as u64;
        let background = self::background(background)?;
        let mut frames = RenderedViews::new(&self.name, gaussians, views).on_background(background);
        frames.allow(budget(memory)?.unwrap_or(Budget::DEFAULT));
        let header = TraceHeader {
            generator: concat!("powergs-sim ", env!("CARGO_PKG_VERSION")).to_owned(),
            scene: self.name.clone(),
            points,
            order,
        };
        let file = path.clone();
        let work = move |shared: &Shared| match file {
            Some(path) => in_file(&mut frames, &header, &path, shared),
            None => in_memory(&mut frames, shared),
        };
        let frames = watch::run(py, progress, (Counts::Frames, "frames"), work)?;
        Ok(Trace::of(frames, path))
    }

    /// Writes the model in the format that the name says, as ``powergs-sim scene convert`` does:
    /// ``.ply``, ``.compressed.ply``, ``.spz``, ``.gltf``, ``.glb`` or ``.sog``; or as ``format``,
    /// such as ``"glb-spz"``.
    ///
    /// Returns what the file holds of every field (``exact``, ``largest``, ``rms``, ``clamped``),
    /// as ``kept`` of ``powergs-sim scene convert --json``.
    ///
    /// Raises ``ConfigError`` where the name says no format that is written, or the format cannot
    /// hold the model.
    #[pyo3(signature = (path, *, format=None))]
    fn save<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        format: Option<&str>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let target = target(&path, format)?;
        let gaussians = self.gaussians()?;
        let work = move |_: &Shared| {
            let written = export::write(&gaussians, target)
                .map_err(|e| Fault::in_file(Class::Config, path.display(), e))?;
            let Files::One(bytes) = &written.files else {
                return Err(Fault::new(Class::Internal, "a folder where a file was asked for"));
            };
            write_atomically(&path, |out| out.write_all(bytes))?;
            Ok(written.fidelity)
        };
        let kept = watch::run(py, None, (Counts::Steps, "bytes"), work)?;
        let text = serde_json::to_value(kept).map_err(defect)?.to_string();
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Frees the memory of the model. Whoever uses the scene afterwards gets a ``ValueError``.
    fn close(&self) {
        *self.gaussians.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = None;
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, _error: &Bound<'_, PyTuple>) {
        self.close();
    }

    fn __repr__(&self) -> String {
        match self.gaussians() {
            Ok(scene) => format!("<Scene {}: {} Gaussians>", self.name, scene.len()),
            Err(_) => format!("<Scene {}, closed>", self.name),
        }
    }

    fn __reduce__(&self) -> PyResult<()> {
        let what = "a scene is not pickled: save it, pickle the path, and open it again";
        Err(PyTypeError::new_err(what))
    }
}

fn in_memory(frames: &mut RenderedViews, shared: &Shared) -> Result<SharedFrames, Fault> {
    shared.begins(frames.range().len() as u64, 0);
    let (mut list, mut bytes) = (Vec::new(), 0_u64);
    for position in frames.range() {
        if shared.is_over() {
            break;
        }
        let pending = frames.take(position)?;
        bytes = bytes.saturating_add(pending.bytes);
        frames.budget().check(bytes).map_err(|over| {
            Fault::config(format!("the frames in memory: {over}; or give a path for the trace"))
        })?;
        list.push(pending.get()?);
        shared.frame_done();
    }
    let mut kept = MemoryFrames { name: frames.name().to_owned(), frames: list.clone() };
    Ok(SharedFrames::of_memory(&mut kept, list)?)
}

fn in_file(
    frames: &mut RenderedViews,
    header: &TraceHeader,
    path: &str,
    shared: &Shared,
) -> Result<SharedFrames, Fault> {
    let place = Path::new(path);
    let refused = |e: &dyn std::fmt::Display| Fault::in_file(Class::Output, path, e);
    let file = temporary(place).map_err(|e| refused(&e))?;
    let trace = extract(frames, header, BufWriter::new(file), shared).map_err(|e| match e {
        RunError::Output { message, .. } => refused(&message),
        other => other.into(),
    })?;
    if shared.is_over() {
        return Err(Fault::config("interrupted"));
    }
    let file = trace.out.into_inner().map_err(|e| refused(&e.error()))?;
    persist(file, place).map_err(|e| refused(&e))?;
    let mut file = TraceFile::open(place)?;
    file.allow(frames.budget());
    Ok(SharedFrames::of_file(file)?)
}

/// Makes a synthetic scene that behaves like a trained one, and the views of its preset.
///
/// ``preset`` is a name of ``powergs.names("synth")`` or a TOML file; ``points`` the number of
/// Gaussians, whose sizes follow so that the look stays; the same ``seed`` gives the same bytes.
///
/// >>> scene, cameras = powergs.synth("demo", points=2000)
#[pyfunction]
#[pyo3(signature = (preset, *, points=None, seed=1))]
pub fn synth(
    py: Python<'_>,
    preset: &Bound<'_, PyAny>,
    points: Option<usize>,
    seed: u64,
) -> PyResult<(Scene, Cameras)> {
    let name = path_text(preset)?;
    let file = read("preset", &name, SYNTH, None).map_err(Fault::from)?;
    let preset = Preset::parse(&file.text).map_err(|e| Fault::config_file(&file.origin, &e))?;
    let points = points.unwrap_or(preset.points);
    if !(1..=MAX_POINTS).contains(&points) {
        return Err(Fault::config(format!("points={points}: must be 1 to {MAX_POINTS}")).raise());
    }
    let views = cameras(&preset);
    let label = preset.name.clone();
    let work = move |_: &Shared| Ok(generate(&preset, points, seed));
    let scene = watch::run(py, None, (Counts::Steps, "points"), work)?;
    Ok((Scene::of(&label, "synthetic", scene), Cameras::of(views)))
}
