//! A made-up foveated run in which every published claim holds.

use powergs_optimize::fit::OptimumPlace;
use powergs_optimize::foveated::{LevelState, Method};
use powergs_optimize::results::{
    ChangeRecord, FORMAT, FilteredRecord, FitRecord, FovealRecord, ModelRecord, Reference, Results,
    ScreenRecord, SeenRecord, VERSION, VariantRecord,
};
use powergs_optimize::role::RoleKind;

/// A model of level 1: display and rendering power, PSNR.
fn model(
    name: &str,
    role: RoleKind,
    variant: &str,
    (display_w, render_w): (f64, f64),
    db: f64,
) -> ModelRecord {
    let seen =
        SeenRecord { psnr_db: Some(db), ssim: Some(db / 33.0), hvsq: Some(2.1e-5), display_w };
    ModelRecord {
        name: name.into(),
        role,
        baseline: None,
        sweep_lambda: None,
        variant: variant.into(),
        level: 1,
        rho: 0.0,
        gaussians: 6000,
        iterations: 500,
        kept_at: Some(499),
        lambda_per_w: Some(0.1),
        gains: None,
        target_hvsq: None,
        margin_db: Some(0.1),
        steered_db: Some(0.1),
        passed: true,
        gate: seen,
        confirmation: None,
        luck_db: None,
        gate_error_db: None,
        test_error_db: None,
        test: seen,
        flip_test: Some(0.05),
        lpips_test: None,
        display_w,
        render_w,
    }
}

fn baseline(name: &str, variant: &str, watts: (f64, f64), db: f64) -> ModelRecord {
    let job = if variant == "H" { name.into() } else { format!("{variant}-{name}") };
    let own = model(&job, RoleKind::Baseline, variant, watts, db);
    ModelRecord { baseline: Some(name.parse().unwrap()), ..own }
}

fn level(name: &str, level: u8, watts: (f64, f64)) -> ModelRecord {
    let own = model(name, RoleKind::Optimum, "H", watts, 25.0);
    let gate = SeenRecord { hvsq: Some(2.0e-5), ..own.gate };
    ModelRecord { level, rho: 0.3, target_hvsq: Some(2.1e-5), gate, flip_test: None, ..own }
}

fn models() -> Vec<ModelRecord> {
    let mut all = vec![model("dense", RoleKind::Dense, "H", (0.27, 0.71), 27.5)];
    for i in 0..5 {
        let rho = 0.2 * f64::from(i);
        let watts = (0.19 + 0.03 * rho, 0.60 - 0.7 * rho);
        let name = format!("sample-{:02}", i + 1);
        all.push(ModelRecord { rho, ..model(&name, RoleKind::Sample, "H", watts, 27.3) });
    }
    all.push(ModelRecord {
        rho: 0.7,
        ..model("optimum", RoleKind::Optimum, "H", (0.21, 0.11), 27.35)
    });
    all.push(model("L-optimum", RoleKind::Optimum, "L", (0.18, 0.09), 27.0));
    for (variant, db) in [("H", 27.36), ("L", 27.05)] {
        let pruned = baseline("render-only", variant, (0.26, 0.15), db);
        all.push(ModelRecord { rho: 0.75, ..pruned });
        all.push(baseline("display-only", variant, (0.20, 0.72), db));
    }
    for (name, db) in [("lightgs-66", 27.2), ("lightgs-76", 26.9), ("lightgs-86", 26.5)] {
        all.push(baseline(name, "H", (0.27, 0.28), db));
    }
    all.push(level("level2-optimum", 2, (0.20, 0.08)));
    all.push(level("level3-optimum", 3, (0.19, 0.06)));
    for i in 0..4 {
        let lambda = 0.1 * f64::from(i);
        let name = format!("lambda-{lambda}");
        let own = model(&name, RoleKind::Sweep, "H", (0.27 - lambda / 4.0, 0.7), 27.0 - lambda);
        all.push(ModelRecord { sweep_lambda: Some(lambda), ..own });
    }
    all
}

