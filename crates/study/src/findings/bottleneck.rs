//! Which unit bounds what share of the frame, and what the rest waits for.
//!
//! Every cycle of a frame is given to one unit that leads: in preprocessing the busiest of its
//! units (the CCU), behind it the busiest of the others; where the phases overlap, the busiest of
//! all over the whole frame. What follows the picture of a step of training is the gradient
//! units', where they have no other work. What the leading unit does in its phase (works, waits
//! for a cause, has no work) adds up to the phase, so the shares add up to the frame.
//!
//! A unit that waits for another unit waits in the end for what holds that one up. Such a wait is
//! traced to the stages before it (VRU, BSU, QSU, CCU): while a unit has nothing to work on, the
//! one before it works or waits, for anything but room behind it. Shares of time stand for
//! simultaneity: which cycles coincide is not recorded.

use powergs_core::flow::steps::StepPart;
use powergs_core::flow::tile_wise::gradients::GRU;
use powergs_core::sim::statistics::{Key, Record};
use powergs_core::stage::{From, Stall, hardware, stage};
use powergs_energy::action::{Phase, StageId};

/// What to make faster first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// A kind of unit.
    Unit(StageId),
    /// The bandwidth or the latency of the DRAM.
    Dram,
}

impl Limit {
    /// The name in every output: of the unit, or `dram`.
    pub fn name(self) -> &'static str {
        match self {
            Limit::Unit(unit) => stage(unit).key,
            Limit::Dram => "dram",
        }
    }
}

/// A leading unit at work.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Bound {
    /// Which kind of unit.
    pub unit: StageId,
    /// Share of the frame in which it works, 0 to 1.
    pub share: f64,
}

/// A leading unit that waits.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Wait {
    /// What for.
    pub cause: Stall,
    /// The leading unit that waits for it longest.
    pub unit: StageId,
    /// Share of the frame, 0 to 1; all leading units together.
    pub share: f64,
    /// Share of the bursts of the stage that waits that had to open a row, where that is known.
    pub row_miss: Option<f64>,
    /// Where a wait for the unit before begins, largest share first; they add up to it. Empty for
    /// other causes, and where the units before have nothing to do either.
    pub roots: Vec<Root>,
}

impl Wait {
    /// The part of it that is for DRAM, but not of the unit itself: another one waits for it.
    pub fn traced_to_dram(&self) -> f64 {
        self.roots.iter().filter(|r| r.is_dram()).map(|r| r.share).sum()
    }

    /// The unit that it is for, where that is another than the one before.
    pub fn waits_for(&self) -> Option<StageId> {
        match self.cause.words().from {
            From::Stage(key) => hardware().stage_called(key),
            From::Memory | From::Neighbour => None,
        }
    }

    /// Whether it is, for the most part and in the end, for DRAM.
    pub fn is_for_dram(&self) -> bool {
        self.cause.is_dram() || 2.0 * self.traced_to_dram() > self.share
    }
}

/// Where a wait for another unit begins.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Root {
    /// The unit that is slow.
    pub unit: StageId,
    /// What it waits for; `None` where it works.
    pub cause: Option<Stall>,
    /// Share of the frame, 0 to 1.
    pub share: f64,
}

impl Root {
    fn is_dram(&self) -> bool {
        self.cause.is_some_and(Stall::is_dram)
    }
}

/// What limits a run, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Bottleneck {
    /// What to make faster first.
    pub limit: Limit,
    /// Leading units at work, largest share first.
    pub bounds: Vec<Bound>,
    /// Leading units waiting, largest share first; causes that do not occur are left out.
    pub waits: Vec<Wait>,
    /// Share of the frame in which leading units have no work: fill, drain, uneven load.
    pub without_work: f64,
    /// Share of the frame for which leading units wait for DRAM in the end, 0 to 1.
    pub dram_wait: f64,
    /// Share of the frame in which the DRAM's data bus moves data, 0 to 1.
    pub bus_busy: f64,
}

