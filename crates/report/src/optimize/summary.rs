//! `summary.md`: the result first, then what it rests on.

use std::fmt::Write as _;

use super::{ITSELF, Story, balance, decimals};
use crate::document::{Block, Cell, Column, Document, Shown, Table, Text};
use crate::format::{engineering, shortened, significant, watt_unit, wrapped};
use powergs_chart::Chart;
use powergs_energy::action::Phase;
use powergs_optimize::counted::PowerCounts;
use powergs_optimize::outcome::{Confirmation, Outcome};
use powergs_optimize::results::LostRecord;
use powergs_optimize::role::Role;
use powergs_optimize::settings::Settings;
use powergs_optimize::target::{Quality, Target};
use powergs_optimize::tune::confirming;
use powergs_optimize::views::TrainingDistance;

/// A result as a list of names and values, for `--json` and the terminal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facts {
    /// Power of the dense model, watts.
    pub dense_w: f64,
    /// Power of the model that the run ends with, watts.
    pub result_w: f64,
    /// Power of the best model of the search, watts; `None` if it has none.
    pub ours_w: Option<f64>,
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
        let (dense, result) = (self.of_role(Role::Dense)?, self.result()?);
        let (dense_w, result_w) = (dense.watts.total_w(), result.watts.total_w());
        Some(Facts {
            dense_w,
            result_w,
            ours_w: self.ours().map(|o| o.watts.total_w()),
            saved: 1.0 - result_w / dense_w,
            rho: result.rho,
            predicted_w: self.conclusion.predicted().map(|p| p.total_w()),
            realised_w: self.of_role(Role::Optimum).map(|o| o.watts.total_w()),
        })
    }

    /// The table that stands under the headline: what it takes, before and after.
    pub fn balance(&self) -> Option<Table> {
        balance::table(self)
    }

    /// What a user should read first: a few lines of at most 80 columns.
    pub fn headline(&self) -> String {
        let mut text = String::new();
        match (self.facts(), self.result()) {
            (Some(f), Some(best)) => {
                let (from, to) = (engineering(f.dense_w, "W"), engineering(f.result_w, "W"));
                let (saved, rho) = (100.0 * f.saved, 100.0 * f.rho);
                let judged = self.judged.note().map_or(String::new(), |note| format!("; {note}"));
                let first =
                    format!("{from} -> {to}: {saved:.1} % saved over {}{judged}", self.priced);
                let _ = writeln!(text, "{}", wrapped(&first, 80));
                if let Some(short_db) = self.short_of_promise() {
                    let psnr_db = best.test.quality.psnr_db;
                    let _ = writeln!(
                        text,
                        "test views, which did not choose it: {psnr_db:.2} dB, {short_db:.2} dB \
                         less than asked for"
                    );
                }
                let name = &best.name;
                let _ = writeln!(
                    text,
                    "result: {name}, in final.ply; {rho:.0} % of the Gaussians pruned"
                );
                self.reached(&mut text, best);
                let _ = writeln!(text, "{}", wrapped(&format!("power by {}", self.counted()), 80));
            }
            _ => {
                let _ = writeln!(text, "no model reached the target: there is no final.ply");
            }
        }
        for missed in &self.conclusion.missed {
            let (name, rho) = (&missed.name, 100.0 * missed.rho);
            let by = short_of(missed.by);
            let _ = writeln!(text, "{name} ({rho:.1} % pruned) missed the target by {by}");
        }
        if let (Some(p), Some(o)) = (self.conclusion.predicted(), self.of_role(Role::Optimum)) {
            let (promised, measured) = (p.total_w(), o.watts.total_w());
            let off = 100.0 * (measured / promised - 1.0);
            let (a, b) = (engineering(promised, "W"), engineering(measured, "W"));
            let (name, rho) = (&o.name, 100.0 * p.rho);
            let _ = writeln!(
                text,
                "{name} ({rho:.1} % pruned): {a} by the fit, {b} measured ({off:+.1} %)"
            );
        }
        for note in self.notes() {
            let _ = writeln!(text, "{}", wrapped(&format!("note: {note}"), 80));
        }
        text
    }

    /// The quality of the result over both splits, against what was asked for.
    fn reached(&self, text: &mut String, best: &Outcome) {
        let rows = [
            ("gate", self.views.0, best.gate.quality, best.error_db[0], self.target),
            ("test", self.views.1, best.test.quality, best.error_db[1], self.test_target),
        ];
        for (name, n, q, error, target) in rows {
            let views = match (name, self.made) {
                ("gate", 1..) => format!("views ({} made between those given)", self.made),
                _ if n == 1 => "view".into(),
                _ => "views".into(),
            };
            let within = error.map_or(String::new(), |error| format!(" ± {error:.2}"));
            let psnr = format!("{:.2}{within} dB", q.psnr_db);
            let mut line = format!("{n} {name} {views}: {psnr}, SSIM {:.4}", q.ssim);
            if let Some(target) = target {
                let by = Target::Likeness(target).shortfall(q);
                let verdict = match by.psnr_db > 0.0 || by.ssim > 0.0 {
                    false => "reached".to_owned(),
                    true => format!("{} below", short_of(by)),
                };
                let _ = write!(line, "; target {}: {verdict}", quality(target));
            }
            let _ = writeln!(text, "{}", wrapped(&line, 80));
        }
        let n = confirming(self.views.0);
        if let Some(Confirmation { seen, luck_db }) = best.confirmation.filter(|_| n > 0) {
            // Views are harder and easier: alone the number would say nothing.
            let before = self.of_role(Role::HeldOut).and_then(|o| o.confirmation);
            let before =
                before.map(|c| format!(", where held-out has {:.2}", c.seen.quality.psnr_db));
            let mut line = format!(
                "{n} of the gate views only confirm what the others chose: {:.2} dB there{}",
                seen.quality.psnr_db,
                before.unwrap_or_default()
            );
            if let Some(luck) = luck_db {
                let than = if luck < 0.0 { "worse" } else { "better" };
                let _ = write!(
                    line,
                    "; when the model was chosen it seemed {:.2} dB {than} than all find it",
                    luck.abs()
                );
            }
            let _ = writeln!(text, "{}", wrapped(&line, 80));
        }
    }

    /// What the search found in place of a comparison that took fewer watts.
    fn missed_by_search(&self, result: &Outcome) -> String {
        match self.ours() {
            Some(ours) => {
                let (watts, least) = (ours.watts.total_w(), result.watts.total_w());
                format!(
                    "the search missed it, its own best model {} takes {}, {:.1} % more; more \
                     iterations (--iterations) bring it nearer",
                    ours.name,
                    engineering(watts, "W"),
                    100.0 * (watts / least - 1.0)
                )
            }
            None => "the search itself has no model that reaches the target; more iterations \
                     (--iterations) may find one"
                .into(),
        }
    }

    /// What limits what the result says.
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let Some(best) = self.result() else { return notes };
        notes.extend(self.priced.note());
        if best.role.baseline().is_some() {
            notes.push(format!("the result is a comparison: {}", self.missed_by_search(best)));
        }
        let missed =
            self.test_target.is_some_and(|t| !Target::Likeness(t).passes(best.test.quality));
        if missed {
            let n = self.views.0;
            notes.push(format!(
                "the test views miss the target. {n} gate view{} decided; with more of them \
                 (--validation 4, without photos --least-gate 48) or a higher target the result is \
                 safer",
                if n == 1 { "" } else { "s" }
            ));
            if let Some(TrainingDistance { made, test }) = self.distance
                && made < NEARER * test
            {
                notes.push(format!(
                    "the {} gate views that were made are {} from the nearest view that trains, \
                     the test views {} (medians): models are better where they train, so the gate \
                     promises more than these see; --validation 4 lets more given views gate",
                    self.made,
                    significant(made),
                    significant(test)
                ));
            }
        }
        if let Some(dense) = self.of_role(Role::Dense) {
            let standby = best.watts.parts.stage_w(Phase::Standby);
            if standby > STANDING * best.watts.total_w() {
                let share = 100.0 * standby / dense.watts.total_w();
                notes.push(format!(
                    "{} of the result, {share:.0} % of what the dense model takes, is standby \
                     power of the accelerator (leakage, DRAM background and refresh), which \
                     pruning cannot save",
                    engineering(standby, "W")
                ));
            }
        }
        if self.iterations < Settings::DEFAULT.iterations {
            notes.push(format!(
                "{} iterations a sample are few (default {}): more of them save more at the same \
                 quality",
                self.iterations,
                Settings::DEFAULT.iterations
            ));
        }
        notes
    }
}

