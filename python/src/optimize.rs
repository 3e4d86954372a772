//! The optimiser: the fewest watts at a given quality.

use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, channel};

use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::cameras::{Cameras, checked_size, resized};
use crate::chart::Chart;
use crate::error::{Class, Fault};
use crate::machine::{DISPLAY, Machine, path_text};
use crate::picture;
use crate::scene::Scene;
use crate::table::{Column, Table};
use crate::trace::budget;
use crate::value::display_rate;
use crate::watch::{self, Counts, Shared};
use powergs_base::budget::Budget;
use powergs_base::config::suggest::nearest;
use powergs_base::picture::Picture;
use powergs_chart::Chart as Drawing;
use powergs_core::run::files::{DiskFiles, FileKind, Files};
use powergs_core::run::{RunError, Watch};
use powergs_frame::display::Display;
use powergs_optimize::campaign::{Campaign, CampaignError, Finished};
use powergs_optimize::history::HistoryRow;
use powergs_optimize::invalid::Invalid;
use powergs_optimize::oracle::{CycleOracle, PaperOracle, PowerOracle};
use powergs_optimize::outcome::Outcome;
use powergs_optimize::photos::Photo;
use powergs_optimize::references::{Reference, ReferenceImages, References};
use powergs_optimize::renderer::Processor;
use powergs_optimize::request::{Goal, Goals, LEAST_GATE, Request};
use powergs_optimize::role::Baseline;
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::{SETTINGS, Setting, Settings, Value};
use powergs_optimize::target::Level;
use powergs_optimize::tune::Iteration;
use powergs_optimize::views::{PowerCameras, PowerViews};
use powergs_optimize::watch::CampaignWatch;
use powergs_report::optimize::{Story, charts, document};
use powergs_scene::camera::lens::without_lens;
use powergs_scene::{Camera, Gaussians};

/// What a worker tells whoever waits.
enum Event {
    Iteration(String, Box<Iteration>),
    Outcome(Box<Outcome>),
}

/// Hears of a campaign on the worker's side.
struct Courier<'a> {
    shared: &'a Shared,
    events: Option<Sender<Event>>,
    notes: Mutex<Vec<String>>,
}

impl Courier<'_> {
    fn send(&self, event: impl FnOnce() -> Event) {
        if let Some(events) = &self.events {
            // Nobody listens any more after an interrupt.
            let _ = events.send(event());
        }
    }

    fn keep(&self, text: &str) {
        let mut notes = self.notes.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        notes.push(text.to_owned());
    }
}

impl Watch for Courier<'_> {
    fn is_cancelled(&self) -> bool {
        self.shared.is_over()
    }
}

impl CampaignWatch for Courier<'_> {
    fn planned(&self, iterations: u64) {
        self.shared.total(iterations);
    }

    fn advanced(&self, n: u64) {
        self.shared.advance(n);
    }

    fn iteration(&self, job: &str, iteration: &Iteration) {
        self.send(|| Event::Iteration(job.to_owned(), Box::new(*iteration)));
    }

    fn outcome(&self, outcome: &Outcome) {
        self.send(|| Event::Outcome(Box::new(outcome.clone())));
    }

    fn note(&self, text: &str) {
        self.keep(text);
    }

    fn warn(&self, text: &str) {
        self.keep(text);
    }
}

impl From<CampaignError> for Fault {
    fn from(error: CampaignError) -> Fault {
        let class = match error {
            CampaignError::Run(error) => return error.into(),
            CampaignError::Invalid(invalid) => return refused(&invalid),
            CampaignError::HoldsRun | CampaignError::NoRun | CampaignError::NoDisplayPower => {
                Class::Config
            }
            CampaignError::NothingSeen
            | CampaignError::Lpips { .. }
            | CampaignError::Tune { .. } => Class::Input,
            CampaignError::Sim { .. } | CampaignError::Foveated(_) => Class::Internal,
        };
        Fault::new(class, error.to_string())
    }
}

fn refused(invalid: &Invalid) -> Fault {
    Fault::config(match invalid {
        Invalid::Range { key, value, low, high } => {
            format!("{key}={value}: must be {low} to {high}")
        }
        Invalid::ShareOfPerfect => "against its own renders the dense model is perfect, so a \
                                    share of its quality says nothing; give decibels, or \"H\", \
                                    \"M\" or \"L\""
            .into(),
        Invalid::Likeness => "quality: 1 to 120 decibels, or a share below 1".into(),
        other => other.to_string(),
    })
}

