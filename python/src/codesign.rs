//! Co-design: the model and the machine that need the fewest watts together.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::cameras::{Cameras, resized};
use crate::chart::Chart;
use crate::error::{Class, Fault};
use crate::machine::{Machine, parts, path_text, unpickled};
use crate::optimize::{goal, settings as settings_of};
use crate::scene::Scene;
use crate::table::{Column, Table};
use crate::trace::budget;
use crate::watch::{self, Counts, Shared};
use powergs_base::budget::Budget;
use powergs_base::config::document::TEXT_MAX;
use powergs_chart::Chart as Drawing;
use powergs_codesign::compare::{Comparison, Found, Way};
use powergs_codesign::machines::Machines;
use powergs_codesign::model::ModelPoint;
use powergs_codesign::pricing::{Fate, MachinePoint, Price};
use powergs_codesign::run::{FIT_SETTINGS, ROUNDS};
use powergs_codesign::space::SpaceFile;
use powergs_codesign::watch::CodesignWatch;
use powergs_codesign::{Codesign, CodesignError, Finished};
use powergs_core::run::files::FileKind;
use powergs_core::run::{RunError, System};
use powergs_optimize::campaign::Campaign;
use powergs_optimize::oracle::CycleOracle;
use powergs_optimize::request::{Goal, Goals, Request};
use powergs_optimize::settings::Settings;
use powergs_optimize::target::Level;
use powergs_report::codesign::{charts, document, headline};
use powergs_scene::Gaussians;

impl CodesignWatch for Shared {
    fn fitting(&self, _: usize, iterations: u64) {
        self.total(iterations);
    }

    fn advanced(&self, n: u64) {
        self.advance(n);
    }
}

impl From<CodesignError> for Fault {
    fn from(error: CodesignError) -> Fault {
        let class = match error {
            CodesignError::Run(error) => return error.into(),
            CodesignError::Space { .. } | CodesignError::TooFewViews { .. } => Class::Config,
            CodesignError::OutOfReach(_) | CodesignError::Infeasible(_) => Class::GoalMissed,
            CodesignError::Tune { .. } => Class::Input,
        };
        Fault::new(class, error.to_string())
    }
}

/// A space file: its text, and what messages call it.
fn space(given: &Bound<'_, PyAny>) -> PyResult<(String, String)> {
    if given.is_instance_of::<PyDict>() {
        let py = given.py();
        let text: String = py.import("json")?.call_method1("dumps", (given,))?.extract()?;
        let wrong = |e: &dyn std::fmt::Display| Fault::config(format!("space: {e}")).raise();
        let value: serde_json::Value = serde_json::from_str(&text).map_err(|e| wrong(&e))?;
        return Ok((toml::to_string(&value).map_err(|e| wrong(&e))?, "space".into()));
    }
    let path = path_text(given)?;
    let mut text = String::new();
    let read =
        File::open(&path).and_then(|file| file.take(TEXT_MAX as u64 + 1).read_to_string(&mut text));
    read.map_err(|e| Fault::config(format!("{path}: {e}")).raise())?;
    Ok((text, path))
}

/// What a co-design found.
///
/// ``model`` and ``machine`` are the pair that needs the fewest watts together; ``ways`` puts it
/// beside what searching one half after the other finds. Notebooks show the page of the run.
#[pyclass(frozen, module = "powergs", name = "Codesigned")]
pub struct Codesigned {
    name: String,
    finished: Finished,
    joint: Option<(Gaussians, Arc<System>)>,
    drawn: Vec<Drawing>,
    text: String,
    html: String,
    headline: String,
}

impl Codesigned {
    fn of(
        codesign: &Codesign,
        finished: Finished,
        store: &dyn powergs_core::run::Store,
    ) -> Result<Codesigned, Fault> {
        let found = finished.of(Way::Joint).and_then(|c| c.found.as_ref().ok());
        let (mut joint, mut picture) = (None, None);
        if let Some(found) = found {
            let model = &finished.models[found.pair.0];
            let scene = codesign.scene(store, model)?;
            joint = Some((scene, system(codesign, &model.point, found.pair.1)?));
            picture = Some(codesign.picture(store, model)?);
        }
        let drawn = charts(&finished, picture.as_ref());
        let page = document(&finished, &drawn);
        let html = page.fragment();
        Ok(Codesigned {
            name: codesign.campaign.name.clone(),
            joint,
            text: page.terminal(100),
            html: html.map_err(|e| Fault::new(Class::Internal, e.to_string()))?,
            headline: headline(&finished),
            drawn,
            finished,
        })
    }

