//! Traces: frames that machines run.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::PyArray1;
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice, PyString};

use crate::arrays::array;
use crate::error::{Fault, closed};
use crate::frames::SharedFrames;
use crate::machine::{DISPLAY, Machine, path_text};
use crate::report::{Live, Report};
use crate::table::{Column, Table};
use crate::value::display_rate;
use crate::watch::{self, Counts};
use powergs_base::budget::Budget;
use powergs_core::run::files::DiskFiles;
use powergs_core::run::{Change, Frames, PaperModel, System, TraceFile};
use powergs_core::workload::paper::Padding;
use powergs_frame::splat::Splat;
use powergs_frame::trace::Frame;

/// Frames of a scene, independent of any machine: made by ``Scene.extract`` or the command
/// ``powergs-sim extract``.
///
/// ``Trace.open(path)`` opens a file; ``trace[2:5]`` is a part of it, ``trace.load()`` keeps the
/// decoded frames in memory. Any number of threads may use a trace at the same time.
#[pyclass(frozen, module = "powergs", name = "Trace")]
pub struct Trace {
    frames: SharedFrames,
    path: Option<String>,
}

impl Trace {
    /// A trace of some frames.
    pub fn of(frames: SharedFrames, path: Option<String>) -> Trace {
        Trace { frames, path }
    }

    /// The frames, where they can be read.
    pub fn frames(&self) -> PyResult<SharedFrames> {
        if self.frames.is_open() { Ok(self.frames.clone()) } else { Err(closed("trace")) }
    }

    /// The frame of a trace of one.
    fn only(&self, py: Python<'_>) -> PyResult<Arc<Frame>> {
        let mut frames = self.frames()?;
        if frames.range().len() != 1 {
            return Err(PyValueError::new_err("splats of one frame: trace[0].splats()"));
        }
        let work = move |_: &watch::Shared| {
            let frame = frames.take(frames.range().start)?.get()?;
            Ok::<_, Fault>(frame)
        };
        watch::run(py, None, (Counts::Steps, "frames"), work)
    }

    /// The file; `None` for frames in memory.
    pub fn file(&self) -> Option<&str> {
        self.path.as_deref()
    }
}

