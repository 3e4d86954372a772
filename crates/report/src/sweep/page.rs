//! The answer for people: what is printed, `summary.md` and `report.html`.

use super::energy::spread;
use super::measure::Measure;
use super::{names, words};
use crate::document::{Block, Cell, Column, Document, Kind, Shown, Table, Text};
use crate::format::{shortened, significant};
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::sim::MODEL_VERSION;
use powergs_study::analysis::marginal::Neighbour;
use powergs_study::analysis::stability::Alternative;
use powergs_study::analysis::{Analysis, Confirmation, Goal, speedup};
use powergs_study::sweep::run::HandOut;

/// What the page says about how it was made.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Provenance {
    /// Name of the sweep, for titles.
    pub title: String,
    /// The commands that made it, in order.
    pub commands: Vec<String>,
    /// What designs are handed out with: commands and machine files; none if it is not known.
    pub hand_out: Option<HandOut>,
}

/// Designs of the front that a page lists; `pareto.csv` has all.
const FRONT_MAX: usize = 200;
/// Objectives that have a column on a terminal.
const OBJECTIVES: usize = 4;
/// Characters of the head of a column of values on a terminal.
const VALUE: usize = 14;
/// Equal designs that a row names.
const TWINS: usize = 3;
/// Steps of single axes that a terminal shows for one design.
const STEPS: usize = 8;
/// Reasons that a page lists.
const REASONS: usize = 20;

/// What every number here leaves out.
const LIMITS: &str = "The front is that of the designs that were simulated, not of all that could \
be. Ranges scale by the front, so another condition can move the knee.";
/// Where they are listed.
const PAGES: &str = "Effects that the model leaves out are listed in docs/limits.md; every number \
is defined in docs/analysis.md.";

/// What is printed, and the pages with `charts`: the front, the knee with its reason, the named
/// design, marginal values, the stability of the ranking.
pub fn document(
    analysis: &Analysis,
    charts: &[Chart],
    confirmation: Option<&Confirmation>,
    provenance: &Provenance,
) -> Document {
    let question = &analysis.question;
    let mut page = Document::new();
    page.on(Shown::Page, Block::Title(provenance.title.as_str().into()));
    if !question.text.is_empty() {
        page.on(Shown::Page, Block::Quote(question.text.as_str().into()));
        let asked = format!("question: {}", question.text);
        page.on(Shown::Terminal, Block::Paragraph(asked.into()));
    }
    let goals = words::objectives(&question.objectives);
    let (scope, table) = (&question.scope, &analysis.energy_table);
    let mut facts = Text::from(format!("{goals}; {scope}, energy table {table}"));
    if let Some(condition) = &question.condition {
        facts = facts.then("; condition ").then(Text::code(condition.text()));
    }
    page.paragraph(facts.then("."));
    page.paragraph(Text::named(&words::memory(analysis)));
    page.paragraph(Text::named(&words::funnel(analysis)));
    page.paragraph(Text::strong(words::rate(analysis)));
    let top = spread(&analysis.front, question.top.max(2), analysis.knee);
    page.on(Shown::Terminal, Block::Paragraph(listed(analysis, top.len()).into()));
    let (best, fixed) = front(analysis, &top, Shown::Terminal);
    page.on(Shown::Terminal, Block::Table(best));
    page.on(Shown::Terminal, Block::Paragraph(fixed.into()));
    page.paragraph(words::knee(analysis).join(" "));
    page.paragraph(words::at_ends(analysis).join(" "));
    page.paragraph(words::free(&question.free).join(" "));
    // A terminal has them as warnings, before the first design.
    for doubt in &question.doubts {
        page.page_paragraph(Text::strong("Note:").then(Text::marked(&format!(" {doubt}."))));
    }
    page.paragraph(words::energy_and_power(analysis));
    page.paragraph(words::named(analysis).unwrap_or_default().join(" "));
    let marginals = analysis.marginals.iter().map(|m| words::marginal(analysis, m).into());
    page.add(Block::List(marginals.collect()));
    page.paragraph(words::stability(analysis));
    for alternative in &analysis.stability.alternatives {
        page.paragraph(words::flip(analysis, alternative).unwrap_or_default());
    }
    page.paragraph(words::axes(analysis).join(" "));
    page.extend(confirmation.map(super::confirmation).unwrap_or_default());
    if !charts.is_empty() {
        page.on(Shown::Screen, Block::Designs(super::designs::of(analysis, provenance)));
    }
    page.charts(charts);
    if let Some(all) = speedup::of(analysis) {
        page.page_heading(format!("Speed-up over {}", all.machines[0].label));
        page.on(Shown::Page, Block::Table(crate::speedup::table(&all)));
        page.page_paragraph(Text::marked("The same with exact numbers: `speedup.csv`."));
    }
    page.page_heading(match analysis.front.len() {
        n if n > FRONT_MAX => format!("Front: the first {FRONT_MAX} of {n}"),
        _ => "Front".to_owned(),
    });
    let shown: Vec<u32> = analysis.front.iter().take(FRONT_MAX).copied().collect();
    let (whole, fixed) = front(analysis, &shown, Shown::Page);
    page.on(Shown::Page, Block::Table(whole));
    page.page_paragraph(fixed);
    let columns = Text::marked("All columns of these designs: `pareto.csv`.");
    page.on(Shown::Folder, Block::Paragraph(columns));
    steps(&mut page, analysis, analysis.knee, &analysis.around_knee);
    if let Some(row) = analysis.baseline {
        steps(&mut page, analysis, row, &analysis.around_baseline);
    }
    if !analysis.stability.alternatives.is_empty() {
        page.heading("Rankings under other tables and traces");
        page.table(stability(analysis));
        page.page_heading("Ranks of the top designs");
        page.on(Shown::Page, Block::Table(ranks(analysis)));
    }
    if !analysis.axes.is_empty() {
        page.page_heading("Axes");
        page.on(Shown::Page, Block::Table(axes(analysis)));
    }
    if !analysis.table.reasons.is_empty() {
        page.page_heading("Invalid and failed designs");
        let reasons = analysis.table.reasons.iter().take(REASONS);
        let items = reasons.map(|(why, n)| Text::named(&format!("{n} x {why}"))).collect();
        page.on(Shown::Page, Block::List(items));
    }
    if !provenance.commands.is_empty() {
        page.page_heading("Commands");
        page.on(Shown::Page, Block::Verbatim(provenance.commands.join("\n")));
    }
    page.page_heading("Limits");
    page.page_paragraph(LIMITS);
    page.on(Shown::Folder, Block::Paragraph(PAGES.into()));
    page.page_paragraph(format!("Model version {MODEL_VERSION}; powergs-sim {TOOL_VERSION}."));
    page
}