/// The wanted quality: a named step, decibels, or a share of the dense model's below 1.
pub fn goal(quality: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Goal>> {
    let Some(quality) = quality else { return Ok(None) };
    if let Ok(name) = quality.cast::<PyString>() {
        let name = name.to_str()?;
        let level = Level::ALL.into_iter().find(|level| level.name() == name);
        let unknown =
            || Fault::config("quality: \"H\", \"M\", \"L\", decibels, or a share").raise();
        return level.map(|level| Some(Goal::Levels(vec![level]))).ok_or_else(unknown);
    }
    let number: f64 = quality.extract()?;
    Ok(Some(match number < 1.0 {
        true => Goal::Share(number),
        false => Goal::Absolute { psnr_db: number, ssim: 0.0 },
    }))
}

/// The settings of the optimiser that a function was given by keyword, of those that it has.
pub fn settings(
    function: &str,
    given: Option<&Bound<'_, PyDict>>,
    has: impl Fn(&Setting) -> bool,
) -> PyResult<Settings> {
    let known = || SETTINGS.iter().filter(|setting| has(setting));
    let mut found: Vec<(&Setting, Value)> = Vec::new();
    for (key, value) in given.into_iter().flatten() {
        let key: String = key.extract()?;
        let Some(setting) = known().find(|setting| setting.key == key) else {
            let near = nearest(&key, known().map(|setting| setting.key));
            let near = near.map_or_else(String::new, |near| format!("; did you mean '{near}'?"));
            let what = format!("{function}() got an unexpected keyword argument '{key}'{near}");
            return Err(PyTypeError::new_err(what));
        };
        if !value.is_none() {
            found.push((setting, said(setting, &value)?));
        }
    }
    Settings::with(&found).map_err(|invalid| refused(&invalid).raise())
}

/// What a keyword says of a setting.
fn said(setting: &Setting, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(n) = value.extract() {
        return Ok(Value::Count(n));
    }
    if let Ok(x) = value.extract() {
        return Ok(Value::Real(x));
    }
    let name: Result<&str, _> = value.extract();
    let named = name.map_or_else(|_| Err(setting.other_kind()), |name| setting.named(name));
    named.map_err(|invalid| refused(&invalid).raise())
}

/// What an optimisation found.
///
/// ``model`` is the scene with the fewest watts that reached the quality; ``models`` all that were
/// made, ``history`` every iteration. Notebooks show the page of the run.
#[pyclass(frozen, module = "powergs", name = "Optimized")]
pub struct Optimized {
    name: String,
    model: Option<Gaussians>,
    history: Vec<HistoryRow>,
    names: Vec<String>,
    results: serde_json::Value,
    charts: Vec<Drawing>,
    pictures: Option<powergs_optimize::pictures::BeforeAfter>,
    text: String,
    html: String,
    headline: String,
    /// What people should know, one sentence each.
    #[pyo3(get)]
    notes: Vec<String>,
}

impl Optimized {
    fn of(campaign: &Campaign, finished: Finished, notes: Vec<String>) -> Result<Self, Fault> {
        let done = finished.first();
        let story = Story::of(campaign, &finished, &done);
        let drawn = charts(&story);
        let page = document(&story, &drawn);
        let failed = |e: &dyn std::fmt::Display| Fault::new(Class::Internal, e.to_string());
        let results = serde_json::to_value(&finished.results).map_err(|e| failed(&e))?;
        let (text, headline) = (page.terminal(100), story.headline());
        let html = page.fragment().map_err(|e| failed(&e))?;
        let names = finished.outcomes.iter().map(|outcome| outcome.name.clone()).collect();
        let Finished { history, model, pictures, .. } = finished;
        let (name, charts) = (campaign.name.clone(), drawn);
        Ok(Optimized {
            name,
            model,
            history,
            names,
            results,
            charts,
            pictures,
            text,
            html,
            headline,
            notes,
        })
    }

    fn records(&self) -> &[serde_json::Value] {
        self.results["models"].as_array().map_or(&[], Vec::as_slice)
    }
}

/// An 8-bit picture as an array of shape (height, width, 3).
fn bytes<'py>(
    py: Python<'py>,
    size: (u32, u32),
    bytes: &[u8],
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    PyArray1::from_slice(py, bytes).reshape([size.1 as usize, size.0 as usize, 3])
}