    fn joint(&self) -> PyResult<&(Gaussians, Arc<System>)> {
        self.joint.as_ref().ok_or_else(|| Fault::new(Class::GoalMissed, &*self.headline).raise())
    }

    fn model_name(&self, model: usize) -> String {
        self.finished.models[model].point.name()
    }
}

/// A machine of the space with the record of a model.
fn system(
    codesign: &Codesign,
    model: &ModelPoint,
    machine: MachinePoint,
) -> Result<Arc<System>, Fault> {
    let text = codesign.machine_toml(model, machine)?;
    let internal = |e: &dyn std::fmt::Display| Fault::new(Class::Internal, e.to_string());
    let (name, mut files) = parts("joint", &codesign.machines.base);
    if let Some(file) = files.get_mut(FileKind::Machine.role()) {
        file.3 = text;
    }
    Ok(Arc::new(unpickled((name, files)).map_err(|e| internal(&e))?))
}

#[pymethods]
impl Codesigned {
    /// The model of the joint pair, as a machine reads it.
    #[getter]
    fn model(&self) -> PyResult<Scene> {
        Ok(Scene::of(&self.name, "co-designed", self.joint()?.0.clone()))
    }

    /// The machine of the joint pair, with the record of the model.
    #[getter]
    fn machine(&self) -> PyResult<Machine> {
        Ok(Machine::new("joint", (*self.joint()?.1).clone()))
    }

    /// The five ways (a) to (e), confirmed with the banked model of the DRAM: model, machine (its
    /// point of the space, nothing for the base machine, and what it has on the axes), watts, area,
    /// slowest frame. What a way does not find is nothing.
    #[getter]
    fn ways(&self) -> PyResult<Table> {
        let found = |c: &Comparison| c.found.as_ref().ok().copied();
        let all: Vec<(Way, Option<Found>)> =
            self.finished.comparisons.iter().map(|c| (c.way, found(c))).collect();
        let real = |name: &str, unit: &str, what: &str, of: &dyn Fn(&Price) -> Option<f64>| {
            let value = |(_, found): &(Way, Option<Found>)| of(&found.as_ref()?.confirmed);
            Column::real(name, unit, what, all.iter().map(value))
        };
        let model =
            |(_, found): &(Way, Option<Found>)| Some(self.model_name(found.as_ref()?.pair.0));
        let settings = |(_, found): &(Way, Option<Found>)| {
            let (model, machine) = found.as_ref()?.pair;
            Some(self.finished.rows[model].name(machine))
        };
        Table::new([
            Column::text("way", "Its letter.", all.iter().map(|w| Some(w.0.letter().to_string()))),
            Column::text("how", "How it is chosen.", all.iter().map(|w| Some(w.0.words()))),
            Column::text("model", "The model.", all.iter().map(model)),
            Column::count(
                "machine",
                "1",
                "The point of the machine; nothing: the base machine.",
                all.iter().map(|w| w.1.as_ref()?.pair.1),
            ),
            Column::text("settings", "What it has on the axes.", all.iter().map(settings)),
            real("total_w", "W", "Display, rendering and standby.", &|p| Some(p.total_w)),
            real("display_w", "W", "The display.", &|p| Some(p.display_w)),
            real("standby_w", "W", "Leakage, background, refresh.", &|p| Some(p.stages_w[3])),
            real("area_mm2", "mm2", "The chip.", &|p| p.area_mm2),
            real("frame_time_ms_max", "ms", "The slowest frame.", &|p| Some(p.frame_ms)),
        ])
    }

