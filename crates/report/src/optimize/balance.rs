//! What a user wants to know first: the watts before and after, where they are, what limits the
//! result, and what a lower quality would buy.

use super::{ITSELF, Story};
use crate::document::{Block, Cell, Column, Document, Shown, Table, Text};
use crate::format::{engineering, watt_unit};
use powergs_core::action::Stage;
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::Role;
use powergs_optimize::target::Target;

/// Quality above the target that a search leaves unspent, decibels.
const UNSPENT_DB: f64 = 0.1;
/// A part of the power below this share of it is not worth a search.
const LITTLE: f64 = 0.02;

/// `62 %`.
fn percent(share: f64) -> String {
    format!("{} %", crate::format::percent(share))
}

/// Standby power of a model, watts.
fn standby_w(o: &Outcome) -> f64 {
    o.watts.parts.stage_w(Stage::Standby)
}

/// Power of the work on frames, watts: rendering without standby.
fn work_w(o: &Outcome) -> f64 {
    (o.watts.render_w - standby_w(o)).max(0.0)
}

/// The dense model and the result of each quality. Parts have the unit of the total.
pub(super) fn table(story: &Story<'_>) -> Option<Table> {
    let dense = story.of_role(Role::Dense)?;
    let (per_watt, unit) = watt_unit(dense.watts.total_w());
    let watts = |name: &str| Column::fixed(name, 2);
    let columns = [
        Column::text("model"),
        Column::count("Gaussians").on(Shown::Page),
        watts(&format!("total, {unit}")),
        watts("display"),
        watts("rendering"),
        watts("standby"),
        Column::fixed("saved, %", 1),
        Column::fixed("gate, dB", 2),
        Column::text("file").on(Shown::Page),
    ];
    let row = |label: String, file: Option<String>, o: &Outcome| {
        let saved = 1.0 - o.watts.total_w() / dense.watts.total_w();
        let cells: [Cell; 9] = [
            label.into(),
            o.points.into(),
            (per_watt * o.watts.total_w()).into(),
            (per_watt * o.watts.display_w).into(),
            (per_watt * work_w(o)).into(),
            (per_watt * standby_w(o)).into(),
            Some(100.0 * saved).filter(|_| o.role != Role::Dense).into(),
            Some(o.gate.quality.psnr_db).filter(|db| *db < ITSELF).into(),
            file.into(),
        ];
        cells
    };
    let mut table = Table::new(columns);
    table.row(row("dense".into(), None, dense));
    for grade in &story.grades {
        let Some(best) = story.best_of(grade) else { continue };
        // The quality of the user's own has no name.
        let label = match grade.name.as_str() {
            "own" => format!("result ({})", best.name),
            name => format!("{name}: {}", best.name),
        };
        table.row(row(label, Some(grade.file()), best));
    }
    Some(table)
}

/// The table with what stands under it.
pub(super) fn section(page: &mut Document, story: &Story<'_>) {
    let (Some(table), Some(dense)) = (table(story), story.of_role(Role::Dense)) else { return };
    page.table(table);
    let Some(best) = story.best() else { return };
    page.paragraph(Text::marked(
        "All powers have the unit of the total. Standby is what the accelerator draws whatever it \
         renders: leakage, DRAM background and refresh. Charts and other tables count it as \
         rendering.",
    ));
    let items = [
        Some(whereabouts(best)),
        quality(story, best),
        pruning(story, best),
        Some(colours(dense, best)),
        next(story, best),
    ];
    page.add(Block::List(items.into_iter().flatten().map(|item| Text::marked(&item)).collect()));
}

/// Where the watts of the result are.
fn whereabouts(best: &Outcome) -> String {
    let share = |watts: f64| percent(watts / best.watts.total_w());
    format!(
        "Where the watts are: {} of the result is the display, {} rendering, {} standby.",
        share(best.watts.display_w),
        share(work_w(best)),
        share(standby_w(best))
    )
}

/// Whether the quality is spent.
fn quality(story: &Story<'_>, best: &Outcome) -> Option<String> {
    let margin = Target::Likeness(story.target?).margin_db(best.gate.quality);
    let verdict = match margin > UNSPENT_DB {
        true => "not all spent: more iterations turn it into watts (`--iterations`)",
        false => "spent",
    };
    Some(format!("Quality: {margin:.2} dB above the target over the gate views, {verdict}."))
}

/// Whether more pruning would help.
fn pruning(story: &Story<'_>, best: &Outcome) -> Option<String> {
    let ours = |o: &&Outcome| matches!(o.role, Role::Sample | Role::Optimum);
    let all = || story.done.iter().filter(ours);
    let most = all().filter(|o| o.passed).map(|o| o.rho).reduce(f64::max)?;
    let beyond = all().filter(|o| !o.passed && o.rho > most);
    let missed = beyond.min_by(|a, b| a.rho.total_cmp(&b.rho));
    let verdict = match missed {
        Some(o) => {
            let by = Target::Likeness(story.target?).shortfall(o.gate.quality);
            let (name, rho) = (&o.name, percent(o.rho));
            format!("exhausted: {name}, {rho} pruned, misses the target by {}", super::short_of(by))
        }
        None => "not exhausted: all shares that were tried passed (`--rhos` takes others)".into(),
    };
    let little = match work_w(best) < LITTLE * best.watts.total_w() {
        true => "; but rendering is so little of the power that more would hardly count",
        false => "",
    };
    Some(format!(
        "Pruning: {} of the Gaussians gone; up to {} passed, {verdict}{little}.",
        percent(best.rho),
        percent(most)
    ))
}

/// What the colours gave.
fn colours(dense: &Outcome, best: &Outcome) -> String {
    let (from, to) = (dense.watts.display_w, best.watts.display_w);
    let change = if from > 0.0 { 100.0 * (to / from - 1.0) } else { 0.0 };
    format!(
        "Colours: display {} -> {} ({change:+.1} %).",
        engineering(from, "W"),
        engineering(to, "W")
    )
}

/// What the next lower quality would buy.
fn next(story: &Story<'_>, best: &Outcome) -> Option<String> {
    let next = story.next.as_ref()?;
    let (level, target) = (next.level.name(), super::summary::quality(next.target));
    let watts = best.watts.total_w();
    let known = match &next.model {
        Some((name, total_w)) if *total_w < watts => format!(
            "at most {}, {} less than the result ({name} reaches it)",
            engineering(*total_w, "W"),
            percent(1.0 - total_w / watts)
        ),
        _ => format!("unknown: no cheaper model of this run reaches it; `--quality {level}` says"),
    };
    Some(format!("The next lower quality, {level} ({target}): {known}."))
}
