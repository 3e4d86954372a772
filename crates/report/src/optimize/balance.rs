//! What a user wants to know first: the watts before and after, where they are, what limits the
//! result, and what a lower quality would buy.

use super::{Grade, ITSELF, Story, decimals};
use crate::document::{Block, Cell, Column, Document, Table, Text};
use crate::format::{engineering, watt_unit};
use powergs_energy::action::Phase;
use powergs_optimize::job::Place;
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::{Baseline, Role};
use powergs_optimize::target::Target;

/// Quality above the target that a search leaves unspent, decibels.
const UNSPENT_DB: f64 = 0.1;
/// A part of the power below this share of it is not worth a search.
const LITTLE: f64 = 0.02;

/// Ratios that differ by less are the same.
const SAME: f64 = 0.01;

/// `62 %`.
fn percent(share: f64) -> String {
    format!("{} %", crate::format::percent(share))
}

/// Standby power of a model, watts.
fn standby_w(o: &Outcome) -> f64 {
    o.watts.parts.stage_w(Phase::Standby)
}

/// Power of the work on frames, watts: rendering without standby.
fn work_w(o: &Outcome) -> f64 {
    (o.watts.render_w - standby_w(o)).max(0.0)
}

/// The dense model and the result of each quality. Parts have the unit of the total.
pub(super) fn table(story: &Story<'_>) -> Option<Table> {
    let dense = story.of_role(Role::Dense)?;
    let (per_watt, unit) = watt_unit(dense.watts.total_w());
    let watts = |name: &str| Column::fixed(name, decimals(per_watt));
    let columns = [
        Column::text("quality"),
        watts(&format!("total, {unit}")),
        watts("display"),
        watts("rendering"),
        watts("standby"),
        Column::fixed("saved, %", 1),
        Column::fixed("gate, dB", 2),
        Column::fixed("test, dB", 2),
        Column::count("Gaussians"),
        Column::text("mostly"),
        Column::text("used up"),
        Column::text("next saves"),
        Column::text("model"),
        Column::text("file"),
    ];
    let row = |label: &str, o: &Outcome, more: [Cell; 5]| {
        let saved = 1.0 - o.watts.total_w() / dense.watts.total_w();
        let psnr = |db: f64| Cell::from(Some(db).filter(|db| *db < ITSELF));
        let numbers: [Cell; 8] = [
            (per_watt * o.watts.total_w()).into(),
            (per_watt * o.watts.display_w).into(),
            (per_watt * work_w(o)).into(),
            (per_watt * standby_w(o)).into(),
            Some(100.0 * saved).filter(|_| o.role != Role::Dense).into(),
            psnr(o.gate.quality.psnr_db),
            psnr(o.test.quality.psnr_db),
            o.points.into(),
        ];
        [Cell::from(label)].into_iter().chain(numbers).chain(more).collect::<Vec<Cell>>()
    };
    let none = || Cell::from(None::<String>);
    let mut table = Table::new(columns);
    table.row(row("dense", dense, [most_of(dense).into(), none(), none(), none(), none()]));
    for grade in &story.grades {
        let Some(result) = story.result_of(grade) else { continue };
        let used_up = grade.target.map(|t| used_up(story, result, Target::Likeness(t)));
        let next = next_saves(grade, result);
        let name = result.name.as_str();
        let more = [
            most_of(result).into(),
            used_up.into(),
            next.into(),
            name.into(),
            Cell::from(grade.file()),
        ];
        table.row(row(&grade.name, result, more));
    }
    Some(table)
}

/// The largest part of the power.
fn most_of(o: &Outcome) -> &'static str {
    let parts =
        [("display", o.watts.display_w), ("rendering", work_w(o)), ("standby", standby_w(o))];
    parts.into_iter().fold(parts[0], |a, b| if b.1 > a.1 { b } else { a }).0
}

/// How far the models of a place are pruned.
struct PruningEnd<'a> {
    /// The largest share of all that passed.
    most: f64,
    /// What says that no more passes; `None` where nothing does.
    end: Option<&'a Outcome>,
}

