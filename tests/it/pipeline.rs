//! Does the pipeline keep its rules?

mod laws;
mod oracle;
pub mod support;
mod timelines;

use powergs_sim::accel::timeline::Timeline;
use powergs_sim::accel::{Machine, Replay, replay_observed};
use rayon::prelude::*;

use self::support::Dice;

/// How many random machines step through random frames.
const CASES: u64 = 2500;

/// Cycles by unit and state: busy, stalls by cause, idle.
type States = [[u64; 5]; 4];

fn states_of(replay: &Replay) -> States {
    std::array::from_fn(|unit| {
        let u = &replay.timing.units[unit];
        [u.busy, u.stalls[..4].iter().sum(), u.stalls[4], u.stalls[5], u.idle]
    })
}

/// The same, counted in the oracle's picture of every cycle.
fn states_seen(seen: &oracle::Seen, machine: &Machine) -> States {
    let gangs = [1, machine.gsu.qsu_per_core, machine.gsu.bsu_per_core, machine.vru.units_per_core];
    let symbols: [fn(char) -> bool; 5] =
        [|c| c.is_ascii_digit(), |c| "rlsf".contains(c), |c| c == 'i', |c| c == 'o', |c| c == '.'];
    std::array::from_fn(|unit| symbols.map(|s| seen.cycles(unit, s) * u64::from(gangs[unit])))
}

fn compare(seed: u64) -> States {
    let mut dice = Dice::new(seed);
    let machine = dice.machine();
    let workload = dice.workload(machine.geometry);
    let mut timeline = Timeline::default();
    let replay = replay_observed(&workload, &machine, &mut timeline);
    let seen = oracle::run(&workload, &machine);
    let case = || format!("seed {seed}\n{machine:#?}\n{:#?}", workload.tiles);
    if timeline.draw() != seen.draw() {
        panic!("pipeline:\n{}\noracle:\n{}\n{}", timeline.draw(), seen.draw(), case());
    }
    assert_eq!(replay.timing.frame, seen.frame, "{}", case());
    assert_eq!(replay.timing.preprocessing_end, seen.preprocessing_end, "{}", case());
    assert_eq!(replay.timing.dram.requests_served, seen.requests, "{}", case());
    assert_eq!(replay.served.stages.map(|s| s.read), seen.read, "{}", case());
    assert_eq!(replay.served.stages.map(|s| s.write), seen.write, "{}", case());
    let states = states_of(&replay);
    assert_eq!(states, states_seen(&seen, &machine), "{}", case());
    states
}

#[test]
fn recurrences_equal_the_cycle_by_cycle_oracle() {
    let all: Vec<States> = (0..CASES).into_par_iter().map(compare).collect();
    // The cases reach every state that the rules know; a CCU never waits for another unit.
    for unit in 0..4 {
        for state in 0..5 {
            let cycles: u64 = all.iter().map(|states| states[unit][state]).sum();
            assert_eq!(cycles == 0, (unit, state) == (0, 2), "unit {unit}, state {state}");
        }
    }
}