/// Gate views are nearer to those that train than test views below this share of their distance.
const NEARER: f64 = 0.8;
/// Standby power above this share of the total is told.
const STANDING: f64 = 0.25;

/// `35.00 dB and SSIM 0.9500`; no SSIM where none was asked for.
pub(super) fn quality(target: Quality) -> String {
    let ssim = if target.ssim > 0.0 { format!(", SSIM {:.4}", target.ssim) } else { String::new() };
    format!("{:.2} dB{ssim}", target.psnr_db)
}

/// `0.28 dB`: what is missing, without what is not.
pub(super) fn short_of(by: Quality) -> String {
    let db = (by.psnr_db > 0.0).then(|| format!("{:.2} dB", by.psnr_db));
    let ssim = (by.ssim > 0.0).then(|| format!("SSIM {:.4}", by.ssim));
    db.into_iter().chain(ssim).collect::<Vec<_>>().join(", ")
}

/// The page, with `charts` beside it.
pub fn document(story: &Story<'_>, charts: &[Chart]) -> Document {
    let mut page = Document::new();
    page.title(format!("{}: the fewest watts at a given quality", story.name));
    page.add(Block::Verbatim(story.headline()));
    balance::section(&mut page, story);
    let (oracle, display, fps) = (&story.oracle, &story.display, story.fps);
    let priced = &story.priced;
    page.paragraph(format!(
        "Power: {oracle} at {fps} FPS over {priced}, display {display}. It is counted by {}.",
        story.counted()
    ));
    if let Some(target) = story.target {
        let (target, asked) = (quality(target), &story.asked);
        let is_same = target == *asked;
        let of = if is_same { String::new() } else { format!(", {asked}") };
        page.paragraph(format!("Target over the gate views: {target}{of}."));
    }
    if let Some(best) = story.result() {
        page.paragraph(Text::marked(&format!(
            "The result is {}: `final.ply`, and its trace `final.bin` for `powergs-sim \
             replay`{}.{}",
            best.name,
            match story.counted.counts {
                PowerCounts::ClosedForm => {
                    ", which counts a whole machine with its standby, where this page has the \
                     closed form"
                }
                PowerCounts::Machine => "",
            },
            match (best.role, story.of_role(Role::Optimum)) {
                (Role::Sample, Some(_)) => " The realised optimum is not better than that sample.",
                _ => "",
            }
        )));
    }
    page.heading("Models");
    page.table(models(story));
    page.paragraph(Text::marked(
        "Gate views decide whether a model passes; test views are only reported. `dense` is the \
         model as it came; `held-out` is the same trained further without the gate views, which \
         it may know by heart: a target that is a share is one of its quality. Samples are pruned \
         to a share ρ of the Gaussians and dimmed until they are just above the target, by gains \
         of their colour channels or by a display term in the loss, weighted by λ; `optimum` is a \
         model at the ρ where the fit has the least power. The result is the cheapest of those \
         that passed.",
    ));
    fits(&mut page, story);
    lost(&mut page, story);
    for chart in charts {
        page.heading(chart.title.clone());
        let pictures = super::strip::pictures(story).filter(|_| chart.name == super::strip::NAME);
        if let Some(pictures) = pictures {
            page.on(Shown::Screen, Block::BeforeAfter(Box::new(pictures)));
        }
        page.add(Block::Chart(chart.clone()));
    }
    page
}

