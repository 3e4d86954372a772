//! Sweeps: every design of a space on every trace, and which designs to keep.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyAny, PyDict};

use crate::chart::Chart;
use crate::error::{Class, Fault, defect};
use crate::machine::{Machine, path_text};
use crate::table::{Column as Given, Table};
use crate::trace::{Trace, budget};
use crate::value;
use crate::watch::{self, Counts, Shared};
use powergs_base::budget::Budget;
use powergs_core::run::{Change, FileStore, Frames, MemoryStore, RunError, Store, System};
use powergs_report::sweep::{Provenance, charts, document};
use powergs_study::analysis::front::{Costs, front};
use powergs_study::analysis::{
    Analysis, AnalysisError, Misses, Objective, Question, Scope, SweepFacts, Table as Analysed,
};
use powergs_study::sweep::expr::Expr;
use powergs_study::sweep::file::{Objectives, Sampling};
use powergs_study::sweep::gathered::{GatheredDesign, differences, gathered};
use powergs_study::sweep::metric::metrics;
use powergs_study::sweep::outcome::Outcome;
use powergs_study::sweep::run::results::CSV;
use powergs_study::sweep::run::state;
use powergs_study::sweep::run::{OpenedSweep, Results, StandIn, Sweep, SweepRequest, SweepWatch};
use powergs_study::sweep::table::{Cell, Column, ColumnKind, FIRST, LAST, MODEL};

impl SweepWatch for Shared {
    fn working(&self, machine_frames: u64, _objectives: &[Objective]) {
        self.total(machine_frames);
    }

    fn known(&self, machine_frames: u64) {
        self.advance(machine_frames);
    }
}

/// What a sweep found, whatever it was made from: ``table`` has the rows of ``results.csv``,
/// ``designs`` those of the means.
#[pyclass(frozen, module = "powergs", name = "SweepResult")]
pub struct SweepResult {
    results: Results,
    facts: SweepFacts,
    name: String,
    /// The machine that designs differ from, with the machines of a list.
    made_from: Option<(Py<Machine>, Listed)>,
    /// Columns of functions, with which tables begin after the axes where tables are shown.
    functions: Vec<String>,
}

/// The machines of a list by their number; `None` for a design that is no machine.
type Listed = BTreeMap<u64, Option<Py<Machine>>>;

/// The best designs of a sweep, the best in the first objective first.
#[pyclass(frozen, module = "powergs", name = "Front")]
pub struct Front {
    /// A row per design, as in the sweep's table, and ``is_knee``.
    #[pyo3(get)]
    table: Py<Table>,
    /// Number of the design from which no objective gains much without another losing more.
    #[pyo3(get)]
    knee: Option<u64>,
    charts: Py<PyDict>,
    text: String,
    html: String,
}

#[pymethods]
impl Front {
    /// The charts of the analysis by name.
    fn charts<'py>(&self, py: Python<'py>) -> Bound<'py, PyDict> {
        self.charts.bind(py).clone()
    }

    fn __len__(&self) -> usize {
        self.table.get().rows()
    }

    fn __repr__(&self) -> String {
        let knee = self.knee.map_or("the base machine".into(), |point| format!("#{point}"));
        format!("<Front: {} designs, the knee is {knee}>", self.__len__())
    }

    fn __str__(&self) -> &str {
        &self.text
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(PyTypeError::new_err("a front is not pickled: pickle its table, and save its charts"))
    }

    fn _repr_html_(&self) -> &str {
        &self.html
    }
}

/// The unit and the definition of a column of results that is no axis.
pub fn known(name: &str) -> Option<(&'static str, String)> {
    if let Some((.., definition)) = FIRST.iter().find(|(first, ..)| *first == name) {
        return Some(("", (*definition).to_owned()));
    }
    if let Some((_, unit, definition)) = LAST.iter().find(|(last, ..)| *last == name) {
        return Some((unit, (*definition).to_owned()));
    }
    let metric = metrics().iter().find(|metric| metric.name == name);
    metric.map(|metric| (metric.unit, metric.definition.clone()))
}

