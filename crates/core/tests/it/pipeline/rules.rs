//! Unit rules from outside of the crate: the same rule gives the same replay, another one closes
//! its accounts, and one that breaks the contract is refused.

use std::sync::atomic::{AtomicU64, Ordering};

use powergs_core::flow::FrameTask;
use powergs_core::flow::tile_wise::batch::Batch;
use powergs_core::flow::tile_wise::bsu::{Bsu, Sort};
use powergs_core::flow::tile_wise::ccu::Ccu;
use powergs_core::flow::tile_wise::qsu::{Keys, Qsu};
use powergs_core::flow::tile_wise::vru::{Render, Vru};
use powergs_core::flow::tile_wise::{
    FrameContext, Rule, RuleError, UnitRule, UnitRules, replay, replay_with,
};
use powergs_core::kernel::timeline::Timeline;
use powergs_core::kernel::{Memo, Unit};
use powergs_core::machine::Machine;
use powergs_core::sim::time;
use powergs_core::stage::{DRAM_READ, work_id};
use powergs_energy::action::{ActionCounts, ActionId, Phase};

use super::support::{Dice, TilePlan, gscore, workload};

/// The built-in rule of every unit, by the way that a user's rule takes.
struct Same;

impl<U: Unit> UnitRule<U> for Same {
    fn name(&self) -> &str {
        "same"
    }
}

fn all_from_outside() -> UnitRules {
    UnitRules {
        ccu: Rule::new(Same),
        qsu: Rule::new(Same),
        bsu: Rule::new(Same),
        vru: Rule::new(Same),
    }
}

#[test]
fn rules_that_equal_the_built_in_ones_change_nothing() {
    for seed in 0..200 {
        let mut dice = Dice::new(seed);
        let mut machine = dice.machine();
        let mut frame = dice.workload(machine.tiles().geometry);
        let (hits, reuse) = (dice.hits(&frame), dice.reuse(&frame));
        dice.foveate(&mut frame, &mut machine);
        let lists = dice.lists(&mut frame, &mut machine, reuse.is_some());
        let context = FrameContext {
            hits: hits.as_deref(),
            reuse: reuse.as_deref(),
            lists: lists.as_ref(),
            ..FrameContext::default()
        };
        let mut outside = machine.clone();
        outside.tiles_mut().rules = all_from_outside();
        let (mut here, mut there) = (Timeline::default(), Timeline::default());
        let memo = Memo::default();
        let built_in = replay_with(&frame, &machine, context, &memo, &mut here);
        let ours = replay_with(&frame, &outside, context, &Memo::default(), &mut there);
        assert_eq!(ours, built_in, "seed {seed}");
        assert_eq!(there, here, "seed {seed}");
        for machine in [&outside, &machine, &outside] {
            let again = replay_with(&frame, machine, context, &memo, &mut ());
            assert_eq!(again, built_in, "seed {seed}");
        }
    }
}

#[test]
fn names_tell_machines_apart() {
    let machine = gscore();
    let mut outside = machine.clone();
    outside.tiles_mut().rules = all_from_outside();
    assert_ne!(outside, machine);
    assert_eq!(outside, outside.clone());
    assert_ne!(format!("{outside:?}"), format!("{machine:?}"));
    assert_eq!(machine.tiles().rules.names(), []);
    let all = [("ccu", "same"), ("qsu", "same"), ("bsu", "same"), ("vru", "same")];
    assert_eq!(outside.tiles().rules.names(), all);
    assert_eq!(outside.flow().shared(&outside), None, "its preprocessing is its own");
    assert!(outside.to_toml().contains("[rules]"), "a machine file names them");
    assert!(!machine.to_toml().contains("rules"), "where there are none, nothing is said");
}

/// Some cycles for any piece of work, and some actions.
struct Fixed {
    cycles: u64,
    stalls: u64,
    action: Option<(ActionId, u64)>,
}

impl Fixed {
    const fn of(cycles: u64, stalls: u64) -> Fixed {
        Fixed { cycles, stalls, action: None }
    }
}

impl<U: Unit> UnitRule<U> for Fixed {
    fn name(&self) -> &str {
        "fixed"
    }

    fn cycles(&self, _: &U, _: &U::Work) -> u64 {
        self.cycles
    }

    fn bank_stalls(&self, _: &U, _: &U::Work) -> u64 {
        self.stalls
    }

    fn charge(&self, _: &U, _: &U::Work, actions: &mut ActionCounts) {
        if let Some((action, n)) = self.action {
            actions.charge(Phase::Rendering, action, n);
        }
    }
}

fn three_tiles() -> (Machine, powergs_core::workload::FrameWorkload) {
    let machine = gscore();
    let tile = || TilePlan { chunks: vec![(256, 500), (100, 200)], unfetched: 0, pixels: 256 };
    let frame = workload(machine.tiles().geometry, 5000, &[tile(), tile(), tile()]);
    (machine, frame)
}