#[pymethods]
impl Optimized {
    /// Whether a model reached the quality.
    #[getter]
    fn reached(&self) -> bool {
        self.model.is_some()
    }

    /// The model with the fewest watts. Raises ``GoalMissed`` where none reached the quality.
    #[getter]
    fn model(&self) -> PyResult<Scene> {
        match &self.model {
            Some(model) => Ok(Scene::of(&self.name, "optimised", model.clone())),
            None => Err(Fault::new(Class::GoalMissed, self.headline.trim_end()).raise()),
        }
    }

    /// All models in the order in which they were made: what for, the share that was pruned,
    /// quality over gate and test views, watts.
    #[getter]
    fn models(&self) -> PyResult<Table> {
        let records = self.records();
        let text = |name: &'static str, what: &'static str| {
            Column::text(name, what, records.iter().map(move |r| r[name].as_str()))
        };
        let real = |name: &'static str, unit: &'static str, what: &'static str| {
            Column::real(name, unit, what, records.iter().map(move |r| r[name].as_f64()))
        };
        let count = |name: &'static str, what: &'static str| {
            Column::count(name, "1", what, records.iter().map(move |r| r[name].as_u64()))
        };
        let gain = |c: usize, name: &'static str, what: &'static str| {
            let of = records.iter().map(move |r| r["gains"][c].as_f64());
            Column::real(name, "1", what, of)
        };
        let seen = |of: &'static str,
                    name: &'static str,
                    head: &'static str,
                    unit: &'static str,
                    what: &'static str| {
            Column::real(head, unit, what, records.iter().map(move |r| r[of][name].as_f64()))
        };
        Table::new([
            text("name", "Its job."),
            text("role", "What it was made for."),
            real("rho", "1", "Share of the Gaussians that were pruned."),
            count("gaussians", "Gaussians left."),
            count("iterations", "Iterations done."),
            real("lambda_per_w", "1/W", "Weight of the display term of the kept model."),
            gain(0, "gain_red", "What its red was scaled by to dim it."),
            gain(1, "gain_green", "What its green was scaled by to dim it."),
            gain(2, "gain_blue", "What its blue was scaled by to dim it."),
            Column::flag(
                "passed",
                "Whether it reached the quality over the gate views.",
                records.iter().map(|r| r["passed"].as_bool()),
            ),
            seen("gate", "psnr_db", "gate_psnr_db", "dB", "PSNR over the gate views."),
            seen("test", "psnr_db", "test_psnr_db", "dB", "PSNR over the test views."),
            seen("test", "ssim", "test_ssim", "1", "SSIM over the test views."),
            real("render_w", "W", "Rendering power over the power views."),
            real("display_w", "W", "Display power over the power views."),
        ])
    }

    /// Every iteration of every job: ``job``, ``iteration``, ``view``, ``gaussians``, ``loss``,
    /// ``psnr_db`` of its training view, ``lambda_per_w``, ``display_w``, and ``gate_psnr_db``
    /// where the quality was checked after it.
    #[getter]
    fn history(&self) -> PyResult<Table> {
        let rows = || self.history.iter().map(|row| row.iteration);
        let job = self.history.iter().map(|row| self.names.get(row.job));
        Table::new([
            Column::text("job", "The model that it makes.", job),
            Column::count("iteration", "1", "From 0.", rows().map(|i| Some(i.iteration.into()))),
            Column::count("view", "1", "The training view.", rows().map(|i| Some(i.view as u64))),
            Column::count("gaussians", "1", "Gaussians.", rows().map(|i| Some(i.points as u64))),
            Column::real("loss", "1", "The loss.", rows().map(|i| Some(i.loss.total))),
            Column::real(
                "psnr_db",
                "dB",
                "PSNR of the training view.",
                rows().map(|i| i.loss.likeness.map(|[_, _, psnr]| psnr)),
            ),
            Column::real("lambda_per_w", "1/W", "λ in the loss.", rows().map(|i| Some(i.lambda))),
            Column::real(
                "display_w",
                "W",
                "Display power of the training view.",
                rows().map(|i| Some(i.loss.display_w)),
            ),
            Column::real(
                "gate_psnr_db",
                "dB",
                "PSNR over the gate views, where it was checked.",
                rows().map(|i| i.check.map(|check| check.seen.quality.psnr_db)),
            ),
        ])
    }

    /// Everything that was found, with the names of ``results.json``.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.results.to_string(),))
    }

    /// The charts of the run by name.
    fn charts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for chart in &self.charts {
            dict.set_item(chart.name, Bound::new(py, Chart::new(chart.clone()))?)?;
        }
        Ok(dict)
    }

    /// The first test view with the dense and with the final model: two arrays of shape (height,
    /// width, 3), uint8; ``None`` where no model reached the quality.
    #[getter]
    #[allow(clippy::type_complexity)] // a pair of arrays
    fn pictures<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(Bound<'py, PyArray3<u8>>, Bound<'py, PyArray3<u8>>)>> {
        let Some(pair) = &self.pictures else { return Ok(None) };
        let size = (pair.width, pair.height);
        Ok(Some((bytes(py, size, &pair.dense)?, bytes(py, size, &pair.ours)?)))
    }

    fn __repr__(&self) -> String {
        let made = self.records().len();
        let end = if self.model.is_some() { "the quality was reached" } else { "goal missed" };
        format!("<Optimized {}: {made} models, {end}>", self.name)
    }

    fn __str__(&self) -> &str {
        &self.text
    }

    fn _repr_html_(&self) -> &str {
        &self.html
    }
}