impl Bottleneck {
    /// Share of the frame in which `unit` works while it leads, or while the leading ones wait for
    /// it.
    pub fn holds_up(&self, unit: StageId) -> f64 {
        let leads = self.bounds.iter().filter(|b| b.unit == unit).map(|b| b.share);
        let roots = self.waits.iter().flat_map(|w| &w.roots);
        let awaited = roots.filter(|r| r.unit == unit && r.cause.is_none()).map(|r| r.share);
        let named = self.waits.iter().filter(|w| w.waits_for() == Some(unit)).map(|w| w.share);
        leads.chain(awaited).chain(named).sum()
    }

    /// Whether the DRAM's data bus is full, so that nothing else can be the limit.
    pub fn is_bus_full(&self) -> bool {
        self.bus_busy > BUS_FULL
    }
}

/// A DRAM bus that is busy for more than this share of the frame is the limit whatever else waits.
const BUS_FULL: f64 = 0.85;

/// Shares below this are rounding.
const NOTHING: f64 = 1e-9;

/// What one kind of unit does, as shares of the frame.
#[derive(Clone)]
struct Leader {
    unit: StageId,
    busy: f64,
    /// In the order of [`Stall::all`].
    stalls: Vec<f64>,
    idle: f64,
}

impl Leader {
    fn of(record: &Record, unit: StageId, frame: f64) -> Leader {
        let all = record.value(Key::Instances(unit)) * frame;
        let has = |cause| stage(unit).stalls().any(|own| own == cause);
        let waits = |cause: &Stall| match has(*cause) {
            true => record.value(Key::Stalled(unit, *cause)) / all,
            false => 0.0,
        };
        Leader {
            unit,
            busy: record.value(Key::Busy(unit)) / all,
            stalls: Stall::all().iter().map(waits).collect(),
            idle: record.value(Key::Idle(unit)) / all,
        }
    }

    fn is_known(&self) -> bool {
        self.busy.is_finite() && self.idle.is_finite() && self.stalls.iter().all(|s| s.is_finite())
    }

    fn works_in(&self, phase: Phase) -> bool {
        stage(self.unit).phase == phase
    }

    /// Share for which it waits for a cause.
    fn waits(&self, cause: Stall) -> f64 {
        let at = Stall::all().iter().position(|known| *known == cause);
        at.map_or(0.0, |at| self.stalls[at])
    }
}

/// The bottleneck of a run; `None` in a model without time, for frames that take none, and for an
/// older report that does not say where its cycles went.
pub fn of(record: &Record) -> Option<Bottleneck> {
    let frame = record.mean(Key::FrameCycles).filter(|f| *f > 0.0)?;
    let first = record.value(Key::PreprocessingCycles) / frame;
    let units: Vec<Leader> = record.units().map(|unit| Leader::of(record, unit, frame)).collect();
    if units.is_empty() || !units.iter().all(Leader::is_known) {
        return None;
    }
    let behind = behind(record);
    // Units of the picture have no work then, and gradient units none before.
    let is_behind = |u: &&Leader| u.unit == GRU && u.idle > 1.0 - behind - NOTHING;
    let is_apart = units.iter().all(|u| is_behind(&u) || u.idle > behind - NOTHING);
    let follower = units.iter().find(|u| behind > 0.0 && is_apart && is_behind(u)).cloned();
    let behind = if follower.is_some() { behind } else { 0.0 };
    let busiest = |in_first: bool| {
        let mine = units.iter().filter(|u| u.works_in(Phase::Preprocessing) == in_first);
        let mine = mine.filter(|u| follower.is_none() || !is_behind(u));
        mine.max_by(|a, b| a.busy.total_cmp(&b.busy)).cloned()
    };
    let mut leaders = match (busiest(true), busiest(false)) {
        // A unit that has no work outside of its phase idles at least as long as that.
        (Some(early), Some(late))
            if early.idle > 1.0 - first - NOTHING && late.idle > first - NOTHING =>
        {
            let early_idle = (early.idle - (1.0 - first)).max(0.0);
            let late_idle = (late.idle - first - behind).max(0.0);
            vec![Leader { idle: early_idle, ..early }, Leader { idle: late_idle, ..late }]
        }
        (Some(early), Some(late)) => vec![if early.busy > late.busy { early } else { late }],
        (only, None) | (None, only) => only.into_iter().collect(),
    };
    leaders.extend(follower.map(|u| Leader { idle: (u.idle - (1.0 - behind)).max(0.0), ..u }));
    Some(found(record, &leaders, &units))
}

