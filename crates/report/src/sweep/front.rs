//! The designs in the plane of two objectives: all of them coloured by a third column, the front as
//! a line, the knee and the base machine by name.

use super::axis::Axis;
use super::colour::ColourKey;
use super::deadline;
use super::measure::Measure;
use super::words::{display_rate, knee_name, prices};
use crate::format::counted;
use powergs_chart::{
    Beside, Chart, Colour, Entry, Form, Line, Panel, Place, Points, Rule, Scale, Side, Size,
    Symbol, Weight, Words,
};
use powergs_study::analysis::front::{Costs, front};
use powergs_study::analysis::table::Values;
use powergs_study::analysis::{Analysis, Goal};

/// File names; further pairs of objectives have no chart.
const NAMES: [&str; 3] = ["front", "front_2", "front_3"];
/// Designs whose front is less than this share of the range of all are drawn without those far
/// away.
const FOCUS: f64 = 0.25;

/// A chart for every pair of the first objectives, the most telling pair first.
pub fn charts(analysis: &Analysis) -> Vec<Chart> {
    let objectives = &analysis.question.objectives;
    let k = objectives.len();
    let mut pairs: Vec<(usize, usize)> =
        (0..k).flat_map(|a| (a + 1..k).map(move |b| (a, b))).collect();
    let area = |j: usize| objectives[j].name == "area_mm2";
    let more = |j: usize| objectives[j].goal == Goal::Maximize;
    pairs.sort_by_key(|&(a, b)| {
        let points = 2 * usize::from(area(a) || area(b)) + usize::from(more(a) || more(b));
        std::cmp::Reverse(points)
    });
    let named = NAMES.into_iter().zip(pairs);
    named
        .map(|(name, (a, b))| {
            // What is paid goes to the right, what is gained upwards.
            let turned = area(b) || (more(a) && !more(b) && !area(a));
            chart(analysis, name, if turned { (b, a) } else { (a, b) })
        })
        .collect()
}

/// The two objectives of a chart.
struct FrontPlane<'a, 't> {
    analysis: &'a Analysis<'t>,
    x: (usize, Axis),
    y: (usize, Axis),
}

impl FrontPlane<'_, '_> {
    fn at(&self, row: u32) -> Place {
        let value = |(j, axis): &(usize, Axis)| axis.factor * self.analysis.value(*j, row);
        (value(&self.x), value(&self.y))
    }

    /// Whether a design is on the axes.
    fn shows(&self, row: u32) -> bool {
        let (x, y) = self.at(row);
        let on = |scale: &Scale, v: f64| v >= scale.low() && v <= scale.high();
        on(&self.x.1.axis.scale, x) && on(&self.y.1.axis.scale, y)
    }

    /// Corners of the staircase that bounds what is reachable in these two objectives.
    fn staircase(&self) -> Vec<Place> {
        let objectives = &self.analysis.question.objectives;
        let (x, y) = (self.x.0, self.y.0);
        let cost = |j: usize, row: u32| objectives[j].goal.cost(self.analysis.value(j, row));
        let mut costs = Costs::new(2);
        let rows = &self.analysis.front;
        rows.iter().for_each(|&row| costs.push(&[cost(x, row), cost(y, row)]));
        let mut line: Vec<u32> = front(&costs).into_iter().map(|i| rows[i]).collect();
        line.sort_by(|&a, &b| cost(x, a).total_cmp(&cost(x, b)));
        let mut points: Vec<Place> = Vec::new();
        for &row in &line {
            let at = self.at(row);
            if let Some(&(_, before)) = points.last() {
                points.push((at.0, before));
            }
            points.push(at);
        }
        points
    }
}

/// Rows of all designs.
fn all<'a>(analysis: &'a Analysis<'_>) -> impl Iterator<Item = &'a u32> {
    let named = analysis.named.as_ref().map(|n| &n.row);
    analysis.rows.iter().chain(&analysis.behind).chain(&analysis.unmet).chain(named)
}

/// The values of objective `j` that its axis should show: all, or where the front is a small part
/// of that, the front with as much room on both sides.
fn focus(analysis: &Analysis, j: usize) -> Vec<f64> {
    let value = |row: &u32| analysis.value(j, *row);
    let named = analysis.named.as_ref().map(|n| n.row);
    let core = analysis.front.iter().copied().chain(named);
    let (low, high) = powergs_chart::ends(core.map(|row| value(&row)));
    let every: Vec<f64> = all(analysis).map(value).collect();
    let whole = powergs_chart::ends(every.iter().copied());
    let (range, room) = (high - low, (high - low).max(0.02 * high.abs()));
    if range.is_nan() || range >= FOCUS * (whole.1 - whole.0) {
        return deadline::with(analysis, j, every);
    }
    let near = |v: &f64| (low - room..=high + room).contains(v);
    deadline::with(analysis, j, every.into_iter().filter(near).collect())
}

fn chart(analysis: &Analysis, name: &'static str, (x, y): (usize, usize)) -> Chart {
    let objectives = &analysis.question.objectives;
    let axis = |j: usize| Axis::of(&objectives[j].name, focus(analysis, j).into_iter());
    let plane = FrontPlane { analysis, x: (x, axis(x)), y: (y, axis(y)) };
    let key = ColourKey::of(analysis, [&objectives[x].name, &objectives[y].name]);
    let off = all(analysis).filter(|row| !plane.shows(**row)).count();
    let off = match off {
        0 => String::new(),
        n => format!("; {} far from it not shown", counted(n, "design")),
    };
    let subtitle = format!(
        "{} on the Pareto front of {}, {}, {}{off}",
        analysis.front.len(),
        counted(analysis.rows.len(), "design"),
        analysis.question.scope,
        prices(analysis)
    );
    let words = |j: usize| Measure::of(&objectives[j].name).words;
    let title = format!("Pareto front: {} against {}", words(y), words(x));
    let lines = deadline::entries(analysis, &[(x, &plane.x.1), (y, &plane.y.1)]);
    let entries = entries(&plane).into_iter().chain(lines).collect();
    let chart = Chart::new(name, title, subtitle)
        .panel(panel(&plane, &key))
        .beside(Beside::Entries { title: String::new(), entries });
    match key.beside() {
        Some(beside) => chart.beside(beside),
        None => chart,
    }
}

