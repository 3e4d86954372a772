//! Machines beside each other, published numbers beside ours, a memory device alone.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value as Json;

use crate::chart::Chart;
use crate::commands::of_csv;
use crate::error::{Class, Fault, defect};
use crate::machine::{Machine, path_text};
use crate::table::{Column, Table};
use crate::trace::{Trace, budget};
use crate::value::{changes, display_rate};
use crate::watch::{self, Counts, Shared};
use powergs_base::config::embedded::DRAM;
use powergs_chart::Chart as Drawing;
use powergs_core::run::files::read;
use powergs_core::run::{Frames, RunError, System};
use powergs_dram::address_trace::Requests;
use powergs_dram::stream::run_stream;
use powergs_dram::{Device, Mode};
use powergs_report as report;
use powergs_study::findings::compare::{
    Across, AskedLimits, Comparison as Compared, Decision, Side,
};
use powergs_study::replay::on_each;
use powergs_study::speedup::SpeedUp;
use powergs_study::validate::run::{MEMORY, steps, value};
use powergs_study::validate::{
    BASELINE, Built, MachineName, PUBLISHED, Row, Tables, WORKLOADS, judge, measure,
};
use powergs_views::rendered;

/// A measure of all machines.
struct Measured {
    trace: String,
    name: &'static str,
    values: Vec<Option<f64>>,
    /// To the first machine.
    ratios: Vec<Option<f64>>,
}

/// Machines beside each other on the same frames; the first is what the others are compared with.
#[pyclass(frozen, module = "powergs", name = "Comparison")]
pub struct Comparison {
    labels: Vec<String>,
    measures: Vec<Measured>,
    /// Frames per second of the slowest other machine over those of the first.
    #[pyo3(get)]
    least_speedup: Option<f64>,
    json: Json,
    /// Frame rates to the first machine on every trace, as CSV; empty for one trace.
    speedup: Vec<u8>,
    charts: Vec<Drawing>,
    text: String,
    html: String,
}

impl Comparison {
    /// Of one comparison per trace.
    fn of(all: &[Compared], names: &[String], limits: &AskedLimits) -> Result<Comparison, Fault> {
        let first = &all[0];
        let decision = Decision::of(all, limits);
        let decision = decision.map_err(|e| Fault::config(format!("where: {e}")))?;
        let decided = report::compare::Decided { decision: &decision, limits };
        let speedup = SpeedUp::of_comparisons(all);
        let json = report::compare::json_of(all, &decision, speedup.as_ref());
        let (charts, page) = match &speedup {
            None => {
                let charts = report::compare::charts(first, limits.budget_w);
                let page = report::compare::document(first, decided, &charts, None);
                (charts, page)
            }
            Some(speedup) => {
                let of = format!("{} traces", all.len());
                let chart = report::speedup::chart(speedup, of);
                let decision = report::compare::decision_chart(all, decided, &speedup.traces);
                let breakdown = report::compare::breakdown(all, &speedup.traces);
                let mut charts = vec![decision, chart, breakdown];
                charts.extend(report::compare::steps_chart(all, &speedup.traces));
                let page = report::compare::document_of(all, decided, speedup, &charts, None);
                (charts, page)
            }
        };
        let sides = first.sides.len();
        let measures = all.iter().zip(names).flat_map(|(comparison, trace)| {
            comparison.rows.iter().map(move |row| Measured {
                trace: trace.clone(),
                name: row.measure.name(),
                values: row.values.clone(),
                ratios: (0..sides).map(|i| row.ratio(i)).collect(),
            })
        });
        let least = all.iter().map(Compared::least_speedup).collect::<Option<Vec<f64>>>();
        Ok(Comparison {
            labels: first.labels().into_iter().map(str::to_owned).collect(),
            measures: measures.collect(),
            least_speedup: least.and_then(|all| all.into_iter().reduce(f64::min)),
            json,
            speedup: speedup.as_ref().map(report::speedup::csv).unwrap_or_default(),
            text: page.terminal(100),
            html: page.fragment().map_err(|e| Fault::new(Class::Internal, e.to_string()))?,
            charts,
        })
    }
}

