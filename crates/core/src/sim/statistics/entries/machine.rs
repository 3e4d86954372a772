//! Where the cycles of the units went, how long tiles took, and how often each action happened.

use super::{List, count, real};
use crate::accel::{Histogram, Stall, UnitCycles};
use crate::sim::FrameReport;
use crate::sim::statistics::Key;
use powergs_energy::action::{Action, UnitKind};

/// What definitions call a kind of unit.
fn unit_words(kind: UnitKind) -> &'static str {
    match kind {
        UnitKind::Ccu => "culling and conversion units (CCU)",
        UnitKind::Qsu => "quick sorting units (QSU)",
        UnitKind::Bsu => "bitonic sorting units (BSU)",
        UnitKind::Vru => "volume rendering units (VRU)",
    }
}

fn unit(frame: &FrameReport, kind: UnitKind) -> Option<&UnitCycles> {
    Some(frame.timing()?.unit(kind))
}

pub(super) fn units(list: &mut List) {
    for kind in UnitKind::ALL {
        let words = unit_words(kind);
        let path = |end: &str| format!("units.{}.{end}", kind.name());
        let text = format!("Number of {words} in the machine.");
        count(list, Key::Instances(kind), "1", text, move |f| {
            Some(u64::from(unit(f, kind)?.instances))
        });
        let text = format!(
            "Cycles with work, summed over the {words}. Busy + stalls + idle = instances x \
             `frame_cycles`."
        );
        count(list, Key::Busy(kind), "cycles", text, move |f| Some(unit(f, kind)?.busy));
        for stall in Stall::ALL {
            let cause = match stall {
                Stall::Records => "records of Gaussians were in DRAM or on their way",
                Stall::List => "the list of a tile was in DRAM or on its way",
                Stall::Spill => "keys that did not fit the sorting buffer were on their way",
                Stall::Features => "features or colours were in DRAM or on their way",
                Stall::Input => "the unit before had not finished",
                Stall::Output => "the buffer behind them was full",
                Stall::Bank => "banks of their buffers were taken by other accesses",
            };
            let text = format!("Cycles in which {words} had to wait because {cause}.");
            count(list, Key::Stalled(kind, stall), "cycles", text, move |f| {
                Some(unit(f, kind)?.stalls[stall as usize])
            });
        }
        let text = format!("Cycles without work: before the phase of the {words} or after it.");
        count(list, Key::Idle(kind), "cycles", text, move |f| Some(unit(f, kind)?.idle));
        let text = format!("Share of the frame in which the {words} worked, 0 to 1.");
        real(list, path("busy_frac"), "1", text, move |f, _| {
            let u = unit(f, kind)?;
            let all = f.timing()?.frame as f64 * f64::from(u.instances);
            Some(if all == 0.0 { 0.0 } else { u.busy as f64 / all })
        });
        let text = format!("Share of the frame in which the {words} had work and waited, 0 to 1.");
        real(list, path("stall_frac"), "1", text, move |f, _| {
            let u = unit(f, kind)?;
            let all = f.timing()?.frame as f64 * f64::from(u.instances);
            let stalls = u.stalls.iter().sum::<u64>() as f64;
            Some(if all == 0.0 { 0.0 } else { stalls / all })
        });
    }
    real(
        list,
        Key::LaneUtilisation,
        "1",
        "Lanes that do something useful while their core works: `counters.live_evaluations` over \
         `units.vru.busy_cycles`, one lane a rendering unit. What is missing to 1: pixels that \
         have stopped, sub-tiles too small for the core, fill and drain.",
        |f, _| {
            let cycle = f.cycle()?;
            Some(cycle.live_evaluations as f64 / cycle.timing.unit(UnitKind::Vru).busy as f64)
        },
    );
}

pub(super) fn colour(list: &mut List) {
    count(
        list,
        "colour.units",
        "1",
        "Number of colour units in the machine, one a core; absent where CCUs evaluate colours \
         (`ccu.fetch` is not `lazy-colour`).",
        |f| Some(u64::from(f.timing()?.colour?.units)),
    );
    count(
        list,
        "colour.busy_cycles",
        "cycles",
        "Cycles in which a chunk held the entry of a colour unit, summed over the units.",
        |f| Some(f.timing()?.colour?.busy),
    );
    real(
        list,
        "colour.busy_frac",
        "1",
        "Share of the frame in which the colour units worked, 0 to 1.",
        |f, _| {
            let timing = f.timing()?;
            let colour = timing.colour?;
            let all = timing.frame as f64 * f64::from(colour.units);
            Some(if all == 0.0 { 0.0 } else { colour.busy as f64 / all })
        },
    );
    count(
        list,
        Key::ColourWaits,
        "cycles",
        "Cycles in which volume rendering units (VRU) had a chunk that was sorted and loaded and \
         waited for its colours: a part of `units.vru.stall_input_cycles`.",
        |f| Some(f.timing()?.colour?.waits),
    );
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
    for action in Action::all() {
        let (name, unit, text) = match action {
            Action::SramRead(b) => (
                format!("actions.sram_read_bytes.{}", b.name()),
                "B",
                format!("Bytes read from the {} buffer.", b.name()),
            ),
            Action::SramWrite(b) => (
                format!("actions.sram_write_bytes.{}", b.name()),
                "B",
                format!("Bytes written to the {} buffer.", b.name()),
            ),
            Action::DramRead | Action::DramWrite => continue,
            _ => {
                let key = action.key();
                let text = format!("How often `{key}` was charged (see the energy table).");
                (format!("actions.{}", key.replace('-', "_")), "1", text)
            }
        };
        count(list, name, unit, text, move |f| {
            f.cycle()?;
            Some(f.actions.total(action))
        });
    }
}