fn models(story: &Story<'_>) -> Table {
    let done = story.done;
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
        ["display", "accelerator", "total"]
            .map(|what| Column::fixed(format!("{what}, {unit}"), decimals(per_watt))),
    );
    let row = |o: &Outcome| {
        let (gate, test) = (o.gate.quality, o.test.quality);
        // Of its own renders a model differs by rounding only.
        let psnr = |q: Quality| Cell::from(Some(q.psnr_db).filter(|db| *db < ITSELF));
        let mut cells: Vec<Cell> = vec![
            story.label(o).into(),
            (100.0 * o.rho).into(),
            o.points.into(),
            psnr(gate),
            gate.ssim.into(),
            story.passed(o).into(),
            psnr(test),
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

/// The views in which the result lost most.
fn lost(page: &mut Document, story: &Story<'_>) {
    if story.lost.is_empty() {
        return;
    }
    page.heading("Views that lost most");
    page.paragraph(
        "Of the gate and test views that were given, those in which the result is furthest below \
         the dense model (where its renders are the reference: those with the lowest PSNR).",
    );
    let columns = [
        Column::text("view"),
        Column::text("split"),
        Column::fixed("PSNR, dB", 2),
        Column::fixed("dense, dB", 2),
        Column::fixed("lost, dB", 2),
    ];
    let row = |o: &LostRecord| -> Vec<Cell> {
        let lost = o.dense_psnr_db.zip(o.psnr_db).map(|(dense, psnr)| dense - psnr);
        let name = shortened(&o.view, 32);
        let split = if o.is_test { "test" } else { "gate" };
        vec![name.into(), split.into(), o.psnr_db.into(), o.dense_psnr_db.into(), lost.into()]
    };
    page.table(Table::new(columns).rows(story.lost.iter().map(row)));
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
                [("Display", &fit.display), ("Accelerator", &fit.render)].map(curve).to_vec();
            items.extend(fit.notes().iter().map(|note| format!("Note: {note}.").into()));
            page.add(Block::List(items));
        }
    }
}