/// Memory that may be used at a time: a number of bytes, or a text such as `2 GiB`.
pub fn budget(memory: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Budget>> {
    let Some(memory) = memory else { return Ok(None) };
    let text = match memory.cast::<PyString>() {
        Ok(text) => text.to_str()?.to_owned(),
        Err(_) => format!("{} B", memory.extract::<u64>()?),
    };
    let wrong = |e| Fault::config(format!("memory=\"{text}\": {e}")).raise();
    text.parse().map(Some).map_err(wrong)
}

#[pymethods]
impl Trace {
    /// Opens a trace.
    ///
    /// ``memory`` is what a frame may take, bytes or a text such as ``"2 GiB"``.
    ///
    /// Raises ``InputError`` for a file that is damaged or no trace.
    #[staticmethod]
    #[pyo3(signature = (path, /, *, memory=None))]
    fn open(
        py: Python<'_>,
        path: &Bound<'_, PyAny>,
        memory: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Trace> {
        let path = path_text(path)?;
        let budget = budget(memory)?;
        let file = PathBuf::from(&path);
        let work = move |_: &watch::Shared| {
            let mut file = TraceFile::open(&file)?;
            budget.into_iter().for_each(|budget| file.allow(budget));
            Ok(SharedFrames::of_file(file)?)
        };
        let frames = watch::run(py, None, (Counts::Steps, "bytes"), work)?;
        Ok(Trace { frames, path: Some(path) })
    }

    /// Name in reports: the file name without its ending.
    #[getter]
    fn name(&self) -> &str {
        Frames::name(&self.frames)
    }

    /// The file; ``None`` for frames that were never in one.
    #[getter]
    fn path(&self) -> Option<&str> {
        self.path.as_deref()
    }

    /// Width and height of the first frame, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.frames.first_size()
    }

    /// Whether the decoded frames are in memory.
    #[getter]
    fn loaded(&self) -> bool {
        self.frames.is_loaded()
    }

    /// Whether the trace is closed.
    #[getter]
    fn closed(&self) -> bool {
        !self.frames.is_open()
    }

    /// What tells these frames from others: the hash of the whole file or list, and which frames of
    /// it these are. Stores use it.
    #[getter]
    fn _key(&self) -> PyResult<(String, usize, usize)> {
        let (mut frames, range) = (self.frames()?, self.frames.range());
        let identity = frames.identity().map_err(Fault::from)?;
        Ok((format!("{:032x}", identity.xxh3), range.start, range.end))
    }

    fn __len__(&self) -> usize {
        self.frames.range().len()
    }

    /// One frame, or some in a row, as a trace of their own: ``trace[0]``, ``trace[2:5]``.
    fn __getitem__(&self, which: &Bound<'_, PyAny>) -> PyResult<Trace> {
        let (whole, count) = (self.frames.range(), self.frames.range().len() as isize);
        let range = if let Ok(slice) = which.cast::<PySlice>() {
            let at = slice.indices(count)?;
            if at.step != 1 || at.stop <= at.start {
                let what = "frames in a row, at least one: trace[2:5]";
                return Err(PyValueError::new_err(what));
            }
            at.start as usize..at.stop as usize
        } else {
            let at: isize = which.extract()?;
            let from_start = if at < 0 { at + count } else { at };
            if !(0..count).contains(&from_start) {
                return Err(PyIndexError::new_err(format!("frame {at} of {count}")));
            }
            from_start as usize..from_start as usize + 1
        };
        let range = whole.start + range.start..whole.start + range.end;
        Ok(Trace { frames: self.frames()?.part(range), path: self.path.clone() })
    }

    /// The same trace with its frames decoded in memory, for many replays.
    ///
    /// Raises ``InputError`` where they take more than the memory allowed.
    #[pyo3(signature = (*, progress=None))]
    fn load(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Trace> {
        let frames = self.frames()?;
        let work = move |shared: &watch::Shared| frames.loaded(shared);
        let frames = watch::run(py, progress, (Counts::Steps, "frames"), work)?;
        Ok(Trace { frames, path: self.path.clone() })
    }

    /// What each frame goes by in the file of a run (``write_run``): a hash of what is in it.
    #[pyo3(signature = (*, progress=None))]
    fn ids(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
        let mut frames = self.frames()?;
        let work = move |shared: &watch::Shared| {
            let range = frames.range();
            shared.total(range.len() as u64);
            let mut ids = Vec::new();
            for position in range.take_while(|_| !shared.is_over()) {
                ids.push(format!("{:016x}", frames.take(position)?.get()?.id()));
                shared.advance(1);
            }
            Ok::<_, Fault>(ids)
        };
        watch::run(py, progress, (Counts::Steps, "frames"), work)
    }

    /// The visible splats of one frame in depth order, as ``powergs-sim trace dump`` writes them:
    /// ``trace[3].splats()``.
    fn splats(&self, py: Python<'_>) -> PyResult<Table> {
        let frame = self.only(py)?;
        let number = |name: &str, means: &str, of: fn(usize, &Splat) -> u64| {
            let all = frame.splats.iter().enumerate().map(|(rank, splat)| Some(of(rank, splat)));
            Column::count(name, "", means, all)
        };
        let real = |name: &str, unit: &str, means: &str, of: fn(&Splat) -> f32| {
            let all = frame.splats.iter().map(|splat| Some(f64::from(of(splat))));
            Column::real(name, unit, means, all)
        };
        Table::new([
            number("rank", "Position in depth order.", |rank, _| rank as u64),
            number("index", "Position in the scene.", |_, s| u64::from(s.index)),
            real("depth_world", "", "Depth in view space, world units.", |s| s.depth),
            real("mean_x_px", "px", "Centre; centres of pixels are whole numbers.", |s| s.mean[0]),
            real("mean_y_px", "px", "Centre; centres of pixels are whole numbers.", |s| s.mean[1]),
            real("cov_xx_px2", "px²", "Covariance, low-pass included.", |s| s.cov[0]),
            real("cov_xy_px2", "px²", "Covariance, low-pass included.", |s| s.cov[1]),
            real("cov_yy_px2", "px²", "Covariance, low-pass included.", |s| s.cov[2]),
            real("opacity", "", "Opacity, 0 to 1.", |s| s.opacity),
        ])
    }

    /// The visible splats of one frame in depth order as arrays: ``trace[3].to_arrays()``.
    ///
    /// ``indices`` (N,) in the scene, uint32; ``depths`` (N,) in world units; ``means`` (N, 2) in
    /// pixels, whose centres are whole numbers; ``covariances`` (N, 3), xx, xy and yy in pixels²,
    /// low-pass included; ``opacities`` (N,): float32.
    fn to_arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let frame = self.only(py)?;
        let splats = &frame.splats;
        let count = splats.len();
        let all = PyDict::new(py);
        let indices: Vec<u32> = splats.iter().map(|s| s.index).collect();
        all.set_item("indices", PyArray1::from_vec(py, indices))?;
        let depths = splats.iter().map(|s| s.depth).collect();
        all.set_item("depths", array(py, depths, &[count])?)?;
        let means = splats.iter().flat_map(|s| s.mean).collect();
        all.set_item("means", array(py, means, &[count, 2])?)?;
        let covariances = splats.iter().flat_map(|s| s.cov).collect();
        all.set_item("covariances", array(py, covariances, &[count, 3])?)?;
        let opacities = splats.iter().map(|s| s.opacity).collect();
        all.set_item("opacities", array(py, opacities, &[count])?)?;
        Ok(all)
    }

    /// Runs the frames on a machine.
    ///
    /// Parameters
    /// ----------
    /// machine : Machine, str or path
    ///     The machine; ``"paper"`` is the published closed-form model, which has no time.
    /// energy : str or path, optional
    ///     Energy table in place of the machine's.
    /// dram : str, optional
    ///     Model of the DRAM: ``"banked"``, ``"calibrated"``, ``"bandwidth"``.
    /// display : str or path, optional
    ///     Display in place of the machine's.
    /// fps : float
    ///     Display rate, frames per second, for power and deadlines.
    /// progress : bool, function or bar, optional
    ///     ``True`` shows a bar; a function is called with ``(done, total)`` frames.
    ///
    /// The numbers are those of ``powergs-sim replay --json``, bit for bit. Ctrl-C raises
    /// ``KeyboardInterrupt`` at once.
    #[pyo3(signature = (machine, /, *, energy=None, dram=None, display=None, fps=60.0,
                        progress=None))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn replay(
        &self,
        py: Python<'_>,
        machine: &Bound<'_, PyAny>,
        energy: Option<&Bound<'_, PyAny>>,
        dram: Option<&str>,
        display: Option<&Bound<'_, PyAny>>,
        fps: f64,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Report> {
        let (frames, display_fps) = (self.frames()?, display_rate(fps)?);
        let energy = energy.map(path_text).transpose()?;
        let display = display.map(path_text).transpose()?;
        let target = if machine.cast::<PyString>().is_ok_and(|name| name == "paper") {
            if energy.is_some() || dram.is_some() {
                let what = "the paper model has no machine: no energy, no dram";
                return Err(Fault::config(what).raise());
            }
            let model = PaperModel::new(Padding::TrueTiles).map_err(Fault::from)?;
            let name = display.unwrap_or_else(|| DISPLAY.into());
            Target::Paper(Box::new(model.with_display(&name, &DiskFiles).map_err(Fault::from)?))
        } else {
            Target::System(on(machine, energy, dram, display)?)
        };
        let live = Live { target: Arc::new(target), frames, display_fps };
        let run = live.run(py, 0, progress)?;
        Ok(Report::new(live, run))
    }

    /// Closes the file. Whoever uses the trace afterwards gets a ``ValueError``.
    fn close(&self) {
        self.frames.close();
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, _error: &Bound<'_, pyo3::types::PyTuple>) {
        self.frames.close();
    }

    fn __repr__(&self) -> String {
        let ((width, height), count) = (self.frames.first_size(), self.frames.range().len());
        let closed = if self.frames.is_open() { "" } else { ", closed" };
        let name = Frames::name(&self.frames);
        format!("<Trace {name}: {count} frames, {width}x{height}{closed}>")
    }

    fn __reduce__(&self) -> PyResult<()> {
        let what = "a trace is not pickled: pickle its path, and open it again with Trace.open";
        Err(PyTypeError::new_err(what))
    }
}

/// What frames are run on.
pub enum Target {
    /// A machine.
    System(Arc<System>),
    /// The published model.
    Paper(Box<PaperModel>),
}

/// The system of an argument: a machine as it is, or one by name or path, with other files.
pub fn on(
    machine: &Bound<'_, PyAny>,
    energy: Option<String>,
    dram: Option<&str>,
    display: Option<String>,
) -> PyResult<Arc<System>> {
    let machine = Machine::from_argument(machine, display)?;
    let mut changes = Vec::new();
    changes.extend(energy.map(|name| Change::machine("energy", name)));
    changes.extend(dram.map(|model| Change::machine("dram.model", model)));
    if changes.is_empty() {
        return Ok(machine.system());
    }
    Ok(Arc::new(machine.changed(&changes)?))
}