fn fit(variant: &str, level: u8, best: &str) -> FitRecord {
    FitRecord {
        variant: variant.into(),
        level,
        passed: 5,
        missed: 0,
        best: Some(best.into()),
        no_curve: None,
        optimum_rho: Some(0.62),
        optimum_place: Some(OptimumPlace::Interior),
        rho_range: Some([0.0, 0.8]),
        chosen_rho: Some(0.62),
        predicted_w: Some(0.33),
        realised_w: Some(0.32),
        r2_display: Some(0.99),
        r2_render: Some(0.98),
        mre_display: Some(0.003),
        mre_render: Some(0.008),
    }
}

/// A foveated model; HVSQ in 1e-5, no test view has R4.
pub fn foveal(
    method: Method,
    variant: &str,
    first: &str,
    (display_w, render_w): (f64, f64),
    hvsq: [f64; 3],
) -> FovealRecord {
    let [a, b, c] = hvsq.map(|v| Some(1e-5 * v));
    let name = |s: &str| s.to_owned();
    FovealRecord {
        method,
        variant: variant.into(),
        jobs: match first {
            "optimum" => {
                ["optimum", "level2-optimum", "level3-optimum", "level3-optimum"].map(name)
            }
            _ => [first; 4].map(name),
        },
        states: [LevelState::Passed, LevelState::Passed, LevelState::Passed, LevelState::NotShown],
        gaussians: [3000, 2000, 1000, 1000],
        display_w,
        render_w,
        filter_w: if method == Method::RtgsD22 { 0.01 } else { 0.0 },
        filtered: (method == Method::RtgsD22).then_some(FilteredRecord {
            psnr_db: Some(24.5),
            ssim: Some(0.79),
            flip: Some(0.2),
            lpips: None,
        }),
        fps: Some(if method == Method::PowerGs { 84.0 } else { 78.0 }),
        hvsq: [a, b, c, None],
        tiles: [40.0, 30.0, 20.0, 0.0],
        region_j: [1e-3, 5e-4, 2e-4, 0.0],
    }
}

/// The run, with the published powers of `bicycle`.
pub fn run() -> Results {
    let foveated = [
        ("H", "optimum", "render-only", "display-only", 0.0),
        ("L", "L-optimum", "L-render-only", "L-display-only", 0.02),
    ];
    let of_variant = |(v, ours, render, display, less): (&str, &str, &str, &str, f64)| {
        [
            foveal(Method::PowerGs, v, ours, (0.21 - less, 0.11 - less), [2.1, 2.1, 2.0]),
            foveal(Method::FrRender, v, render, (0.26, 0.13 - less), [2.1, 2.1, 2.1]),
            foveal(Method::FrDisplay, v, display, (0.20, 0.72), [2.1, 2.1, 2.1]),
            foveal(Method::RtgsD22, v, render, (0.23, 0.15), [2.1, 2.6, 5.0]),
        ]
    };
    Results {
        judged: None,
        priced: None,
        lost: Vec::new(),
        format: FORMAT.into(),
        version: VERSION,
        tool_version: "0.1.0".into(),
        scene: "bicycle".into(),
        reference: Reference::Photos,
        width_px: 791,
        height_px: 593,
        screen: Some(ScreenRecord { fov_deg: 90.0, widest_deg: None, pooling_rate: 0.05 }),
        missing_regions: vec!["R4".into()],
        oracle: "gscore".into(),
        counted: None,
        fps: 60.0,
        display: "oled-powergs".into(),
        display_scale: 3.0,
        display_to_render: Some(0.27 / 0.71),
        stopped: None,
        variants: [("H", 27.2), ("L", 26.9)]
            .map(|(name, db)| VariantRecord {
                name: name.into(),
                target_psnr_db: Some(db),
                target_ssim: Some(0.8),
                result: None,
                foveated_result: None,
            })
            .into(),
        levels: 3,
        models: models(),
        fits: vec![fit("H", 1, "optimum"), fit("L", 1, "L-optimum"), fit("H", 2, "level2-optimum")],
        dense_fps: Some(20.0),
        foveated: foveated.into_iter().flat_map(of_variant).collect(),
        mean_change: Some(ChangeRecord {
            view: "a".into(),
            level_1: [-1.0, 0.5, -5.0],
            dense: Some([100.0, 90.0, 80.0]),
            regions: Some([
                Some([-1.0, 0.5, -4.0]),
                Some([-1.0, 0.5, -5.0]),
                Some([-1.0, 0.5, -6.0]),
                None,
            ]),
        }),
    }
}
