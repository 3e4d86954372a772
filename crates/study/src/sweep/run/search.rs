//! An adaptive search: generation by generation, every result kept like any other. A search that
//! was interrupted asks for the same points again and finds their results in its journals.

use std::collections::BTreeSet;

use super::columns;
use super::folder::{Shard, SweepFolder};
use super::opened::OpenedSweep;
use super::plan::Plan;
use super::shared::SharedResults;
use super::watch::SweepWatch;
use super::work::{ResultSink, work};
use crate::sweep::design::Rejected;
use crate::sweep::expr::Value;
use crate::sweep::metric::{metrics, values};
use crate::sweep::objective::Objective;
use crate::sweep::outcome::Outcome;
use crate::sweep::record::Record;
use crate::sweep::search::Search;
use crate::sweep::search::front::FrontTrial;
use crate::sweep::table::LAST;
use powergs_core::run::RunError;

/// Runs the search; all designs that it tried, or `None` after a cancellation.
///
/// # Errors
/// As [`work()`].
pub fn search(
    sweep: &mut OpenedSweep<'_>,
    folder: &mut SweepFolder<'_>,
    shared: &mut SharedResults,
    memory: usize,
    watch: &dyn SweepWatch,
) -> Result<Option<Plan>, RunError> {
    let space = &sweep.designs.space;
    let mut search = Search::new(space.lattice(), space.sampling());
    let mut looked_at = BTreeSet::new();
    loop {
        let space = &sweep.designs.space;
        // What a constraint leaves out costs nothing: the search is told before it asks.
        let allowed = |point: u64| match space.design(point) {
            Ok(_) => Some(point),
            Err(Rejected::Duplicate { canonical, .. }) => {
                space.design(canonical).is_ok().then_some(canonical)
            }
            Err(_) => None,
        };
        let generation = search.ask(&allowed);
        if generation.is_empty() {
            return Ok(Plan::of(&sweep.designs, looked_at.into_iter(), watch));
        }
        looked_at.extend(&generation);
        let Some(plan) = Plan::of(&sweep.designs, generation.iter().copied(), watch) else {
            return Ok(None);
        };
        let machines = plan.machines(Shard::WHOLE);
        let sink = ResultSink { folder, shared };
        if !work(sweep, &plan, &machines, sink, memory, watch)? {
            return Ok(None);
        }
        let mut answers: Vec<(u64, Option<FrontTrial>)> =
            generation.iter().map(|&point| (point, None)).collect();
        for (design, planned) in plan.designs.iter().enumerate() {
            let Some(point) = planned.point else { continue };
            let trial = trial(sweep, folder, &plan, design)?;
            if let Some(answer) = answers.iter_mut().find(|(p, _)| *p == point) {
                answer.1 = trial;
            }
        }
        search.tell(&answers);
    }
}

/// The objectives of a design, all to be small, under the first energy table and the mean of all
/// traces, and by how much it misses the display rate: the time of its slowest frame, ms. `None` if
/// it failed.
fn trial(
    sweep: &OpenedSweep<'_>,
    folder: &mut SweepFolder<'_>,
    plan: &Plan,
    design: usize,
) -> Result<Option<FrontTrial>, RunError> {
    let mut outcomes: Vec<(f64, Outcome)> = Vec::new();
    for trace in &sweep.traces {
        match folder.records.get(plan.key(design, 0, trace.hash))? {
            Some(Record::Ok(outcome)) => outcomes.push((trace.label.weight, outcome)),
            _ => return Ok(None),
        }
    }
    let weighted: Vec<_> = outcomes.iter().map(|(w, o)| (*w, o)).collect();
    let values = values(&weighted);
    let cells = sweep.designs.cells(plan.designs[design].point);
    let columns = sweep.designs.columns();
    let facts = plan.facts[design * plan.tables];
    let lookup = |name: &str| -> Option<Value> {
        if let Some(place) = metrics().iter().position(|m| m.name == name) {
            return values[place].map(Value::Number);
        }
        if let Some(place) = LAST.iter().position(|fact| fact.0 == name) {
            return facts[place].map(Value::Number);
        }
        columns::value(&cells[columns.iter().position(|c| c.name == name)?])
    };
    let cost = |objective: &Objective| Some(objective.goal.cost(objective.value(&lookup)?));
    let metric = |name: &str| values[metrics().iter().position(|m| m.name == name)?];
    let is_late = metric("deadline_missed_frac").is_some_and(|share| share > 0.0);
    let miss = match is_late && !sweep.file.objectives.include_misses {
        true => metric("frame_time_ms.max").unwrap_or(f64::MAX),
        false => 0.0,
    };
    let costs: Option<Vec<f64>> = sweep.objectives.iter().map(cost).collect();
    Ok(costs.map(|costs| FrontTrial { costs, miss }))
}