impl<'a> PruningEnd<'a> {
    /// Of all models that were trained at a place: one that is pruned further and missed, or one
    /// that was pruned for as long as the target was met.
    fn of(story: &Story<'a>, place: Place) -> PruningEnd<'a> {
        let all = || story.all.iter().filter(|o| o.place == place && is_trained(o));
        let most = all().filter(|o| o.passed).map(|o| o.rho).fold(0.0, f64::max);
        let missed = all().filter(|o| !o.passed && o.rho > most);
        let missed = missed.min_by(|a, b| a.rho.total_cmp(&b.rho));
        let stops = |o: &&Outcome| o.is_end || o.role == Role::Baseline(Baseline::RenderOnly);
        let stopped = all().filter(stops).find(|o| o.passed && o.rho + SAME >= most);
        PruningEnd { most, end: missed.or(stopped) }
    }

    /// Whether a share is as much as can be pruned.
    fn is_reached(&self, rho: f64) -> bool {
        self.end.is_some() && rho + SAME >= self.most
    }
}

/// Which of the two ways to save is used up: pruning where it is known that no more passes, dimming
/// where all quality is spent.
fn used_up(story: &Story<'_>, result: &Outcome, target: Target) -> &'static str {
    let is_pruned = PruningEnd::of(story, result.place).is_reached(result.rho);
    let is_dimmed = target.margin_db(result.gate.quality) <= UNSPENT_DB;
    match (is_pruned, is_dimmed) {
        (true, true) => "both",
        (true, false) => "pruning",
        (false, true) => "dimming",
        (false, false) => "neither",
    }
}

/// Samples, the realised optimum and comparisons.
fn is_trained(o: &Outcome) -> bool {
    matches!(o.role, Role::Sample | Role::Optimum | Role::Baseline(_))
}

/// `M: 4.1 %`, what the next lower quality takes less; at least so much unless it was made.
fn next_saves(grade: &Grade, result: &Outcome) -> Option<String> {
    let next = grade.next.as_ref()?;
    let watts = result.watts.total_w();
    let (_, least) = next.model.as_ref().filter(|(_, total)| *total < watts)?;
    Some(format!("{}: {:.1} %", next.level.name(), 100.0 * (1.0 - least / watts)))
}

/// The table with what stands under it.
pub(super) fn section(page: &mut Document, story: &Story<'_>) {
    let (Some(table), Some(dense)) = (table(story), story.of_role(Role::Dense)) else { return };
    page.table(table);
    let Some(best) = story.result() else { return };
    page.paragraph(Text::marked(
        "All powers have the unit of the total. Standby is what the accelerator draws whatever it \
         renders: leakage, DRAM background and refresh. With rendering it makes up the \
         accelerator, which charts and other tables have. Pruning is used up where the result is \
         pruned as far as any model that passes, and one that is pruned further misses the target \
         or it was pruned for as long as that was met; dimming where no quality is left above the \
         target.",
    ));
    let several = story.grades.iter().filter(|g| g.result.is_some()).count() > 1;
    if several {
        page.paragraph(Text::marked(&which_file(story)));
        page.paragraph(format!("Of {}, the highest quality:", best.name));
    }
    let items = [
        Some(whereabouts(best)),
        quality(story, best),
        pruning(story, best),
        Some(colours(dense, best)),
        next(story, best),
    ];
    page.add(Block::List(items.into_iter().flatten().map(|item| Text::marked(&item)).collect()));
}

/// Which file to take.
fn which_file(story: &Story<'_>) -> String {
    let file = |g: &Grade| format!("`{}` for {}", g.file(), g.name);
    let files: Vec<String> = story.grades.iter().filter(|g| g.result.is_some()).map(file).collect();
    format!(
        "Take the file of the lowest quality that looks right: {}. Each reaches its target over \
         the gate views.",
        files.join(", ")
    )
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
    let pruning = PruningEnd::of(story, best.place);
    let why = match pruning.end {
        Some(o) if !o.passed => {
            let by = Target::Likeness(story.target?).shortfall(o.gate.quality);
            let (name, rho) = (&o.name, percent(o.rho));
            format!("{name}, {rho} pruned, misses the target by {}", super::short_of(by))
        }
        Some(o) => format!("{} was pruned for as long as the target was met", o.name),
        None => "all shares that were tried passed (`--rhos` takes others)".into(),
    };
    let verdict = match (pruning.is_reached(best.rho), pruning.end) {
        (true, _) => format!("used up: {why}"),
        (false, Some(_)) => format!("not used up, because the fewest watts lie before that: {why}"),
        (false, None) => format!("not used up: {why}"),
    };
    let most = pruning.most;
    // Where the price is that of smaller images than are shown, this would mislead.
    let is_little = work_w(best) < LITTLE * best.watts.total_w() && story.priced.photos.is_none();
    let little = match is_little {
        true => format!(
            "; but at {} rendering is so little of the power that more would hardly count",
            story.priced.size_text()
        ),
        false => String::new(),
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
    let next = story.grades.first()?.next.as_ref()?;
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
