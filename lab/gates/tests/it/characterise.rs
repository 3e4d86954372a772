//! Prices of units on work that is made up.

use powergs_datapath::{NumberFormat, Outcome, Pixel, Record, Vrc};
use powergs_gates::characterise::vrc::{Splat, Work};
use powergs_gates::characterise::{CharacteriseError, Characterised, bsu, qsu, vrc, vru};
use powergs_gates::committed::netlist;
use powergs_gates::energy;
use powergs_gates::netlist::{Behaviour, Netlist};
use powergs_gates::yosys::ZERO;
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
    assert_eq!(refused, Err(CharacteriseError::Port { port: "sort_valid".into() }));
    assert!(netlist("qsu", "28nm").is_none());
}

/// The netlist of a unit with another net, or none, at a port.
fn with_port(unit: &str, port: &str, nets: &[u32]) -> Netlist {
    let mut parts = netlist(unit, "45nm").expect("a netlist").parts().clone();
    let found = parts.ports.iter_mut().find(|found| found.name == port).expect("a port");
    found.nets = nets.to_vec();
    Netlist::new(parts).expect("as good as before")
}

#[test]
fn a_netlist_of_other_parameters_or_with_an_error_is_refused() {
    let lists = lists(600, 256, 0);
    let narrow = bsu::prices(&with_port("bsu", "out_row", &[ZERO; 8]), &lists);
    let (port, expected) = ("out_row".to_owned(), "512".to_owned());
    assert_eq!(narrow, Err(CharacteriseError::Width { port, bits: 8, expected }));
    let silent = bsu::prices(&with_port("bsu", "out_valid", &[ZERO]), &lists);
    assert_eq!(silent, Err(CharacteriseError::Stuck { cycles: 1 << 16 }));
    let deaf = qsu::prices(&with_port("qsu", "out_valid", &[ZERO]), &lists);
    let what = "a key does not leave two cycles after it came";
    assert_eq!(deaf, Err(CharacteriseError::Differs { what }));
    let small = netlist("vrc-e5m6", "45nm").expect("a netlist");
    let cores = vrc::prices(&small, &cores(600, 40, 30));
    assert_eq!(cores, Err(CharacteriseError::Differs { what: "a pixel is another" }));
}

#[test]
fn energies_that_leave_no_price_are_refused() {
    let mut parts = netlist("qsu", "45nm").expect("a netlist").parts().clone();
    for pin in &mut parts.pins {
        (pin.rise_fj, pin.fall_fj) = (-100.0, -100.0);
    }
    for kind in &mut parts.kinds {
        if let Behaviour::FlipFlop(flip_flop) = &mut kind.behaviour {
            (flip_flop.idle_fj, flip_flop.change_fj) = (-1e3, -1e3);
        }
    }
    let unit = Netlist::new(parts).expect("as good as before");
    assert_eq!(qsu::prices(&unit, &lists(600, 256, 0)), Err(CharacteriseError::BelowZero));
}

/// Cores of four pixels, `count` of them, with `splats` splats each, which are over the pixels or,
/// `far` of 100, beside them.
fn cores(count: usize, splats: usize, far: u32) -> Vec<Work> {
    let format = NumberFormat::FP16;
    let core = Vrc::new(format).expect("FP16 will do");
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let mut work = |number: usize| {
        let place = [0; 2].map(|_| 2 * random.random_range(0..8u8));
        let mask: u64 = if number.is_multiple_of(16) { 0b0111 } else { 0b1111 };
        let mut pixels = [0, 1, 2, 3].map(|i| Pixel::open(format, mask >> i & 1 == 1));
        let splats = (0..splats).map(|_| {
            let away = if random.random_range(0..100) < far { 9.0 } else { 0.0 };
            let mean = place.map(|p| f64::from(p) - 7.0 + away + random.random_range(-1.0..1.0));
            let size = random.random_range(1.0f32..4.0);
            let opacity = random.random_range(0.02f32..0.3);
            let colour = [0; 3].map(|_| random.random_range(0.0f32..1.0));
            let record = Record::new(format, mean, [size, 0.0, size], opacity, colour);
            let record = record.expect("an ellipse");
            let mut outcomes = [0; 4];
            for (i, pixel) in (0..).zip(&mut pixels) {
                let (x, y) = (u32::from(place[0]) + i % 2, u32::from(place[1]) + i / 2);
                let outcome = match core.blend(pixel, &record, x, y) {
                    Outcome::Idle => 0,
                    Outcome::Dropped => 1,
                    Outcome::Blended => 2,
                    Outcome::Stopped => 3,
                };
                outcomes[outcome] += 1;
            }
            let ([u, v], [a, b, c]) = (record.mean, record.root);
            let [red, green, blue] = record.colour;
            let numbers = [u, v, a, b, c, record.opacity, red, green, blue];
            Splat { numbers, outcomes }
        });
        let splats = splats.collect();
        let pixel = |pixel: Pixel| {
            let [red, green, blue] = pixel.colour;
            [red, green, blue, pixel.transmittance]
        };
        Work { place, mask, splats, pixels: pixels.map(pixel).to_vec() }
    };
    (0..count).map(&mut work).collect()
}

