//! Orders in which Gaussians lie in memory.

use std::io::Cursor;

use powergs_frame::scene::{Gaussians, StorageOrder};
use powergs_frame::trace::{Reader, TraceHeader, Writer};
use powergs_testkit::scenes::random_scene;
use powergs_testkit::traces::header;

/// Gaussians at the corners of a cube of `side` cells, mixed up.
fn grid(side: usize) -> Gaussians {
    let count = side.pow(3);
    let mut scene = random_scene(5, count, 1);
    for (i, mean) in scene.means.iter_mut().enumerate() {
        // 5 has no factor in common with a power of two.
        let at = (i * 5 + 3) % count;
        *mean = [at % side, at / side % side, at / side / side].map(|v| v as f32 - 2.5);
    }
    scene
}

fn sorted(scene: &Gaussians, order: StorageOrder) -> Gaussians {
    let places = order.of(scene).expect("an order that moves");
    let mut all = places.clone();
    all.sort_unstable();
    assert!(all.into_iter().eq(0..scene.len() as u32), "everybody once");
    let sorted = scene.permuted(&places);
    for (i, &from) in places.iter().enumerate() {
        let from = from as usize;
        assert_eq!(sorted.means[i], scene.means[from]);
        assert_eq!(sorted.log_scales[i], scene.log_scales[from]);
        assert_eq!(sorted.rotations[i], scene.rotations[from]);
        assert_eq!(sorted.logit_opacities[i], scene.logit_opacities[from]);
        assert_eq!(sorted.sh_of(i), scene.sh_of(from));
    }
    sorted
}

#[test]
fn each_step_along_a_hilbert_curve_goes_to_a_neighbour() {
    let sorted = sorted(&grid(8), StorageOrder::Hilbert);
    for pair in sorted.means.windows(2) {
        let step: f32 = (0..3).map(|axis| (pair[0][axis] - pair[1][axis]).abs()).sum();
        assert_eq!(step, 1.0, "{pair:?}");
    }
}

#[test]
fn a_morton_curve_takes_half_after_half_x_first() {
    let sorted = sorted(&grid(4), StorageOrder::Morton);
    let place = |i: usize| {
        // Bits of the place in turn: x, y, z of the half, then of the quarter.
        let bit = |n: usize| (i >> (5 - n) & 1) as f32;
        [0, 1, 2].map(|axis| 2.0 * bit(axis) + bit(axis + 3) - 2.5)
    };
    assert!(sorted.means.iter().enumerate().all(|(i, mean)| *mean == place(i)), "{sorted:?}");
}

#[test]
fn the_most_opaque_come_first_and_equal_ones_stay() {
    let mut scene = grid(2);
    scene.logit_opacities = vec![0.5, -0.0, 3.0, -7.0, 0.5, 0.0, -2.0, 0.5];
    let places = StorageOrder::Opacity.of(&scene).expect("an order that moves");
    assert_eq!(places, [2, 0, 4, 7, 5, 1, 6, 3]);
    sorted(&scene, StorageOrder::Opacity);
}

#[test]
fn few_and_equal_gaussians_have_orders() {
    for order in StorageOrder::ALL {
        assert_eq!(StorageOrder::from_name(order.name()), Some(order));
        let none = order.of(&Gaussians::default());
        assert!(none.is_none_or(|places| places.is_empty()));
        let mut same = grid(2);
        same.means.fill([3.0; 3]);
        same.logit_opacities.fill(1.0);
        let places = order.of(&same);
        assert!(places.is_none_or(|places| places.into_iter().eq(0..8)), "{}", order.name());
    }
    assert_eq!(StorageOrder::from_name("random"), None);
    assert_eq!(StorageOrder::Storage.of(&grid(2)), None);
}

#[test]
fn traces_keep_the_order() {
    for order in StorageOrder::ALL {
        let header = TraceHeader { order, ..header(3) };
        let bytes = Writer::new(Vec::new(), &header).unwrap().finish().unwrap();
        assert_eq!(*Reader::open(Cursor::new(bytes)).unwrap().header(), header);
    }
}