fn panel(plane: &FrontPlane, key: &ColourKey) -> Panel {
    let analysis = plane.analysis;
    let coloured = |rows: &[u32]| -> Vec<(Place, Colour)> {
        let shown = rows.iter().filter(|row| plane.shows(**row));
        shown.map(|&row| (plane.at(row), key.colour(row))).collect()
    };
    let outside = analysis.behind.iter().chain(&analysis.unmet);
    let outside = outside.filter(|row| plane.shows(**row)).map(|&row| plane.at(row));
    let crowd = |points: Points| Points { crowd: true, ..points };
    let all =
        Points { points: coloured(&analysis.rows), ..Points::dots([], Colour::INK, Size::Small) };
    let (x, y) = (plane.x.1.axis.clone().ticks(8), plane.y.1.axis.clone());
    let ring = Some(Colour::INK);
    let front = Points {
        points: coloured(&analysis.front),
        ring,
        ..Points::dots([], Colour::INK, Size::Medium)
    };
    let knee = plane.at(analysis.knee);
    let look = Points::dots([knee], key.colour(analysis.knee), Size::Huge);
    let mut panel = slowest(plane)
        .fold(Panel::new(x, y), Panel::line)
        .points(crowd(Points::dots(outside, Colour::PALE, Size::Small)))
        .points(crowd(all))
        .line(Line::thin(plane.staircase(), Colour::NOTE))
        .points(front)
        .points(Points { ring: Some(Colour::VERMILION), ..look });
    for (j, axis) in [&plane.x, &plane.y] {
        if let Some(at) = deadline::line(analysis, *j, axis) {
            let at = if *j == plane.x.0 { Rule::X(at) } else { Rule::Y(at) };
            panel = panel.dashed(at, deadline::COLOUR);
        }
    }
    let label = |row: u32| Words::bold(analysis.table.label(row));
    panel = panel.label(
        Words::bold(format!("{} {}", knee_name(analysis), analysis.table.label(analysis.knee))),
        knee,
        Side::Free,
    );
    if let Some(named) = &analysis.named {
        let at = plane.at(named.row);
        let look = Points::dots([at], key.colour(named.row), Size::Large);
        panel = panel.points(Points { form: Form::Square, ring, ..look }).label(
            label(named.row),
            at,
            Side::Free,
        );
    }
    let mut ends = analysis.ends.clone();
    ends.sort_unstable();
    ends.dedup();
    ends.into_iter()
        .filter(|row| *row != analysis.knee)
        .fold(panel, |panel, row| panel.label(label(row), plane.at(row), Side::Free))
}

/// From the mean frame rate of each design that misses the display rate down to that of its slowest
/// frame: the mean alone may lie above the rate that the design misses.
fn slowest(plane: &FrontPlane) -> impl Iterator<Item = Line> {
    let analysis = plane.analysis;
    let (j, axis) = &plane.y;
    let is_mean = analysis.question.objectives[*j].name == "fps.mean";
    let column = analysis.table.metrics.iter().find(|c| is_mean && c.name == "fps.min");
    let least = match column.map(|c| &c.values) {
        Some(Values::Numbers(numbers)) => numbers.as_slice(),
        _ => &[],
    };
    let low = axis.axis.scale.low();
    let shown = analysis.behind.iter().filter(|row| plane.shows(**row));
    shown.filter_map(move |&row| {
        let least = least.get(row as usize).filter(|fps| fps.is_finite())?;
        let at = plane.at(row);
        let whisker = vec![at, (at.0, (least * axis.factor).max(low))];
        Some(Line { weight: Weight::Hair, ..Line::curve(whisker, Colour::PALE) })
    })
}

fn entries(plane: &FrontPlane) -> Vec<Entry> {
    let analysis = plane.analysis;
    let mut entries = vec![
        Entry::new("on the Pareto front", Symbol::Ring(Colour::INK, Colour::PALE)),
        Entry::new(knee_name(analysis), Symbol::Ring(Colour::VERMILION, Colour::PALE)),
    ];
    if let Some(named) = &analysis.named {
        entries.push(Entry::new(analysis.table.label(named.row), Symbol::Square(Colour::INK)));
    }
    let pale = match (analysis.unmet.is_empty(), analysis.behind.is_empty()) {
        (true, true) => None,
        (false, true) => Some("condition not met".to_owned()),
        (true, false) => Some(format!("misses {} in some frame", display_rate(analysis))),
        (false, false) => Some(format!("condition or {} not met", display_rate(analysis))),
    };
    entries.extend(pale.map(|text| Entry::new(text, Symbol::Dot(Colour::PALE))));
    if slowest(plane).next().is_some() {
        entries.push(Entry::new("down to its slowest frame", Symbol::Line(Colour::PALE)));
    }
    // One design may be the best in both: a front of a single point has no line.
    if analysis.question.objectives.len() > 2 && plane.staircase().len() > 1 {
        entries.push(Entry::new("Pareto front of these two", Symbol::Line(Colour::NOTE)));
    }
    entries
}