#[test]
fn rendering_prices_hold_on_other_tiles() {
    let unit = netlist("vrc", "7nm").expect("a netlist");
    let work = cores(2400, 40, 50);
    let found = vrc::prices(&unit, &work).expect("prices");
    assert!(found.held_out.abs() < 0.05, "{found:?}");
    let (dropped, blended) = (price(&found, "dropped"), price(&found, "blended"));
    assert!(0.0 < dropped && 1.1 * dropped < blended, "{found:?}");
    assert_eq!(found, vrc::prices(&unit, &work).expect("prices"));
}

/// As many evaluations, of which one scene blends more: energy follows the scene.
#[test]
fn energy_follows_what_is_blended() {
    let unit = netlist("vrc", "7nm").expect("a netlist");
    let slots = |work: &[Work]| -> u64 {
        let splats = work.iter().flat_map(|work| &work.splats);
        splats.map(|splat| u64::from(splat.outcomes[1] + splat.outcomes[2])).sum()
    };
    let (near, far) = (cores(3000, 20, 5), cores(3000, 20, 95));
    assert_eq!(slots(&near), slots(&far));
    let pj = |work| vrc::prices(&unit, work).expect("prices").held_out_pj_per_cycle;
    assert!(pj(&far) < 0.9 * pj(&near), "{} and {} pJ a cycle", pj(&far), pj(&near));
}

/// Lists of tiles with splats for one to four sub-tiles; sub-tiles of every third tile stop.
fn tiles(count: usize) -> Vec<vru::Work> {
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let tile = |i: usize| {
        let entries: Vec<([u16; 9], u8)> = (0..random.random_range(1..80))
            .map(|_| (std::array::from_fn(|_| random.random()), random.random_range(1..16)))
            .collect();
        let stop = |_| match i % 3 {
            0 => Some(random.random_range(1..=entries.len())),
            _ => None,
        };
        vru::Work { size: [16, 16], ends: [0, 1, 2, 3].map(stop), entries }
    };
    (0..count).map(tile).collect()
}

#[test]
fn prices_of_the_control_hold_on_other_tiles() {
    for library in ["45nm", "7nm"] {
        let unit = netlist("vru", library).expect("a netlist");
        let found = vru::prices(&unit, &tiles(1200)).expect("prices");
        assert!(found.held_out.abs() < 0.05, "{library}: {found:?}");
        assert!(price(&found, "pair") > 0.0 && price(&found, "entry") > 0.0, "{found:?}");
        // A cycle without anything to do is most of what an idle unit draws.
        assert!(price(&found, "cycle") < found.held_out_pj_per_cycle, "{found:?}");
    }
}

/// A report without vectors knows nothing of the work: the same for any, and proportional to
/// toggles beside the clock.
#[test]
fn without_vectors_a_unit_costs_the_same_whatever_it_does() {
    let unit = netlist("qsu", "45nm").expect("a netlist");
    let [random, near] = [0, 95].map(|near| qsu::prices(&unit, &lists(800, 300, near)));
    let (random, near) = (random.expect("prices"), near.expect("prices"));
    assert_eq!(random.vectorless_pj_per_cycle, near.vectorless_pj_per_cycle);
    assert!(random.held_out_pj_per_cycle > 1.02 * near.held_out_pj_per_cycle);
    let (all, cycles) = energy::vectorless(&unit);
    assert!(all.clock() > 0.3 * all.clock_ungated && all.clock() < all.clock_ungated);
    let per_cycle = all.total() / cycles * 1e-3;
    assert_eq!(per_cycle, random.vectorless_pj_per_cycle);
    assert!((0.2..2.0).contains(&(per_cycle / random.held_out_pj_per_cycle)), "{per_cycle}");
}
