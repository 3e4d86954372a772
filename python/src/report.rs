//! Reports: what frames did on a machine.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use pyo3::exceptions::{PyAttributeError, PyKeyError, PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value as Json;

use crate::chart::{Chart, style};
use crate::error::{Fault, defect};
use crate::frames::SharedFrames;
use crate::table::{Column, Table};
use crate::trace::Target;
use crate::watch::{self, Counts};
use powergs_base::config::suggest::nearest;
use powergs_chart::Format;
use powergs_core::run::session::Target as Ran;
use powergs_core::sim::statistics::{
    Aggregate, Kind, Statistic, Value, catalogue, find, shown, values,
};
use powergs_core::stage::stage;
use powergs_report as report;
use powergs_report::Drawing;
use powergs_sim::cli::run_folder::RunFolder;
use powergs_sim::cli::{Exit, Failure, OrExit};
use powergs_study::findings::what_if::Step;
use powergs_study::findings::{self, Key, Record, WhatIf, bottleneck};
use powergs_study::replay::Replay;
use powergs_study::run_record::Run;
use powergs_study::sweep::outcome::Outcome;

/// What a report was made of, for experiments beside it.
#[derive(Clone)]
pub struct Live {
    /// The machine or the published model.
    pub target: Arc<Target>,
    /// The frames.
    pub frames: SharedFrames,
    /// Display rate, frames per second.
    pub display_fps: f64,
}

impl Live {
    /// Runs all frames, and doubles resources on some of them.
    pub fn run(
        &self,
        py: Python<'_>,
        what_if_frames: usize,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Run> {
        let Live { target, mut frames, display_fps } = self.clone();
        let counts = if what_if_frames > 0 { Counts::Simulations } else { Counts::Frames };
        watch::run(py, progress, (counts, "frames"), move |shared| {
            let target = match &*target {
                Target::System(system) => Ran::System(system),
                Target::Paper(model) => Ran::Paper(model),
            };
            let replay = Replay {
                latency_ms: None,
                target,
                display_fps,
                what_if_frames,
                calibrates_what_if: true,
                compares_models: false,
            };
            Ok(replay.run(&mut frames, shared)?)
        })
    }
}

/// What is left of a report that was pickled.
struct Kept {
    charts: Vec<(String, String, String)>,
    html: String,
    text: String,
}

enum State {
    Live(Box<(Live, Run)>),
    Kept(Kept),
}

/// What frames did on a machine: times, energies, powers, what limits it.
///
/// ``frames`` and ``summary`` are tables; ``report["power_w.total"]`` is the mean of a statistic,
/// ``report["frame_time_ms.p99"]`` another part of it (``mean``, ``p50``, ``p95``, ``p99``,
/// ``max``). ``powergs.explain(name)`` defines every statistic.
#[pyclass(frozen, module = "powergs", name = "Report")]
pub struct Report {
    state: State,
    /// Name of the machine.
    #[pyo3(get)]
    machine: String,
    /// Name of the trace.
    #[pyo3(get)]
    trace: String,
    /// ``"cycle"`` or ``"paper"``.
    #[pyo3(get)]
    model: String,
    record: Record,
    json: OnceLock<Json>,
}

/// A frame: its position in the trace, the name of its view, its statistics.
type Row = (Option<u64>, Option<String>, Vec<Option<Value>>);

impl Report {
    /// A report of a run, which has frames.
    pub fn new(live: Live, run: Run) -> Report {
        Report {
            machine: run.facts.machine.name.clone(),
            trace: run.facts.trace.name.clone(),
            model: run.facts.model.name().to_owned(),
            record: run.statistics().expect("a reported run has frames"),
            state: State::Live(Box::new((live, run))),
            json: OnceLock::new(),
        }
    }

    fn json(&self) -> &Json {
        self.json.get_or_init(|| match &self.state {
            State::Live(live) => report::json::report(&live.1),
            State::Kept(_) => Json::Null,
        })
    }

    /// What machines like this one may have, by places in the catalogue.
    fn shown(&self) -> Vec<usize> {
        shown(|i| self.record.aggregates[i].is_some())
    }