fn column(column: &Column, cells: &[&Cell]) -> Given {
    let axis = || ("", format!("Axis: the value of `{}`.", column.name));
    let (unit, definition) = known(&column.name).unwrap_or_else(axis);
    let (name, definition) = (column.name.as_str(), definition.as_str());
    match column.kind {
        ColumnKind::Text => Given::text(
            name,
            definition,
            cells.iter().map(|cell| match cell {
                Cell::Text(text) => Some(text.as_str()),
                _ => None,
            }),
        ),
        ColumnKind::Truth => Given::flag(
            name,
            definition,
            cells.iter().map(|cell| match cell {
                Cell::Truth(flag) => Some(*flag),
                _ => None,
            }),
        ),
        ColumnKind::Integer => Given::integer(
            name,
            unit,
            definition,
            cells.iter().map(|cell| match cell {
                Cell::Integer(number) => Some(*number),
                _ => None,
            }),
        ),
        ColumnKind::Real => Given::real(
            name,
            unit,
            definition,
            cells.iter().map(|cell| match cell {
                Cell::Real(number) => Some(*number),
                Cell::Integer(number) => Some(*number as f64),
                _ => None,
            }),
        ),
    }
}

fn columns(results: &Results, rows: &[&Vec<Cell>]) -> Vec<Given> {
    let of = |(i, head): (usize, &Column)| {
        let cells: Vec<&Cell> = rows.iter().map(|row| &row[i]).collect();
        column(head, &cells)
    };
    results.columns.iter().enumerate().map(of).collect()
}

fn unanswered(error: AnalysisError) -> Fault {
    let class = match error {
        AnalysisError::Unmet { .. } => Class::GoalMissed,
        _ => Class::Config,
    };
    Fault::new(class, error.to_string())
}

#[pymethods]
impl SweepResult {
    /// A finished sweep in a folder: of the program, or a ``store`` that is complete.
    ///
    /// Raises ``InputError`` where there is none, or it is unfinished.
    #[staticmethod]
    #[pyo3(signature = (folder, /))]
    fn open(folder: &Bound<'_, PyAny>) -> PyResult<SweepResult> {
        let folder = PathBuf::from(path_text(folder)?);
        let path = folder.join(CSV);
        let place = path.display().to_string();
        let file = File::open(&path).map_err(|e| match folder.join(state::FILE).exists() {
            true => {
                let what = "the sweep in it is unfinished: call the same sweep with this store, or \
                            the program with --resume";
                Fault::in_file(Class::Input, folder.display(), what)
            }
            false => RunError::input(&place, e).into(),
        });
        let results = Results::read(BufReader::new(file?));
        let results = results.map_err(|e| Fault::in_file(Class::Input, &place, e))?;
        let facts = SweepFacts::read(&FileStore::new(&folder)).map_err(Fault::from)?;
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(SweepResult { results, facts, name, made_from: None, functions: Vec::new() })
    }

    /// The machine of a design by its number in ``point``; without one the base. Raises
    /// ``ConfigError`` for a sweep of a file or a folder: ``powergs.commands.sweep_show`` has it.
    #[pyo3(signature = (point=None))]
    fn machine(&self, py: Python<'_>, point: Option<u64>) -> PyResult<Py<Machine>> {
        let Some((base, machines)) = &self.made_from else {
            let what =
                "machines of a sweep file: powergs.commands.sweep_show(FOLDER, ID, toml=True)";
            return Err(Fault::config(what).raise());
        };
        let Some(point) = point else { return Ok(base.clone_ref(py)) };
        let none = || PyKeyError::new_err(format!("no design #{point} in this sweep"));
        if !machines.is_empty() {
            let invalid = || Fault::config(format!("design #{point} is no machine")).raise();
            return match machines.get(&point).ok_or_else(none)? {
                Some(machine) => Ok(machine.clone_ref(py)),
                None => Err(invalid()),
            };
        }
        let own = Cell::Integer(i64::try_from(point).unwrap_or(-1));
        let row = self.results.means().find(|row| row[0] == own).ok_or_else(none)?;
        let axes = self.results.columns.iter().zip(row).skip(FIRST.len());
        let axes = axes.take_while(|(column, _)| column.name != "frames");
        let mut changes = Vec::new();
        for (column, cell) in axes.filter(|(_, cell)| **cell != Cell::Empty) {
            // Behind a measure stands the same as a number.
            if column.name.ends_with(".si") {
                continue;
            }
            let written = format!("{}={}", column.name, cell.text());
            changes.push(written.parse::<Change>().map_err(Fault::config)?);
        }
        let system = base.get().changed(&changes)?;
        Py::new(py, base.get().of(system))
    }