/// An iteration as a callback gets it.
fn told<'py>(py: Python<'py>, event: &Event) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    match event {
        Event::Iteration(job, i) => {
            dict.set_item("event", "iteration")?;
            dict.set_item("job", job)?;
            dict.set_item("iteration", i.iteration)?;
            dict.set_item("view", i.view)?;
            dict.set_item("gaussians", i.points)?;
            dict.set_item("loss", i.loss.total)?;
            dict.set_item("psnr_db", i.loss.likeness.map(|[_, _, psnr]| psnr))?;
            dict.set_item("lambda_per_w", i.lambda)?;
            dict.set_item("display_w", i.loss.display_w)?;
            let gate = i.check.map(|check| check.seen.quality.psnr_db);
            dict.set_item("gate_psnr_db", gate)?;
        }
        Event::Outcome(outcome) => {
            dict.set_item("event", "model")?;
            dict.set_item("job", &outcome.name)?;
            dict.set_item("rho", outcome.rho)?;
            dict.set_item("gaussians", outcome.points)?;
            dict.set_item("passed", outcome.passed)?;
            dict.set_item("gate_psnr_db", outcome.gate.quality.psnr_db)?;
            dict.set_item("render_w", outcome.watts.render_w)?;
            dict.set_item("display_w", outcome.watts.display_w)?;
        }
    }
    Ok(dict)
}

/// Calls a function with all that came in meanwhile.
fn tell(
    py: Python<'_>,
    events: &Receiver<Event>,
    callback: Option<&Bound<'_, PyAny>>,
) -> PyResult<()> {
    let Some(callback) = callback else { return Ok(()) };
    for event in events.try_iter() {
        callback.call1((told(py, &event)?,))?;
        py.check_signals()?;
    }
    Ok(())
}

/// Photos as references: in the size that models train in, and those that have more pixels whole,
/// for the views that judge models in another one.
struct PhotoArrays {
    images: Vec<Reference>,
    photos: Vec<(Photo, Option<Reference>)>,
}

impl References for PhotoArrays {
    fn write_to(&self, view: usize, picture: &mut Picture) {
        self.images[view].write_to(picture);
    }

    fn digest(&self) -> u128 {
        self.images.digest()
    }

    fn push_at(&mut self, view: usize, camera: &Camera) -> Result<Option<Camera>, RunError> {
        let (photo, whole) = &self.photos[view];
        let larger = photo.in_size_of(camera);
        let size = |camera: &Camera| (camera.width, camera.height);
        let Some(whole) = whole.as_ref().filter(|_| size(&larger.view) != size(&photo.view)) else {
            return Ok(None);
        };
        let mut picture = Picture::default();
        whole.write_to(&mut picture);
        self.images.push(larger.reference(&picture));
        Ok(Some(larger.view))
    }
}