#[pymethods]
impl Comparison {
    /// A row per trace and measure: ``trace``, ``measure``, a column per machine, and ``MACHINE /
    /// FIRST`` per other.
    #[getter]
    fn table(&self) -> PyResult<Table> {
        let traces = self.measures.iter().map(|measure| Some(&measure.trace));
        let names = self.measures.iter().map(|measure| Some(measure.name));
        let mut columns = vec![
            Column::text("trace", "Name of the trace.", traces),
            Column::text("measure", "Its name, with its unit.", names),
        ];
        for (i, label) in self.labels.iter().enumerate() {
            let values = self.measures.iter().map(|measure| measure.values[i]);
            columns.push(Column::real(label, "", "Value on this machine.", values));
        }
        for (i, label) in self.labels.iter().enumerate().skip(1) {
            let name = format!("{label} / {}", self.labels[0]);
            let ratios = self.measures.iter().map(|measure| measure.ratios[i]);
            columns.push(Column::real(&name, "1", "Ratio of the two.", ratios));
        }
        Table::new(columns)
    }

    /// With several traces: frame rates over those of the first machine, a row per trace and the
    /// geometric mean; ``None`` with one.
    #[getter]
    fn speedup(&self) -> PyResult<Option<Table>> {
        let some = Some(&self.speedup).filter(|csv| !csv.is_empty());
        some.map(|csv| of_csv(&csv[..], "speedup")).transpose()
    }

    /// Names of the machines; those of one name are numbered.
    #[getter]
    fn labels(&self) -> Vec<String> {
        self.labels.clone()
    }

    /// The comparison with the names of ``powergs-sim compare --json``.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.json.to_string(),))
    }

    /// The charts by name.
    fn charts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for chart in &self.charts {
            dict.set_item(chart.name, Bound::new(py, Chart::new(chart.clone()))?)?;
        }
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        format!("<Comparison: {}>", self.labels.join(", "))
    }

    fn __str__(&self) -> &str {
        &self.text
    }

    fn _repr_html_(&self) -> &str {
        &self.html
    }
}

/// Runs the frames of one trace or of several on machines, and compares them with the first.
///
/// ``machines`` are ``Machine``s, names or paths, two at least; ``fps`` is the display rate. With
/// ``at_least`` the others must have that many times the frame rate of the first. Areas and
/// energies of different technology nodes have ratios only with ``across_nodes``, times and
/// energies of different tasks only with ``across_tasks``. ``budget_w``, ``latency_ms`` and
/// ``where`` (a condition such as ``"area_mm2.total <= 4"``) are what machines must meet besides
/// the display rate.
///
/// Raises ``GoalMissed`` where they have not.
#[pyfunction]
#[pyo3(signature = (
    machines, trace, *, fps=60.0, at_least=None, across_nodes=false, across_tasks=false,
    budget_w=None, latency_ms=None, r#where=None, progress=None
))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn compare(
    py: Python<'_>,
    machines: Vec<Bound<'_, PyAny>>,
    trace: &Bound<'_, PyAny>,
    fps: f64,
    at_least: Option<f64>,
    across_nodes: bool,
    across_tasks: bool,
    budget_w: Option<f64>,
    latency_ms: Option<f64>,
    r#where: Option<&str>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Comparison> {
    if machines.len() < 2 {
        return Err(Fault::config("machines: two at least").raise());
    }
    if at_least.is_some_and(|ratio| !(ratio > 0.0 && ratio.is_finite())) {
        return Err(Fault::config("at_least: a number above zero").raise());
    }
    let fps = display_rate(fps)?;
    let condition = r#where.map(str::parse).transpose();
    let condition = condition.map_err(|e| Fault::config(format!("where: {e}")).raise())?;
    let limits = AskedLimits { budget_w, latency_ms, condition };
    let across = Across { nodes: across_nodes, tasks: across_tasks };
    let mut systems: Vec<System> = Vec::new();
    for machine in &machines {
        systems.push((*Machine::from_argument(machine, None)?.system()).clone());
    }
    let traces: Vec<Py<Trace>> = match trace.cast::<Trace>() {
        Ok(trace) => vec![trace.clone().unbind()],
        Err(_) => trace.extract().map_err(|_| {
            pyo3::exceptions::PyTypeError::new_err("trace: a powergs.Trace or a list of them")
        })?,
    };
    let lists = traces.iter().map(|trace| trace.get().frames());
    let mut lists = lists.collect::<PyResult<Vec<_>>>()?;
    let names: Vec<String> = lists.iter().map(|list| list.name().to_owned()).collect();
    if names.is_empty() {
        return Err(Fault::config("trace: at least one").raise());
    }
    let found = watch::run(py, progress, (Counts::Frames, "frames"), move |shared| {
        let mut all = Vec::new();
        for frames in &mut lists {
            let runs = on_each(&systems, fps, frames, None, shared)?;
            let sides: Option<Vec<Side>> = runs.iter().map(Side::of_run).collect();
            let sides = sides.ok_or_else(|| Fault::config("interrupted"))?;
            all.push(Compared::new(sides, across));
        }
        Comparison::of(&all, &names, &limits)
    })?;
    match (at_least, found.least_speedup) {
        (Some(wanted), Some(least)) if least < wanted => {
            let first = &found.labels[0];
            let what =
                format!("{least:.3} times the frame rate of {first}, {wanted} was asked for");
            Err(Fault::new(Class::GoalMissed, what).raise())
        }
        _ => Ok(found),
    }
}

