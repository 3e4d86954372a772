//! Machines that take over the preprocessing of an earlier one do exactly what they do alone.

use powergs_base::config::embedded::{MACHINES, find};
use powergs_core::flow::tile_wise::{FrameContext, replay, replay_with};
use powergs_core::kernel::Memo;
use powergs_core::machine::DramModel;
use powergs_core::machine::Machine;

use super::support::{Dice, TilePlan, gscore, workload};

/// Variants of a machine that differ behind its CCUs, and in them.
fn variants(base: &Machine) -> Vec<Machine> {
    let mut all = Vec::new();
    for cores in [1, 2, 3] {
        for units in [1, 2] {
            let mut machine = base.clone();
            machine.tiles_mut().vru.cores = cores;
            machine.tiles_mut().ccu.units = units;
            all.push(machine.clone());
            machine.tiles_mut().vru.latency += 7;
            all.push(machine.clone());
            machine.tiles_mut().ccu.latency += 3;
            all.push(machine.clone());
            machine.dram.latency.0 *= 2.0;
            all.push(machine);
        }
    }
    all
}

#[test]
fn what_others_have_preprocessed_changes_nothing() {
    let mut shared = 0;
    for seed in 0..120 {
        let mut dice = Dice::new(seed);
        let mut base = dice.machine();
        if seed % 4 == 0 && base.device.is_some() {
            base.dram.model = DramModel::Calibrated;
        }
        let frame = dice.workload(base.tiles().geometry);
        let memo = Memo::default();
        for machine in variants(&base) {
            let given = FrameContext::default();
            let alone = replay(&frame, &machine);
            let first = replay_with(&frame, &machine, given, &memo, &mut ());
            let again = replay_with(&frame, &machine, given, &memo, &mut ());
            assert_eq!(first, alone, "seed {seed}");
            assert_eq!(again, alone, "seed {seed}");
            shared += u32::from(alone.timing.preprocessing_end > 0);
        }
    }
    assert!(shared > 1000, "{shared} machines preprocessed anything");
}

#[test]
fn machines_that_differ_in_front_do_not_share() {
    let machine = gscore();
    let tile = || TilePlan { chunks: vec![(100, 200)], unfetched: 0, pixels: 256 };
    let frame = workload(machine.tiles().geometry, 5000, &[tile(), tile(), tile()]);
    let memo = Memo::default();
    let mut slow = machine.clone();
    slow.tiles_mut().ccu.operations_per_cycle = 20;
    let fast = replay_with(&frame, &machine, FrameContext::default(), &memo, &mut ());
    let slow = replay_with(&frame, &slow, FrameContext::default(), &memo, &mut ());
    assert!(slow.timing.preprocessing_end > fast.timing.preprocessing_end);

    // An entry of the first carries the distance to the next tile of its splat, of the other not.
    let text = find(MACHINES, "gbu").expect("a machine");
    let of = |set: &str| {
        let sets = [set, "dram.model=bandwidth"].map(str::to_owned);
        Machine::parse_with(text, &sets).expect("a good machine")
    };
    let (gbu, without) = (of("cache.capacity=32KiB"), of("cache.capacity=0 B"));
    assert!(gbu.tiles().list_entry() > without.tiles().list_entry());
    let shared = |machine: &Machine| machine.flow().shared(machine);
    assert!(shared(&gbu).is_some());
    assert_ne!(shared(&gbu), shared(&without));
}
