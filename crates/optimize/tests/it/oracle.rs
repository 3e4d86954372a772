//! Oracles against the models that they stand for.

use powergs_base::budget::Budget;
use powergs_base::quantity::Bytes;
use powergs_core::run::System;
use powergs_core::sim::paper::UnitPrices;
use powergs_core::sim::{Label, paper};
use powergs_core::workload::paper::Padding;
use powergs_core::workload::{Geometry, bin};
use powergs_energy::action::Phase;
use powergs_optimize::oracle::{CycleOracle, PaperOracle, PowerOracle};
use powergs_raster::{Detail, Options, render};

use super::scenes::tiny;

#[test]
fn paper_is_the_closed_form_mean_over_views() {
    let tiny = tiny(800, 8, (96, 70));
    let oracle = PaperOracle { prices: UnitPrices::PUBLISHED, fps: 60.0 };
    let watts = oracle.watts(&tiny.dense, &tiny.cameras, [0.0; 3], &tiny.display).unwrap();
    let (mut render_w, mut display_w) = (0.0, 0.0);
    for camera in &tiny.cameras {
        let rendered = render(&tiny.dense, camera, &Options::reference(Detail::Counters));
        display_w += tiny.display.power(rendered.picture.mean_linear_rgb()).0;
        let work = bin(&rendered.into_frame(camera, [0.0; 3]), Geometry::REFERENCE);
        let report =
            paper::simulate(Label::default(), &work, Padding::TrueTiles, &UnitPrices::PUBLISHED);
        render_w += report.power_display_rate_w(60.0);
    }
    let n = tiny.cameras.len() as f64;
    assert!((watts.render_w / (render_w / n) - 1.0).abs() < 1e-12);
    assert!((watts.display_w / (display_w / n) - 1.0).abs() < 1e-12);
    assert!((watts.parts.total_w() - watts.render_w).abs() < 1e-15);
}

#[test]
fn cycle_is_the_simulated_machine_at_the_display_rate() {
    let tiny = tiny(800, 12, (96, 70));
    for name in ["gscore", "edge"] {
        let system = System::named(name).unwrap();
        let camera = &tiny.cameras[0];
        let rendered = render(&tiny.dense, camera, &Options::reference(Detail::Counters));
        let frame = rendered.into_frame(camera, [0.0; 3]);
        let work = bin(&frame, system.machine().tiles().geometry);
        let report = system.simulate(Label::default(), &work).unwrap();
        let fps = 60.0;
        let oracle = CycleOracle { system, fps, memory: Budget::DEFAULT };
        let watts = oracle.watts(&tiny.dense, &tiny.cameras[..1], [0.0; 3], &tiny.display).unwrap();
        let expected = report.power_display_rate_w(fps);
        assert!((watts.render_w / expected - 1.0).abs() < 1e-12, "{name}");
        let standing: f64 = report.standby_w(fps).iter().sum();
        assert!((watts.parts.stage_w(Phase::Standby) - standing).abs() < 1e-12, "{name}");
        assert!(standing > 0.0, "{name} costs nothing when idle");
    }
}

#[test]
fn lists_over_the_budget_of_memory_are_refused() {
    let tiny = tiny(800, 12, (96, 70));
    let system = System::named("gscore").unwrap();
    let oracle = CycleOracle { system, fps: 60.0, memory: Budget(Bytes(1000)) };
    let refused = oracle.watts(&tiny.dense, &tiny.cameras[..1], [0.0; 3], &tiny.display);
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("(splat, tile) pairs") && message.contains("--memory"), "{message}");
}

#[test]
fn fewer_gaussians_cost_less() {
    let mut tiny = tiny(800, 12, (96, 70));
    let oracle = PaperOracle { prices: UnitPrices::PUBLISHED, fps: 60.0 };
    let before = oracle.watts(&tiny.dense, &tiny.cameras, [0.0; 3], &tiny.display).unwrap();
    let kept: Vec<u32> = (0..400).collect();
    powergs_optimize::prune::select(&mut tiny.dense, &kept);
    let after = oracle.watts(&tiny.dense, &tiny.cameras, [0.0; 3], &tiny.display).unwrap();
    assert!(after.render_w < before.render_w);
}