    fn rows(&self) -> Vec<Row> {
        let State::Live(live) = &self.state else {
            let frames = self.json()["frames"].as_array().map_or(&[][..], Vec::as_slice);
            let name = |frame: &Json| frame["name"].as_str().map(str::to_owned);
            let row = |f: &Json| (f["frame"].as_u64(), name(f), report::json::values(f));
            return frames.iter().map(row).collect();
        };
        let fps = self.record.display_fps;
        let frames = live.1.frames.iter();
        frames.map(|f| (Some(f.frame as u64), Some(f.name.clone()), values(f, fps))).collect()
    }

    fn text(&self) -> String {
        match &self.state {
            State::Live(live) => report::page::document(&live.1, &[], &[]).terminal(100),
            State::Kept(kept) => kept.text.clone(),
        }
    }

    fn html(&self) -> PyResult<String> {
        match &self.state {
            State::Live(live) => {
                report::page::document(&live.1, &[], &[]).fragment().map_err(defect)
            }
            State::Kept(kept) => Ok(kept.html.clone()),
        }
    }

    fn list(&self) -> PyResult<Vec<Chart>> {
        match &self.state {
            State::Live(live) => {
                Ok(report::charts::all(&live.1).into_iter().map(Chart::new).collect())
            }
            State::Kept(kept) => {
                let chart = |(name, title, svg): &(String, String, String)| {
                    Chart::kept(name.clone(), title.clone(), svg.clone())
                };
                Ok(kept.charts.iter().map(chart).collect())
            }
        }
    }
}

/// A column of the frames: the values of a statistic, whose place in the catalogue is `at`.
fn column((at, statistic): (usize, &Statistic), rows: &[Row]) -> Column {
    let (name, unit, definition) = (&statistic.name, statistic.unit, &statistic.definition);
    let values = rows.iter().map(|(_, _, row)| row[at]);
    match statistic.kind {
        Kind::Count => {
            let counts = values.map(|value| match value {
                Some(Value::Count(n)) => Some(n),
                _ => None,
            });
            Column::count(name, unit, definition, counts)
        }
        Kind::Real => Column::real(name, unit, definition, values.map(|v| v.map(Value::as_f64))),
    }
}

#[pymethods]
impl Report {
    /// Every statistic of every frame: a row per frame. Units and definitions are in the metadata
    /// of the columns.
    #[getter]
    fn frames(&self) -> PyResult<Table> {
        let rows = self.rows();
        let first = [
            Column::count("frame", "1", "Position in the trace.", rows.iter().map(|row| row.0)),
            Column::text("name", "Name of the view.", rows.iter().map(|row| row.1.as_ref())),
        ];
        let own = self.shown();
        let statistics = own.iter().map(|&i| column((i, &catalogue()[i]), &rows));
        Table::new(first.into_iter().chain(statistics))
    }

    /// Every statistic over the frames: a row per statistic, with ``unit``, ``mean``, ``p50``,
    /// ``p95``, ``p99``, ``max`` and ``definition``.
    #[getter]
    fn summary(&self) -> PyResult<Table> {
        let own = self.shown();
        let all: Vec<&Statistic> = own.iter().map(|&i| &catalogue()[i]).collect();
        let part = |i: usize, what: &'static str| {
            let value = |at: &usize| Some(self.record.aggregates[*at]?.parts()[i].as_f64());
            Column::real(Aggregate::PARTS[i], "", what, own.iter().map(value))
        };
        Table::new([
            Column::text("statistic", "Its name.", all.iter().map(|s| Some(&s.name))),
            Column::text("unit", "Its unit.", all.iter().map(|s| Some(s.unit))),
            part(0, "Mean over the frames; of powers, energy over time."),
            part(1, "Half of the frames are at or below it."),
            part(2, "95 % of the frames are at or below it."),
            part(3, "99 % of the frames are at or below it."),
            part(4, "The largest."),
            Column::text("definition", "What it is.", all.iter().map(|s| Some(&s.definition))),
        ])
    }

