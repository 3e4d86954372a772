//! Does the `paper` model reproduce the published one?

use powergs_core::sim::paper::{UnitPrices, breakdown, simulate};
use powergs_core::sim::{Label, Model};
use powergs_core::workload::paper::{
    Padding, StageCounts, TileLoad, count, count_foveated, count_frame, pad,
};
use powergs_core::workload::{Geometry, bin};
use powergs_energy::Component;
use powergs_energy::action::Phase;
use powergs_frame::splat::{Counters, FoveaCounters};
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{floats, load};
use serde_json::Value;

use crate::pipeline::support::Dice;

/// The published numbers are sums of a few exact products; only the order of additions differs.
const TOLERANCE: f64 = 1e-9;

/// Compares counts and watts at 60 frames a second with a block of reference results.
fn check(counts: &[StageCounts; 3], expected: &Value) {
    let close = |key: &str, value: f64| {
        // Totals are not in every block.
        let Some(want) = expected.get(key).and_then(Value::as_f64) else { return 0 };
        assert!((value - want).abs() <= TOLERANCE * want.abs(), "{key}: {value} for {want}");
        1
    };
    let energy = breakdown(counts, &UnitPrices::PUBLISHED);
    let watts = |picojoules: f64| picojoules * 1e-12 * 60.0;
    let mut checked = 0;
    for (stage, c) in Phase::WORK.into_iter().zip(counts) {
        let name = stage.name();
        checked += close(&format!("{name}_dram"), c.dram_read + c.dram_write);
        checked += close(&format!("{name}_sram"), c.sram);
        checked += close(&format!("{name}_flops"), c.flops);
        checked += close(&format!("{name}_power"), watts(energy.stage(stage).0));
    }
    checked += close("total_power", watts(energy.total().0));
    assert_eq!(checked, 13);
    let sum = |part: fn(&StageCounts) -> f64| counts.iter().map(part).sum::<f64>();
    close("total_dram", sum(|c| c.dram_read + c.dram_write));
    close("total_sram", sum(|c| c.sram));
    close("total_flops", sum(|c| c.flops));
    close("total_dram_power", watts(energy.component(Component::Dram).0));
    close("total_sram_power", watts(energy.component(Component::Sram).0));
    close("total_flops_power", watts(energy.component(Component::Flop).0));
}

fn tile_loads(entries: &Value, loaded: &Value) -> Vec<TileLoad> {
    let pairs = floats(entries).into_iter().zip(floats(loaded));
    pairs.map(|(entries, loaded)| TileLoad { entries, loaded }).collect()
}

#[test]
fn published_results_are_reproduced() {
    let file = load("power_model.json");
    for case in file["cases"].as_array().unwrap() {
        let n = |key: &str| case[key].as_u64().unwrap();
        let counters = Counters {
            points: n("points"),
            survivors: n("survivors"),
            tile_pairs: n("tile_pairs"),
            intersecting_points: n("intersecting_points"),
            fetched_points: n("fetched_points"),
            obb_tests: n("obb_tests"),
            obb_prepared: n("obb_prepared"),
            tile_loads: 0,
            alpha_evaluations: n("alpha_evaluations"),
            blends: n("blends"),
        };
        let (width, height) = (n("width"), n("height"));
        let tiles = tile_loads(&case["tile_entries"], &case["tile_loaded"]);
        check(&count(&counters, &tiles, width * height), &case["output_true_tiles"]);
        let padded = pad(&tiles, width as u32, height as u32);
        check(&count(&counters, &padded, width * height), &case["output"]);
    }
}

#[test]
fn a_rendered_and_binned_frame_costs_what_the_reference_says() {
    let (case, scene, camera, background) = powergs_testkit::scenes::forward_input();
    let options = Options { background, ..Options::reference(Detail::Dominance) };
    let frame = render(&scene, &camera, &options).into_frame(&camera, options.background);
    let workload = bin(&frame, Geometry::REFERENCE);
    let expected = &case["correct_obb"];
    check(&count_frame(&workload, Padding::TrueTiles), &expected["power_true_tiles"]);
    check(&count_frame(&workload, Padding::Reference), &expected["power_reference_padding"]);

    let label = Label { frame: 3, name: "view".into(), display_w: Some(0.5), ..Label::default() };
    let report = simulate(label, &workload, Padding::TrueTiles, &UnitPrices::PUBLISHED);
    let want = expected["power_true_tiles"]["total_power"].as_f64().unwrap();
    assert!((report.power_display_rate_w(60.0) - want).abs() <= TOLERANCE * want);
    assert_eq!((report.frame, report.display_w), (3, Some(0.5)));
    assert_eq!(report.frame_time_s(), None);
    assert_eq!(report.power_full_rate_w(), None);
    assert!(!report.misses_deadline(1e9), "no time, no deadline");
    let bytes = report.stages.map(|s| (s.read + s.write) as f64);
    let want = Phase::WORK
        .map(|s| expected["power_true_tiles"][format!("{}_dram", s.name())].as_f64().unwrap());
    assert_eq!(bytes, want);
    assert_eq!(Model::Paper.name(), "paper");
}

