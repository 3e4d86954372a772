//! The parts of an existing sweep: how much is done, and which design an id means.

use super::folder::{RECORDS, Shard, SweepFolder, same};
use super::opened::{Designs, OpenedSweep};
use super::plan::Plan;
use super::records::Records;
use super::request::SweepRequest;
use super::state::State;
use super::watch::SweepWatch;
use crate::sweep::design::Design;
use crate::sweep::record::Record;
use powergs_core::run::{RunError, Store};

/// Opens the sweep of a folder.
///
/// # Errors
/// [`RunError::Request`]: a folder that holds no sweep; [`RunError::Output`]: one whose files have
/// changed since.
pub fn reopen(store: &dyn Store) -> Result<OpenedSweep<'static>, RunError> {
    let then = state_of(store)?;
    let sweep = OpenedSweep::open(&SweepRequest::recall(store)?)?;
    same(store, &then, &sweep.state)?;
    Ok(sweep)
}

fn state_of(store: &dyn Store) -> Result<State, RunError> {
    let none = || RunError::Request(format!("{}: holds no sweep", store.place("")));
    State::read(store)?.ok_or_else(none)
}

/// Takes over the results of another folder of the same sweep.
///
/// # Errors
/// As [`reopen`] for a folder of another sweep, and those of reading and writing.
pub fn take_over(
    folder: &mut SweepFolder<'_>,
    sweep: &OpenedSweep<'_>,
    from: &dyn Store,
) -> Result<(), RunError> {
    same(from, &state_of(from)?, &sweep.state)?;
    folder.records.take_over(&mut SweepFolder::records_of(from)?)
}

/// How many results there are.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct PartCount {
    /// Designs with all results. The baseline is not counted, here and below.
    pub ok: u64,
    /// Configurations that cannot exist.
    pub invalid: u64,
    /// Designs whose simulation went wrong.
    pub failed: u64,
    /// Designs with a result missing.
    pub missing: u64,
    /// Parts of the last division into shards that have something missing.
    pub parts: Vec<u32>,
}

impl PartCount {
    /// Counts the results of a sweep that was divided into `of` parts.
    ///
    /// # Errors
    /// [`RunError::Input`]: a journal that cannot be read.
    pub fn of(
        sweep: &OpenedSweep<'_>,
        plan: &Plan,
        records: &mut Records,
        of: u32,
    ) -> Result<PartCount, RunError> {
        let mut count = PartCount { invalid: plan.invalid.len() as u64, ..PartCount::default() };
        for number in 1..=of {
            let mut is_missing = false;
            for &design in plan.machines(Shard { number, of }).iter().flatten() {
                let mut found = [false; 2];
                for trace in &sweep.traces {
                    for table in 0..plan.tables {
                        match records.get(plan.key(design as usize, table, trace.hash))? {
                            Some(Record::Ok(_)) => {}
                            Some(Record::Failed(_) | Record::Defect(_)) => found[0] = true,
                            None => found[1] = true,
                        }
                    }
                }
                is_missing |= found[1];
                if plan.designs[design as usize].point.is_none() {
                    continue;
                }
                match found {
                    [_, true] => count.missing += 1,
                    [true, false] => count.failed += 1,
                    [false, false] => count.ok += 1,
                }
            }
            if is_missing {
                count.parts.push(number);
            }
        }
        Ok(count)
    }
}

/// How many parts the journals of a folder are of: the largest number that was used.
pub fn parts_of(store: &dyn Store) -> u32 {
    let names = store.list(RECORDS).unwrap_or_default();
    let of = names
        .iter()
        .filter_map(|name| name.strip_suffix(".jsonl")?.rsplit_once("-of-")?.1.parse().ok());
    of.max().unwrap_or(1)
}

/// A design that was asked for by name.
#[derive(Debug)]
pub enum FoundDesign {
    /// It is there; without a point it is the base machine.
    Found(Option<u64>, Box<Design>),
    /// The walk through the space was cancelled.
    Cancelled,
}

/// Hexadecimal digits of an id that are needed at least.
const DIGITS_MIN: usize = 4;

/// Numbers with more digits are ids.
const NUMBER_MAX: usize = 12;

/// The design of an id, the beginning of one, the number of a point, or `baseline`.
///
/// # Errors
/// [`RunError::Request`]: no such design, or several; `place` is what messages call the sweep.
pub fn find(
    designs: &Designs,
    name: &str,
    place: &str,
    watch: &dyn SweepWatch,
) -> Result<FoundDesign, RunError> {
    let refuse = |what: String| Err(RunError::Request(what));
    if name == "baseline" {
        return Ok(FoundDesign::Found(None, Box::new(designs.base.clone())));
    }
    let points = designs.space.lattice().points();
    let number = name.parse::<u64>().ok().filter(|&p| p < points && name.len() < NUMBER_MAX);
    if let Some(point) = number {
        let design = designs.space.design(point);
        let design = design.map_err(|e| RunError::config(format!("point {point}"), e))?;
        return Ok(FoundDesign::Found(Some(point), Box::new(design)));
    }
    let is_hex = name.len() >= DIGITS_MIN && name.chars().all(|c| c.is_ascii_hexdigit());
    if !is_hex {
        let what = "give an id of the table (4 digits of it at least), a point, or `baseline`";
        return refuse(format!("`{name}`: {what}"));
    }
    let Some(plan) = Plan::new(designs, watch) else { return Ok(FoundDesign::Cancelled) };
    let begins = |id: u128| format!("{id:032x}").starts_with(&name.to_lowercase());
    let mut fits = plan.designs.iter().filter(|d| begins(d.id));
    let Some(first) = fits.next() else {
        return refuse(format!("no design `{name}` in {place}"));
    };
    if fits.any(|d| d.id != first.id) {
        return refuse(format!("several designs begin with `{name}`: give more of it"));
    }
    let design = designs.design(first.point);
    let design = design.map_err(|e| RunError::Internal(format!("design: {e}")))?;
    Ok(FoundDesign::Found(first.point, Box::new(design)))
}
