//! Splits and the order of training views.

use glam::DVec3;
use powergs_optimize::views::{ViewOrder, split};
use powergs_scene::{Camera, Split};

fn cameras(n: usize) -> Vec<Camera> {
    let one = |i: usize| {
        let centre = DVec3::new(i as f64, 0.0, 5.0);
        let mut camera = Camera::looking_at(centre, DVec3::ZERO, DVec3::Y, 0.7, (32, 24));
        // Names against the order of the file.
        camera.name = format!("{:03}.jpg", n - i);
        camera
    };
    (0..n).map(one).collect()
}

#[test]
fn every_eighth_name_tests_and_the_gate_comes_from_training_views() {
    let views = cameras(24);
    let split = split(&views, 0);
    // The names 001, 009 and 017 belong to the files at 23, 15 and 7.
    assert_eq!(split.test, [7, 15, 23]);
    let mut all: Vec<usize> =
        split.train.iter().chain(&split.validation).chain(&split.test).copied().collect();
    all.sort_unstable();
    assert_eq!(all, (0..24).collect::<Vec<_>>(), "every view has one use");
    assert_eq!(split.validation.len(), 3);
    assert!(split.notes.is_empty());
}

#[test]
fn the_split_of_the_file_is_respected() {
    let mut views = cameras(12);
    for (i, camera) in views.iter_mut().enumerate() {
        camera.split = Some(if i < 2 { Split::Test } else { Split::Train });
    }
    let split = split(&views, 5);
    assert_eq!(split.test, [0, 1]);
    assert_eq!(split.validation.len(), 2);
    assert_eq!(split.train.len(), 8);
}

#[test]
fn too_few_views_serve_twice_and_that_is_said() {
    for n in 1..4 {
        let split = split(&cameras(n), 0);
        assert!(!split.train.is_empty() && !split.validation.is_empty() && !split.test.is_empty());
        assert!(!split.notes.is_empty(), "{n}");
    }
}

#[test]
fn an_epoch_is_a_permutation_and_the_next_is_another() {
    let mut order = ViewOrder::new(7, 13);
    let epoch = |order: &mut ViewOrder, e: u64| -> Vec<usize> {
        (0..13).map(|i| order.at(13 * e + i)).collect()
    };
    let first = epoch(&mut order, 0);
    let mut sorted = first.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..13).collect::<Vec<_>>());
    assert_ne!(first, epoch(&mut order, 1));
    // Anywhere, in any order of asking.
    let mut other = ViewOrder::new(7, 13);
    assert_eq!(other.at(13 * 5 + 4), order.at(13 * 5 + 4));
    assert_eq!(first, epoch(&mut other, 0));
    assert_ne!(first, epoch(&mut ViewOrder::new(8, 13), 0));
}

#[test]
fn validation_views_may_train_too() {
    let split = split(&cameras(24), 0);
    let seen = split.clone().validation_trains();
    assert_eq!(seen.train.len(), split.train.len() + split.validation.len());
    assert!(seen.train.is_sorted() && seen.validation == split.validation);
    assert!(seen.train.iter().all(|v| !seen.test.contains(v)), "test views never train");
}
