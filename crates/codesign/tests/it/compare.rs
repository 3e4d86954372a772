//! The five ways on made-up prices: the joint one finds the optimum and is never worse.

use std::collections::BTreeMap;

use powergs_codesign::compare::{
    CompareBudget, Comparison, Limit, Market, Pair, Way, compare, front,
};
use powergs_codesign::pricing::{Fate, Price, Row, SCOPES};
use powergs_codesign::stability::{alternatives, coupling, sequential};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const BUDGET: CompareBudget = CompareBudget { area_mm2: 4.0, frame_ms: 16.0 };

fn price(total_w: f64, area_mm2: f64, frame_ms: f64) -> Price {
    let display_w = total_w / 2.0;
    let stages_w = [total_w / 8.0; 4];
    Price { total_w, display_w, stages_w, area_mm2: Some(area_mm2), frame_ms, dram_bytes: 1e6 }
}

/// Models with prices on the base machine and on as many others.
fn rows(prices: &[Vec<Price>]) -> Vec<Row> {
    let row = |prices: &Vec<Price>| {
        let fate = |price: &Price| Fate::Priced(vec![[*price; SCOPES]]);
        let machines = [None].into_iter().chain((0..).map(Some));
        Row { pairs: machines.zip(prices.iter().map(fate)).collect(), ..Row::default() }
    };
    prices.iter().map(row).collect()
}

fn random(seed: u64, models: usize, machines: usize) -> Vec<Vec<Price>> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut one = || {
        let mut draw = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        price(draw(0.5, 2.0), draw(2.0, 6.0), draw(4.0, 24.0))
    };
    (0..models).map(|_| (0..=machines).map(|_| one()).collect()).collect()
}

/// Goes the five ways where the banked model says `factor` times the calibrated watts.
fn found(rows: &[Row], factor: &dyn Fn(Pair) -> f64) -> Vec<Comparison> {
    let passed = vec![true; rows.len()];
    let market = Market { rows, passed: &passed, budget: BUDGET, table: 0, scope: 0 };
    let banked = |pair: Pair| {
        let price = market.price(pair).expect("a price");
        Price { total_w: factor(pair) * price.total_w, ..price }
    };
    let mut confirm = |pairs: &[Pair]| -> Result<_, ()> {
        Ok(Some(pairs.iter().map(|pair| Some(banked(*pair))).collect()))
    };
    compare(&market, &mut confirm, &mut |_| {}).expect("no error").expect("not cancelled")
}

/// By exhaustion: the least watts of all pairs that `keep` keeps and that keep the budget.
fn exhaustive(prices: &[Vec<Price>], keep: impl Fn(Pair) -> bool) -> Option<Pair> {
    let mut best: Option<(f64, Pair)> = None;
    for (model, row) in prices.iter().enumerate() {
        for (place, price) in row.iter().enumerate() {
            let pair = (model, place.checked_sub(1).map(|point| point as u64));
            let fits = price.area_mm2.unwrap() <= 4.0 && price.frame_ms <= 16.0;
            if keep(pair) && fits && best.is_none_or(|(w, _)| price.total_w < w) {
                best = Some((price.total_w, pair));
            }
        }
    }
    best.map(|(_, pair)| pair)
}

#[test]
fn on_toy_spaces_every_way_finds_what_exhaustion_finds() {
    let mut coupled = 0;
    for seed in 0..200 {
        let prices = random(seed, 4, 64);
        let found = found(&rows(&prices), &|_| 1.0);
        let pair = |way: Way| found[way as usize].found.as_ref().ok().map(|f| f.pair);
        assert_eq!(pair(Way::Joint), exhaustive(&prices, |_| true), "seed {seed}");
        let dense = exhaustive(&prices, |pair| pair.0 == 0);
        assert_eq!(pair(Way::Dense), dense, "seed {seed}");
        let base = exhaustive(&prices, |pair| pair.1.is_none());
        assert_eq!(pair(Way::Base), base, "seed {seed}");
        let after = |first: Option<Pair>, same: fn(Pair, Pair) -> bool| {
            first.and_then(|first| exhaustive(&prices, |pair| same(pair, first)))
        };
        assert_eq!(pair(Way::MachineFirst), after(dense, |a, b| a.1 == b.1), "seed {seed}");
        assert_eq!(pair(Way::ModelFirst), after(base, |a, b| a.0 == b.0), "seed {seed}");
        coupled += u32::from(pair(Way::Joint) != pair(Way::MachineFirst));
    }
    assert!(coupled > 20, "{coupled}");
}

#[test]
fn the_joint_pair_is_never_worse_whatever_confirmation_says() {
    for seed in 0..200 {
        let prices = random(seed, 5, 40);
        // Confirmation turns the order round within half as much again.
        let factor = |(model, machine): Pair| {
            let point = machine.map_or(7, |point| point + 11);
            1.0 + 0.5 * ((model as u64 * 31 + point * 17 + seed) % 13) as f64 / 13.0
        };
        let found = found(&rows(&prices), &factor);
        let joint = found[Way::Joint as usize].watts().expect("a pair");
        for other in &found {
            assert!(other.watts().is_none_or(|watts| joint <= watts), "seed {seed}: {found:?}");
        }
    }
}