    /// All models, the dense one first: what they are, and whether they reach the quality.
    #[getter]
    fn models(&self) -> PyResult<Table> {
        let all = || self.finished.models.iter();
        let quality = |m: &powergs_codesign::fit::Fitted| m.facts.gate.quality.psnr_db;
        let passed = Finished::passed(&self.finished.models);
        Table::new([
            Column::text("model", "Its name.", all().map(|m| Some(m.point.name()))),
            Column::real("rho", "1", "Share that is pruned.", all().map(|m| Some(m.point.rho))),
            Column::text("formats", "Its formats.", all().map(|m| Some(m.point.format.as_str()))),
            Column::count(
                "codebook",
                "1",
                "Entries of its codebook of colours; 0 for none.",
                all().map(|m| Some(m.point.formats.codebook.map_or(0, |n| n.get().into()))),
            ),
            Column::count(
                "gaussians",
                "1",
                "Gaussians.",
                all().map(|m| Some(m.facts.points as u64)),
            ),
            Column::flag("passed", "Whether it reaches the quality.", passed.into_iter().map(Some)),
            Column::real(
                "gate_psnr_db",
                "dB",
                "Over the gate views.",
                all().map(|m| Some(quality(m))),
            ),
            Column::real(
                "test_psnr_db",
                "dB",
                "Over the test views.",
                all().map(|m| Some(m.facts.test.quality.psnr_db)),
            ),
            Column::real(
                "gate_display_w",
                "W",
                "Display power over the gate views.",
                all().map(|m| Some(m.facts.gate.display_w)),
            ),
        ])
    }

    /// Every pair that was priced, under the first energy table, with the calibrated model of the
    /// DRAM.
    #[getter]
    fn pairs(&self) -> PyResult<Table> {
        let rows = self.finished.rows.iter().enumerate();
        let pairs = rows.flat_map(|(model, row)| {
            row.pairs.iter().filter_map(move |(machine, fate)| match fate {
                Fate::Priced(prices) => Some((model, *machine, prices.first()?[0])),
                Fate::Refused(_) => None,
            })
        });
        let pairs: Vec<(usize, MachinePoint, Price)> = pairs.collect();
        let real = |name: &str, unit: &str, what: &str, of: &dyn Fn(&Price) -> Option<f64>| {
            Column::real(name, unit, what, pairs.iter().map(|p| of(&p.2)))
        };
        Table::new([
            Column::text("model", "The model.", pairs.iter().map(|p| Some(self.model_name(p.0)))),
            Column::count(
                "machine",
                "1",
                "The point of the machine; nothing: the base machine.",
                pairs.iter().map(|p| p.1),
            ),
            Column::flag(
                "is_within_budget",
                "Whether it keeps area and deadline.",
                pairs.iter().map(|p| Some(self.finished.budget.limit(&p.2).is_none())),
            ),
            real("total_w", "W", "Display, rendering and standby.", &|p| Some(p.total_w)),
            real("display_w", "W", "The display.", &|p| Some(p.display_w)),
            real("standby_w", "W", "Leakage, background, refresh.", &|p| Some(p.stages_w[3])),
            real("area_mm2", "mm2", "The chip.", &|p| p.area_mm2),
            real("frame_time_ms_max", "ms", "The slowest frame.", &|p| Some(p.frame_ms)),
            real("dram_bytes", "B", "DRAM traffic of a frame.", &|p| Some(p.dram_bytes)),
        ])
    }

    /// Watts that the joint pair saves against the best of (a) to (d), confirmed.
    #[getter]
    fn gain_w(&self) -> Option<f64> {
        self.finished.gain_w()
    }

    /// The charts of the run by name.
    fn charts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for chart in &self.drawn {
            dict.set_item(chart.name, Bound::new(py, Chart::new(chart.clone()))?)?;
        }
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        format!("<Codesigned {}: {}>", self.name, self.headline)
    }

    fn __str__(&self) -> &str {
        &self.text
    }

    fn _repr_html_(&self) -> &str {
        &self.html
    }
}