/// Share of a frame that is behind its picture.
fn behind(record: &Record) -> f64 {
    let part = |part: StepPart| record.mean(Key::Stat(part.time())).unwrap_or(0.0);
    let all: f64 = StepPart::ALL.into_iter().map(part).sum();
    record.mean(Key::FrameTime).filter(|time| *time > 0.0).map_or(0.0, |time| all / time)
}

/// Where `share` of the frame begins in which unit `at` of `all` has nothing to work on.
fn roots(all: &[Leader], at: StageId, share: f64) -> Vec<Root> {
    let before = stage(at).after;
    let before = all.iter().find(|unit| Some(stage(unit.unit).key) == before);
    let Some(before) = before else { return Vec::new() };
    let waits = Stall::all().iter().filter(|cause| **cause != Stall::OUTPUT);
    let waits = waits.map(|cause| (Some(*cause), before.waits(*cause)));
    let does: Vec<(Option<Stall>, f64)> = [(None, before.busy)].into_iter().chain(waits).collect();
    let sum: f64 = does.iter().map(|(_, share)| share).sum();
    if sum < NOTHING {
        return Vec::new();
    }
    let mut found: Vec<Root> = Vec::new();
    for (cause, part) in does {
        let root = Root { unit: before.unit, cause, share: share * part / sum };
        let further = match cause {
            Some(Stall::INPUT) => roots(all, before.unit, root.share),
            _ => Vec::new(),
        };
        let ends_here = further.is_empty() && root.share > NOTHING;
        found.extend(ends_here.then_some(root));
        found.extend(further);
    }
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found
}

fn found(record: &Record, leaders: &[Leader], all: &[Leader]) -> Bottleneck {
    let mut bounds: Vec<Bound> =
        leaders.iter().map(|u| Bound { unit: u.unit, share: u.busy }).collect();
    bounds.sort_by(|a, b| b.share.total_cmp(&a.share));
    let wait = |cause: &Stall| {
        let cause = *cause;
        let longest = leaders.iter().max_by(|a, b| a.waits(cause).total_cmp(&b.waits(cause)))?;
        let (unit, share) = (longest.unit, leaders.iter().map(|l| l.waits(cause)).sum());
        let roots = match cause {
            Stall::INPUT => roots(all, unit, share),
            _ => Vec::new(),
        };
        Some(Wait { cause, unit, share, row_miss: misses(record, cause), roots })
    };
    let mut waits: Vec<Wait> =
        Stall::all().iter().filter_map(wait).filter(|w| w.share > NOTHING).collect();
    waits.sort_by(|a, b| b.share.total_cmp(&a.share));
    let direct = waits.iter().filter(|w| w.cause.is_dram()).map(|w| w.share);
    let dram_wait = direct.chain(waits.iter().map(Wait::traced_to_dram)).sum();
    let without_work = leaders.iter().map(|u| u.idle).sum();
    let bus_busy = record.value(Key::DramBusy);
    let limit = Limit::Unit(bounds[0].unit);
    let mut found = Bottleneck { limit, bounds, waits, without_work, dram_wait, bus_busy };
    let works = all.iter().map(|unit| (unit.unit, found.holds_up(unit.unit)));
    let slowest = works.max_by(|a, b| a.1.total_cmp(&b.1));
    let (slowest, works) = slowest.unwrap_or((found.bounds[0].unit, 0.0));
    found.limit = match found.is_bus_full() || dram_wait > works {
        true => Limit::Dram,
        false => Limit::Unit(slowest),
    };
    found
}

/// Share of the bursts of the stage that waits for `cause` that had to open a row.
fn misses(record: &Record, cause: Stall) -> Option<f64> {
    let phase = cause.stage().filter(|_| cause.is_dram())?.phase;
    let bursts = record.mean(Key::BurstsRead(phase))? + record.mean(Key::BurstsWritten(phase))?;
    let opened = record.mean(Key::RowsOpened(phase))?;
    (bursts > 0.0).then(|| (opened / bursts).min(1.0))
}
