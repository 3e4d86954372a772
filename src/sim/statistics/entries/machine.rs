//! Where the cycles of the units went, what the DRAM did, and how often each action happened.

use super::{List, count, real};
use crate::accel::{Stall, UnitCycles};
use crate::action::Action;
use crate::sim::FrameReport;

/// Units of the pipeline, in its order, with what the reports call them.
const UNITS: [(&str, &str); 4] = [
    ("ccu", "culling and conversion units (CCU)"),
    ("qsu", "quick sorting units (QSU)"),
    ("bsu", "bitonic sorting units (BSU)"),
    ("vru", "volume rendering units (VRU)"),
];

fn unit<'a>(frame: &'a FrameReport, name: &str) -> Option<&'a UnitCycles> {
    frame.timing.as_ref()?.units.iter().find(|u| u.unit == name)
}

pub(super) fn units(list: &mut List) {
    for (name, words) in UNITS {
        let path = |end: &str| format!("units.{name}.{end}");
        let text = format!("Number of {words} in the machine.");
        count(list, path("instances"), "1", text, move |f| {
            Some(u64::from(unit(f, name)?.instances))
        });
        let text = format!(
            "Cycles with work, summed over the {words}. Busy + stalls + idle = instances x \
             `frame_cycles`."
        );
        count(list, path("busy_cycles"), "cycles", text, move |f| Some(unit(f, name)?.busy));
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
            let path = path(&format!("stall_{}_cycles", stall.name()));
            count(list, path, "cycles", text, move |f| Some(unit(f, name)?.stalls[stall as usize]));
        }
        let text = format!("Cycles without work: before the phase of the {words} or after it.");
        count(list, path("idle_cycles"), "cycles", text, move |f| Some(unit(f, name)?.idle));
        let text = format!("Share of the frame in which the {words} worked, 0 to 1.");
        real(list, path("busy_frac"), "1", text, move |f, _| {
            let u = unit(f, name)?;
            let all = f.timing.as_ref()?.frame as f64 * f64::from(u.instances);
            Some(if all == 0.0 { 0.0 } else { u.busy as f64 / all })
        });
    }
}

pub(super) fn dram(list: &mut List) {
    count(list, "dram.requests", "1", "Requests issued to the DRAM, all served.", |f| {
        Some(f.timing.as_ref()?.dram.requests_served)
    });
    count(list, "dram.busy_cycles", "cycles", "Cycles in which the data bus moved data.", |f| {
        Some(f.timing.as_ref()?.dram.busy_cycles)
    });
    real(
        list,
        "dram.busy_frac",
        "1",
        "Share of the frame in which the data bus moved data, 0 to 1.",
        |f, _| {
            let t = f.timing.as_ref()?;
            Some(if t.frame == 0 { 0.0 } else { t.dram.busy_cycles as f64 / t.frame as f64 })
        },
    );
    real(
        list,
        "dram.bandwidth_gb_s",
        "GB/s",
        "DRAM bytes read and written over the whole frame time, in 10⁹ bytes per second.",
        |f, _| {
            let d = &f.timing.as_ref()?.dram;
            Some((d.read_bytes + d.write_bytes) as f64 * 1e-9 / f.frame_time_s()?)
        },
    );
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
            f.timing.as_ref()?;
            Some(f.actions.total(action))
        });
    }
}