    /// Display rate, frames per second.
    #[getter]
    fn fps(&self) -> f64 {
        self.record.display_fps
    }

    /// Frames per second when frames run back to back; NaN in the ``paper`` model, which has no
    /// time.
    #[getter]
    fn throughput_fps(&self) -> f64 {
        self.record.throughput_fps().unwrap_or(f64::NAN)
    }

    /// Power at that rate, watts; NaN in the ``paper`` model.
    #[getter]
    fn throughput_power_w(&self) -> f64 {
        self.record.throughput_power_w().unwrap_or(f64::NAN)
    }

    /// Mean time of a frame, milliseconds; NaN in the ``paper`` model.
    #[getter]
    fn frame_time_ms(&self) -> f64 {
        self.record.mean(Key::FrameTime).unwrap_or(f64::NAN)
    }

    /// Mean energy of a frame, picojoules; NaN where the energy table lacks a price.
    #[getter]
    fn energy_pj(&self) -> f64 {
        self.record.mean(Key::Energy).unwrap_or(f64::NAN)
    }

    /// Power at the display rate, watts; NaN where the energy table lacks a price.
    #[getter]
    fn power_w(&self) -> f64 {
        self.record.mean(Key::Power).unwrap_or(f64::NAN)
    }

    /// Power of the display, watts, where the trace has the means of its pictures.
    #[getter]
    fn display_power_w(&self) -> Option<f64> {
        self.record.mean(Key::DisplayPower)
    }

    /// Area of the chip, mm²; NaN where the energy table has no areas.
    #[getter]
    fn area_mm2(&self) -> f64 {
        self.record.mean(Key::Area).unwrap_or(f64::NAN)
    }

    /// Frames that took longer than a period of the display; ``None`` in the ``paper`` model.
    #[getter]
    fn deadline_misses(&self) -> Option<u64> {
        self.record.deadline_misses()
    }

    /// What limits the machine. Raises ``ConfigError`` in the ``paper`` model, which has no time.
    #[getter]
    fn bottleneck(&self) -> PyResult<Bottleneck> {
        let found = bottleneck::of(&self.record);
        let none =
            || Fault::config("a model without time has no bottleneck: use a machine").raise();
        found.as_ref().map(Bottleneck::of).ok_or_else(none)
    }

    /// What doubling each resource would buy, by simulation of ``frames`` frames spread over the
    /// trace: ``resource``, ``set`` (what to give to ``with_``) and relative changes.
    #[pyo3(signature = (frames=3, *, progress=None))]
    fn what_if(
        &self,
        py: Python<'_>,
        frames: usize,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Table> {
        if frames == 0 {
            return Err(Fault::config("frames=0: at least one").raise());
        }
        let State::Live(live) = &self.state else {
            let what = "a report that was pickled has no trace: replay it again for what_if";
            return Err(PyValueError::new_err(what));
        };
        if matches!(*live.0.target, Target::Paper(_)) {
            let what = "the paper model has no machine whose resources could be doubled";
            return Err(Fault::config(what).raise());
        }
        if !live.0.frames.is_open() {
            return Err(crate::error::closed("trace"));
        }
        let run = live.0.run(py, frames, progress)?;
        let experiment = run.experiments.what_if.as_ref();
        what_if(experiment.ok_or_else(|| defect("a replay without its experiment"))?)
    }

    /// The charts of the report by name.
    fn charts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for chart in self.list()? {
            let chart = Bound::new(py, chart)?;
            dict.set_item(chart.getattr("name")?, chart)?;
        }
        Ok(dict)
    }