    /// Every row of ``results.csv``: per design, energy table and trace, and the ``mean`` and the
    /// ``worst`` over the traces (column ``scope``); the base machine first.
    #[getter]
    fn table(&self) -> PyResult<Table> {
        Table::new(columns(&self.results, &self.results.rows.iter().collect::<Vec<_>>()))
    }

    /// The rows of the means over the traces: one per design and energy table.
    #[getter]
    fn designs(&self) -> PyResult<Table> {
        Table::new(columns(&self.results, &self.results.means().collect::<Vec<_>>()))
    }

    /// How many designs there are by fate: ``ok``, ``invalid``, ``failed``, ``missing``.
    #[getter]
    fn tally<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let tally = self.results.tally;
        dict.set_item("ok", tally.ok)?;
        dict.set_item("invalid", tally.invalid)?;
        dict.set_item("failed", tally.failed)?;
        dict.set_item("missing", tally.missing)?;
        Ok(dict)
    }

    /// The designs that no other beats.
    ///
    /// Parameters
    /// ----------
    /// minimize, maximize : list of str, optional
    ///     Columns of the table, or expressions of them; those of the sweep without any.
    /// where : str, optional
    ///     Condition: ``"frame_time_ms.p99 <= 16.67 && area_mm2.core <= 4"``.
    /// scope : str
    ///     ``"mean"``, ``"worst"``, or the label of a trace.
    /// energy_table : str, optional
    ///     Label of the energy table; the first without it.
    /// include_misses : bool, optional
    ///     Whether designs that miss the display rate are ranked like all others.
    ///
    /// Raises ``GoalMissed`` where no design meets the condition.
    #[pyo3(signature = (*, minimize=None, maximize=None, r#where=None, scope="mean",
                        energy_table=None, include_misses=None))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn pareto(
        &self,
        py: Python<'_>,
        minimize: Option<Vec<String>>,
        maximize: Option<Vec<String>>,
        r#where: Option<&str>,
        scope: &str,
        energy_table: Option<String>,
        include_misses: Option<bool>,
    ) -> PyResult<Front> {
        let asked = self.facts.question();
        let minimize = minimize.unwrap_or_default().into_iter().map(Objective::minimize);
        let maximize = maximize.unwrap_or_default().into_iter().map(Objective::maximize);
        let given: Vec<Objective> = minimize.chain(maximize).collect();
        let wrong = |e| Fault::config(format!("where: {e}"));
        let misses = match include_misses {
            None => asked.misses,
            Some(true) => Misses::Included,
            Some(false) => Misses::Behind,
        };
        let question = Question {
            objectives: if given.is_empty() { asked.objectives.clone() } else { given },
            condition: r#where.map(Expr::parse).transpose().map_err(wrong)?,
            scope: match scope {
                "mean" => Scope::Mean,
                "worst" => Scope::Worst,
                label => Scope::Trace(label.to_owned()),
            },
            energy_table,
            misses,
            ..asked
        };
        let table = Analysed::of(&self.results, &question);
        let mut table = table.map_err(|e| Fault::new(Class::Input, e.to_string()))?;
        self.facts.settle(&mut table, 0);
        table.compute(&question.objectives).map_err(unanswered)?;
        let analysis = Analysis::of(&table, &question).map_err(unanswered)?;
        self.front(py, &analysis)
    }

    fn __len__(&self) -> usize {
        self.results.means().count()
    }

    fn __repr__(&self) -> String {
        let tally = self.results.tally;
        let cell = |row: &Vec<Cell>| self.results.cell(row, MODEL).map(Cell::text);
        let mut models: Vec<String> = self.results.means().filter_map(cell).collect();
        models.sort();
        models.dedup();
        format!(
            "<SweepResult {}: {} designs, {} invalid, DRAM model {}>",
            self.name,
            tally.ok,
            tally.invalid,
            models.join(" and ")
        )
    }

    fn __iter__(slf: PyRef<'_, Self>) -> PyResult<Bound<'_, PyAny>> {
        let py = slf.py();
        Bound::new(py, slf.designs()?)?.into_any().try_iter().map(|rows| rows.into_any())
    }

    fn _repr_html_(&self) -> PyResult<String> {
        Table::new(self.shown())?.html()
    }

    fn __reduce__(&self) -> PyResult<()> {
        let what = "a sweep is not pickled: keep it with store=, and open that with \
                    SweepResult.open; or pickle its table";
        Err(PyTypeError::new_err(what))
    }
}

