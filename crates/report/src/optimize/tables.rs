//! Tables as CSV: the record that everything else is derived from.

use super::Story;
use crate::document::{Cell, Column, Table};
use powergs_optimize::conclusion::Conclusion;
use powergs_optimize::outcome::Outcome;
use powergs_optimize::ratio_study::RatioRow;
use powergs_optimize::role::Role;

/// λ as the files have it.
fn lambda(outcome: &Outcome) -> Cell {
    outcome.lambda.map(|v| format!("{v:.6e}")).into()
}

/// `samples.csv`, which `powergs-sim fit` reads: a row per sample. `conclusion` knows what display
/// power the curve is fitted to.
pub fn samples_csv(done: &[Outcome], conclusion: &Conclusion) -> Vec<u8> {
    let text = Column::text;
    let mut table = Table::new([
        text("sample"),
        Column::fixed("rho", 6),
        Column::fixed("display_w", 8),
        Column::fixed("render_w", 8),
        Column::fixed("total_w", 8),
        Column::fixed("psnr_db", 4),
        Column::fixed("ssim", 6),
        text("passed"),
        text("lambda_per_w"),
        text("gaussians"),
        text("iterations"),
        text("kept_at"),
        Column::fixed("display_spent_w", 8),
    ]);
    let spent = |o: &Outcome| {
        let fitted = conclusion.fitted.iter().find(|f| f.name == o.name);
        Cell::from(fitted.map(|f| f.sample.display_w))
    };
    for o in done.iter().filter(|o| o.role == Role::Sample) {
        table.row([
            o.name.as_str().into(),
            o.rho.into(),
            o.watts.display_w.into(),
            o.watts.render_w.into(),
            o.watts.total_w().into(),
            o.gate.quality.psnr_db.into(),
            o.gate.quality.ssim.into(),
            o.passed.into(),
            lambda(o),
            o.points.into(),
            o.iterations.into(),
            o.kept_at.into(),
            spent(o),
        ]);
    }
    table.csv()
}

/// `models.csv`: every model of the run, with its quality on both splits and its power. LPIPS has a
/// column if it was measured.
pub fn models_csv(story: &Story<'_>) -> Vec<u8> {
    let (done, text) = (story.done, Column::text);
    let has_lpips = done.iter().any(|o| o.lpips_test.is_some());
    let mut columns = vec![
        text("model"),
        Column::fixed("rho", 6),
        text("gaussians"),
        text("iterations"),
        text("lambda_per_w"),
        Column::fixed("gate_psnr_db", 4),
        Column::fixed("gate_ssim", 6),
        text("passed"),
        Column::fixed("test_psnr_db", 4),
        Column::fixed("test_ssim", 6),
        Column::fixed("display_w", 8),
        Column::fixed("render_w", 8),
        Column::fixed("total_w", 8),
        Column::fixed("flip_test", 6),
    ];
    columns.extend(["gain_red", "gain_green", "gain_blue"].map(|name| Column::fixed(name, 6)));
    columns.extend(has_lpips.then(|| Column::fixed("lpips_test", 6)));
    let row = |o: &Outcome| {
        let mut cells: Vec<Cell> = vec![
            o.name.as_str().into(),
            o.rho.into(),
            o.points.into(),
            o.iterations.into(),
            lambda(o),
            o.gate.quality.psnr_db.into(),
            o.gate.quality.ssim.into(),
            story.passed(o).into(),
            o.test.quality.psnr_db.into(),
            o.test.quality.ssim.into(),
            o.watts.display_w.into(),
            o.watts.render_w.into(),
            o.watts.total_w().into(),
            o.flip_test.into(),
        ];
        cells.extend([0, 1, 2].map(|c| Cell::from(o.gains.map(|gains| f64::from(gains.0[c])))));
        cells.extend(has_lpips.then(|| Cell::from(o.lpips_test)));
        cells
    };
    Table::new(columns).rows(done.iter().map(row)).csv()
}

/// `ratios.csv`: the study of display-to-render ratios.
pub fn ratios_csv(rows: &[RatioRow]) -> Vec<u8> {
    let columns = [
        Column::fixed("display_to_render", 4),
        Column::fixed("display_scale", 6),
        Column::fixed("rho", 6),
        Column::fixed("ours_w", 8),
        Column::fixed("saved_over_render_only", 6),
        Column::fixed("saved_over_display_only", 6),
        Column::fixed("saved_over_dense", 6),
    ];
    let row = |r: &RatioRow| {
        let numbers = [r.ratio, r.scale, r.rho, r.ours_w].map(Some);
        let saved = [r.over_render_only, r.over_display_only, Some(r.over_dense)];
        numbers.into_iter().chain(saved).map(Cell::from)
    };
    Table::new(columns).rows(rows.iter().map(row)).csv()
}
