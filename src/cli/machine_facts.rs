//! What reports say about a machine, and its roofline.

use powergs_core::action::Action;
use powergs_core::energy;
use powergs_core::run::System;
use powergs_study::findings::roofline::Roofline;
use powergs_study::run_record::MachineFacts;

/// What reports say about a machine.
pub fn machine_facts(system: &System) -> MachineFacts {
    MachineFacts {
        name: system.machine().name.clone(),
        energy_table: system.energy_table().name.clone(),
        clock_hz: Some(system.machine().clock.0),
        dram_peak_gb_s: Some(system.dram_peak() * 1e-9),
        dram_model: Some(system.machine().dram.model),
        roofline: Some(roofline(system)),
    }
}

/// Peaks of a machine in the operations that PowerGS counts. A CCU takes a Gaussian through
/// everything each interval and makes its box tests beside that; a rendering unit evaluates and
/// blends a pixel each cycle. Sorting counts no operations.
fn roofline(system: &System) -> Roofline {
    let machine = system.machine();
    let flops = energy::flops::per_action();
    let sum = |actions: &[Action]| f64::from(actions.iter().map(|a| flops[a.index()]).sum::<u32>());
    let (ccu, vru) = (&machine.ccu, &machine.vru);
    let gaussian = [Action::Cull, Action::Project, Action::ObbPrepare, Action::ShColour];
    let per_ccu = sum(&gaussian) / f64::from(ccu.initiation_interval)
        + sum(&[Action::ObbTest]) * f64::from(ccu.intersection_units);
    let lanes = f64::from(vru.cores) * f64::from(vru.units_per_core);
    let ceilings = vec![
        ("CCU", machine.clock.0 * f64::from(ccu.units) * per_ccu),
        ("VRU", machine.clock.0 * lanes * sum(&[Action::Alpha, Action::Blend])),
    ];
    Roofline { flops, ceilings, dram_bytes_s: system.dram_peak() }
}