/// Which designs of the front a terminal shows, and in which order.
fn listed(analysis: &Analysis, shown: usize) -> String {
    let first = &analysis.question.objectives[0];
    let order = match first.goal {
        Goal::Minimize => "lowest",
        Goal::Maximize => "highest",
    };
    let sorted = format!("sorted by {}, {order} first", Measure::of(&first.name).words);
    match analysis.front.len() {
        1 => "The front is one design:".to_owned(),
        n if n == shown => format!("All {n} designs of the front, {sorted}:"),
        n => format!(
            "{shown} of the {n} designs of the front, evenly spread with the {}, {sorted} (all: \
             pareto.csv):",
            words::knee_name(analysis)
        ),
    }
}

/// Designs with their objectives, what the condition is about, and settings; then the named one.
/// Settings that all of them have are said in the sentence.
fn front(analysis: &Analysis, rows: &[u32], on: Shown) -> (Table, String) {
    let named = analysis.named.as_ref().map(|n| n.row).filter(|row| !rows.contains(row));
    let rows: Vec<u32> = rows.iter().copied().chain(named).collect();
    let terminal = on == Shown::Terminal;
    let mut columns = vec![Column::text("design").at_most(16)];
    let mut cells: Vec<Vec<Cell>> = rows.iter().map(|&row| vec![design(analysis, row)]).collect();
    let mut add = |column: Column, cell: &dyn Fn(u32) -> Cell| {
        columns.push(column);
        cells.iter_mut().zip(&rows).for_each(|(cells, &row)| cells.push(cell(row)));
    };
    if rows.iter().any(|&row| analysis.is_late(row)) {
        add(Column::text("display rate"), &|row| {
            if analysis.is_late(row) { "missed" } else { "met" }.into()
        });
    }
    for (name, goal) in measures(analysis, terminal) {
        let measure = Measure::of(&name);
        let goal = goal.map_or("", |goal| match goal {
            Goal::Minimize => " ↓",
            Goal::Maximize => " ↑",
        });
        let head = match terminal {
            true => short_head(&measure.words) + goal,
            false => measure.words.clone(),
        };
        add(Column::count(head), &|row| {
            let value = analysis.table.number(&name, row).unwrap_or(f64::NAN);
            measure.text(value).into()
        });
    }
    let axes = &analysis.table.axes;
    let names: Vec<&str> = axes.iter().map(|(name, _)| name.as_str()).collect();
    let heads = match terminal {
        true => names::short(&names),
        false => names.iter().map(|name| (*name).to_owned()).collect(),
    };
    let mut fixed = Vec::new();
    for ((name, words), head) in axes.iter().zip(heads) {
        let value = |row: u32| match analysis.table.counts(name, row) {
            true => words.word(row),
            false => "-",
        };
        match rows.len() > 1 && rows.iter().all(|&row| value(row) == value(rows[0])) {
            true => fixed.push(format!("{name} = {}", value(rows[0]))),
            false => add(Column::count(head), &|row| value(row).into()),
        }
    }
    if rows.iter().any(|&row| !words::twins(analysis, row, TWINS).is_empty()) {
        add(Column::text("same as"), &|row| words::twins(analysis, row, TWINS).into());
    }
    let fixed = match fixed.is_empty() {
        true => String::new(),
        false => format!("The same in all of them: {}.", fixed.join(", ")),
    };
    (Table::new(columns).rows(cells), fixed)
}

