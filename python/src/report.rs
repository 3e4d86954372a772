//! Reports: what frames did on a machine.

use std::sync::{Arc, OnceLock};

use pyo3::exceptions::{PyAttributeError, PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value as Json;

use crate::chart::Chart;
use crate::error::{Fault, defect};
use crate::frames::SharedFrames;
use crate::table::{Column, Table};
use crate::trace::Target;
use crate::watch::{self, Counts};
use powergs_base::config::suggest::nearest;
use powergs_core::run::session::Target as Ran;
use powergs_core::sim::statistics::{Aggregate, Kind, Statistic, catalogue};
use powergs_report as report;
use powergs_study::replay::Replay;
use powergs_study::run_record::Run;

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
    json: OnceLock<Json>,
}

impl Report {
    /// A report of a run.
    pub fn new(live: Live, run: Run) -> Report {
        Report { state: State::Live(Box::new((live, run))), json: OnceLock::new() }
    }

    fn json(&self) -> &Json {
        self.json.get_or_init(|| match &self.state {
            State::Live(live) => report::json::report(&live.1),
            State::Kept(_) => Json::Null,
        })
    }

    /// A value of the report by path.
    fn at(&self, path: &str) -> &Json {
        path.split('.').fold(self.json(), |at, part| &at[part])
    }

    fn real(&self, path: &str) -> Option<f64> {
        self.at(path).as_f64()
    }

    fn page(&self) -> Option<report::document::Document> {
        match &self.state {
            State::Live(live) => Some(report::page::document(&live.1, &[], &[])),
            State::Kept(_) => None,
        }
    }

    fn text(&self) -> String {
        match &self.state {
            State::Live(_) => self.page().map(|page| page.terminal(100)).unwrap_or_default(),
            State::Kept(kept) => kept.text.clone(),
        }
    }

    fn html(&self) -> PyResult<String> {
        match &self.state {
            State::Kept(kept) => Ok(kept.html.clone()),
            State::Live(_) => {
                self.page().map_or(Ok(String::new()), |page| page.fragment().map_err(defect))
            }
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

/// The value at the dots of a name.
fn dotted<'a>(json: &'a Json, name: &str) -> &'a Json {
    name.split('.').fold(json, |at, part| &at[part])
}

/// A column of the frames: the values of a statistic.
fn column(statistic: &Statistic, frames: &[Json]) -> Column {
    let values = frames.iter().map(|frame| dotted(frame, &statistic.name));
    let (name, unit, definition) = (&statistic.name, statistic.unit, &statistic.definition);
    match statistic.kind {
        Kind::Count => Column::count(name, unit, definition, values.map(Json::as_u64)),
        Kind::Real => Column::real(name, unit, definition, values.map(Json::as_f64)),
    }
}

#[pymethods]
impl Report {
    /// Every statistic of every frame: a row per frame. Units and definitions are in the metadata
    /// of the columns.
    #[getter]
    fn frames(&self) -> PyResult<Table> {
        let frames = self.at("frames").as_array().map_or(&[][..], Vec::as_slice);
        let first = [
            Column::count(
                "frame",
                "1",
                "Position in the trace.",
                frames.iter().map(|frame| frame["frame"].as_u64()),
            ),
            Column::text("name", "Name of the view.", frames.iter().map(|f| f["name"].as_str())),
        ];
        let statistics = catalogue().iter().map(|statistic| column(statistic, frames));
        Table::new(first.into_iter().chain(statistics))
    }

    /// Every statistic over the frames: a row per statistic, with ``unit``, ``mean``, ``p50``,
    /// ``p95``, ``p99``, ``max`` and ``definition``.
    #[getter]
    fn summary(&self) -> PyResult<Table> {
        let all = catalogue();
        let aggregates = self.at("aggregate");
        let part = |part: &'static str, what: &'static str| {
            let value = move |s: &Statistic| dotted(aggregates, &s.name)[part].as_f64();
            Column::real(part, "", what, all.iter().map(value))
        };
        Table::new([
            Column::text("statistic", "Its name.", all.iter().map(|s| Some(&s.name))),
            Column::text("unit", "Its unit.", all.iter().map(|s| Some(s.unit))),
            part("mean", "Mean over the frames; of powers, energy over time."),
            part("p50", "Half of the frames are at or below it."),
            part("p95", "95 % of the frames are at or below it."),
            part("p99", "99 % of the frames are at or below it."),
            part("max", "The largest."),
            Column::text("definition", "What it is.", all.iter().map(|s| Some(&s.definition))),
        ])
    }

    /// Name of the machine.
    #[getter]
    fn machine(&self) -> &str {
        self.at("machine.name").as_str().unwrap_or_default()
    }

    /// Name of the trace.
    #[getter]
    fn trace(&self) -> &str {
        self.at("trace.name").as_str().unwrap_or_default()
    }

    /// ``"cycle"`` or ``"paper"``.
    #[getter]
    fn model(&self) -> &str {
        self.at("model").as_str().unwrap_or_default()
    }

    /// Display rate, frames per second.
    #[getter]
    fn fps(&self) -> f64 {
        self.real("fps").unwrap_or_default()
    }

    /// Frames per second when frames run back to back; ``None`` in the ``paper`` model.
    #[getter]
    fn throughput_fps(&self) -> Option<f64> {
        self.real("throughput_fps")
    }

    /// Power at that rate, watts; ``None`` in the ``paper`` model.
    #[getter]
    fn throughput_power_w(&self) -> Option<f64> {
        self.real("throughput_power_w")
    }

    /// Mean time of a frame, milliseconds; ``None`` in the ``paper`` model.
    #[getter]
    fn frame_time_ms(&self) -> Option<f64> {
        self.real("aggregate.frame_time_ms.mean")
    }

