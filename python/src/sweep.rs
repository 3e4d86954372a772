//! Sweeps: every design of a space on every trace, and which designs to keep.

use std::path::PathBuf;

use pyo3::exceptions::PyTypeError;
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
use powergs_core::run::{Change, FileStore, Frames, MemoryStore, Store};
use powergs_report::sweep::{Provenance, charts, document};
use powergs_study::analysis::front::{Costs, front};
use powergs_study::analysis::{
    Analysis, AnalysisError, Misses, Objective, Question, Scope, SweepFacts, Table as Analysed,
};
use powergs_study::sweep::expr::Expr;
use powergs_study::sweep::file::Sampling;
use powergs_study::sweep::metric::metrics;
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

/// What a sweep found: ``table`` has the rows of ``results.csv``, ``designs`` those of the means.
#[pyclass(frozen, module = "powergs", name = "SweepResult")]
pub struct SweepResult {
    results: Results,
    facts: SweepFacts,
    name: String,
}

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

    fn _repr_html_(&self) -> &str {
        &self.html
    }
}

/// The unit and the definition of a column of results.
fn known(name: &str) -> (&'static str, String) {
    if let Some((.., definition)) = FIRST.iter().find(|(first, ..)| *first == name) {
        return ("", (*definition).to_owned());
    }
    if let Some((_, unit, definition)) = LAST.iter().find(|(last, ..)| *last == name) {
        return (unit, (*definition).to_owned());
    }
    match metrics().iter().find(|metric| metric.name == name) {
        Some(metric) => (metric.unit, metric.definition.clone()),
        None => ("", format!("Axis: the value of `{name}`.")),
    }
}

fn column(column: &Column, cells: &[&Cell]) -> Given {
    let (unit, definition) = known(&column.name);
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

    fn _repr_html_(&self) -> PyResult<String> {
        self.designs()?.html()
    }
}

impl SweepResult {
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
    Ok(SweepResult { results, facts: SweepFacts::of(sweep), name: sweep.name.clone() })
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
    base: &Machine,
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
        Some(model) => base.changed(&[Change::machine("dram.model", model)])?,
        None => (*base.system()).clone(),
    };
    let mut sweep = Sweep::over(system).display_fps(value::display_rate(fps)?);
    for (key, values) in axes.iter() {
        let key: String = key.extract().map_err(|_| PyTypeError::new_err("axes are keys"))?;
        let values = values.try_iter()?.map(|value| value::toml(&key, &value?));
        let values = values.collect::<PyResult<Vec<toml::Value>>>()?;
        sweep = sweep.axis(&key, values);
    }
    for text in constraints.iter().flatten() {
        sweep = sweep.constraint(text);
    }
    for column in minimize.iter().flatten() {
        sweep = sweep.minimize(column);
    }
    for column in maximize.iter().flatten() {
        sweep = sweep.maximize(column);
    }
    if let Some(sampling) = sampling {
        sweep = sweep.sampling(self::sampling(sampling)?);
    }
    let lists: Vec<_> = traces.iter().map(|t| t.get().frames()).collect::<PyResult<_>>()?;
    let store = store.map(path_text).transpose()?;
    let budget = budget(memory)?.unwrap_or(Budget::DEFAULT);
    watch::run(py, progress, (Counts::Simulations, "frames on machines"), move |shared| {
        let store = self::store(store, shared);
        let lists = lists.into_iter().map(|list| Box::new(list) as Box<dyn Frames>);
        let opened = sweep.open_on(lists);
        let mut opened = opened.map_err(|e| Fault::from(e).without_lines())?;
        finished(&mut opened, &*store, budget, shared)
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
