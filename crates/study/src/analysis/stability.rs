//! Do the top designs stay on top under other energy tables, on other traces, on the slowest one?
//!
//! Designs are ranked by their merit (see [`super::knee`]), so the first is the knee. Every
//! alternative scales by its own front. Only designs that meet the condition in the reference are
//! ranked, and in an alternative those that were measured there. Designs that miss the display rate
//! in an alternative rank behind all others there.

pub mod rank;

use std::collections::BTreeMap;

use super::designs::{DesignSlice, meeting, with_costs};
use super::front::Costs;
use super::knee::{KneeScaling, front};
use super::question::{AnalysisError, Question, Scope};
use super::rate::Late;
use super::table::Table;
use rank::{kendall, spearman};

/// The most alternatives that are compared; a sweep has a few energy tables and traces.
pub(crate) const ALTERNATIVES_MAX: usize = 24;

/// The ranking of one energy table and scope.
#[derive(Debug, Clone, PartialEq)]
struct Ranking {
    /// The rows that are ranked, by point.
    rows: Vec<u32>,
    /// What they are ranked by, the smaller the better: the merits, and behind these the times of
    /// the slowest frames of designs that miss the display rate.
    scores: Vec<f64>,
    /// Places in `rows`, the best first.
    order: Vec<usize>,
    /// Places in `rows` of the front.
    front: Vec<usize>,
    costs: Costs,
}

impl Ranking {
    fn of(table: &Table, question: &Question, rows: &[u32], late: &Late) -> Ranking {
        let (rows, costs) = with_costs(table, &question.objectives, rows);
        let (first, behind) = late.split(table, &rows, question.epsilon);
        let mut first_costs = Costs::new(costs.objectives());
        first.iter().for_each(|&d| first_costs.push(costs.of(d)));
        let front: Vec<usize> = front(&first_costs, question.epsilon);
        let scaling = KneeScaling::of(&first_costs, &front);
        let front: Vec<usize> = front.into_iter().map(|place| first[place]).collect();
        let merit = |d: usize| scaling.merit(costs.of(d));
        // A design off the front can have a smaller merit than the knee by noise only.
        let knee = front.iter().map(|&d| merit(d)).fold(f64::INFINITY, f64::min);
        let mut scores: Vec<f64> = (0..rows.len()).map(|d| merit(d).max(knee)).collect();
        let worst = first.iter().map(|&d| scores[d]).fold(0.0, f64::max);
        for d in behind {
            let slowest = late.slowest_ms(table.points[rows[d] as usize]).unwrap_or(f64::MAX);
            scores[d] = (worst + 1.0) * (1.0 + slowest);
        }
        let mut on_front = vec![false; rows.len()];
        front.iter().for_each(|&d| on_front[d] = true);
        let mut order: Vec<usize> = (0..rows.len()).collect();
        let key = |d: usize| (scores[d], !on_front[d]);
        order.sort_by(|&a, &b| {
            let ((a, a_off), (b, b_off)) = (key(a), key(b));
            a.total_cmp(&b).then(a_off.cmp(&b_off))
        });
        Ranking { rows, scores, order, front, costs }
    }

    /// Place of every point in `rows`.
    fn places(&self, table: &Table) -> BTreeMap<u64, usize> {
        let point = |&row: &u32| table.points[row as usize];
        self.rows.iter().map(point).zip(0..).collect()
    }

    fn ranks(&self) -> Vec<usize> {
        let mut ranks = vec![0; self.rows.len()];
        for (rank, &design) in self.order.iter().enumerate() {
            ranks[design] = rank + 1;
        }
        ranks
    }
}

/// What another energy table or scope says.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// Label of the energy table.
    pub energy_table: String,
    /// Which rows.
    pub scope: Scope,
    /// What differs from the reference, in a few words.
    pub label: String,
    /// Designs that both rank.
    pub designs: usize,
    /// Kendall's τ-b of the merits.
    pub kendall: Option<f64>,
    /// Spearman's ρ of the merits.
    pub spearman: Option<f64>,
    /// Kendall's τ-b of each objective.
    pub objectives: Vec<Option<f64>>,
    /// How many of the top designs of the reference are among as many here.
    pub top_kept: usize,
    /// How many of the designs on the front of the reference are on the front here.
    pub front_kept: usize,
    /// Size of the front here.
    pub front: usize,
    /// How many of the designs on the front of the reference break the condition here.
    pub broken: usize,
    /// Rank here of each of the top designs of the reference, from 1; `None`: not measured here.
    pub ranks: Vec<Option<usize>>,
    /// The first here: its row here.
    pub winner: Option<u32>,
    /// Row here of the first of the reference.
    pub reference_winner: Option<u32>,
}

/// How stable the ranking is.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Stability {
    /// Rows of the top designs of the reference, the best first.
    pub top: Vec<u32>,
    /// Designs that the reference ranks.
    pub designs: usize,
    /// The alternatives: energy tables, then scopes, then traces, in the order of the results.
    pub alternatives: Vec<Alternative>,
    /// Alternatives beyond the most that are compared.
    pub left_out: usize,
    /// Points that are on a front, with the number of fronts (reference and alternatives) that they
    /// are on, the most frequent first.
    pub membership: Vec<(u64, usize)>,
}

impl Stability {
    /// How many rankings there are, the reference included.
    pub fn rankings(&self) -> usize {
        self.alternatives.len() + 1
    }