    /// Writes the report folder that ``powergs-sim replay --what-if 0`` writes: pages, tables,
    /// charts (``size``, ``title`` as for ``Chart.styled``; ``formats`` of ``"svg"``, ``"png"``,
    /// ``"pdf"``, by default the first two) and the record. It appears whole or not at all.
    ///
    /// Raises ``OSError`` where something is there; ``overwrite`` replaces a finished report.
    #[pyo3(signature = (folder, *, overwrite=false, size="slide", title=true,
                        formats=None))]
    fn save(
        &self,
        folder: PathBuf,
        overwrite: bool,
        size: &str,
        title: bool,
        formats: Option<Vec<String>>,
    ) -> PyResult<()> {
        let State::Live(live) = &self.state else {
            let what = "a report that was pickled is not written: replay it again";
            return Err(PyValueError::new_err(what));
        };
        let formats = formats.unwrap_or_else(|| ["png", "svg"].map(str::to_owned).to_vec());
        let known = |name: &String| Format::ALL.into_iter().find(|f| f.ending() == name.as_str());
        let formats: Option<Vec<Format>> = formats.iter().map(known).collect();
        let formats = formats.ok_or_else(|| Fault::config("formats: of svg, png, pdf").raise())?;
        let drawing = Drawing { style: style(size, title)?, formats };
        let written = || -> Result<(), Failure> {
            let target = RunFolder::create(Some(&folder), "report", overwrite)?;
            for file in report::files(&live.1, &drawing).or_exit(Exit::Internal, "report")? {
                target.write(&file.name, &file.bytes)?;
            }
            target.finish().map(drop)
        };
        written().map_err(|failure| match failure.exit {
            Exit::Internal => defect(failure),
            _ => PyOSError::new_err(
                failure
                    .to_string()
                    .replace("--force to replace it", "overwrite=True")
                    .replace("--force", "overwrite=True"),
            ),
        })
    }

    /// The report as JSON, as ``powergs-sim replay --json --what-if 0`` prints it.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string_pretty(self.json()).map(|text| text + "\n").map_err(defect)
    }

    /// The report as a dictionary with the structure of ``to_json``.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(self.json()).map_err(defect)?;
        py.import("json")?.call_method1("loads", (text,))
    }

    /// What a sweep keeps of the report, as JSON.
    fn _outcome(&self) -> PyResult<String> {
        let State::Live(live) = &self.state else {
            return Err(PyValueError::new_err("a report that was pickled is in no sweep"));
        };
        let outcome = Outcome::of(&live.1.frames, self.record.display_fps);
        serde_json::to_string(&outcome.ok_or_else(|| defect("a report without frames"))?)
            .map_err(defect)
    }

    /// A statistic by name: its mean, or the part that follows the name.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let found = find(name).map(|_| (name, 0)).or_else(|| {
            let (name, part) = name.rsplit_once('.')?;
            let part = Aggregate::PARTS.iter().position(|one| *one == part)?;
            find(name).map(|_| (name, part))
        });
        let Some((name, part)) = found else {
            let near = nearest(name, catalogue().iter().map(|s| s.name.as_str()));
            let hint = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            return Err(PyKeyError::new_err(format!("no statistic `{name}`{hint}")));
        };
        match self.record.named(name).map(|all| all.parts()[part]) {
            Some(Value::Count(count)) => Ok(count.into_pyobject(py)?.into_any()),
            Some(Value::Real(number)) => Ok(number.into_pyobject(py)?.into_any()),
            None => Ok(py.None().into_bound(py)),
        }
    }

    fn __getattr__(&self, name: &str) -> PyResult<()> {
        let near = catalogue().iter().find(|s| s.name == name || s.name.starts_with(name));
        let hint = near.map(|s| format!("; statistics are items: report[\"{}\"]", s.name));
        let hint = hint.filter(|_| !name.starts_with('_')).unwrap_or_default();
        Err(PyAttributeError::new_err(format!("a report has no attribute `{name}`{hint}")))
    }

    fn __repr__(&self) -> String {
        let number = |name: &str, value: Option<f64>| {
            let text =
                value.map(|value| format!(", {} {name}", report::format::significant(value)));
            text.unwrap_or_default()
        };
        let fps = number("FPS", self.record.throughput_fps());
        let power = number("W", self.record.mean(Key::Power));
        let frames = self.record.frames;
        format!("<Report {} on {}: {frames} frames{fps}{power}>", self.trace, self.machine)
    }

    fn __str__(&self) -> String {
        self.text()
    }

    fn _repr_html_(&self) -> PyResult<String> {
        self.html()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts)> {
        let of = py.import("powergs._powergs")?.getattr("_report")?;
        let json = serde_json::to_string(self.json()).map_err(defect)?;
        let chart = |chart: &Chart| {
            let (name, title) = chart.names();
            Ok((name.to_owned(), title.to_owned(), chart.drawn()?))
        };
        let charts = self.list()?.iter().map(chart).collect::<PyResult<_>>()?;
        Ok((of, (json, charts, self.html()?, self.text())))
    }
}

