//! One sentence that says which unit bounds what share of the frame, and what the rest waits for.
//!
//! Every cycle of a frame is given to one unit that leads: in preprocessing the CCU, in the tile
//! phase the busiest of QSU, BSU and VRU; where the phases overlap, the busiest of all over the
//! whole frame. What the leading unit does in its phase (works, waits for a cause, has no work)
//! adds up to the phase, so the shares in the sentence add up to the frame.

use super::Means;
use super::format::percent;
use powergs_core::accel::Stall;
use powergs_core::action::Stage;

/// What to make faster first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// A kind of unit, by name (`vru`).
    Unit(&'static str),
    /// The bandwidth or the latency of the DRAM.
    Dram,
}

/// A leading unit at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Name of the unit.
    pub unit: &'static str,
    /// Share of the frame in which it works, 0 to 1.
    pub share: f64,
}

/// A leading unit that waits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wait {
    /// What for.
    pub cause: Stall,
    /// Share of the frame, 0 to 1; all leading units together.
    pub share: f64,
    /// Share of the bursts of the stage that waits that had to open a row, where that is known.
    pub row_miss: Option<f64>,
}

/// What limits a run, and the sentence that says why.
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
    /// The reason, for people.
    pub sentence: String,
}

/// A DRAM bus that is busy for more than this share of the frame is the limit whatever else waits.
const BUS_FULL: f64 = 0.85;

/// Shares below this are rounding.
const NOTHING: f64 = 1e-9;

/// What one kind of unit does, as shares of the frame.
struct Unit {
    name: &'static str,
    busy: f64,
    stalls: [f64; Stall::ALL.len()],
    idle: f64,
}

impl Unit {
    fn of(means: &Means, name: &'static str, frame: f64) -> Option<Unit> {
        let get = |end: &str| means.get(&format!("units.{name}.{end}"));
        let all = get("instances")? * frame;
        let mut stalls = [0.0; Stall::ALL.len()];
        for (share, cause) in stalls.iter_mut().zip(Stall::ALL) {
            *share = get(&format!("stall_{}_cycles", cause.name()))? / all;
        }
        let (busy, idle) = (get("busy_cycles")? / all, get("idle_cycles")? / all);
        Some(Unit { name, busy, stalls, idle })
    }
}

/// The bottleneck of a run; `None` in a model without time, or without frames.
pub fn of(means: &Means) -> Option<Bottleneck> {
    let frame = means.get("frame_cycles").filter(|f| *f > 0.0)?;
    let first = means.get("preprocessing_cycles")? / frame;
    let ccu = Unit::of(means, "ccu", frame)?;
    let others = ["qsu", "bsu", "vru"].map(|name| Unit::of(means, name, frame));
    let tiles = others.into_iter().flatten().max_by(|a, b| a.busy.total_cmp(&b.busy))?;
    // A unit that has no work outside of its phase idles at least as long as that.
    let apart = ccu.idle > 1.0 - first - NOTHING && tiles.idle > first - NOTHING;
    let leaders = if apart {
        let ccu_idle = (ccu.idle - (1.0 - first)).max(0.0);
        let tiles_idle = (tiles.idle - first).max(0.0);
        vec![Unit { idle: ccu_idle, ..ccu }, Unit { idle: tiles_idle, ..tiles }]
    } else {
        vec![if ccu.busy > tiles.busy { ccu } else { tiles }]
    };
    Some(found(means, &leaders))
}

fn found(means: &Means, leaders: &[Unit]) -> Bottleneck {
    let mut bounds: Vec<Bound> =
        leaders.iter().map(|u| Bound { unit: u.name, share: u.busy }).collect();
    bounds.sort_by(|a, b| b.share.total_cmp(&a.share));
    let mut waits: Vec<Wait> = Stall::ALL
        .map(|cause| {
            let share = leaders.iter().map(|u| u.stalls[cause as usize]).sum();
            Wait { cause, share, row_miss: misses(means, cause) }
        })
        .into_iter()
        .filter(|w| w.share > NOTHING)
        .collect();
    waits.sort_by(|a, b| b.share.total_cmp(&a.share));
    let dram: f64 = waits.iter().filter(|w| w.cause.is_dram()).map(|w| w.share).sum();
    let bus = means.get("dram.busy_frac").unwrap_or(0.0);
    let limit = if bus > BUS_FULL || dram > bounds[0].share {
        Limit::Dram
    } else {
        Limit::Unit(bounds[0].unit)
    };
    let without_work = leaders.iter().map(|u| u.idle).sum();
    let mut found = Bottleneck { limit, bounds, waits, without_work, sentence: String::new() };
    found.sentence = sentence(&found, dram, bus);
    found
}

/// Share of the bursts of the stage that waits for `cause` that had to open a row.
fn misses(means: &Means, cause: Stall) -> Option<f64> {
    let stage = match cause {
        Stall::Records => Stage::Preprocessing,
        Stall::List | Stall::Spill => Stage::Sorting,
        Stall::Features => Stage::Rendering,
        Stall::Input | Stall::Output | Stall::Bank => return None,
    };
    let get = |end: &str| means.get(&format!("dram.stages.{}.{end}", stage.name()));
    let accesses = get("reads")? + get("writes")?;
    (accesses > 0.0).then(|| get("activates").map(|a| (a / accesses).min(1.0)))?
}

fn words(cause: Stall) -> &'static str {
    match cause {
        Stall::Records => "records of Gaussians",
        Stall::List => "tile lists",
        Stall::Spill => "spilled keys",
        Stall::Features => "feature loads",
        Stall::Input => "the unit before",
        Stall::Output => "room in the output",
        Stall::Bank => "busy banks",
    }
}

fn sentence(found: &Bottleneck, dram: f64, bus: f64) -> String {
    let cause = |w: &Wait| {
        let row = w.row_miss.map_or(String::new(), |m| format!(" (row-miss {} %)", percent(m)));
        format!("{} {} %{row}", words(w.cause), percent(w.share))
    };
    let shown = |w: &&Wait| w.share >= 0.005;
    let mut heads: Vec<String> = found
        .bounds
        .iter()
        .filter(|b| b.share >= 0.005)
        .map(|b| format!("{}-bound {} %", b.unit.to_uppercase(), percent(b.share)))
        .collect();
    let mut waits = Vec::new();
    if found.limit == Limit::Dram && dram >= 0.005 {
        let causes: Vec<String> =
            found.waits.iter().filter(|w| w.cause.is_dram()).filter(shown).map(cause).collect();
        heads.insert(0, format!("DRAM-bound {} %: {}", percent(dram), causes.join(", ")));
        waits.extend(found.waits.iter().filter(|w| !w.cause.is_dram()).filter(shown).map(cause));
    } else {
        waits.extend(found.waits.iter().filter(shown).map(cause));
    }
    let full = if bus > BUS_FULL {
        format!("The DRAM bus is full, it moves data {} % of the time. ", percent(bus))
    } else {
        String::new()
    };
    if let Some(first) = heads.first_mut() {
        *first = first.replacen(" %", " % of the frame", 1);
    }
    if heads.len() > 1 && heads[0].contains(':') {
        let first = heads.remove(0);
        heads[0] = format!("{first}; {}", heads[0]);
    }
    let mut text = format!("{full}{}", heads.join(", "));
    if !waits.is_empty() {
        text += &format!("; the rest waits for {}", waits.join(", "));
    }
    if found.without_work >= 0.005 {
        text += &format!("; {} % without work", percent(found.without_work));
    }
    text + "."
}
