//! The plan of a sweep: which designs there are, in which order they are worked on, and under which
//! key each result is kept.

use std::collections::BTreeMap;

use rayon::prelude::*;
use xxhash_rust::xxh3::Xxh3;

use super::folder::Shard;
use super::opened::Designs;
use super::watch::SweepWatch;
use crate::sweep::design::{Design, Rejected};
use crate::sweep::outcome::OUTCOME_VERSION;
use crate::sweep::space::facts;
use crate::sweep::table::Facts;
use powergs_core::flow::WorkKey;
use powergs_core::machine::DramModel;
use powergs_core::sim::MODEL_VERSION;
use powergs_core::sim::cost::untimed;

/// Designs that are made at a time while the space is walked.
const STRIDE: u64 = 4096;

/// A design that can be simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannedDesign {
    /// Number in the space; `None` for the baseline.
    pub point: Option<u64>,
    /// Its hash.
    pub id: u128,
    /// Hash of what decides its timing.
    pub timing: u128,
    /// Place of what it needs of a frame in [`Plan::works`].
    pub work: u32,
    /// Its model of the DRAM.
    pub model: DramModel,
}

/// All designs of a sweep.
#[derive(Debug, Default)]
pub struct Plan {
    /// Those that can be simulated: the baseline, then in the order of the space.
    pub designs: Vec<PlannedDesign>,
    /// Hash of what each energy table makes of each design, and of its display: tables run fastest.
    pub priced: Vec<u128>,
    /// What is known of each design before it is simulated, as `priced`.
    pub facts: Vec<Facts>,
    /// Why a table has no price for a design: by its place in `designs`, and that of the table.
    pub unpriced: BTreeMap<(usize, usize), String>,
    /// Energy tables.
    pub tables: usize,
    /// What designs need of a frame: frames are prepared once for all with the same; sorted.
    pub works: Vec<WorkKey>,
    /// Points that a constraint excludes, counted by constraint.
    pub excluded: BTreeMap<String, u64>,
    /// Points that are the same as another one because an axis does not count there, counted by
    /// axis.
    pub duplicates: BTreeMap<String, u64>,
    /// Points that are configurations which cannot exist: number and reason.
    pub invalid: Vec<(u64, String)>,
    /// The reasons of those, and of tables that cannot price a design, without their numbers.
    pub causes: BTreeMap<String, Cause>,
}

/// Why points are invalid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cause {
    /// How many.
    pub points: u64,
    /// The first of them, and its reason.
    pub example: (u64, String),
}

/// What one point of the space is.
enum PlanFound {
    Design(PlannedDesign, WorkKey, Vec<(u128, Facts)>, Vec<(usize, Rejected)>),
    Excluded(String),
    Duplicate(String),
    Invalid(u64, Rejected),
}

impl Plan {
    /// Walks the points that the sampling of the sweep file takes; `None` after a cancellation.
    pub fn new(designs: &Designs, watch: &dyn SweepWatch) -> Option<Plan> {
        let selected = designs.space.selected();
        watch.planning(selected.size_hint().1.unwrap_or(usize::MAX) as u64);
        Plan::of(designs, selected, watch)
    }

    /// Walks some points of the space; `None` after a cancellation.
    pub fn of(
        designs: &Designs,
        points: impl Iterator<Item = u64>,
        watch: &dyn SweepWatch,
    ) -> Option<Plan> {
        let mut plan = Plan { tables: designs.tables().len(), ..Plan::default() };
        let mut works = BTreeMap::new();
        // Every plan begins with the base machine, wanted or not: tables compare with it.
        plan.add(planned(None, &designs.base), &mut works);
        let mut points = points.peekable();
        while points.peek().is_some() {
            if watch.is_cancelled() {
                return None;
            }
            let some: Vec<u64> = points.by_ref().take(STRIDE as usize).collect();
            let found: Vec<PlanFound> = some.par_iter().map(|&p| find(designs, p)).collect();
            watch.planned(some.len() as u64);
            // In the order of the points, whichever thread found them.
            found.into_iter().for_each(|f| plan.add(f, &mut works));
        }
        // Numbers in the order of the keys, whatever order they were met in.
        plan.works = works.keys().cloned().collect();
        let mut places = vec![0; works.len()];
        for (place, met) in works.values().enumerate() {
            places[*met as usize] = place as u32;
        }
        plan.designs.iter_mut().for_each(|d| d.work = places[d.work as usize]);
        Some(plan)
    }

