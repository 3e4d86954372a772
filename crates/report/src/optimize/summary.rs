//! `summary.md`: the result first, then what it rests on.

use std::fmt::Write as _;

use super::Story;
use crate::claims::table;
use crate::format::{engineering, watt_unit};
use powergs_chart::Chart;
use powergs_optimize::claims::Verdict;
use powergs_optimize::plan::{Outcome, Role};

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

/// The file.
pub fn markdown(story: &Story<'_>, charts: &[Chart]) -> String {
    let mut text = format!("# {}: the fewest watts at a given quality\n\n", story.name);
    let _ = writeln!(text, "```\n{}```\n", story.headline());
    let (oracle, display, fps) = (&story.oracle, &story.display, story.fps);
    let _ = writeln!(text, "Power: {oracle} at {fps} FPS, display {display}.");
    if let Some(target) = story.target {
        let (db, ssim) = (target.psnr_db, target.ssim);
        let _ = writeln!(text, "Target over the gate views: {db:.3} dB and SSIM {ssim:.4}.\n");
    }
    if let Some(best) = story.best().filter(|o| o.role == Role::Sample) {
        let name = &best.name;
        let _ = writeln!(
            text,
            "The realised optimum is not better than {name}: that sample is the final model.\n"
        );
    }
    models(&mut text, story.done);
    fits(&mut text, story);
    claims(&mut text, story);
    for chart in charts {
        let _ = writeln!(text, "## {0}\n\n![{0}]({1}.png)\n", chart.title, chart.name);
    }
    text
}

fn models(text: &mut String, done: &[Outcome]) {
    let (per_watt, unit) = watt_unit(done.iter().map(|o| o.watts.total_w()).fold(0.0, f64::max));
    // A column only if it was measured.
    let has_lpips = done.iter().any(|o| o.lpips_test.is_some());
    let (lpips, line) = if has_lpips { (" test LPIPS |", "---|") } else { ("", "") };
    let _ = write!(
        text,
        "## Models\n\n| model | pruned, % | Gaussians | gate PSNR, dB | gate SSIM | passed | test \
         PSNR, dB | test SSIM | test FLIP |{lpips} display, {unit} | rendering, {unit} | \
         total, {unit} |\n\
         |---|---|---|---|---|---|---|---|---|{line}---|---|---|\n",
    );
    for o in done {
        let (gate, test) = (o.gate.quality, o.test.quality);
        let lpips = match o.lpips_test {
            Some(v) => format!(" {v:.4} |"),
            None if has_lpips => " |".into(),
            None => String::new(),
        };
        let _ = writeln!(
            text,
            "| {} | {:.1} | {} | {:.2} | {:.4} | {} | {:.2} | {:.4} | {:.4} |{lpips} \
             {:.2} | {:.2} | {:.2} |",
            o.name,
            100.0 * o.rho,
            o.points,
            gate.psnr_db,
            gate.ssim,
            if o.passed { "yes" } else { "no" },
            test.psnr_db,
            test.ssim,
            o.flip_test,
            per_watt * o.watts.display_w,
            per_watt * o.watts.render_w,
            per_watt * o.watts.total_w()
        );
    }
    text.push('\n');
}

fn fits(text: &mut String, story: &Story<'_>) {
    text.push_str("## Fit\n\n");
    match &story.conclusion.fit {
        Err(error) => {
            let _ = writeln!(text, "No curve: {error}.\n");
        }
        Ok(fit) => {
            let shown = |v: Option<f64>| v.map_or("none".into(), |v| format!("{v:.4}"));
            for (name, curve) in [("Display", &fit.display), ("Rendering", &fit.render)] {
                let (r2, mre) = (shown(curve.r2), shown(curve.mre));
                let _ = writeln!(text, "- {name} power: R² {r2}, mean relative error {mre}.");
            }
            for note in fit.notes() {
                let _ = writeln!(text, "- Note: {note}.");
            }
            text.push('\n');
        }
    }
}

/// The published claims that this run can say something about.
fn claims(text: &mut String, story: &Story<'_>) {
    let mut book = story.claims.clone();
    book.rows.retain(|row| row.verdict != Verdict::Unchecked);
    if book.rows.is_empty() {
        return;
    }
    text.push_str(
        "## Published claims, checked here\n\nSign and order are what a small scene and a short \
         run can show; the published numbers are for full-size scenes and 150,000 iterations. \
         `powergs-sim claims RUN...` also says what could not be checked, and why.\n\n",
    );
    let _ = writeln!(text, "{}", table(&book));
}