/// Metrics of the short view of a sweep.
const SHOWN: [&str; 6] =
    ["status", "frame_time_ms.mean", "power_w.mean", "energy_pj.mean", "area_mm2", "dram_model"];

impl SweepResult {
    /// What a person looks at first: the number, the axes, the functions and the usual metrics.
    fn shown(&self) -> Vec<Given> {
        let all = &self.results.columns;
        let frames = all.iter().position(|column| column.name == "frames").unwrap_or(FIRST.len());
        let by_name = |name: &str| all.iter().position(|column| column.name == name);
        let own = self.functions.iter().filter_map(|name| by_name(name));
        let usual = SHOWN.iter().filter_map(|name| by_name(name));
        let places = [0].into_iter().chain(FIRST.len()..frames).chain(own).chain(usual);
        let rows: Vec<&Vec<Cell>> = self.results.means().collect();
        let of = |i: usize| {
            let cells: Vec<&Cell> = rows.iter().map(|row| &row[i]).collect();
            column(&all[i], &cells)
        };
        places.map(of).collect()
    }

    fn front(&self, py: Python<'_>, analysis: &Analysis<'_>) -> PyResult<Front> {
        let record = |row: u32| &self.results.rows[analysis.table.records[row as usize] as usize];
        let rows: Vec<&Vec<Cell>> = analysis.front.iter().map(|&row| record(row)).collect();
        let is_knee = analysis.front.iter().map(|&row| Some(row == analysis.knee));
        let what = "Whether no objective gains much from here without another losing more.";
        let mut columns = columns(&self.results, &rows);
        columns.push(Given::flag("is_knee", what, is_knee));
        let all = PyDict::new(py);
        for chart in charts(analysis) {
            let chart = Bound::new(py, Chart::new(chart))?;
            all.set_item(chart.getattr("name")?, chart)?;
        }
        let provenance = Provenance { title: self.name.clone(), ..Provenance::default() };
        let page = document(analysis, &[], None, &provenance);
        let knee = (!analysis.table.is_baseline(analysis.knee))
            .then(|| analysis.table.points[analysis.knee as usize]);
        Ok(Front {
            table: Py::new(py, Table::new(columns)?)?,
            knee,
            charts: all.unbind(),
            text: page.terminal(100),
            html: page.fragment().map_err(defect)?,
        })
    }
}

/// Where results are kept.
pub fn store(path: Option<String>, shared: &Shared) -> Box<dyn Store> {
    match path {
        Some(path) => {
            shared.after_interrupted();
            Box::new(FileStore::new(PathBuf::from(path)))
        }
        None => Box::new(MemoryStore::new()),
    }
}

fn finished(
    sweep: &mut OpenedSweep<'_>,
    store: &dyn Store,
    budget: Budget,
    shared: &Shared,
) -> Result<SweepResult, Fault> {
    sweep.allow(budget);
    let memory = usize::try_from(budget.0.0).unwrap_or(usize::MAX);
    let results = sweep.run(store, memory, shared)?;
    if results.is_complete {
        results.keep(sweep, store)?;
    }
    let (facts, name) = (SweepFacts::of(sweep), sweep.name.clone());
    Ok(SweepResult { results, facts, name, made_from: None, functions: Vec::new() })
}