/// Padding as the published code does it: replicate to pixels, reflect, average 16x16 blocks.
fn naive_pad(tiles: &[TileLoad], width: usize, height: usize) -> Vec<TileLoad> {
    let (nx, ny) = (width.div_ceil(16), height.div_ceil(16));
    let reflect = |x: usize, n: usize| if x < n { x } else { 2 * (n - 1) - x };
    let mut out = Vec::new();
    for ty in 0..ny {
        for tx in 0..nx {
            let mut sum = TileLoad::default();
            for y in ty * 16..ty * 16 + 16 {
                for x in tx * 16..tx * 16 + 16 {
                    let from = reflect(y, height) / 16 * nx + reflect(x, width) / 16;
                    sum.entries += tiles[from].entries;
                    sum.loaded += tiles[from].loaded;
                }
            }
            out.push(TileLoad { entries: sum.entries / 256.0, loaded: sum.loaded / 256.0 });
        }
    }
    out
}

#[test]
fn padding_equals_a_naive_twin_at_every_remainder() {
    let mut dice = Dice::new(7);
    let mut mixed = 0;
    for width in [16, 17, 20, 24, 25, 31, 32, 33, 40, 41, 47] {
        for height in [9, 12, 15, 16, 18, 24, 40, 57] {
            let n = usize::div_ceil(width, 16) * usize::div_ceil(height, 16);
            let tiles: Vec<TileLoad> = (0..n)
                .map(|_| TileLoad {
                    entries: f64::from(dice.roll(0, 5000)),
                    loaded: f64::from(dice.roll(0, 4000)),
                })
                .collect();
            let ours = pad(&tiles, width as u32, height as u32);
            let naive = naive_pad(&tiles, width, height);
            for (a, b) in ours.iter().zip(&naive) {
                // Sums of at most four weighted values against sums of 256.
                assert!((a.entries - b.entries).abs() < 1e-9 && (a.loaded - b.loaded).abs() < 1e-9);
            }
            mixed += usize::from(ours != tiles);
        }
    }
    // Remainders of 1 to 8 in either direction mix an edge tile with its neighbour.
    assert!(mixed > 30, "{mixed}");
}

#[test]
fn tiny_images_are_padded_without_panic() {
    for (width, height) in [(1, 1), (1, 40), (5, 3)] {
        let n = usize::div_ceil(width, 16) * usize::div_ceil(height, 16);
        let tiles = vec![TileLoad { entries: 300.0, loaded: 256.0 }; n];
        let padded = pad(&tiles, width as u32, height as u32);
        for tile in padded {
            // All tiles are equal, so every mean is the same value, up to rounding of the weights.
            assert!((tile.entries - 300.0).abs() < 1e-9 && (tile.loaded - 256.0).abs() < 1e-9);
        }
    }
}

#[test]
fn published_foveated_results_are_reproduced_with_the_right_row() {
    let file = load("power_model_foveated.json");
    for case in file["cases"].as_array().unwrap() {
        let n = |key: &str| case[key].as_u64().unwrap();
        let counters = Counters {
            points: n("points"),
            survivors: n("survivors"),
            tile_pairs: n("tile_pairs"),
            intersecting_points: n("intersecting_points"),
            fetched_points: n("fetched_points"),
            obb_tests: n("obb_tests"),
            obb_prepared: 0,
            tile_loads: 0,
            alpha_evaluations: n("alpha_evaluations"),
            blends: n("blends"),
        };
        let levels = floats(&case["points_by_levels"]);
        let fovea = FoveaCounters {
            lookups: n("lookups"),
            prepared_published: n("prepared_published"),
            points_by_levels: std::array::from_fn(|k| levels[k] as u64),
            extra_alpha: n("extra_alpha"),
            blends_2: n("blends_2"),
        };
        let tiles = tile_loads(&case["tile_entries"], &case["tile_loaded"]);
        let pixels = n("width") * n("height");
        let counts = count_foveated(&counters, &fovea, &tiles, pixels);
        check(&counts, &case["output_true_tiles"]);
    }
}
