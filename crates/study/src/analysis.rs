//! Answers from the results of a sweep: which designs to keep, and why. Nothing is simulated here;
//! every number follows from a [`Table`] and a [`Question`], and [`SweepFacts`] says where these
//! are from. `docs/analysis.md` gives the formulas.

pub mod axes;
mod confirmation;
mod designs;
pub mod distance;
pub mod ends;
mod facts;
pub mod front;
pub mod indices;
pub mod knee;
pub mod marginal;
pub mod morris;
pub mod question;
pub mod rate;
pub mod speedup;
pub mod stability;
pub mod table;

pub use confirmation::{Compared, Confirmation, Confirmed, Order, Standing};
pub use facts::SweepFacts;
pub use question::{AnalysisError, Goal, Misses, Named, Objective, Question, Scope};
pub use stability::Stability;
pub use table::{Table, TableError};

use axes::Axis;
use designs::DesignSlice;
use distance::Distance;
use ends::AtEnd;
use front::{Costs, are_alike, is_alike};
use knee::KneeScaling;
use marginal::{Marginal, Neighbour};
use rate::Late;

/// A design that the question names, and how far it is from the front.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedDesign {
    /// Its row.
    pub row: u32,
    /// Whether it is one of the designs that meet the condition.
    pub meets: bool,
    /// Whether it is on the front.
    pub on_front: bool,
    /// The design of the front that is alike in every objective, if it is not on the front itself.
    pub twin: Option<u32>,
    /// What beats it by more than noise.
    pub distance: Distance,
}

/// The answer. Designs are named by their row in the table, except where costs are indexed.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Analysis<'t> {
    /// What the answer was made from.
    pub table: &'t Table,
    /// What was asked.
    pub question: Question,
    /// Label of the energy table whose rows are analysed.
    pub energy_table: String,
    /// Designs that were simulated, have every objective, and need not meet the condition.
    pub simulated: usize,
    /// Rows of the designs that are ranked, by point: they meet the condition, and the display rate
    /// unless none does.
    pub rows: Vec<u32>,
    /// Rows of the designs that meet the condition, but rank behind all others as they miss the
    /// display rate, by point.
    pub behind: Vec<u32>,
    /// Rows of the designs that do not meet the condition, by point.
    pub unmet: Vec<u32>,
    /// The designs that miss the display rate.
    pub late: Late,
    /// The costs of `rows`, in the same order.
    pub costs: Costs,
    /// Rows of the front, the best in the first objective first. Designs that differ by noise only
    /// have one entry.
    pub front: Vec<u32>,
    /// For every entry of the front the rows of other designs that are alike in every objective, by
    /// point.
    pub twins: Vec<Vec<u32>>,
    /// Axes at one end of which the whole front is.
    pub at_ends: Vec<AtEnd>,
    /// Places of the front in `rows`, in the same order.
    pub members: Vec<usize>,
    /// How costs are scaled.
    pub scaling: KneeScaling,
    /// Row of the knee.
    pub knee: u32,
    /// Rows of the best designs of every objective.
    pub ends: Vec<u32>,
    /// The base machine, if it was simulated.
    pub baseline: Option<u32>,
    /// The design that the question names; `None` if that is the base machine and there is none.
    pub named: Option<NamedDesign>,
    /// What area and power buy along the front.
    pub marginals: Vec<Marginal>,
    /// Designs one step from the knee.
    pub around_knee: Vec<Neighbour>,
    /// Designs one step from the base machine.
    pub around_baseline: Vec<Neighbour>,
    /// Rankings under other tables and scopes.
    pub stability: Stability,
    /// What the axes move.
    pub axes: Vec<Axis>,
}

/// The rows of `all` whose points are none of those of `rows`, which are in the order of points.
fn without(table: &Table, all: &[u32], rows: &[u32]) -> Vec<u32> {
    let point = |row: &u32| table.points[*row as usize];
    let is_other = |row: &u32| rows.binary_search_by_key(&point(row), point).is_err();
    all.iter().copied().filter(is_other).collect()
}

