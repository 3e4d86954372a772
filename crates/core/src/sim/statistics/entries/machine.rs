//! Where the cycles of the units went, how long tiles took, and how often each action happened.

use super::of_stages;
use super::{List, count, real};
use crate::kernel::{Histogram, UnitCycles};
use crate::sim::FrameReport;
use crate::sim::statistics::Key;
use crate::stage::{hardware, stage};
use powergs_energy::action::StageId;
use powergs_energy::hardware::Does;

fn unit(frame: &FrameReport, kind: StageId) -> Option<&UnitCycles> {
    frame.timing()?.unit(kind)
}

/// A number of cycles as a share of all cycles of the units.
fn share(frame: &FrameReport, kind: StageId, cycles: fn(&UnitCycles) -> u64) -> Option<f64> {
    let units = unit(frame, kind)?;
    let all = frame.timing()?.frame as f64 * f64::from(units.instances);
    Some(if all == 0.0 { 0.0 } else { cycles(units) as f64 / all })
}

pub(super) fn units(list: &mut List) {
    for (kind, facts) in hardware().units().filter(|(kind, _)| stage(*kind).within.is_none()) {
        let (first, words) = (list.len(), facts.words);
        let path = |end: &str| format!("units.{}.{end}", facts.key);
        let text = format!("Number of {words} in the machine; absent where it has none.");
        count(list, Key::Instances(kind), "1", text, move |f| {
            Some(u64::from(unit(f, kind)?.instances))
        });
        let text = format!(
            "Cycles with work, summed over the {words}. Busy + stalls + idle = instances x \
             `frame_cycles`."
        );
        count(list, Key::Busy(kind), "cycles", text, move |f| Some(unit(f, kind)?.busy));
        for stall in stage(kind).stalls() {
            let cause = stall.words().because;
            let text = format!("Cycles in which {words} had to wait because {cause}.");
            count(list, Key::Stalled(kind, stall), "cycles", text, move |f| {
                Some(unit(f, kind)?.stalls[stall.index()])
            });
        }
        let text = format!("Cycles without work: before the phase of the {words} or after it.");
        count(list, Key::Idle(kind), "cycles", text, move |f| Some(unit(f, kind)?.idle));
        let text = format!("Share of the frame in which the {words} worked, 0 to 1.");
        real(list, path("busy_frac"), "1", text, move |f, _| share(f, kind, |u| u.busy));
        let text = format!("Share of the frame in which the {words} had work and waited, 0 to 1.");
        real(list, path("stall_frac"), "1", text, move |f, _| {
            share(f, kind, |u| u.stalls.iter().sum())
        });
        if stage(kind).has_lanes {
            let text = format!(
                "Lanes that do something useful while their core works: \
                 `counters.live_evaluations` over `{}`, one lane a unit. What is missing to 1: \
                 pixels that have stopped, sub-tiles too small for the core, fill and drain.",
                path("busy_cycles")
            );
            real(list, Key::LaneUtilisation(kind), "1", text, move |f, _| {
                Some(f.cycle()?.live_evaluations as f64 / unit(f, kind)?.busy as f64)
            });
        }
        of_stages(&mut list[first..], [kind]);
    }
}

/// The value of a histogram that at least `share` of its entries are at or below, as the upper edge
/// of a bin; `None` where it is empty.
fn quantile(bins: &Histogram, share: f64) -> Option<f64> {
    let total: u64 = bins.bins.iter().map(|&n| u64::from(n)).sum();
    let wanted = (total as f64 * share).ceil().max(1.0) as u64;
    let mut seen = 0;
    let bin = bins.bins.iter().position(|&n| {
        seen += u64::from(n);
        seen >= wanted
    })?;
    Some(if bin == 0 { 0.0 } else { Histogram::least(bin + 1) })
}

pub(super) fn tiles(list: &mut List) {
    count(
        list,
        "tile_time.tiles",
        "1",
        "Tiles (or merged tiles, or sort groups) that a core rendered.",
        |f| Some(histogram(f)?.bins.iter().map(|&n| u64::from(n)).sum()),
    );
    for (name, share) in [("p50", 0.5), ("p95", 0.95), ("p99", 0.99), ("max", 1.0)] {
        let text = format!(
            "Cycles for which a tile held a core's renderer, {name} over the tiles of the frame: \
             the upper edge of a bin, at most 1.42 times too high."
        );
        real(list, format!("tile_time.{name}_cycles"), "cycles", text, move |f, _| {
            quantile(histogram(f)?, share)
        });
    }
}

/// The tile times of a frame, where they were measured.
fn histogram(frame: &FrameReport) -> Option<&Histogram> {
    let bins = &frame.timing()?.tile_cycles;
    bins.bins.iter().any(|&n| n > 0).then_some(bins)
}

pub(super) fn actions(list: &mut List) {
    let hardware = hardware();
    for (action, does) in hardware.actions() {
        let buffer = |buffer| hardware.buffer(buffer).name;
        let (name, unit, text) = match does {
            Does::SramRead(b) => (
                format!("actions.sram_read_bytes.{}", buffer(b)),
                "B",
                format!("Bytes read from the {} buffer.", buffer(b)),
            ),
            Does::SramWrite(b) => (
                format!("actions.sram_write_bytes.{}", buffer(b)),
                "B",
                format!("Bytes written to the {} buffer.", buffer(b)),
            ),
            Does::DramRead | Does::DramWrite => continue,
            Does::Work(..) | Does::Clock(_) | Does::IdleClock(_) => {
                let key = hardware.key(action);
                let text = format!("How often `{key}` was charged (see the energy table).");
                (format!("actions.{}", key.replace('-', "_")), "1", text)
            }
        };
        count(list, name, unit, text, move |f| {
            f.cycle()?;
            Some(f.actions.total(action))
        });
        let stages: Vec<StageId> = match does {
            Does::SramRead(b) | Does::SramWrite(b) => vec![hardware.stage_of(b)],
            Does::Work(stage, work) => hardware.doers(stage, work.key).collect(),
            Does::Clock(stage) | Does::IdleClock(stage) => vec![stage],
            Does::DramRead | Does::DramWrite => Vec::new(),
        };
        let last = list.len() - 1;
        of_stages(&mut list[last..], stages);
    }
}