#[test]
fn a_pair_that_misses_the_deadline_once_confirmed_is_not_taken() {
    // The three best of ten are late when they are simulated with the banked model.
    let row = (0..=10).map(|i| price(1.0 + 0.01 * f64::from(i), 3.0, 10.0)).collect();
    let rows = rows(&[row]);
    let market = Market { rows: &rows, passed: &[true], budget: BUDGET, table: 0, scope: 0 };
    let mut asked = Vec::new();
    let mut confirm = |pairs: &[Pair]| -> Result<_, ()> {
        asked.extend_from_slice(pairs);
        let late = |machine: Option<u64>| machine.is_none_or(|point| point < 2);
        let banked = |pair: &Pair| {
            let price = market.price(*pair)?;
            Some(Price { frame_ms: if late(pair.1) { 17.0 } else { 10.0 }, ..price })
        };
        Ok(Some(pairs.iter().map(banked).collect()))
    };
    let found = compare(&market, &mut confirm, &mut |_| {}).unwrap().unwrap();
    let joint = found[Way::Joint as usize].found.as_ref().expect("a pair");
    assert_eq!(joint.pair, (0, Some(2)));
    let base = found[Way::Base as usize].found.as_ref().expect_err("the base machine is late");
    assert_eq!(base.limits, BTreeMap::from([(Limit::FrameTime, 1)]));
    assert_eq!(found[Way::ModelFirst as usize].watts(), None, "(d) has no model to begin with");
    // Nothing is simulated twice.
    let mut once = asked.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), asked.len());
}

#[test]
fn without_a_pair_the_limits_are_counted_and_the_nearest_miss_is_named() {
    let row = vec![price(1.0, 9.0, 10.0), price(1.0, 5.0, 17.0), price(1.0, 4.4, 10.0)];
    let rows = rows(&[row]);
    let market = Market { rows: &rows, passed: &[true], budget: BUDGET, table: 0, scope: 0 };
    let nothing = market.ranked(market.pairs()).expect_err("all are too large");
    assert_eq!(nothing.pairs, 3);
    assert_eq!(nothing.limits, BTreeMap::from([(Limit::Area, 2), (Limit::Both, 1)]));
    assert_eq!(nothing.nearest.map(|nearest| nearest.0), Some((0, Some(1))));
}

#[test]
fn models_that_miss_the_quality_are_no_candidates() {
    let rows = rows(&[vec![price(2.0, 3.0, 10.0)], vec![price(1.0, 3.0, 10.0)]]);
    let passed = [true, false];
    let market = Market { rows: &rows, passed: &passed, budget: BUDGET, table: 0, scope: 0 };
    assert_eq!(market.pairs().collect::<Vec<_>>(), [(0, None)]);
    assert_eq!(front(&market), [(0, None)]);
}

#[test]
fn the_front_holds_what_nothing_beats_in_all_three() {
    let prices = random(3, 3, 30);
    let rows = rows(&prices);
    let passed = [true; 3];
    let market = Market { rows: &rows, passed: &passed, budget: BUDGET, table: 0, scope: 0 };
    let numbers = |pair: Pair| {
        let price = market.price(pair).unwrap();
        [price.total_w, price.area_mm2.unwrap(), price.frame_ms]
    };
    let in_time: Vec<Pair> = market.pairs().filter(|p| numbers(*p)[2] <= 16.0).collect();
    let beats = |a: Pair, b: Pair| {
        let (a, b) = (numbers(a), numbers(b));
        a != b && a.iter().zip(b).all(|(a, b)| *a <= b)
    };
    let mut wanted: Vec<Pair> = in_time.clone();
    wanted.retain(|pair| !in_time.iter().any(|other| beats(*other, *pair)));
    let mut got = front(&market);
    got.sort_unstable();
    wanted.sort_unstable();
    assert_eq!(got, wanted);
    assert!(wanted.len() > 3);
}

#[test]
fn a_coupling_is_what_neither_half_has_alone() {
    // Model 1 is dear on the base machine, machine 0 is too slow for the dense model: only both
    // together are good, and going one after the other finds neither.
    let rows = rows(&[
        vec![price(1.0, 3.0, 10.0), price(0.9, 3.0, 20.0)],
        vec![price(1.2, 3.0, 10.0), price(0.5, 3.0, 10.0)],
    ]);
    let found = found(&rows, &|_| 1.0);
    let watts: Vec<_> = found.iter().map(|c| c.watts().unwrap()).collect();
    assert_eq!(watts, [1.0, 1.0, 1.0, 1.0, 0.5]);
    let passed = [true; 2];
    let market = Market { rows: &rows, passed: &passed, budget: BUDGET, table: 0, scope: 0 };
    let why = coupling(&market, &found).expect("a coupling");
    assert_eq!((why.before.0, why.joint.0), ((0, None), (1, Some(0))));
    assert_eq!(why.model_alone.unwrap().1.total_w, 1.2);
    assert_eq!(why.machine_alone.unwrap().1.frame_ms, 20.0);
    let tables = ["own".to_owned()];
    let all = alternatives(&market, &tables, Some((1, Some(0))), &|_| BUDGET);
    assert_eq!(all.len(), SCOPES);
    for a in all {
        assert_eq!(a.gain_w(), Some(0.5));
        assert_eq!(sequential(&a.watts), Some(1.0));
        assert_eq!(a.regret_w, Some(0.0));
    }
}
