//! Prices of the sorting units on lists that are made up.

use powergs_gates::characterise::{CharacteriseError, Characterised, bsu, qsu};
use powergs_gates::committed::netlist;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Lists of up to `longest` keys; `near` of 100 follow the one before closely.
fn lists(count: usize, longest: usize, near: u32) -> Vec<Vec<u16>> {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut list = |_| {
        let length = random.random_range(16..=longest);
        let mut key = 0u16;
        let mut next = |_| {
            let far = random.random_range(0..100) >= near;
            let away = if far { random.random() } else { random.random_range(0..9) };
            key = key.wrapping_add(away);
            key
        };
        (0..length).map(&mut next).collect()
    };
    (0..count).map(&mut list).collect()
}

fn price(found: &Characterised, action: &str) -> f64 {
    found.prices.iter().find(|price| price.action == action).expect(action).pj
}

#[test]
fn quick_sorting_prices_hold_on_other_lists() {
    for library in ["45nm", "7nm"] {
        let unit = netlist("qsu", library).expect("a netlist");
        let found = qsu::prices(&unit, &lists(800, 300, 0)).expect("prices");
        assert!(found.held_out.abs() < 0.05, "{library}: {found:?}");
        assert!(price(&found, "key") > 0.0 && price(&found, "cycle") > 0.0);
        assert!(found.prices.iter().all(|price| price.pj >= 0.0), "{library}: {found:?}");
        assert_eq!(found.prices.len() + found.left_out.len(), 4);
        assert_eq!(found, qsu::prices(&unit, &lists(800, 300, 0)).expect("prices"));
    }
}

#[test]
fn bitonic_sorting_prices_hold_on_other_chunks() {
    let unit = netlist("bsu", "45nm").expect("a netlist");
    let found = bsu::prices(&unit, &lists(600, 256, 0)).expect("prices");
    assert!(found.held_out.abs() < 0.05, "{found:?}");
    assert!(price(&found, "merged-row") > 0.0 && price(&found, "cycle") > 0.0, "{found:?}");
    assert!(found.prices.iter().all(|price| price.pj >= 0.0), "{found:?}");
}

#[test]
fn energy_follows_the_keys() {
    let unit = netlist("bsu", "45nm").expect("a netlist");
    let of = |near| bsu::prices(&unit, &lists(600, 256, near)).expect("prices");
    let (random, near) = (of(0).held_out_pj_per_cycle, of(95).held_out_pj_per_cycle);
    assert!(near < 0.97 * random, "{near} pJ a cycle where keys are alike, {random} where not");
}

#[test]
fn too_little_work_and_other_units_are_refused() {
    let unit = netlist("qsu", "45nm").expect("a netlist");
    let refused = qsu::prices(&unit, &lists(8, 20, 0));
    assert_eq!(refused, Err(CharacteriseError::TooLittle { windows: 0 }));
    let refused = bsu::prices(&unit, &lists(8, 20, 0));
    assert_eq!(refused, Err(CharacteriseError::Port { port: "sort_valid" }));
    assert!(netlist("qsu", "28nm").is_none());
}
