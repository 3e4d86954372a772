//! Which published numbers are held against a machine, by what the program says of them in the
//! baseline that comes with it: nothing is simulated.

use std::sync::OnceLock;

use super::judge::{Judged, judge};
use super::numbers::Tables;
use super::row::{Row, Status};

/// The tables that come with the program.
fn shipped() -> &'static Tables {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    TABLES.get_or_init(Tables::embedded)
}

/// Version of the models that the stored values came out of.
pub fn stored_model() -> Option<u32> {
    shipped().model
}

/// Published numbers that are held against a machine that comes with the program.
#[derive(Debug, Clone, Default)]
pub struct HeldRows {
    /// Against the machine as its file says, with the stored values of ours: the headline first,
    /// then what is outside of its tolerance, those that are farthest off first, then the others
    /// in the order of the table.
    pub rows: Vec<Judged<'static>>,
    /// Against the machine with other keys, in the order of the table.
    pub variants: Vec<Judged<'static>>,
    /// Of other machines, with this one on the other side of the comparison.
    pub against: Vec<&'static Row>,
}

impl HeldRows {
    /// See [`headline`].
    pub fn headline(&self) -> Option<&Judged<'static>> {
        headline_of(&self.rows)
    }

    /// The same of the machine with other keys, where its own file misses nothing.
    pub fn variant_headline(&self) -> Option<&Judged<'static>> {
        headline_of(&self.variants)
    }

    /// Whether a published number of its frames is held against it.
    pub fn is_measured(&self) -> bool {
        self.rows.iter().any(|j| j.row.status != Status::Dropped && j.row.metric.is_of_frames())
    }
}

/// The rows of a machine by the name of its file.
pub fn rows_of(machine: &str) -> HeldRows {
    let tables = shipped();
    let (mut held, name) = (HeldRows::default(), machine);
    for row in &tables.rows {
        if row.machine.arch == name {
            let judged = judge(row, tables.before(row), None);
            let is_plain = row.machine.sets.is_empty();
            (if is_plain { &mut held.rows } else { &mut held.variants }).push(judged);
        } else if row.against.as_ref().is_some_and(|against| against.arch == name) {
            held.against.push(row);
        }
    }
    let headline = headline_of(&held.rows).map(|judged| judged.row.id.as_str());
    held.rows.sort_by(|a, b| {
        let key = |j: &Judged| (Some(j.row.id.as_str()) != headline, !is_missed(j));
        let far = |j: &Judged| if is_missed(j) { distance(j).unwrap_or(0.0) } else { 0.0 };
        key(a).cmp(&key(b)).then(far(b).total_cmp(&far(a)))
    });
    held
}

/// The number of the whole machine (rate, speed-up, power or energy of its frames) that is missed
/// most: among known gaps and rows that fail, the one that is farthest off. `None` where no such
/// number is missed.
pub fn headline(machine: &str) -> Option<Judged<'static>> {
    rows_of(machine).headline().cloned()
}

fn headline_of<'a>(rows: &'a [Judged<'static>]) -> Option<&'a Judged<'static>> {
    let missed = rows.iter().filter(|j| is_missed(j) && j.row.metric.is_of_frames());
    // The first of those that are equally far off.
    missed.rev().max_by(|a, b| {
        let far = |j: &Judged| distance(j).unwrap_or(0.0);
        far(a).total_cmp(&far(b))
    })
}

/// Whether a row is a known gap, or fails.
fn is_missed(judged: &Judged) -> bool {
    let is_gap = matches!(judged.row.status, Status::KnownGap(_));
    let is_near = judged.ours.is_none_or(|ours| judged.row.is_near(ours));
    is_gap || (judged.row.status != Status::Dropped && !is_near)
}

/// How far ours is from the published value: half of it is as far as twice.
fn distance(judged: &Judged) -> Option<f64> {
    let (ours, published) = (judged.ours?, judged.row.published);
    let is_ratio = ours > 0.0 && published > 0.0;
    if is_ratio { Some((ours / published).ln().abs()) } else { judged.deviation().map(f64::abs) }
}
