//! Energy, and power at each of the rates that must not be confused.

use super::of_stages;
use super::{List, real, weighted};
use crate::sim::FrameReport;
use crate::sim::statistics::{Key, Weight};
use crate::stage::hardware;
use powergs_energy::action::Phase;
use powergs_energy::{Area, Component};

/// Watts of one component at the display rate `fps`, or at the rate that is reached.
fn component_w(frame: &FrameReport, component: Component, fps: f64) -> f64 {
    match component {
        Component::Leakage => frame.standby_w(fps)[0],
        Component::Background => frame.standby_w(fps)[1],
        Component::Refresh => frame.standby_w(fps)[2],
        Component::Dram | Component::Sram | Component::Flop => {
            frame.energy.component(component).0 * 1e-12 * frame.displayed_fps(fps)
        }
    }
}

fn stage_w(frame: &FrameReport, stage: Phase, fps: f64) -> f64 {
    match stage {
        Phase::Standby => frame.standby_w(fps).iter().sum(),
        Phase::Preprocessing | Phase::Sorting | Phase::Rendering => {
            frame.energy.stage(stage).0 * 1e-12 * frame.displayed_fps(fps)
        }
    }
}

pub(super) fn stage_words(stage: Phase) -> &'static str {
    match stage {
        Phase::Preprocessing => "preprocessing (cull, project, intersect)",
        Phase::Sorting => "sorting",
        Phase::Rendering => "rendering (colour, features, α, blending)",
        Phase::Standby => {
            "standby (leakage, background and refresh of the memory: paid for time, not for work)"
        }
    }
}

fn component_words(component: Component) -> &'static str {
    match component {
        Component::Dram => "DRAM accesses",
        Component::Sram => "on-chip buffer accesses",
        Component::Flop => "arithmetic and control of the units",
        Component::Leakage => "leakage of the chip",
        Component::Background => "background of the memory: DRAM, and the PHY on the chip",
        Component::Refresh => "DRAM refresh",
    }
}

pub(super) fn power(list: &mut List) {
    weighted(
        list,
        Weight::Displayed,
        Key::Power,
        "W",
        "Power at the display rate, standby during frames and between them included: energy over \
         the longer of the frame time and the display period 1 / `fps`. The power to compare \
         designs with; of a frame that misses the display rate it is the power at full rate.",
        |f, fps| Some(f.power_display_rate_w(fps)),
    );
    for c in Component::ALL {
        let text = format!("Part of `power_w.total`: {}.", component_words(c));
        weighted(list, Weight::Displayed, Key::PowerOf(c), "W", text, move |f, fps| {
            Some(component_w(f, c, fps))
        });
    }
    for s in Phase::ALL {
        let text = format!("Part of `power_w.total`: {}.", stage_words(s));
        weighted(
            list,
            Weight::Displayed,
            format!("power_w.{}", s.name()),
            "W",
            text,
            move |f, fps| Some(stage_w(f, s, fps)),
        );
    }
    real(
        list,
        "phy_standby_w",
        "W",
        "Standby power of the chip's side of the memory channels (PHY): a part of \
         `power_w.background`.",
        |f, _| f.cycle().map(|_| f.phy_standby_w),
    );
    weighted(
        list,
        Weight::Running,
        "power_full_rate_w.total",
        "W",
        "Power at full rate: `energy_pj.total` x `achieved_fps`, as if frames ran back to back; \
         its mean is energy over time of all frames.",
        |f, _| f.power_full_rate_w(),
    );
    weighted(
        list,
        Weight::Displayed,
        Key::DisplayPower,
        "W",
        "Power of the display while it shows the frame's image; absent where the trace does not \
         carry the image's mean colour.",
        |f, _| f.display_w,
    );
    weighted(
        list,
        Weight::Displayed,
        Key::PowerWithDisplay,
        "W",
        "`power_w.total` + `display_power_w`.",
        |f, fps| Some(f.power_display_rate_w(fps) + f.display_w?),
    );
}

pub(super) fn area(list: &mut List) {
    real(
        list,
        Key::Area,
        "mm2",
        "Area of the die at the node of the energy table, PHY and controllers of the memory \
         included; absent where the table has none. DRAM is another chip.",
        |f, _| Some(f.area.as_ref()?.total().0),
    );
    real(
        list,
        Key::AreaCore,
        "mm2",
        "Area of the die without `area_mm2.phy` and `area_mm2.controllers`: what papers on these \
         accelerators print.",
        |f, _| Some(f.area.as_ref()?.core().0),
    );
    let hardware = hardware();
    for (i, block) in Area::blocks(hardware).into_iter().enumerate() {
        let name = block.name;
        let unit = hardware.units().find(|(_, unit)| unit.key == name);
        let what = match name {
            "rest" => "everything of the core that is neither unit nor buffer".to_owned(),
            "phy" => "the chip's side of the memory channels (PHY)".to_owned(),
            "controllers" => "memory controllers".to_owned(),
            _ => match unit {
                Some((_, unit)) => format!("all {}", unit.words),
                None => format!("the {name} buffer, all shares and banks"),
            },
        };
        let text = format!("Part of `area_mm2.total`: {what}.");
        real(list, format!("area_mm2.{name}"), "mm2", text, move |f, _| {
            Some(f.area.as_ref()?.areas()[i].0)
        });
        let buffer = hardware.buffers().find(|(_, buffer)| buffer.name == name);
        let stage = unit.map(|(id, _)| id).or(buffer.map(|(id, _)| hardware.stage_of(id)));
        if let Some(stage) = stage {
            let last = list.len() - 1;
            of_stages(&mut list[last..], [stage]);
        }
    }
}

pub(super) fn energy(list: &mut List) {
    real(
        list,
        Key::Energy,
        "pJ",
        "Energy of the frame; standby parts are for the frame's own time.",
        |f, _| Some(f.energy.total().0),
    );
    for c in Component::ALL {
        let text = format!("Part of `energy_pj.total`: {}.", component_words(c));
        real(list, Key::EnergyOf(c), "pJ", text, move |f, _| Some(f.energy.component(c).0));
    }
    for s in Phase::ALL {
        let text = format!("Part of `energy_pj.total`: {}.", stage_words(s));
        real(list, Key::EnergyIn(s), "pJ", text, move |f, _| Some(f.energy.stage(s).0));
    }
    for s in Phase::WORK {
        for c in Key::COMPONENTS {
            let text = format!("Energy of {} in {}.", component_words(c), stage_words(s));
            real(list, Key::EnergyPart(s, c), "pJ", text, move |f, _| Some(f.energy.part(s, c).0));
        }
    }
}