    /// Mean energy of a frame, picojoules.
    #[getter]
    fn energy_pj(&self) -> Option<f64> {
        self.real("aggregate.energy_pj.total.mean")
    }

    /// Power at the display rate, watts.
    #[getter]
    fn power_w(&self) -> Option<f64> {
        self.real("aggregate.power_w.total.mean")
    }

    /// Power of the display, watts, where the trace has the means of its pictures.
    #[getter]
    fn display_power_w(&self) -> Option<f64> {
        self.real("aggregate.display_power_w.mean")
    }

    /// Area of the chip, mm²; ``None`` where the energy table has no areas.
    #[getter]
    fn area_mm2(&self) -> Option<f64> {
        self.real("aggregate.area_mm2.total.mean")
    }

    /// Frames that took longer than a period of the display; ``None`` in the ``paper`` model.
    #[getter]
    fn deadline_misses(&self) -> Option<u64> {
        self.at("deadline_misses").as_u64()
    }

    /// What limits the machine; ``None`` in a model without time.
    #[getter]
    fn bottleneck(&self) -> Option<Bottleneck> {
        Bottleneck::of(self.at("bottleneck"))
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
        let json = report::json::report(&run);
        what_if(json["what_if"]["doubled"].as_array().map_or(&[][..], Vec::as_slice))
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

    /// The report as JSON, as ``powergs-sim replay --json --what-if 0`` prints it.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string_pretty(self.json()).map(|text| text + "\n").map_err(defect)
    }

    /// The report as a dictionary with the structure of ``to_json``.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(self.json()).map_err(defect)?;
        py.import("json")?.call_method1("loads", (text,))
    }

    /// A statistic by name: its mean, or the part that follows the name.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let aggregates = self.at("aggregate");
        let whole = catalogue().iter().find(|s| s.name == name);
        let found = match whole {
            Some(_) => Some((name, "mean")),
            None => name.rsplit_once('.').filter(|(name, part)| {
                Aggregate::PARTS.contains(part) && catalogue().iter().any(|s| s.name == *name)
            }),
        };
        let Some((name, part)) = found else {
            let near = nearest(name, catalogue().iter().map(|s| s.name.as_str()));
            let hint = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            return Err(PyKeyError::new_err(format!("no statistic `{name}`{hint}")));
        };
        number(py, &dotted(aggregates, name)[part])
    }

    fn __getattr__(&self, name: &str) -> PyResult<()> {
        let near = catalogue().iter().find(|s| s.name == name || s.name.starts_with(name));
        let hint = near.map(|s| format!("; statistics are items: report[\"{}\"]", s.name));
        let hint = hint.filter(|_| !name.starts_with('_')).unwrap_or_default();
        Err(PyAttributeError::new_err(format!("a report has no attribute `{name}`{hint}")))
    }

    fn __repr__(&self) -> String {
        let number = |path: &str| self.real(path).map(report::format::significant);
        let fps = number("throughput_fps").map(|fps| format!(", {fps} FPS"));
        let power = number("aggregate.power_w.total.mean").map(|watts| format!(", {watts} W"));
        let [fps, power] = [fps, power].map(Option::unwrap_or_default);
        let frames = self.at("frames").as_array().map_or(0, Vec::len);
        format!("<Report {} on {}: {frames} frames{fps}{power}>", self.trace(), self.machine())
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
    let state = State::Kept(Kept { charts, html, text });
    Ok(Report { state, json: OnceLock::from(json) })
}

fn number<'py>(py: Python<'py>, value: &Json) -> PyResult<Bound<'py, PyAny>> {
    if let Some(count) = value.as_u64() {
        return Ok(count.into_pyobject(py)?.into_any());
    }
    match value.as_f64() {
        Some(number) => Ok(number.into_pyobject(py)?.into_any()),
        None => Ok(py.None().into_bound(py)),
    }
}

/// The table of a what-if experiment.
fn what_if(steps: &[Json]) -> PyResult<Table> {
    let sets = |step: &Json| {
        let sets = step["set"].as_array()?;
        Some(sets.iter().filter_map(Json::as_str).collect::<Vec<_>>().join("; "))
    };
    let real = |name: &'static str, unit: &'static str, what: &'static str| {
        Column::real(name, unit, what, steps.iter().map(move |step| step[name].as_f64()))
    };
    Table::new([
        Column::text("resource", "What is doubled.", steps.iter().map(|s| s["resource"].as_str())),
        Column::text("set", "The keys that double it.", steps.iter().map(sets)),
        real("frame_time_ms", "ms", "Mean time of the frames tried."),
        real("frame_time_change_frac", "1", "Relative change of the time: -0.1 is 10 % less."),
        real("energy_change_frac", "1", "Relative change of the energy of a frame."),
        real("power_change_frac", "1", "Relative change of the power at the display rate."),
        real("area_change_frac", "1", "Relative change of the area of the chip."),
        real("fps_per_mm2_change_frac", "1", "Relative change of frames per second and mm²."),
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
    fn of(json: &Json) -> Option<Bottleneck> {
        let text = |json: &Json| json.as_str().unwrap_or_default().to_owned();
        let shares = |key: &str, name: &str| -> Vec<(String, f64)> {
            let all = json[key].as_array().map_or(&[][..], Vec::as_slice);
            all.iter().map(|x| (text(&x[name]), x["frame_frac"].as_f64().unwrap_or(0.0))).collect()
        };
        Some(Bottleneck {
            limit: json["limit"].as_str()?.to_owned(),
            sentence: text(&json["sentence"]),
            bounds: shares("bounds", "unit"),
            waits: shares("waits", "cause"),
            without_work: json["without_work_frac"].as_f64().unwrap_or(0.0),
        })
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