/// The views as their photos show them, and the photos in their size.
fn photographed(
    cameras: &Cameras,
    photos: &[Bound<'_, PyAny>],
    size: Option<(u32, u32)>,
) -> PyResult<(Vec<Camera>, ReferenceImages)> {
    let all = cameras.views();
    let wrong = |what: String| Fault::new(Class::Input, what).raise();
    if photos.len() != all.len() {
        return Err(wrong(format!("{} photos for {} views", photos.len(), all.len())));
    }
    let mut views = Vec::new();
    let mut references = PhotoArrays { images: Vec::new(), photos: Vec::new() };
    for (photo, camera) in photos.iter().zip(all) {
        let picture = picture::picture(photo)?;
        let shown = (picture.width, picture.height);
        let photo = Photo::new(shown, camera, cameras.lens(camera), size);
        let photo = photo.map_err(|e| wrong(format!("the photo of view {}: {e}", camera.name)))?;
        references.images.push(photo.reference(&picture));
        views.push(photo.view.clone());
        let is_larger = shown != (photo.view.width, photo.view.height);
        let whole = is_larger.then(|| Reference::new(&picture));
        references.photos.push((photo, whole));
    }
    Ok((views, ReferenceImages::Photos(Box::new(references))))
}

/// The fewest watts of rendering and display at a given quality: Gaussians are pruned and colours
/// dimmed, and the model is fine-tuned until it sits just above the quality.
///
/// Parameters
/// ----------
/// scene : Scene
///     The trained model.
/// cameras : Cameras
///     Its views; some train, some decide, some are only reported.
/// photos : list, optional
///     What the views should look like: an array of shape (height, width, 3) or a path for each.
///     Another size than that of the camera is averaged down to it, or the camera is scaled to a
///     smaller photo; lenses that the camera file names are taken out of them. Without photos the
///     model is compared with its own renders.
/// quality : str or float, optional
///     ``"H"``, ``"M"`` (the default) or ``"L"``, decibels, or with photos a share below 1 of the
///     dense model's.
/// machine : Machine, str or path
///     What rendering costs: a machine, or ``"paper"``, the published closed form.
/// display : str or path, optional
///     The panel.
/// display_ratio : float, optional
///     The panel is scaled so that the dense model's display power is so many times that of the
///     accelerator.
/// fps : float
///     Frames shown per second.
/// size : (int, int), optional
///     Width and height that models train at, pixels, in place of those of the views.
/// power_size : (int, int), optional
///     Width and height that power is counted and quality measured at, pixels: that of the screen.
///     Without it, that of the views, whatever ``size`` says. Where it is larger than ``size``,
///     power is a mean over at most 16 views, and at most 24 decide, evenly spaced.
///     ``gate_size="trained"`` measures quality at ``size``.
/// rhos : list of float, optional
///     Shares to prune that are tried, ascending.
/// baselines : bool
///     Whether the comparisons of the publication are trained as well.
/// store : path, optional
///     Folder of checkpoints: a run that was interrupted goes on there, bit for bit.
/// memory : int or str, optional
///     What a frame may take.
/// callback : function, optional
///     Called with a dictionary for every iteration (``event`` is ``"iteration"``) and every model
///     that is made (``"model"``), in their order. An exception of it ends the run.
/// progress : bool, function or bar, optional
///     As for ``Trace.replay``; counts iterations.
/// **settings : int, float or str, optional
///     ``iterations`` of a sample, ``final_iterations`` (twice as many), the ``seed`` of the order
///     of views; ``first_effort``, ``held_out_iterations``, ``level_effort``, ``interval``,
///     ``adjust_share``, ``display_weight`` (the flag ``--lambda``), ``level_display_weight``
///     (``--level-lambda``), ``dimming``, ``epsilon_db``, ``opacity_cap``, ``rate_scale``,
///     ``rate_end``, ``checkpoint_every``, ``gate``, ``gate_size``. ``powergs-sim optimize
///     --help`` says what they are.
#[pyfunction]
#[pyo3(signature = (scene, cameras, *, photos=None, quality=None, machine=None, display=None,
                    display_ratio=None, fps=60.0, size=None, power_size=None, rhos=None,
                    baselines=false, store=None, memory=None, callback=None, progress=None,
                    **settings))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn optimize(
    py: Python<'_>,
    scene: &Scene,
    cameras: &Cameras,
    photos: Option<Vec<Bound<'_, PyAny>>>,
    quality: Option<&Bound<'_, PyAny>>,
    machine: Option<&Bound<'_, PyAny>>,
    display: Option<&Bound<'_, PyAny>>,
    display_ratio: Option<f64>,
    fps: f64,
    size: Option<(u32, u32)>,
    power_size: Option<(u32, u32)>,
    rhos: Option<Vec<f64>>,
    baselines: bool,
    store: Option<&Bound<'_, PyAny>>,
    memory: Option<&Bound<'_, PyAny>>,
    callback: Option<&Bound<'_, PyAny>>,
    progress: Option<&Bound<'_, PyAny>>,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Optimized> {
    if callback.is_some_and(|function| !function.is_callable()) {
        return Err(PyTypeError::new_err("callback: a function of one dictionary"));
    }
    let settings = self::settings("optimize", settings, |_| true)?;
    let fps = display_rate(fps)?;
    let budget = budget(memory)?.unwrap_or(Budget::DEFAULT);
    let oracle: Box<dyn PowerOracle> = match machine {
        Some(name) if name.cast::<PyString>().is_ok_and(|name| name == "paper") => {
            Box::new(PaperOracle::published(fps).map_err(Fault::from)?)
        }
        given => {
            let system = match given {
                Some(given) => Machine::from_argument(given, None)?.system(),
                None => Machine::named("gscore")?.system(),
            };
            Box::new(CycleOracle { system: (*system).clone(), fps, memory: budget })
        }
    };
    let panel = display.map(path_text).transpose()?.unwrap_or_else(|| DISPLAY.into());
    let panel = DiskFiles.read(FileKind::Display, &panel, None).map_err(Fault::from)?;
    let display = Display::parse(&panel.text).map_err(|e| RunError::config(&panel.origin, e));
    let display = display.map_err(Fault::from)?;
    let (views, references) = match photos {
        None => (resized(cameras.views().to_vec(), size)?, ReferenceImages::own()),
        Some(photos) => photographed(cameras, &photos, checked_size(size)?)?,
    };
    let straight = |camera: &Camera| {
        let lens = cameras.lens(camera);
        lens.and_then(|lens| without_lens(camera, lens)).unwrap_or_else(|| camera.clone())
    };
    let whole: Vec<Camera> = cameras.views().iter().map(straight).collect();
    let full = whole.iter().max_by_key(|c| u64::from(c.width) * u64::from(c.height));
    let full_size = full.map(|c| [c.width, c.height]);
    let shown = resized(whole, power_size)?;
    let sizes = |cameras: &[Camera]| -> Vec<[u32; 2]> {
        cameras.iter().map(|c| [c.width, c.height]).collect()
    };
    let power_cameras = match sizes(&shown) == sizes(&views) {
        true => PowerCameras::Same,
        false => PowerCameras::Shown(shown),
    };
    let schedule = match rhos {
        Some(rhos) => Schedule::listed(&rhos).map_err(|e| refused(&e))?,
        None => Schedule::FIVE,
    };
    let goals = Goals {
        goal: goal(quality)?,
        schedule,
        baselines: if baselines { Baseline::ALL.to_vec() } else { Vec::new() },
        ..Goals::default()
    };
    let request = Request {
        name: scene.label().to_owned(),
        dense: (*scene.gaussians()?).clone(),
        externals: Vec::new(),
        cameras: views,
        references,
        background: [0.0; 3],
        validation_every: 0,
        least_gate: LEAST_GATE,
        power_cameras,
        power_views: PowerViews::Usual,
        full_size,
        goals,
        renderer: Box::new(Processor),
        oracle,
        display,
        display_ratio,
        settings,
        foveation: None,
        lpips: None,
        keep_all: false,
    };
    let store = store.map(path_text).transpose()?;
    let (sender, events) = channel();
    let sender = callback.is_some().then_some(sender);
    let work = move |shared: &Shared| {
        let courier = Courier { shared, events: sender, notes: Mutex::new(Vec::new()) };
        let store = crate::sweep::store(store, shared);
        let campaign = Campaign::open(request, &courier)?;
        let finished = campaign.run(&*store, &courier)?;
        let notes = courier.notes.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        // Cancelled: nobody listens any more.
        let finished = finished.ok_or_else(|| Fault::config("interrupted"))?;
        Optimized::of(&campaign, finished, notes)
    };
    let counts = (Counts::Steps, "iterations");
    watch::run_and(py, progress, counts, &mut || tell(py, &events, callback), work)
}