    /// Compares the ranking of `rows` of one energy table and scope with all others.
    ///
    /// # Errors
    /// Those of the condition.
    pub fn of(
        table: &Table,
        question: &Question,
        energy_table: u32,
        rows: &[u32],
    ) -> Result<Stability, AnalysisError> {
        let late = Late::of(table, energy_table, &question.scope, question.misses);
        let reference = Ranking::of(table, question, rows, &late);
        let point = |row: u32| table.points[row as usize];
        let top: Vec<u32> =
            reference.order.iter().take(question.top).map(|&d| reference.rows[d]).collect();
        let mut membership: BTreeMap<u64, usize> =
            reference.front.iter().map(|&d| (point(reference.rows[d]), 1)).collect();
        let mut alternatives = Vec::new();
        let (tables, left_out) = alternatives_of(table, question, energy_table);
        for (energy_table, scope, label) in tables {
            let here = Here { table, question, energy_table, scope, label };
            if let Some((alternative, front)) = here.compared(&reference, &top)? {
                front.into_iter().for_each(|p| *membership.entry(p).or_default() += 1);
                alternatives.push(alternative);
            }
        }
        let mut membership: Vec<(u64, usize)> = membership.into_iter().collect();
        membership.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let designs = reference.rows.len();
        Ok(Stability { top, designs, alternatives, left_out, membership })
    }
}

/// An alternative to compare with.
struct Here<'t> {
    table: &'t Table,
    question: &'t Question,
    energy_table: u32,
    scope: Scope,
    label: String,
}

impl Here<'_> {
    /// The alternative, and the points of its front; `None` if no ranked design was measured in it.
    fn compared(
        self,
        reference: &Ranking,
        top: &[u32],
    ) -> Result<Option<(Alternative, Vec<u64>)>, AnalysisError> {
        let (table, question) = (self.table, self.question);
        let point = |row: u32| table.points[row as usize];
        let slice = DesignSlice::of(table, self.energy_table, &self.scope);
        let ranked: Vec<u32> =
            reference.rows.iter().filter_map(|&row| slice.row(table, point(row))).collect();
        let late = Late::of(table, self.energy_table, &self.scope, question.misses);
        let here = Ranking::of(table, question, &ranked, &late);
        if here.rows.is_empty() {
            return Ok(None);
        }
        let (places, ranks) = (here.places(table), here.ranks());
        // The same designs on both sides, those of the reference that were measured here.
        let both: Vec<(usize, usize)> = (0..reference.rows.len())
            .filter_map(|d| Some((d, *places.get(&point(reference.rows[d]))?)))
            .collect();
        let scores = |side: &Ranking, of: fn(&(usize, usize)) -> usize| -> Vec<f64> {
            both.iter().map(|pair| side.scores[of(pair)]).collect()
        };
        let (there_scores, here_scores) = (scores(reference, |p| p.0), scores(&here, |p| p.1));
        let objective = |j: usize| {
            let there: Vec<f64> = both.iter().map(|p| reference.costs.of(p.0)[j]).collect();
            let here: Vec<f64> = both.iter().map(|p| here.costs.of(p.1)[j]).collect();
            kendall(&there, &here)
        };
        let rank = |row: &u32| Some(ranks[*places.get(&point(*row))?]);
        let top_ranks: Vec<Option<usize>> = top.iter().map(rank).collect();
        let front: Vec<u64> = here.front.iter().map(|&d| point(here.rows[d])).collect();
        let fronts: Vec<u64> = reference.front.iter().map(|&d| point(reference.rows[d])).collect();
        let broken = match &question.condition {
            None => 0,
            Some(condition) => {
                let rows: Vec<u32> = fronts.iter().filter_map(|&p| slice.row(table, p)).collect();
                rows.len() - meeting(table, condition, &rows)?.len()
            }
        };
        let first = |row: &u32| slice.row(table, point(*row));
        let alternative = Alternative {
            energy_table: table.energy_tables.distinct()[self.energy_table as usize].clone(),
            scope: self.scope,
            label: self.label,
            designs: both.len(),
            kendall: kendall(&there_scores, &here_scores),
            spearman: spearman(&there_scores, &here_scores),
            objectives: (0..question.objectives.len()).map(objective).collect(),
            top_kept: top_ranks.iter().flatten().filter(|r| **r <= top.len()).count(),
            front_kept: fronts.iter().filter(|p| front.binary_search(p).is_ok()).count(),
            front: front.len(),
            broken,
            ranks: top_ranks,
            winner: here.order.first().map(|&d| here.rows[d]),
            reference_winner: top.first().and_then(first),
        };
        Ok(Some((alternative, front)))
    }
}

/// The other energy tables under the same scope, then the other scopes and traces with the same
/// table; and how many more there are.
fn alternatives_of(
    table: &Table,
    question: &Question,
    energy_table: u32,
) -> (Vec<(u32, Scope, String)>, usize) {
    let mut all = Vec::new();
    for (code, label) in (0..).zip(table.energy_tables.distinct()) {
        if code != energy_table {
            all.push((code, question.scope.clone(), label.clone()));
        }
    }
    let traces: Vec<&String> =
        table.traces.distinct().iter().filter(|label| !label.is_empty()).collect();
    // The mean over one trace is that trace, and the slowest of one is it too.
    if traces.len() > 1 {
        let mut scope = |scope: Scope, label: &str| {
            if scope != question.scope {
                all.push((energy_table, scope, label.to_owned()));
            }
        };
        scope(Scope::Mean, "mean of traces");
        scope(Scope::Worst, "worst trace of each column");
        for label in traces {
            scope(Scope::Trace(label.clone()), label);
        }
    }
    let left_out = all.len().saturating_sub(ALTERNATIVES_MAX);
    all.truncate(ALTERNATIVES_MAX);
    (all, left_out)
}