/// Published numbers beside ours: a row per number, with ``published``, ``ours``, ``deviation``,
/// ``tolerance``, ``status`` and ``verdict``; ``evidence/validation.md`` explains them.
///
/// ``only`` are parts of row names; ``quick`` leaves rows out whose scenes take long (a minute is
/// left). With ``check`` a row that must hold and does not raises ``GoalMissed``.
#[pyfunction]
#[pyo3(signature = (*, only=None, quick=true, check=false, memory=None, progress=None))]
pub fn validate(
    py: Python<'_>,
    only: Option<Vec<String>>,
    quick: bool,
    check: bool,
    memory: Option<&Bound<'_, PyAny>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Table> {
    let only = only.unwrap_or_default();
    let memory = budget(memory)?.unwrap_or(MEMORY);
    let work = move |shared: &Shared| {
        let tables = Tables::parse(PUBLISHED, WORKLOADS, BASELINE);
        let tables = tables.map_err(|e| Fault::new(Class::Internal, e.to_string()))?;
        let wanted = |row: &&Row| {
            (only.is_empty() || only.iter().any(|name| row.id.contains(name.as_str())))
                && (!quick || tables.is_quick(row))
        };
        let rows: Vec<&Row> = tables.rows.iter().filter(wanted).collect();
        if rows.is_empty() {
            return Err(Fault::config("only: no row has such a name"));
        }
        let mut built: BTreeMap<MachineName, Built> = BTreeMap::new();
        for name in rows.iter().flat_map(|row| [Some(&row.machine), row.against.as_ref()]) {
            if let Some(name) = name.filter(|name| !built.contains_key(name)) {
                let spec = powergs_core::run::SystemSpec {
                    machine: name.arch.clone(),
                    sets: name.sets.clone(),
                    ..powergs_core::run::SystemSpec::default()
                };
                let system = System::load(&spec, &powergs_core::run::files::DiskFiles)?;
                built.insert(name.clone(), Built::new(system));
            }
        }
        shared.total(steps(&tables, &rows));
        let measured = measure(&tables, &rows, &built, &rendered, memory, &Counted(shared))?;
        let measured = measured.ok_or_else(|| Fault::config("interrupted"))?;
        let judged: Vec<_> = rows
            .iter()
            .map(|row| {
                let ours = value(row, &measured);
                judge(row, ours.as_ref(), tables.before(row))
            })
            .collect();
        Ok(report::validate::json(&tables, &judged))
    };
    let json = watch::run(py, progress, (Counts::Steps, "frames on machines"), work)?;
    if check && json["passed"] == Json::Bool(false) {
        let what = "a row that must hold is outside of its tolerance, or has worsened";
        return Err(Fault::new(Class::GoalMissed, what).raise());
    }
    let rows = json["rows"].as_array().map_or(&[][..], Vec::as_slice);
    let text = |name: &'static str, what: &'static str| {
        Column::text(name, what, rows.iter().map(move |row| row[name].as_str()))
    };
    let real = |name: &'static str, what: &'static str| {
        Column::real(name, "", what, rows.iter().map(move |row| row[name].as_f64()))
    };
    Table::new([
        text("id", "Name of the row."),
        text("what", "What was published."),
        text("machine", "The machine."),
        text("against", "The machine that it is a ratio to."),
        text("metric", "What is measured."),
        text("unit", "Its unit."),
        real("published", "The published number."),
        real("ours", "What came out."),
        real("deviation", "Ours over published, less one."),
        text("tolerance", "What is allowed."),
        text("status", "What the row is good for."),
        text("verdict", "What to think of it."),
        text("source", "Where the number is from."),
    ])
}

