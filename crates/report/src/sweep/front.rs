//! The designs in the plane of two objectives: all of them coloured by a third column, the front as
//! a line, the knee and the base machine by name.

use std::collections::HashSet;

use super::axis::Axis;
use super::colour::Key;
use super::labels::{self, Label};
use super::words::count;
use crate::ReportError;
use crate::charts::Chart;
use crate::plot::{Align, Canvas, Drawn, GREY, INK, Page, Panel, palette};
use powergs_study::analysis::front::{Costs, front};
use powergs_study::analysis::{Analysis, Goal};

/// File names; further pairs of objectives have no chart.
const NAMES: [&str; 3] = ["front", "front_2", "front_3"];
const TITLE: &str = "Which designs are worth keeping";
/// The plane.
const PANEL: Panel = Panel { left: 120.0, top: 105.0, right: 985.0, bottom: 620.0 };

/// A chart for every pair of the first objectives, the most telling pair first.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn charts(analysis: &Analysis) -> Result<Vec<Chart>, ReportError> {
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
struct Plane<'a, 't> {
    analysis: &'a Analysis<'t>,
    x: (usize, Axis),
    y: (usize, Axis),
}

impl Plane<'_, '_> {
    fn at(&self, row: u32) -> (f64, f64) {
        let value = |(j, axis): &(usize, Axis)| axis.at(self.analysis.value(*j, row));
        (value(&self.x), value(&self.y))
    }

    /// Dots, one per place and colour however many designs lie there.
    fn dots(
        &self,
        canvas: &Canvas,
        rows: &[u32],
        colour: impl Fn(u32) -> plotters::style::RGBColor,
    ) -> Drawn {
        let mut seen = HashSet::new();
        for &row in rows {
            let (x, y) = self.at(row);
            let colour = colour(row);
            if seen.insert(((x / 2.0) as i32, (y / 2.0) as i32, colour.0, colour.1, colour.2)) {
                canvas.dot((x, y), 4, colour)?;
            }
        }
        Ok(())
    }