impl<'t> Analysis<'t> {
    /// Answers `question` from `table`, which has a column for every objective: see
    /// [`Table::compute`].
    ///
    /// # Errors
    /// Names that are no columns, labels that do not occur, conditions that no design meets.
    pub fn of(table: &'t Table, question: &Question) -> Result<Analysis<'t>, AnalysisError> {
        check(table, question)?;
        let energy_table = energy_table(table, question)?;
        let label = table.energy_tables.distinct().get(energy_table as usize);
        let label = label.cloned().unwrap_or_default();
        let slice = DesignSlice::of(table, energy_table, &question.scope);
        let (simulated, _) = designs::with_costs(table, &question.objectives, &slice.rows);
        if simulated.is_empty() {
            let scope = question.scope.to_string();
            return Err(AnalysisError::Nothing { scope, energy_table: label });
        }
        let meeting = match &question.condition {
            None => simulated.clone(),
            Some(condition) => designs::meeting(table, condition, &simulated)?,
        };
        if let (true, Some(condition)) = (meeting.is_empty(), &question.condition) {
            let parts = designs::parts(table, condition, &simulated);
            let nearest = designs::nearest(table, condition, &simulated);
            let others = (0..table.energy_tables.distinct().len() as u32)
                .filter(|code| *code != energy_table)
                .filter_map(|code| {
                    let rows = DesignSlice::of(table, code, &question.scope).rows;
                    let met = designs::meeting(table, condition, &rows).ok()?.len();
                    Some((table.energy_tables.distinct()[code as usize].clone(), met))
                });
            let tables = others.filter(|(_, met)| *met > 0).collect();
            return Err(AnalysisError::Unmet { designs: simulated.len(), parts, nearest, tables });
        }
        let unmet = without(table, &simulated, &meeting);
        let epsilon = question.epsilon;
        let late = Late::of(table, energy_table, &question.scope, question.misses);
        let (first, behind) = late.split(table, &meeting, epsilon);
        let rows_at = |places: Vec<usize>| places.into_iter().map(|p| meeting[p]).collect();
        let (rows, behind): (Vec<u32>, Vec<u32>) = (rows_at(first), rows_at(behind));
        let (rows, costs) = designs::with_costs(table, &question.objectives, &rows);
        let mut members = knee::front(&costs, epsilon);
        members.sort_by(|&a, &b| {
            let by_first = costs.of(a)[0].total_cmp(&costs.of(b)[0]);
            by_first.then(a.cmp(&b))
        });
        let scaling = KneeScaling::of(&costs, &members);
        let row_of = |design: usize| rows[design];
        let front: Vec<u32> = members.iter().copied().map(row_of).collect();
        let twins = front::twins(&costs, &members, epsilon);
        let twins: Vec<Vec<u32>> =
            twins.into_iter().map(|t| t.into_iter().map(row_of).collect()).collect();
        let entry = |(row, twins): (&u32, &Vec<u32>)| [&[*row], twins.as_slice()].concat();
        let entries: Vec<Vec<u32>> = front.iter().zip(&twins).map(entry).collect();
        let at_ends = ends::at_ends(table, &simulated, &entries);
        // By point, so that of equals the same design is taken as in rankings.
        let mut by_point = members.clone();
        by_point.sort_unstable();
        let knee = knee::knee(&costs, &by_point, &scaling).map(row_of);
        let knee = knee.expect("finite costs have a front");
        let ends = knee::ends(&costs, &by_point, &scaling).into_iter().map(row_of).collect();
        let around = |row: u32| marginal::around(table, &question.objectives, &simulated, row);
        let mut analysis = Analysis {
            table,
            question: question.clone(),
            energy_table: label,
            simulated: simulated.len(),
            front,
            twins,
            at_ends,
            knee,
            ends,
            baseline: slice.baseline,
            named: None,
            marginals: Vec::new(),
            around_knee: around(knee),
            around_baseline: slice.baseline.map_or(Vec::new(), around),
            stability: Stability::of(table, question, energy_table, &rows)?,
            axes: axes::effects(table, &question.objectives, &simulated),
            rows,
            behind,
            unmet,
            late,
            costs,
            members,
            scaling,
        };
        let objectives = &question.objectives;
        analysis.marginals = marginal::along(table, objectives, &analysis.front, epsilon);
        analysis.named = analysis.named(slice.named(table, &question.design)?)?;
        Ok(analysis)
    }

    fn named(&self, row: Option<u32>) -> Result<Option<NamedDesign>, AnalysisError> {
        let Some(row) = row else { return Ok(None) };
        let objectives = &self.question.objectives;
        let Some(values) = designs::values(self.table, objectives, row) else { return Ok(None) };
        let costs: Vec<f64> = values.iter().zip(objectives).map(|(v, o)| o.goal.cost(*v)).collect();
        let meets = match &self.question.condition {
            None => true,
            Some(condition) => !designs::meeting(self.table, condition, &[row])?.is_empty(),
        };
        let epsilon = self.question.epsilon;
        let distance =
            distance::distance(&self.costs, &self.members, &self.scaling, &costs, epsilon);
        let on_front = self.front.contains(&row);
        let alike = |m: &&usize| are_alike(self.costs.of(**m), &costs, epsilon);
        let twin = self.members.iter().find(alike).map(|&m| self.rows[m]);
        let twin = twin.filter(|_| !on_front);
        Ok(Some(NamedDesign { row, meets, on_front, twin, distance }))
    }

    /// The value of objective `j` of a row; NaN where it was not measured.
    pub fn value(&self, j: usize, row: u32) -> f64 {
        self.table.number(&self.question.objectives[j].name, row).unwrap_or(f64::NAN)
    }

    /// The relative change of objective `j` from one row to another: 0.1 is ten percent more.
    pub fn change(&self, j: usize, from: u32, to: u32) -> Option<f64> {
        let (old, new) = (self.value(j, from), self.value(j, to));
        Some((new - old) / old.abs()).filter(|c| c.is_finite())
    }

    /// Whether objective `j` of two rows is alike: they differ by noise at most.
    pub fn alike(&self, j: usize, a: u32, b: u32) -> bool {
        is_alike(self.value(j, a), self.value(j, b), self.question.epsilon)
    }

    /// Whether a row misses the display rate.
    pub fn is_late(&self, row: u32) -> bool {
        self.late.has(self.table.points[row as usize])
    }

    /// The best frame rate in the slowest frame, FPS, with its row, if no design that meets the
    /// condition meets the display rate.
    pub fn unreached(&self) -> Option<(u32, f64)> {
        if self.rows.iter().any(|&row| !self.is_late(row)) {
            return None;
        }
        let slowest = |row: u32| self.late.slowest_ms(self.table.points[row as usize]);
        let all = self.rows.iter().filter_map(|&row| Some((row, slowest(row)?)));
        let best = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((best.0, 1e3 / best.1))
    }
}

/// Whether every name of the question is a column of numbers.
fn check(table: &Table, question: &Question) -> Result<(), AnalysisError> {
    let objectives = &question.objectives;
    if objectives.is_empty() {
        let what = "no objective: name columns with --minimize and --maximize";
        return Err(AnalysisError::Objectives(what.into()));
    }
    for (i, objective) in objectives.iter().enumerate() {
        if objectives[..i].iter().any(|o| o.name == objective.name) {
            let what = format!("the objective `{}` appears twice", objective.name);
            return Err(AnalysisError::Objectives(what));
        }
        if table.numbers(&objective.name).is_some() {
            continue;
        }
        return Err(match table.metric_names.contains(&objective.name) {
            true => AnalysisError::Words(objective.name.clone()),
            false => AnalysisError::column(&objective.name, table),
        });
    }
    if let Some(colour) = &question.colour
        && !designs::names(table).any(|name| name == colour)
    {
        return Err(AnalysisError::column(colour, table));
    }
    if let Scope::Trace(label) = &question.scope {
        let labels = table.traces.distinct();
        known("trace", label, labels)?;
    }
    Ok(())
}

fn energy_table(table: &Table, question: &Question) -> Result<u32, AnalysisError> {
    match &question.energy_table {
        None => Ok(0),
        Some(label) => known("energy table", label, table.energy_tables.distinct()),
    }
}

/// The place of a label among those that occur.
fn known(what: &'static str, name: &str, labels: &[String]) -> Result<u32, AnalysisError> {
    if let Some(code) = labels.iter().position(|l| l == name) {
        return Ok(code as u32);
    }
    let known: Vec<&str> = labels.iter().map(String::as_str).filter(|l| !l.is_empty()).collect();
    let known = if known.is_empty() { "none".into() } else { known.join(", ") };
    Err(AnalysisError::Label { what, name: name.to_owned(), known })
}
