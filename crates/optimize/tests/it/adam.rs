//! Adam against the formula in double precision.

use powergs_optimize::adam::{Adam, Group, Rates, bad_gradient};
use powergs_optimize::prune;
use powergs_scene::Gaussians;

use super::scenes::tiny;

fn scene() -> Gaussians {
    tiny(40, 24, (16, 12)).dense
}

/// Some gradient, other in every step: a fixed hash of position and step.
fn slope(group: usize, i: usize, step: usize) -> f32 {
    let h = (group * 7_919 + i * 104_729 + step * 1_299_709) as u64;
    let h = h.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
    (h as f32 / (1u64 << 24) as f32 - 0.5) * 10f32.powi((h % 7) as i32 - 5)
}

fn gradients(scene: &Gaussians, step: usize) -> [Vec<f32>; 5] {
    std::array::from_fn(|g| (0..Group::ALL[g].of(scene).len()).map(|i| slope(g, i, step)).collect())
}

fn refs(of: &[Vec<f32>; 5]) -> [&[f32]; 5] {
    std::array::from_fn(|i| of[i].as_slice())
}

const RATES: Rates = Rates {
    means: 1e-4,
    scales: 0.005,
    rotations: 0.001,
    opacities: 0.05,
    sh_dc: 0.0025,
    sh_rest: 0.000_125,
};

#[test]
fn fifty_steps_agree_with_double_precision() {
    let before = scene();
    let (mut trained, mut adam) = (before.clone(), Adam::new(&before));
    for step in 0..50 {
        adam.step(&mut trained, refs(&gradients(&before, step)), &RATES);
    }
    let n = before.sh_coefficients();
    for (g, group) in Group::ALL.into_iter().enumerate() {
        for (i, (&p0, &p)) in group.of(&before).iter().zip(group.of(&trained)).enumerate() {
            let rate = match group {
                Group::Means => RATES.means,
                Group::Scales => RATES.scales,
                Group::Rotations => RATES.rotations,
                Group::Opacities => RATES.opacities,
                Group::Sh if i % n == 0 => RATES.sh_dc,
                Group::Sh => RATES.sh_rest,
            };
            let (mut value, mut m, mut v) = (f64::from(p0), 0.0, 0.0);
            for step in 0..50 {
                let slope = f64::from(slope(g, i, step));
                m = 0.9 * m + 0.1 * slope;
                v = 0.999 * v + 0.001 * slope * slope;
                let t = step as i32 + 1;
                let (mh, vh) = (m / (1.0 - 0.9f64.powi(t)), v / (1.0 - 0.999f64.powi(t)));
                value -= rate * mh / (vh.sqrt() + 1e-15);
            }
            // Fifty roundings of the value, and of steps of at most the rate each.
            let tolerance = 50.0 * (f64::from(p0).abs() * 6e-8 + rate * 1e-5);
            let off = (f64::from(p) - value).abs();
            assert!(off <= tolerance, "{} {i}: {p} is not {value}", group.name());
        }
    }
}

#[test]
fn a_rate_of_zero_leaves_everything_alone() {
    let before = scene();
    let (mut trained, mut adam) = (before.clone(), Adam::new(&before));
    adam.step(&mut trained, refs(&gradients(&before, 0)), &RATES.colours_only());
    assert_ne!(trained.sh, before.sh);
    trained.sh.clone_from(&before.sh);
    assert_eq!(trained, before);
    assert!(adam.first.logit_opacities.iter().all(|m| *m == 0.0));
}

#[test]
fn a_parameter_without_gradient_does_not_move() {
    let before = scene();
    let (mut trained, mut adam) = (before.clone(), Adam::new(&before));
    let zeros: [Vec<f32>; 5] = std::array::from_fn(|g| vec![0.0; Group::ALL[g].of(&before).len()]);
    adam.step(&mut trained, refs(&zeros), &RATES);
    assert_eq!(trained, before);
}

#[test]
fn a_bad_gradient_is_found_and_named() {
    let scene = scene();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        let mut slopes = gradients(&scene, 0);
        assert_eq!(bad_gradient(&scene, refs(&slopes)), None);
        slopes[4][17 * 48 + 5] = bad;
        slopes[4][20 * 48] = bad;
        let found = bad_gradient(&scene, refs(&slopes)).unwrap();
        assert_eq!((found.group, found.gaussian, found.position), (Group::Sh, 17, 5));
        slopes[2][11] = bad;
        let found = bad_gradient(&scene, refs(&slopes)).unwrap();
        assert_eq!((found.group, found.gaussian, found.position), (Group::Rotations, 2, 3));
    }
}

#[test]
fn moments_follow_their_gaussians() {
    let before = scene();
    let (mut pruned, mut adam) = (before.clone(), Adam::new(&before));
    adam.step(&mut pruned, refs(&gradients(&before, 0)), &RATES);
    let (whole, moments) = (pruned.clone(), adam.clone());
    let kept = [0, 3, 4, 20, 39];
    prune::keep(&mut pruned, &mut adam, &kept, 1.0);
    assert_eq!(pruned.len(), 5);
    for (to, from) in kept.into_iter().map(|i| i as usize).enumerate() {
        for (now, old) in
            [(&pruned, &whole), (&adam.first, &moments.first), (&adam.second, &moments.second)]
        {
            assert_eq!(now.means[to], old.means[from]);
            assert_eq!(now.log_scales[to], old.log_scales[from]);
            assert_eq!(now.rotations[to], old.rotations[from]);
            assert_eq!(now.logit_opacities[to], old.logit_opacities[from]);
            assert_eq!(now.sh_of(to), old.sh_of(from));
        }
    }
    assert_eq!(adam.steps, 1);
}

#[test]
fn the_opacity_cap_limits_and_forgets() {
    let before = scene();
    let (mut pruned, mut adam) = (before.clone(), Adam::new(&before));
    adam.step(&mut pruned, refs(&gradients(&before, 0)), &RATES);
    let kept: Vec<u32> = (0..40).collect();
    prune::keep(&mut pruned, &mut adam, &kept, 0.5);
    // The logit of one half is zero.
    assert!(pruned.logit_opacities.iter().all(|o| *o <= 0.0));
    assert!(pruned.logit_opacities.contains(&0.0), "nothing was above the cap");
    assert!(adam.first.logit_opacities.iter().all(|m| *m == 0.0));
    assert!(adam.first.means.iter().flatten().any(|m| *m != 0.0));
}
