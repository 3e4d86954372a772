//! Pictures of lists in an order of one's own.

use fearless_simd::Level;
use powergs_base::picture::Picture;
use powergs_frame::splat::{Cover, Intersection, TileGrid};
use powergs_raster::lists::{ListBlending, PaintedView};
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{front_camera, random_scene};

const BACKGROUND: [f32; 3] = [0.2, 0.5, 0.1];

/// A view of a scene that stops pixels, and the lists of its tiles, nearest first.
fn view(seed: u64, tile: u32) -> (PaintedView, Vec<Vec<u32>>, Picture) {
    let mut scene = random_scene(seed, 800, 2);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
    let camera = front_camera(75, 51);
    let options = Options {
        background: BACKGROUND,
        test: Intersection::Aabb,
        tile,
        ..Options::reference(Detail::Image)
    };
    let exact = render(&scene, &camera, &options).picture;
    let painted = PaintedView::new(&scene, &camera, Level::new());
    let grid = TileGrid::new(75, 51, tile);
    let mut lists = vec![Vec::new(); grid.len()];
    for (rank, splat) in (0..).zip(painted.splats()) {
        for row in Cover::new(splat, grid, Intersection::Aabb).rows() {
            (row.x0..row.x1).for_each(|x| lists[grid.index(x, row.y)].push(rank));
        }
    }
    (painted, lists, exact)
}

fn worst(a: &Picture, b: &Picture) -> f32 {
    let values = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    values.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn exact_lists_give_the_exact_picture() {
    for (seed, tile) in [(1, 16), (2, 64), (3, 8)] {
        let (painted, lists, exact) = view(seed, tile);
        let made = painted.blend(tile, &lists, ListBlending::Over, BACKGROUND);
        // A pixel may stop one entry sooner, or an α miss 1/255, in other arithmetic.
        let differs =
            |(a, b): &(&[f32; 3], &[f32; 3])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-4);
        let count = made.pixels.iter().zip(&exact.pixels).filter(differs).count();
        assert!(count <= 3 && worst(&made, &exact) < 5e-3, "{count} {}", worst(&made, &exact));
    }
}

#[test]
fn the_order_counts_where_it_is_blended_and_not_where_it_is_weighted() {
    let (painted, lists, exact) = view(4, 16);
    let turned: Vec<Vec<u32>> =
        lists.iter().map(|list| list.iter().rev().copied().collect()).collect();
    let over = painted.blend(16, &turned, ListBlending::Over, BACKGROUND);
    assert!(worst(&over, &exact) > 0.1);
    for power in [0.0, 4.0, 64.0] {
        let blend = |lists| painted.blend(16, lists, ListBlending::Weighted(power), BACKGROUND);
        assert!(worst(&blend(&lists), &blend(&turned)) < 1e-4);
    }
}

/// One splat has nothing to be ordered with; where nothing is, the background shows.
#[test]
fn a_lonely_splat_is_the_same_in_any_way() {
    let scene = random_scene(5, 1, 0);
    let camera = front_camera(75, 51);
    let painted = PaintedView::new(&scene, &camera, Level::new());
    let lists = vec![(0..painted.splats().len() as u32).collect(); TileGrid::new(75, 51, 16).len()];
    let [over, weighted] = [ListBlending::Over, ListBlending::Weighted(3.0)]
        .map(|blending| painted.blend(16, &lists, blending, BACKGROUND));
    assert!(worst(&over, &weighted) < 1e-5);
    let none = vec![Vec::new(); lists.len()];
    let empty = painted.blend(16, &none, ListBlending::Weighted(3.0), BACKGROUND);
    assert!(empty.pixels.iter().all(|pixel| *pixel == BACKGROUND));
}