/// Counts simulations whatever sessions begin: the total is known from the start.
struct Counted<'a>(&'a Shared);

impl powergs_core::run::Watch for Counted<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_over()
    }

    fn simulated(&self, n: u64) {
        self.0.advance(n);
    }
}

/// A memory device alone on a list of requests: time, bandwidth, row hits, latencies, commands and
/// energies, as a dictionary with the names of ``powergs-sim dram --json``.
///
/// ``requests`` is the path of an address trace, or a list of ``("R" or "W", address, bytes)``;
/// ``device`` a name of ``names("dram")`` or a TOML file, ``keys`` changes of it; ``mode`` says how
/// requests arrive (``"sat"``, ``"idle"``, ``"mlp32"``, ``"look16"``, ``"rate20"``).
#[pyfunction]
#[pyo3(signature = (requests, *, device="lpddr4-3200-x16x8", keys=None, mode="sat"))]
pub fn dram<'py>(
    py: Python<'py>,
    requests: &Bound<'py, PyAny>,
    device: &str,
    keys: Option<&Bound<'py, PyDict>>,
    mode: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let file = read("DRAM device", device, DRAM, None).map_err(Fault::from)?;
    let sets: Vec<String> = changes(keys, None)?.iter().map(ToString::to_string).collect();
    let device = Device::parse_with(&file.text, &sets);
    let device = device.map_err(|e| Fault::config_file(&file.origin, &e))?;
    let wrong = |e| Fault::config(format!("mode=\"{mode}\": {e}")).raise();
    let mode: Mode = mode.parse().map_err(wrong)?;
    let list: Option<Vec<(String, u64, u64)>> = requests.extract().ok();
    let (place, input): (String, Box<dyn BufRead + Send>) = match list {
        Some(list) => {
            let line = |(kind, address, bytes): &(String, u64, u64)| {
                format!("{kind} {address:#x} {bytes}\n")
            };
            let text: String = list.iter().map(line).collect();
            ("requests".into(), Box::new(Cursor::new(text)))
        }
        None => {
            let path = path_text(requests)?;
            let failed = |e: std::io::Error| Fault::from(RunError::input(&path, e)).raise();
            let file = File::open(&path).map_err(failed)?;
            (path.clone(), Box::new(BufReader::with_capacity(1 << 18, file)))
        }
    };
    let work = move |shared: &Shared| {
        let found = run_stream(&device, mode, Requests::new(input), || shared.is_over());
        let found = found.map_err(|e| Fault::in_file(Class::Input, place, e))?;
        let found = found.ok_or_else(|| Fault::config("interrupted"))?;
        Ok(report::dram::json(&device, mode, &found))
    };
    let json = watch::run(py, None, (Counts::Steps, "requests"), work)?;
    let text = serde_json::to_string(&json).map_err(defect)?;
    py.import("json")?.call_method1("loads", (text,))
}
