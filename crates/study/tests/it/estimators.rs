//! Morris effects and Sobol indices of functions whose values are known in closed form.

use std::f64::consts::PI;

use powergs_study::analysis::{indices, morris};

/// The Ishigami function on the unit cube: a = 7, b = 0.1.
fn ishigami(u: &[f64]) -> f64 {
    let x: Vec<f64> = u.iter().map(|u| (2.0 * u - 1.0) * PI).collect();
    x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
}

/// `(first, total)` of the Ishigami function: parts of the variance by hand.
fn ishigami_indices() -> [(f64, f64); 3] {
    let (a, b) = (7.0, 0.1);
    let v1 = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
    let v2 = a * a / 8.0;
    let v13 = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
    let v = v1 + v2 + v13;
    [(v1 / v, (v1 + v13) / v), (v2 / v, v2 / v), (0.0, v13 / v)]
}

const G: [f64; 6] = [0.0, 1.0, 4.5, 9.0, 99.0, 99.0];

/// The g-function of Sobol.
fn g(u: &[f64]) -> f64 {
    u.iter().zip(G).map(|(u, a)| ((4.0 * u - 2.0).abs() + a) / (1.0 + a)).product()
}

fn g_indices() -> Vec<(f64, f64)> {
    let parts = G.map(|a| 1.0 / (3.0 * (1.0 + a) * (1.0 + a)));
    let product: f64 = parts.iter().map(|v| 1.0 + v).product();
    let total = product - 1.0;
    parts.iter().map(|v| (v / total, v * product / (1.0 + v) / total)).collect()
}

fn sobol(f: impl Fn(&[f64]) -> f64, factors: usize, n: usize, seed: u64) -> Vec<indices::Index> {
    let design = indices::Design::new(factors, n, seed, |_| true);
    let values: Vec<f64> = design.points().map(|p| f(&p)).collect();
    assert_eq!(values.len(), n * (factors + 2));
    let found = design.indices(&values, seed + 1);
    let sum: f64 = found.each.iter().map(|i| i.first.value).sum();
    assert!((found.alone.value - sum).abs() < 1e-12, "{found:?}");
    assert!(found.alone.low <= sum && sum <= found.alone.high, "{found:?}");
    found.each
}

/// Within 0.03: the error falls with the root of the rows, of 8192 rows to about 0.01.
fn near(found: &[indices::Index], exact: &[(f64, f64)]) {
    for (i, (index, &(first, total))) in found.iter().zip(exact).enumerate() {
        let differences = [index.first.value - first, index.total.value - total];
        assert!(differences.iter().all(|d| d.abs() < 0.03), "factor {i}: {index:?}");
    }
}

#[test]
fn sobol_indices_of_known_functions() {
    near(&sobol(ishigami, 3, 8192, 1), &ishigami_indices());
    near(&sobol(g, 6, 8192, 2), &g_indices());
}

/// Of ten samples, at least eight have the exact value in the 95 % interval of each index: fewer
/// than eight would happen once in 90 times by chance, and the seeds are fixed.
#[test]
fn bootstrap_intervals_cover() {
    let exact = ishigami_indices();
    let mut covered = [[0; 2]; 3];
    for seed in 0..10 {
        for (i, index) in sobol(ishigami, 3, 256, 100 + seed).iter().enumerate() {
            let is_in = |e: indices::Estimate, x: f64| usize::from(e.low <= x && x <= e.high);
            covered[i][0] += is_in(index.first, exact[i].0);
            covered[i][1] += is_in(index.total, exact[i].1);
            assert!(index.first.low <= index.first.value && index.first.value <= index.first.high);
            assert!(index.total.high - index.total.low < 0.5, "{index:?}");
        }
    }
    assert!(covered.iter().flatten().all(|&n| n >= 8), "{covered:?}");
}

#[test]
fn a_sum_has_no_interactions_and_a_constant_no_variance() {
    let found = sobol(|u| 3.0 * u[0] + u[1] + 1e6, 3, 2048, 5);
    near(&found, &[(0.9, 0.9), (0.1, 0.1), (0.0, 0.0)]);
    assert_eq!(found[2].total.value, 0.0);
    assert_eq!(sobol(|_| 7.25, 2, 16, 6), vec![indices::Index::default(); 2]);
    let none = indices::Design::new(2, 0, 7, |_| true);
    assert_eq!(none.indices(&[], 7).each, vec![indices::Index::default(); 2]);
}

#[test]
fn what_is_not_valid_is_drawn_again() {
    let design = indices::Design::new(3, 64, 9, |p| p[0] + p[1] < 1.2);
    assert_eq!((design.rows(), design.asked), (64, 64));
    assert!(design.redrawn > 0 && design.points().all(|p| p[0] + p[1] < 1.2));
    let nothing = indices::Design::new(2, 3, 9, |_| false);
    assert_eq!((nothing.rows(), nothing.redrawn), (0, 600));
    let design = morris::Design::new(&[4, 4], 20, 9, |p| p != [3, 3]);
    assert_eq!(design.trajectories.len(), 20);
    assert!(design.redrawn > 0 && design.points().all(|p| p != [3, 3]));
    assert!(morris::Design::new(&[2, 2], 5, 9, |_| false).trajectories.is_empty());
}

fn elementary(
    f: impl Fn(&[f64]) -> f64,
    levels: &[usize],
    n: usize,
) -> (morris::Design, Vec<morris::Effect>) {
    let design = morris::Design::new(levels, n, 3, |_| true);
    let unit = |p: &[usize]| -> Vec<f64> {
        p.iter().enumerate().map(|(i, &level)| design.unit(i, level)).collect()
    };
    let values: Vec<f64> = design.points().map(|p| f(&unit(p))).collect();
    let effects = design.effects(&values);
    (design, effects)
}

/// Of a sum the effects are its coefficients, whatever the levels.
#[test]
fn morris_effects_of_a_sum_are_exact() {
    let (_, effects) =
        elementary(|x| 5.0 - 2.0 * x[0] + 0.5 * x[1] + 8.0 * x[3], &[4, 2, 3, 7], 10);
    for (effect, slope) in effects.iter().zip([-2.0, 0.5, 0.0, 8.0]) {
        let expected = [slope, f64::abs(slope), 0.0];
        let found = [effect.mu, effect.mu_star, effect.sigma];
        // Differences of numbers near 10: rounding, no more.
        let differences = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
        assert!(differences.fold(0.0, f64::max) < 1e-12, "{effect:?} {slope}");
    }
}

/// Of a product each effect is the other factor: mean 1/2, spread that of its levels.
#[test]
fn morris_sigma_shows_interactions() {
    let (design, effects) = elementary(|x| 6.0 * x[0] * x[1] + x[2], &[4, 4, 4], 400);
    for effect in &effects[..2] {
        // Levels 0, 1/3, 2/3, 1 with equal chance, times 6: mean 3, deviation 2.236; 400 draws
        // leave an error of 0.11 on the mean.
        assert!((effect.mu - 3.0).abs() < 0.4, "{effect:?}");
        assert!((effect.sigma - 2.236).abs() < 0.25, "{effect:?}");
    }
    assert!(effects[2].sigma < 1e-12);
    for t in &design.trajectories {
        let mut moved = t.moved.clone();
        moved.sort_unstable();
        assert_eq!(moved, [0, 1, 2], "each factor moves once");
        for (pair, &factor) in t.points.windows(2).zip(&t.moved) {
            let different: Vec<usize> = (0..3).filter(|&i| pair[0][i] != pair[1][i]).collect();
            assert_eq!(different, [factor]);
        }
    }
}