/// The model and the machine that need the fewest watts together: every model of a space is
/// fine-tuned to the quality once and priced on every machine of it.
///
/// Parameters
/// ----------
/// scene : Scene
///     The trained model. It is compared with its own renders.
/// cameras : Cameras
///     Its views; some train, some decide, some are only reported.
/// space : path or dict
///     The space, as a TOML file or the same as a dictionary: axes of the model, axes of the
///     machine, the budget.
/// quality : str or float, optional
///     ``"H"``, ``"M"`` or ``"L"``, or decibels; that of the space's budget, else ``"M"``.
/// rounds : int
///     Rounds at most in which the machine that was found gives another ratio to try.
/// halving : bool
///     Fine-tune all models for a part of the iterations first, and only the better ones in full.
/// size : (int, int), optional
///     Width and height of the views, pixels, in place of their own.
/// store : path, optional
///     Folder in which models and pairs are kept: a run that was interrupted goes on there, and
///     another space makes only what is new.
/// memory : int or str, optional
///     What binned frames may take.
/// progress : bool, function or bar, optional
///     As for ``Trace.replay``; counts iterations, then machines times frames.
/// **settings : int, optional
///     ``iterations`` of a fine-tune at most, ``interval`` between checks of the quality, the
///     ``seed`` of the order of views, ``checkpoint_every`` so many iterations.
///
/// Raises ``GoalMissed`` where no model reaches the quality or no pair keeps the budget.
#[pyfunction]
#[pyo3(signature = (scene, cameras, space, *, quality=None, rounds=5, halving=false, size=None,
                    store=None, memory=None, progress=None, **settings))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn codesign(
    py: Python<'_>,
    scene: &Scene,
    cameras: &Cameras,
    space: &Bound<'_, PyAny>,
    quality: Option<&Bound<'_, PyAny>>,
    rounds: u32,
    halving: bool,
    size: Option<(u32, u32)>,
    store: Option<&Bound<'_, PyAny>>,
    memory: Option<&Bound<'_, PyAny>>,
    progress: Option<&Bound<'_, PyAny>>,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Codesigned> {
    const _: () = assert!(ROUNDS == 5, "the default above");
    let (text, origin) = self::space(space)?;
    let file = SpaceFile::parse(&text).map_err(|e| Fault::from(RunError::config(&origin, e)));
    let mut file = file?;
    if !space.is_instance_of::<PyDict>() {
        file.machine.folder = Path::new(&origin).parent().map(Path::to_path_buf);
    }
    let memory = budget(memory)?.unwrap_or(Budget::DEFAULT);
    let machines = Machines::open(&file.machine, &text, &origin).map_err(Fault::from)?;
    let display = machines.base.display().cloned();
    let display = display.ok_or_else(|| Fault::config("a machine without a display").raise())?;
    let own = file.budget.psnr.map(|psnr_db| Goal::Absolute { psnr_db, ssim: 0.0 });
    let goal = goal(quality)?.or(own).unwrap_or_else(|| Goal::Levels(vec![Level::Medium]));
    let settings = settings_of("codesign", settings, |s| FIT_SETTINGS.contains(&s.key))?;
    let settings = Settings { final_iterations: settings.iterations, ..settings };
    let oracle = CycleOracle { system: machines.base.clone(), fps: machines.fps(), memory };
    let (dense, views) = ((*scene.gaussians()?).clone(), resized(cameras.views().to_vec(), size)?);
    let request = Request {
        goals: Goals { goal: Some(goal), ..Goals::default() },
        settings,
        least_gate: 0,
        ..Request::new(scene.label(), dense, views, oracle, display)
    };
    let store = store.map(path_text).transpose()?;
    let work = move |shared: &Shared| {
        let store = crate::sweep::store(store, shared);
        let campaign = Campaign::open(request, &())?;
        let mut codesign = Codesign::open(campaign, file, &text, &origin)?;
        codesign.rounds = rounds;
        codesign.halving = halving;
        codesign.memory = usize::try_from(memory.0.0).unwrap_or(usize::MAX);
        let finished = codesign.run(&*store, shared)?;
        // Cancelled: nobody listens any more.
        let finished = finished.ok_or_else(|| Fault::config("interrupted"))?;
        Codesigned::of(&codesign, finished, &*store)
    };
    watch::run(py, progress, (Counts::Simulations, "steps"), work)
}