/// A sweep file on traces.
#[pyfunction]
#[pyo3(signature = (file, traces, *, keys=None, points=None, dram=None, store=None, memory=None,
                    progress=None))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn _sweep_file(
    py: Python<'_>,
    file: &Bound<'_, PyAny>,
    traces: Vec<String>,
    keys: Option<&Bound<'_, PyDict>>,
    points: Option<u64>,
    dram: Option<String>,
    store: Option<&Bound<'_, PyAny>>,
    memory: Option<&Bound<'_, PyAny>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<SweepResult> {
    let sets = value::changes(keys, None)?.iter().map(ToString::to_string).collect();
    let request = SweepRequest {
        file: path_text(file)?,
        traces,
        frames: None,
        sets,
        points,
        dram_model: dram,
        // The same for all forms of a sweep: the machine's own.
        stand_in: StandIn::Never,
        ..SweepRequest::default()
    };
    let store = store.map(path_text).transpose()?;
    let budget = budget(memory)?.unwrap_or(Budget::DEFAULT);
    watch::run(py, progress, (Counts::Simulations, "frames on machines"), move |shared| {
        let store = self::store(store, shared);
        let mut sweep = OpenedSweep::open(&request)?;
        let result = finished(&mut sweep, &*store, budget, shared)?;
        if result.results.is_complete {
            request.remember(&*store)?;
        }
        Ok(result)
    })
}

/// Axes over a machine on traces.
#[pyfunction]
#[pyo3(signature = (base, axes, traces, *, constraints=None, minimize=None, maximize=None,
                    sampling=None, fps=60.0, dram=None, store=None, memory=None, progress=None))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn _sweep_axes(
    py: Python<'_>,
    base: Py<Machine>,
    axes: &Bound<'_, PyDict>,
    traces: Vec<Py<Trace>>,
    constraints: Option<Vec<String>>,
    minimize: Option<Vec<String>>,
    maximize: Option<Vec<String>>,
    sampling: Option<&Bound<'_, PyDict>>,
    fps: f64,
    dram: Option<&str>,
    store: Option<&Bound<'_, PyAny>>,
    memory: Option<&Bound<'_, PyAny>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<SweepResult> {
    let system = match dram {
        Some(model) => base.get().changed(&[Change::machine("dram.model", model)])?,
        None => (*base.get().system()).clone(),
    };
    let constraints = constraints.unwrap_or_default();
    let mut sweep = over(system, axes, &constraints, sampling)?;
    sweep = sweep.display_fps(value::display_rate(fps)?);
    for column in minimize.iter().flatten() {
        sweep = sweep.minimize(column);
    }
    for column in maximize.iter().flatten() {
        sweep = sweep.maximize(column);
    }
    let lists: Vec<_> = traces.iter().map(|t| t.get().frames()).collect::<PyResult<_>>()?;
    let store = store.map(path_text).transpose()?;
    let budget = budget(memory)?.unwrap_or(Budget::DEFAULT);
    let found =
        watch::run(py, progress, (Counts::Simulations, "frames on machines"), move |shared| {
            let store = self::store(store, shared);
            let lists = lists.into_iter().map(|list| Box::new(list) as Box<dyn Frames>);
            let opened = sweep.open_on(lists);
            let mut opened = opened.map_err(|e| Fault::from(e).without_lines())?;
            finished(&mut opened, &*store, budget, shared)
        })?;
    Ok(SweepResult { made_from: Some((base, BTreeMap::new())), ..found })
}

/// A machine that was replayed by itself.
#[derive(FromPyObject)]
pub struct Replayed<'py> {
    /// Its number; `None` for the base.
    point: Option<u64>,
    /// Its settings, where they have names.
    settings: Bound<'py, PyDict>,
    /// The machine; `None` where there is none.
    machine: Option<Py<Machine>>,
    /// An outcome per trace (``Report._outcome``).
    outcomes: Vec<String>,
    /// Why there is no machine.
    reason: String,
    /// A value per function and trace.
    values: Vec<Vec<Option<f64>>>,
}