    /// Corners of the staircase that bounds what is reachable in these two objectives.
    fn staircase(&self) -> Vec<(f64, f64)> {
        let objectives = &self.analysis.question.objectives;
        let (x, y) = (self.x.0, self.y.0);
        let cost = |j: usize, row: u32| objectives[j].goal.cost(self.analysis.value(j, row));
        let mut costs = Costs::new(2);
        let rows = &self.analysis.front;
        rows.iter().for_each(|&row| costs.push(&[cost(x, row), cost(y, row)]));
        let mut line: Vec<u32> = front(&costs).into_iter().map(|i| rows[i]).collect();
        line.sort_by(|&a, &b| cost(x, a).total_cmp(&cost(x, b)));
        let mut points: Vec<(f64, f64)> = Vec::new();
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

fn chart(
    analysis: &Analysis,
    name: &'static str,
    (x, y): (usize, usize),
) -> Result<Chart, ReportError> {
    let objectives = &analysis.question.objectives;
    let shown = || {
        analysis.rows.iter().chain(&analysis.unmet).chain(analysis.named.as_ref().map(|n| &n.row))
    };
    let axis = |j: usize, page: (f64, f64)| {
        Axis::of(&objectives[j].name, shown().map(|row| analysis.value(j, *row)), page)
    };
    let plane =
        Plane { analysis, x: (x, axis(x, PANEL.horizontal())), y: (y, axis(y, PANEL.vertical())) };
    let key = Key::of(analysis, [&objectives[x].name, &objectives[y].name]);
    let subtitle = format!(
        "{} on the front of {}, {}, energy table {}",
        analysis.front.len(),
        count(analysis.rows.len(), "design"),
        analysis.question.scope,
        analysis.energy_table
    );
    let page = Page { name, title: TITLE.into(), subtitle, underlay: None };
    let drawing = page.draw(|canvas| {
        let (x, y) = (&plane.x.1, &plane.y.1);
        PANEL.vertical_axis(canvas, &y.scale, &y.name)?;
        for tick in x.scale.ticks(8) {
            let at = x.scale.at(tick);
            canvas.line(&[(at, PANEL.top), (at, PANEL.bottom)], crate::plot::GRID, 1)?;
        }
        PANEL.horizontal_axis(canvas, &x.scale, &x.scale.ticks(8), &x.name)?;
        plane.dots(canvas, &analysis.unmet, |_| palette::PALE)?;
        plane.dots(canvas, &analysis.rows, |row| key.colour(row))?;
        let stairs = plane.staircase();
        if stairs.len() > 1 {
            canvas.line(&stairs, GREY, 2)?;
        }
        for &row in &analysis.front {
            canvas.dot(plane.at(row), 8, INK)?;
            canvas.dot(plane.at(row), 6, key.colour(row))?;
        }
        marks(canvas, &plane, &key, &stairs)?;
        legend(canvas, &plane, &key)
    })?;
    Ok(Chart { name, title: TITLE, drawing })
}

/// The knee, the named design and the ends, with their names.
fn marks(canvas: &Canvas, plane: &Plane, key: &Key, stairs: &[(f64, f64)]) -> Drawn {
    let analysis = plane.analysis;
    let label = |row: u32| analysis.table.label(row);
    let knee = plane.at(analysis.knee);
    canvas.dot(knee, 13, palette::VERMILION)?;
    canvas.dot(knee, 9, INK)?;
    canvas.dot(knee, 7, key.colour(analysis.knee))?;
    let mut all = vec![Label { text: format!("knee {}", label(analysis.knee)), at: knee }];
    if let Some(named) = &analysis.named {
        let (x, y) = plane.at(named.row);
        canvas.fill((x - 8.0, y - 8.0), (x + 8.0, y + 8.0), INK)?;
        canvas.fill((x - 5.0, y - 5.0), (x + 5.0, y + 5.0), key.colour(named.row))?;
        all.push(Label { text: label(named.row), at: (x, y) });
    }
    let mut ends = analysis.ends.clone();
    ends.sort_unstable();
    ends.dedup();
    let others = ends.into_iter().filter(|row| *row != analysis.knee);
    all.extend(others.map(|row| Label { text: label(row), at: plane.at(row) }));
    let mut points: Vec<(f64, f64)> = analysis.front.iter().map(|&row| plane.at(row)).collect();
    points.extend(along(stairs));
    let frame = [PANEL.left, PANEL.top - 10.0, PANEL.right + 20.0, PANEL.bottom];
    labels::draw(canvas, &labels::place(&all, &points, frame))
}

/// Points of a line, near enough to each other that no label lies between two of them.
fn along(line: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> {
    const STEP: f64 = 12.0;
    line.windows(2).flat_map(|ends| {
        let ((x, y), (to_x, to_y)) = (ends[0], ends[1]);
        let steps = ((to_x - x).hypot(to_y - y) / STEP).ceil();
        (0..steps as usize).map(move |i| {
            let share = i as f64 / steps;
            (x + share * (to_x - x), y + share * (to_y - y))
        })
    })
}

fn legend(canvas: &Canvas, plane: &Plane, key: &Key) -> Drawn {
    let left = PANEL.right + 40.0;
    let mut y = 130.0;
    let mut row = |draw: &dyn Fn(f64) -> Drawn, text: &str| {
        draw(y)?;
        canvas.text(text, (left + 26.0, y), Align::Left, INK)?;
        y += 28.0;
        Ok::<(), String>(())
    };
    let x = left + 8.0;
    row(
        &|y| {
            canvas.dot((x, y), 8, INK)?;
            canvas.dot((x, y), 6, palette::PALE)
        },
        "on the front",
    )?;
    row(&|y| canvas.dot((x, y), 11, palette::VERMILION), "knee")?;
    if let Some(named) = &plane.analysis.named {
        let label = plane.analysis.table.label(named.row);
        row(&|y| canvas.fill((x - 8.0, y - 8.0), (x + 8.0, y + 8.0), INK), &label)?;
    }
    if !plane.analysis.unmet.is_empty() {
        row(&|y| canvas.dot((x, y), 4, palette::PALE), "condition not met")?;
    }
    if plane.analysis.question.objectives.len() > 2 {
        row(&|y| canvas.line(&[(x - 8.0, y), (x + 10.0, y)], GREY, 2), "front of these two")?;
    }
    key.legend(canvas, (left, y + 20.0), 26)
}
