//! An adaptive search: generation by generation, every result kept like any other. A search that
//! was broken off asks the same questions again and finds the answers in its journals.

use std::collections::BTreeSet;

use super::folder::{Shard, SweepFolder};
use super::meter::Meter;
use super::opened::{Objective, Opened};
use super::plan::Plan;
use super::run::frames;
use super::store::Store;
use super::work::{Sink, Work, run as work};
use crate::cli::{Context, Failure};
use powergs_study::sweep::design::Rejected;
use powergs_study::sweep::journal::Record;
use powergs_study::sweep::metric::{metrics, values};
use powergs_study::sweep::outcome::Outcome;
use powergs_study::sweep::search::Search;
use powergs_study::sweep::table::Cell;

/// Runs the search; all designs that it looked at, or `None` if the user broke off.
///
/// # Errors
/// As the work of any sweep.
pub fn run(
    opened: &mut Opened,
    folder: &mut SweepFolder,
    store: &mut Store,
    memory: usize,
    context: &Context,
) -> Result<Option<Plan>, Failure> {
    let mut search = Search::new(opened.space.lattice(), opened.space.sampling());
    let mut looked_at = BTreeSet::new();
    loop {
        let space = &opened.space;
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
            return Ok(Plan::of(opened, looked_at.into_iter(), context, |_| {}));
        }
        looked_at.extend(&generation);
        let Some(plan) = Plan::of(opened, generation.iter().copied(), context, |_| {}) else {
            return Ok(None);
        };
        let machines = plan.machines(Shard::WHOLE);
        let meter = Meter::new(context, frames(opened, machines.len()), &opened.objectives);
        let sink = Sink { folder, store };
        let one = Work { opened, plan: &plan, sink, memory, meter: &meter, context };
        if !work(one, &machines)? {
            return Ok(None);
        }
        let mut answers: Vec<(u64, Option<Vec<f64>>)> =
            generation.iter().map(|&point| (point, None)).collect();
        for (design, planned) in plan.designs.iter().enumerate() {
            let Some(point) = planned.point else { continue };
            let costs = costs(opened, folder, &plan, design)?;
            if let Some(answer) = answers.iter_mut().find(|(p, _)| *p == point) {
                answer.1 = costs;
            }
        }
        search.tell(&answers);
    }
}

/// The objectives of a design, all to be small, under the first energy table and the mean of all
/// traces; `None` if it failed.
fn costs(
    opened: &Opened,
    folder: &mut SweepFolder,
    plan: &Plan,
    design: usize,
) -> Result<Option<Vec<f64>>, Failure> {
    let mut outcomes: Vec<(f64, Outcome)> = Vec::new();
    for trace in &opened.traces {
        match folder.records.get(plan.key(design, 0, trace.hash))? {
            Some(Record::Ok(outcome)) => outcomes.push((trace.label.weight, outcome)),
            _ => return Ok(None),
        }
    }
    let weighted: Vec<_> = outcomes.iter().map(|(w, o)| (*w, o)).collect();
    let values = values(&weighted);
    let cells = opened.axis_cells(plan.designs[design].point);
    let cost = |objective: &Objective| {
        let metric = metrics().iter().position(|m| m.name == objective.column);
        let value = match metric {
            Some(place) => values[place],
            None => {
                let columns = opened.axis_columns();
                let place = columns.iter().position(|c| c.name == objective.column)?;
                match cells[place] {
                    Cell::Integer(n) => Some(n as f64),
                    Cell::Real(x) => Some(x),
                    _ => None,
                }
            }
        }?;
        Some(if objective.maximize { -value } else { value })
    };
    Ok(opened.objectives.iter().map(cost).collect())
}