/// The sweep of machines that were replayed one by one, the base first.
#[pyfunction]
pub fn _gathered(
    py: Python<'_>,
    designs: Vec<Replayed<'_>>,
    traces: Vec<String>,
    functions: Vec<String>,
    fps: f64,
) -> PyResult<SweepResult> {
    let systems = designs.iter().map(|design| design.machine.as_ref().map(|m| m.get().system()));
    let systems: Vec<Option<Arc<System>>> = systems.collect();
    let own = |design: &Replayed<'_>| design.machine.as_ref().map(|m| m.clone_ref(py));
    let base = designs.first().and_then(own);
    let listed = designs.iter().filter_map(|design| Some((design.point?, own(design))));
    let made_from = base.zip(Some(listed.collect()));
    let ran: Vec<&System> = systems.iter().flatten().map(|system| &**system).collect();
    let is_named = designs.iter().any(|design| !design.settings.is_empty());
    let differences = if is_named { Vec::new() } else { differences(&ran) };
    let mut differences = differences.into_iter();
    let mut rows = Vec::new();
    for (design, system) in designs.into_iter().zip(&systems) {
        let Replayed { point, settings, outcomes, reason, values, .. } = design;
        let mut own = Vec::new();
        for (key, value) in &settings {
            let key: String = key.extract()?;
            own.push((key.clone(), value::toml(&key, &value)?));
        }
        let ran = match system {
            Some(system) => {
                own.extend(differences.next().into_iter().flatten());
                let read = outcomes.iter().map(|text| serde_json::from_str(text));
                let read = read.collect::<Result<Vec<Outcome>, _>>();
                Ok((&**system, read.map_err(|e| Fault::new(Class::Input, e.to_string()))?))
            }
            None => Err(reason),
        };
        rows.push(GatheredDesign { point, settings: own, ran, values });
    }
    if rows.first().is_none_or(|base| base.ran.is_err()) {
        return Err(Fault::config("no machine was replayed").raise());
    }
    let results = gathered(&rows, &traces, &functions);
    let objectives = Objectives { minimize: functions.clone(), ..Objectives::default() };
    let objectives = Some(objectives).filter(|_| !functions.is_empty());
    let facts = SweepFacts { display_fps: Some(fps), traces, objectives, ..SweepFacts::default() };
    Ok(SweepResult { results, facts, name: "machines".into(), made_from, functions })
}

/// A sweep over a machine.
pub fn over(
    system: System,
    axes: &Bound<'_, PyDict>,
    constraints: &[String],
    sampling: Option<&Bound<'_, PyDict>>,
) -> PyResult<Sweep> {
    let mut sweep = Sweep::over(system);
    for (key, values) in axes.iter() {
        let key: String = key.extract().map_err(|_| PyTypeError::new_err("axes are keys"))?;
        let values = values.try_iter()?.map(|value| value::toml(&key, &value?));
        let values = values.collect::<PyResult<Vec<toml::Value>>>()?;
        sweep = sweep.axis(&key, values);
    }
    for text in constraints {
        sweep = sweep.constraint(text);
    }
    Ok(match sampling {
        Some(given) => sweep.sampling(self::sampling(given)?),
        None => sweep,
    })
}

fn sampling(given: &Bound<'_, PyDict>) -> PyResult<Sampling> {
    let mut table = toml::Table::new();
    for (key, value) in given {
        let key: String = key.extract()?;
        table.insert(key.clone(), value::toml(&key, &value)?);
    }
    let wrong = |e: toml::de::Error| Fault::config(format!("sampling: {}", e.message())).raise();
    table.try_into().map_err(wrong)
}

/// Which of many designs no other beats, by their costs: smaller is better, NaN is never kept.
/// ``Space`` uses it, whose values are whatever it was told.
#[pyfunction]
pub fn _front(designs: Vec<Vec<f64>>) -> PyResult<Vec<usize>> {
    let Some(first) = designs.first() else { return Ok(Vec::new()) };
    let mut costs = Costs::new(first.len().max(1));
    for design in &designs {
        if design.len() != costs.objectives() {
            return Err(Fault::config("every design has as many costs").raise());
        }
        costs.push(design);
    }
    Ok(front(&costs))
}