fn design(analysis: &Analysis, row: u32) -> Cell {
    let label = analysis.table.label(row);
    match row == analysis.knee {
        true => format!("{label} {}", words::knee_name(analysis)).into(),
        false => label.into(),
    }
}

/// The columns of numbers of the front: the objectives, then what the condition is about.
pub(super) fn measures(analysis: &Analysis, terminal: bool) -> Vec<(String, Option<Goal>)> {
    let question = &analysis.question;
    let most = if terminal { OBJECTIVES } else { usize::MAX };
    let objectives = question.objectives.iter().take(most);
    let mut all: Vec<(String, Option<Goal>)> =
        objectives.map(|o| (o.name.clone(), Some(o.goal))).collect();
    let names = question.condition.iter().flat_map(|c| c.names());
    for name in names.filter(|name| analysis.table.numbers(name).is_some()) {
        let is_axis = analysis.table.axis(name.trim_end_matches(".si")).is_some();
        if !is_axis && !all.iter().any(|(known, _)| known == name) {
            all.push((name.to_owned(), None));
        }
    }
    all
}

/// The head of a column of numbers where there is little room.
fn short_head(words: &str) -> String {
    let words = words.replace(" per frame", "").replace(" at the display rate", "");
    shortened(&words, VALUE)
}

/// What one step of one axis changes.
fn steps(page: &mut Document, analysis: &Analysis, row: u32, steps: &[Neighbour]) {
    if steps.is_empty() {
        return;
    }
    page.heading(format!("One step from {}", analysis.table.label(row)));
    let items: Vec<Text> =
        steps.iter().map(|step| words::neighbour(analysis, row, step).into()).collect();
    let mut short: Vec<Text> = items.iter().take(STEPS).cloned().collect();
    if items.len() > STEPS {
        short.push(format!("... and {} more: summary.md", items.len() - STEPS).into());
    }
    page.on(Shown::Terminal, Block::List(short));
    page.on(Shown::Page, Block::List(items));
}

/// How alike the rankings are.
fn stability(analysis: &Analysis) -> Table {
    let stability = &analysis.stability;
    let objectives = &analysis.question.objectives;
    let mut columns = vec![
        Column::text("ranked under").at_most(28),
        Column::real("Kendall τ"),
        Column::real("Spearman ρ").on(Shown::Page),
    ];
    columns.extend(
        objectives
            .iter()
            .map(|o| Column::real(format!("τ of {}", Measure::of(&o.name).words)).on(Shown::Page)),
    );
    columns.extend([
        Column::count(format!("top {} kept", stability.top.len())),
        Column::count(format!("front of {} kept", analysis.front.len())),
        Column::count("break the condition").on(match analysis.question.condition {
            Some(_) => Shown::Everywhere,
            None => Shown::Page,
        }),
        Column::count("first"),
    ]);
    let row = |a: &Alternative| {
        let mut cells: Vec<Cell> = vec![a.label.as_str().into()];
        cells.extend([a.kendall, a.spearman].map(Cell::from));
        cells.extend(a.objectives.iter().map(|tau| Cell::from(*tau)));
        cells.extend([a.top_kept, a.front_kept, a.broken].map(Cell::from));
        cells.push(a.winner.map(|row| analysis.table.label(row)).into());
        cells
    };
    Table::new(columns).rows(stability.alternatives.iter().map(row))
}

/// The top designs under every ranking.
fn ranks(analysis: &Analysis) -> Table {
    let stability = &analysis.stability;
    let mut columns = vec![Column::text("design"), Column::count(analysis.energy_table.clone())];
    columns.extend(stability.alternatives.iter().map(|a| Column::count(a.label.clone())));
    columns.push(Column::count("fronts"));
    let row = |(i, &row): (usize, &u32)| {
        let point = analysis.table.points[row as usize];
        let on = stability.membership.iter().find(|(p, _)| *p == point).map_or(0, |(_, n)| *n);
        let mut cells: Vec<Cell> = vec![analysis.table.label(row).into(), (i + 1).into()];
        cells.extend(stability.alternatives.iter().map(|a| Cell::from(a.ranks[i])));
        cells.push(format!("{on} of {}", stability.rankings()).into());
        cells
    };
    Table::new(columns).rows(stability.top.iter().enumerate().map(row))
}

/// What the axes move.
fn axes(analysis: &Analysis) -> Table {
    let mut columns = vec![Column::text("axis"), Column::count("values")];
    let percent = Kind::Real(|x| significant(x * 100.0));
    for objective in &analysis.question.objectives {
        let words = Measure::of(&objective.name).words;
        columns.push(Column::new("main effect, %", percent).group(words.clone()));
        columns.push(Column::new("alone at most, %", percent).group(words));
    }
    columns.push(Column::text("dead"));
    let row = |axis: &powergs_study::analysis::axes::Axis| {
        let mut cells: Vec<Cell> = vec![axis.name.as_str().into(), axis.values.into()];
        for effect in &axis.effects {
            cells.extend([effect.main.into(), Cell::from(effect.alone)]);
        }
        cells.push(axis.is_dead().into());
        cells
    };
    Table::new(columns).rows(analysis.axes.iter().map(row))
}
