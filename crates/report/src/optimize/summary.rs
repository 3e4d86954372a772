//! `summary.md`: the result first, then what it rests on.

use std::fmt::Write as _;

use super::Story;
use crate::claims::table;
use crate::document::{Block, Cell, Column, Document, Table, Text};
use crate::format::{engineering, watt_unit};
use powergs_chart::Chart;
use powergs_optimize::claims::Verdict;
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::Role;

/// A result as a list of names and values, for `--json` and the terminal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facts {
    /// Power of the dense model, watts.
    pub dense_w: f64,
    /// Power of the model that the run ends with, watts.
    pub ours_w: f64,
    /// The share saved.
    pub saved: f64,
    /// The share of Gaussians that it lost.
    pub rho: f64,
    /// What the fit promised at its ratio, watts.
    pub predicted_w: Option<f64>,
    /// What the realised model takes, watts.
    pub realised_w: Option<f64>,
}

impl Story<'_> {
    /// The result; `None` if no model reached the target.
    pub fn facts(&self) -> Option<Facts> {
        let (dense, ours) = (self.of(Role::Dense)?, self.best()?);
        let (dense_w, ours_w) = (dense.watts.total_w(), ours.watts.total_w());
        Some(Facts {
            dense_w,
            ours_w,
            saved: 1.0 - ours_w / dense_w,
            rho: ours.rho,
            predicted_w: self.conclusion.predicted().map(|p| p.total_w()),
            realised_w: self.of(Role::Final).map(|o| o.watts.total_w()),
        })
    }

    /// What a user should read first: a few lines of at most 80 columns.
    pub fn headline(&self) -> String {
        let mut text = String::new();
        match (self.facts(), self.best()) {
            (Some(f), Some(ours)) => {
                let (from, to) = (engineering(f.dense_w, "W"), engineering(f.ours_w, "W"));
                let (saved, rho) = (100.0 * f.saved, 100.0 * f.rho);
                let _ = writeln!(
                    text,
                    "{from} -> {to}: {saved:.1} % saved, {rho:.0} % of the Gaussians pruned"
                );
                let q = ours.test.quality;
                let (db, ssim) = (q.psnr_db, q.ssim);
                let _ = writeln!(text, "{}: test views {db:.2} dB, SSIM {ssim:.4}", ours.name);
            }
            _ => {
                let _ = writeln!(text, "no model reached the target");
            }
        }
        for missed in &self.conclusion.missed {
            let (db, ssim) = (missed.by.psnr_db, missed.by.ssim);
            let (name, rho) = (&missed.name, missed.rho);
            let _ = writeln!(text, "{name} (rho {rho:.3}) missed by {db:.2} dB, SSIM {ssim:.4}");
        }
        if let (Some(p), Some(o)) = (self.conclusion.predicted(), self.of(Role::Final)) {
            let (promised, measured) = (p.total_w(), o.watts.total_w());
            let off = 100.0 * (measured / promised - 1.0);
            let (a, b) = (engineering(promised, "W"), engineering(measured, "W"));
            let rho = p.rho;
            let _ = writeln!(
                text,
                "at rho {rho:.3} the fit predicts {a}; realised and measured {b} ({off:+.1} %)"
            );
        }
        text
    }
}

/// The page, with `charts` beside it.
pub fn document(story: &Story<'_>, charts: &[Chart]) -> Document {
    let mut page = Document::new();
    page.title(format!("{}: the fewest watts at a given quality", story.name));
    page.add(Block::Verbatim(story.headline()));
    let (oracle, display, fps) = (&story.oracle, &story.display, story.fps);
    page.paragraph(format!("Power: {oracle} at {fps} FPS, display {display}."));
    if let Some(target) = story.target {
        let (db, ssim) = (target.psnr_db, target.ssim);
        page.paragraph(format!("Target over the gate views: {db:.3} dB and SSIM {ssim:.4}."));
    }
    if let Some(best) = story.best().filter(|o| o.role == Role::Sample) {
        page.paragraph(format!(
            "The realised optimum is not better than {}: that sample is the final model.",
            best.name
        ));
    }
    page.heading("Models");
    page.table(models(story.done));
    fits(&mut page, story);
    claims(&mut page, story);
    for chart in charts {
        page.heading(chart.title);
        page.add(Block::Chart(chart.clone()));
    }
    page
}

fn models(done: &[Outcome]) -> Table {
    let (per_watt, unit) = watt_unit(done.iter().map(|o| o.watts.total_w()).fold(0.0, f64::max));
    // A column only if it was measured.
    let has_lpips = done.iter().any(|o| o.lpips_test.is_some());
    let mut columns = vec![
        Column::text("model"),
        Column::fixed("pruned, %", 1),
        Column::count("Gaussians"),
        Column::fixed("gate PSNR, dB", 2),
        Column::fixed("gate SSIM", 4),
        Column::text("passed"),
        Column::fixed("test PSNR, dB", 2),
        Column::fixed("test SSIM", 4),
        Column::fixed("test FLIP", 4),
    ];
    columns.extend(has_lpips.then(|| Column::fixed("test LPIPS", 4)));
    columns.extend(
        ["display", "rendering", "total"].map(|what| Column::fixed(format!("{what}, {unit}"), 2)),
    );
    let row = |o: &Outcome| {
        let (gate, test) = (o.gate.quality, o.test.quality);
        let mut cells: Vec<Cell> = vec![
            o.name.as_str().into(),
            (100.0 * o.rho).into(),
            o.points.into(),
            gate.psnr_db.into(),
            gate.ssim.into(),
            o.passed.into(),
            test.psnr_db.into(),
            test.ssim.into(),
            o.flip_test.into(),
        ];
        cells.extend(has_lpips.then(|| Cell::from(o.lpips_test)));
        let watts = [o.watts.display_w, o.watts.render_w, o.watts.total_w()];
        cells.extend(watts.map(|w| Cell::Real(per_watt * w)));
        cells
    };
    Table::new(columns).rows(done.iter().map(row))
}

fn fits(page: &mut Document, story: &Story<'_>) {
    page.heading("Fit");
    match &story.conclusion.fit {
        Err(error) => page.paragraph(format!("No curve: {error}.")),
        Ok(fit) => {
            let shown = |v: Option<f64>| v.map_or("none".into(), |v| format!("{v:.4}"));
            let curve = |(name, curve): (&str, &powergs_optimize::fit::Curve)| {
                let (r2, mre) = (shown(curve.r2), shown(curve.mre));
                format!("{name} power: R² {r2}, mean relative error {mre}.").into()
            };
            let mut items: Vec<Text> =
                [("Display", &fit.display), ("Rendering", &fit.render)].map(curve).to_vec();
            items.extend(fit.notes().iter().map(|note| format!("Note: {note}.").into()));
            page.add(Block::List(items));
        }
    }
}

/// The published claims that this run can say something about.
fn claims(page: &mut Document, story: &Story<'_>) {
    let mut book = story.claims.clone();
    book.rows.retain(|row| row.verdict != Verdict::Unchecked);
    if book.rows.is_empty() {
        return;
    }
    page.heading("Published claims, checked here");
    page.paragraph(Text::marked(
        "Sign and order are what a small scene and a short run can show; the published numbers \
         are for full-size scenes and 150,000 iterations. `powergs-sim claims RUN...` also says \
         what could not be checked, and why.",
    ));
    page.table(table(&book));
}