#[test]
fn busy_cycles_and_actions_are_those_of_the_rule() {
    let (mut machine, frame) = three_tiles();
    let action = Some((work_id("alpha"), 3));
    machine.tiles_mut().rules.vru = Rule::new(Fixed { cycles: 700, stalls: 11, action });
    let memo = Memo::default();
    let timed = time(&FrameTask::first(&machine, &frame, &memo)).expect("accounts close").outcome;
    let vru = &timed.timing.units[3];
    let gang = u64::from(machine.tiles().vru.units_per_core);
    assert_eq!(vru.busy, 6 * 700 * gang, "six chunks");
    assert_eq!(vru.stalls[powergs_core::stage::Stall::BANK.index()], 6 * 11 * gang);
    // Once for every chunk, and once for every tile.
    assert_eq!(timed.actions.total(work_id("alpha")), (6 + 3) * 3);
    assert_eq!(timed.actions.total(work_id("blend")), 0, "the built-in actions are replaced");
}

/// Counts how often each rule is asked.
struct Asked<'a>(&'a [AtomicU64; 4]);

impl UnitRule<Ccu> for Asked<'static> {
    fn name(&self) -> &str {
        "asked"
    }

    fn cycles(&self, unit: &Ccu, work: &Batch) -> u64 {
        self.0[0].fetch_add(1, Ordering::Relaxed);
        unit.cycles(work)
    }
}

impl UnitRule<Qsu> for Asked<'static> {
    fn name(&self) -> &str {
        "asked"
    }

    fn cycles(&self, unit: &Qsu, work: &Keys) -> u64 {
        assert_eq!(work.passes, 1, "one pass at a time");
        self.0[1].fetch_add(1, Ordering::Relaxed);
        unit.cycles(work)
    }
}

impl UnitRule<Bsu> for Asked<'static> {
    fn name(&self) -> &str {
        "asked"
    }

    fn cycles(&self, unit: &Bsu, work: &Sort) -> u64 {
        self.0[2].fetch_add(1, Ordering::Relaxed);
        unit.cycles(work)
    }
}

impl UnitRule<Vru> for Asked<'static> {
    fn name(&self) -> &str {
        "asked"
    }

    fn cycles(&self, unit: &Vru, work: &Render) -> u64 {
        self.0[3].fetch_add(1, Ordering::Relaxed);
        unit.cycles(work)
    }
}

#[test]
fn every_piece_of_work_is_asked_for_once() {
    static COUNTS: [AtomicU64; 4] = [const { AtomicU64::new(0) }; 4];
    let (mut machine, frame) = three_tiles();
    machine.tiles_mut().rules = UnitRules {
        ccu: Rule::new(Asked(&COUNTS)),
        qsu: Rule::new(Asked(&COUNTS)),
        bsu: Rule::new(Asked(&COUNTS)),
        vru: Rule::new(Asked(&COUNTS)),
    };
    let built_in = replay(&frame, &gscore());
    let ours = replay(&frame, &machine);
    assert_eq!(ours, built_in);
    let [ccu, qsu, bsu, vru] = COUNTS.each_ref().map(|n| n.load(Ordering::Relaxed));
    assert!(ccu > 0, "batches");
    // 356 entries a tile: one pass each.
    assert_eq!([qsu, bsu, vru], [3, 6, 6]);
}

#[test]
fn rules_that_break_their_contract_are_refused() {
    let refused = |change: &dyn Fn(&mut UnitRules)| {
        let (mut machine, frame) = three_tiles();
        change(&mut machine.tiles_mut().rules);
        let error = replay(&frame, &machine).rule_error.expect("a violation");
        let memo = Memo::default();
        let refusal = time(&FrameTask::first(&machine, &frame, &memo)).expect_err("a refusal");
        assert_eq!(refusal.to_string(), error.to_string());
        error
    };
    let no_cycles = refused(&|rules| rules.vru = Rule::new(Fixed::of(0, 0)));
    assert!(matches!(no_cycles, RuleError::NoCycles { .. }), "{no_cycles}");
    let huge = [(u64::MAX, 0), (u64::MAX, u64::MAX), (1, u64::MAX), (1 << 40, 1)];
    for (cycles, stalls) in huge {
        let changes: [&dyn Fn(&mut UnitRules); 4] = [
            &|rules| rules.ccu = Rule::new(Fixed::of(cycles, stalls)),
            &|rules| rules.qsu = Rule::new(Fixed::of(cycles, stalls)),
            &|rules| rules.bsu = Rule::new(Fixed::of(cycles, stalls)),
            &|rules| rules.vru = Rule::new(Fixed::of(cycles, stalls)),
        ];
        for (change, name) in changes.into_iter().zip(["ccu", "qsu", "bsu", "vru"]) {
            let error = refused(change);
            let is_it = matches!(&error, RuleError::TooLong { unit, .. } if *unit == name);
            assert!(is_it, "{error}");
        }
    }
    let charging = |action, n| {
        refused(&move |rules: &mut UnitRules| {
            rules.vru = Rule::new(Fixed { cycles: 1, stalls: 0, action: Some((action, n)) });
        })
    };
    let dram = charging(DRAM_READ, 1);
    assert!(matches!(dram, RuleError::DramBytes { .. }), "{dram}");
    let many = charging(work_id("alpha"), u64::MAX);
    assert!(matches!(many, RuleError::TooMany { .. }), "{many}");
}