    fn add(&mut self, found: PlanFound, works: &mut BTreeMap<WorkKey, u32>) {
        match found {
            PlanFound::Excluded(by) => *self.excluded.entry(by).or_default() += 1,
            PlanFound::Duplicate(axis) => *self.duplicates.entry(axis).or_default() += 1,
            PlanFound::Invalid(point, why) => {
                self.count(point, &why);
                self.invalid.push((point, why.to_string()));
            }
            PlanFound::Design(mut design, work, priced, unpriced) => {
                for (table, why) in unpriced {
                    if let Some(point) = design.point {
                        self.count(point, &why);
                    }
                    self.unpriced.insert((self.designs.len(), table), why.to_string());
                }
                let next = works.len() as u32;
                design.work = *works.entry(work).or_insert(next);
                self.designs.push(design);
                let (priced, facts): (Vec<u128>, Vec<Facts>) = priced.into_iter().unzip();
                self.priced.extend(priced);
                self.facts.extend(facts);
            }
        }
    }

    fn count(&mut self, point: u64, why: &Rejected) {
        let new = || Cause { points: 0, example: (point, why.to_string()) };
        self.causes.entry(why.cause()).or_insert_with(new).points += 1;
    }

    /// The key of the result of a design under an energy table on the trace with this hash.
    pub fn key(&self, design: usize, table: usize, trace: u128) -> u128 {
        let mut hash = Xxh3::new();
        hash.update(&u64::from(MODEL_VERSION).to_le_bytes());
        hash.update(&u64::from(OUTCOME_VERSION).to_le_bytes());
        hash.update(&self.designs[design].timing.to_le_bytes());
        hash.update(&self.priced[design * self.tables + table].to_le_bytes());
        hash.update(&trace.to_le_bytes());
        hash.digest128()
    }

    /// The designs of a part of the sweep, machine by machine: places in [`Plan::designs`] of
    /// designs with the same machine, sorted by what they need of a frame. Parts never share a
    /// machine.
    pub fn machines(&self, shard: Shard) -> Vec<Vec<u32>> {
        let mut order: Vec<u32> = (0..self.designs.len() as u32).collect();
        let rank = |&i: &u32| {
            let d = &self.designs[i as usize];
            (d.work, d.timing, i)
        };
        order.sort_by_key(rank);
        let same =
            |a: &u32, b: &u32| self.designs[*a as usize].timing == self.designs[*b as usize].timing;
        let machines: Vec<&[u32]> = order.chunk_by(same).collect();
        let count = machines.len() as u64;
        let ours = (0..).zip(machines).filter(|(i, _)| shard.has(*i, count));
        ours.map(|(_, machine)| machine.to_vec()).collect()
    }
}

fn find(designs: &Designs, point: u64) -> PlanFound {
    match designs.space.design(point) {
        Ok(design) => planned(Some(point), &design),
        Err(why @ Rejected::Constraint { .. }) => PlanFound::Excluded(why.cause()),
        Err(Rejected::Duplicate { axis, .. }) => PlanFound::Duplicate(axis),
        Err(why) => PlanFound::Invalid(point, why),
    }
}

fn planned(point: Option<u64>, design: &Design) -> PlanFound {
    let model = design.machine.dram.model;
    let planned = PlannedDesign { point, id: design.id, timing: design.timing_id, work: 0, model };
    let priced = |table| (price_id(design, table), facts(design, table));
    let priced = (0..design.prices.len()).map(priced).collect();
    let tables = design.prices.iter().enumerate();
    let unpriced = tables.filter_map(|(i, priced)| {
        let (label, message) = (priced.label.clone(), priced.prices.as_ref().err()?.clone());
        Some((i, Rejected::Price { label, message }))
    });
    let work = design.machine.flow().work_key(&design.machine);
    PlanFound::Design(planned, work, priced, unpriced.collect())
}

/// Hash of what an energy table and the display make of a timing.
fn price_id(design: &Design, table: usize) -> u128 {
    let mut hash = Xxh3::new();
    untimed(&design.machine).iter().for_each(|x| hash.update(&x.to_le_bytes()));
    hash.update(&design.prices[table].table.id.to_le_bytes());
    hash.update(&design.display.as_ref().map_or(0, |d| d.id).to_le_bytes());
    hash.update(&design.display_fps.to_le_bytes());
    hash.digest128()
}