/// What a report is pickled as: JSON, charts (name, title, SVG), HTML, text.
type Parts = (String, Vec<(String, String, String)>, String, String);

/// A pickled report.
#[pyfunction]
pub fn _report(
    json: &str,
    charts: Vec<(String, String, String)>,
    html: String,
    text: String,
) -> PyResult<Report> {
    let json: Json = serde_json::from_str(json).map_err(|e| Fault::config(e.to_string()))?;
    let text_at = |json: &Json| json.as_str().unwrap_or_default().to_owned();
    Ok(Report {
        machine: text_at(&json["machine"]["name"]),
        trace: text_at(&json["trace"]["name"]),
        model: text_at(&json["model"]),
        record: report::json::record(&json),
        state: State::Kept(Kept { charts, html, text }),
        json: OnceLock::from(json),
    })
}

/// The table of a what-if experiment.
fn what_if(experiment: &WhatIf) -> PyResult<Table> {
    let steps = &experiment.steps;
    let sets = steps.iter().map(|step| Some(step.sets.join("; ")));
    let times = steps.iter().map(|step| Some(step.cost.frame_time_ms));
    let change = |name: &str, what: &str, of: &dyn Fn(&Step) -> Option<f64>| {
        let (name, what) = (format!("{name}_change_frac"), format!("Relative change of {what}."));
        Column::real(&name, "1", &what, steps.iter().map(of))
    };
    Table::new([
        Column::text("resource", "What is doubled.", steps.iter().map(|s| Some(s.resource))),
        Column::text("set", "The keys that double it.", sets),
        Column::real("frame_time_ms", "ms", "Mean time of the frames tried.", times),
        change("frame_time", "the time: -0.1 is 10 % less", &|s| Some(experiment.time_change(s))),
        change("energy", "the energy of a frame", &|s| Some(experiment.energy_change(s))),
        change("power", "the power at the display rate", &|s| Some(experiment.power_change(s))),
        change("area", "the area of the chip", &|s| experiment.area_change(s)),
        change("fps_per_mm2", "frames per second and mm²", &|s| experiment.merit_change(s)),
    ])
}

/// What limits a machine, and why.
#[pyclass(frozen, module = "powergs", name = "Bottleneck", get_all)]
#[derive(Clone)]
pub struct Bottleneck {
    /// What to make faster first: a unit, ``"colour"`` or ``"dram"``.
    limit: String,
    /// The same as a sentence.
    sentence: String,
    /// Leading units at work: name and share of the frame, largest first.
    bounds: Vec<(String, f64)>,
    /// Leading units that wait: cause and share of the frame, largest first.
    waits: Vec<(String, f64)>,
    /// Share of the frame in which leading units have no work.
    without_work: f64,
}

impl Bottleneck {
    fn of(found: &findings::Bottleneck) -> Bottleneck {
        let bounds = found.bounds.iter().map(|b| (stage(b.unit).key.to_owned(), b.share));
        let waits = found.waits.iter().map(|w| (w.cause.name().to_owned(), w.share));
        Bottleneck {
            limit: found.limit.name().to_owned(),
            sentence: report::bottleneck::sentence(found),
            bounds: bounds.collect(),
            waits: waits.collect(),
            without_work: found.without_work,
        }
    }
}

#[pymethods]
impl Bottleneck {
    fn __repr__(&self) -> String {
        format!("<Bottleneck {}: {}>", self.limit, self.sentence)
    }

    fn __str__(&self) -> &str {
        &self.sentence
    }
}
