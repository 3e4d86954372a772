//! The quality over the iterations of all fine-tunes, and what moves it: λ where there is a display
//! term, else the Gaussians that are left.

use super::Story;
use crate::format::shortened;
use powergs_chart::{Axis, Chart, Colour, Line, Mark, Panel, Rule, Scale, Words};

const NAME: &str = "course";
const TITLES: [&str; 2] = ["Gaussians and PSNR while tuning", "λ and PSNR while tuning"];

/// PSNR is drawn up to so much above the target, decibels.
const HEADROOM_DB: f64 = 12.0;
/// λ below this share of the largest is drawn there: the floor of λ would flatten the rest.
const SHOWN: f64 = 1e-4;

/// A check of the quality.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// The job.
    pub job: String,
    /// Iteration of the job, counted from 0.
    pub iteration: u32,
    /// λ of the iteration, 1/W; 0 without a display term.
    pub lambda: f64,
    /// Gaussians that are left.
    pub points: usize,
    /// PSNR over the gate views, decibels.
    pub psnr_db: f64,
}

/// The jobs that are shown, with where each begins on the axis.
struct CourseStretch<'a> {
    job: &'a str,
    begin: f64,
    moments: Vec<&'a Moment>,
}

pub(super) fn chart(story: &Story<'_>) -> Option<Chart> {
    let shown = stretches(story);
    let last = shown.last()?;
    let end = last.moments.last().map(|m| last.begin + f64::from(m.iteration))?;
    let target = story.target.map_or(String::new(), |t| format!("; dashed: {:.2} dB", t.psnr_db));
    let what = format!("gate views; samples, then the realised optimum{target}");
    let has_term = shown.iter().flat_map(|s| &s.moments).any(|m| m.lambda > 0.0);
    let chart = story.chart(NAME, TITLES[usize::from(has_term)], &what);
    let moved = if has_term { weight(&shown, end) } else { size(&shown, end) };
    let chart = chart.panel(quality(story, &shown, end)).panel(moved);
    let cut = story
        .target
        .map(|t| t.psnr_db + HEADROOM_DB)
        .filter(|cut| shown.iter().flat_map(|s| &s.moments).any(|m| m.psnr_db > *cut));
    let cut = cut.map_or(String::new(), |db| format!(" PSNR above {db:.0} dB is cut off."));
    let what = match has_term {
        true => "λ is the weight of display power in the loss.",
        false => "What a model has above the target is spent on the display when it is trained.",
    };
    Some(chart.note(format!("{what}{cut}")))
}

fn stretches<'a>(story: &'a Story<'_>) -> Vec<CourseStretch<'a>> {
    let mut shown: Vec<CourseStretch<'a>> = Vec::new();
    for moment in &story.course {
        if shown.last().is_none_or(|s| s.job != moment.job) {
            let end = |s: &CourseStretch<'_>| {
                s.begin + s.moments.last().map_or(0.0, |m| f64::from(m.iteration) + 1.0)
            };
            let begin = shown.last().map_or(0.0, end);
            shown.push(CourseStretch { job: &moment.job, begin, moments: Vec::new() });
        }
        if let Some(stretch) = shown.last_mut() {
            stretch.moments.push(moment);
        }
    }
    shown
}

/// PSNR over the iterations.
fn quality(story: &Story<'_>, shown: &[CourseStretch<'_>], end: f64) -> Panel {
    let target = story.target.map(|t| t.psnr_db);
    // The first checks against its own renders are near perfect: they would flatten the rest.
    let ceiling = target.map_or(f64::INFINITY, |t| t + HEADROOM_DB);
    let psnr = shown.iter().flat_map(|s| &s.moments).map(|m| m.psnr_db.min(ceiling));
    let y = Axis::new("PSNR, dB", Scale::around(psnr.chain(target), 0.08));
    let mut panel = panel(shown, end, y, |m| m.psnr_db, Colour::BLUE);
    panel.x = panel.x.hidden();
    panel.over = names(shown, end);
    match target {
        Some(target) => panel.dashed(Rule::Y(target), Colour::VERMILION),
        None => panel,
    }
}

/// λ over the iterations.
fn weight(shown: &[CourseStretch<'_>], end: f64) -> Panel {
    let all = shown.iter().flat_map(|s| &s.moments).map(|m| m.lambda);
    let positive: Vec<f64> = all.filter(|l| *l > 0.0).collect();
    let high = positive.iter().copied().fold(0.0, f64::max);
    let low = positive.iter().copied().fold(f64::INFINITY, f64::min).max(SHOWN * high);
    let scale = if low <= high { Scale::logarithmic(low, high) } else { Scale::from_zero(1.0) };
    let y = Axis::new("λ, 1/W", scale);
    // Zero has no place on this scale: what is below it lies on its floor.
    let floor = y.scale.low();
    panel(shown, end, y, |m| m.lambda.max(floor), Colour::ORANGE)
}

/// Gaussians over the iterations.
fn size(shown: &[CourseStretch<'_>], end: f64) -> Panel {
    let points = |m: &Moment| m.points as f64;
    let most = shown.iter().flat_map(|s| &s.moments).map(|m| points(m)).fold(1.0, f64::max);
    let y = Axis::new("Gaussians", Scale::from_zero(most));
    panel(shown, end, y, points, Colour::ORANGE)
}

/// A line for every stretch, and where each begins.
fn panel(
    shown: &[CourseStretch<'_>],
    end: f64,
    y: Axis,
    height: impl Fn(&Moment) -> f64,
    colour: Colour,
) -> Panel {
    let x = Axis::new("iteration", Scale::linear(0.0, end.max(1.0))).whole(10).plain();
    shown.iter().fold(Panel::new(x, y), |panel, stretch| {
        let point = |m: &&Moment| (stretch.begin + f64::from(m.iteration), height(m));
        let line = Line::thin(stretch.moments.iter().map(point).collect(), colour);
        let at = Rule::X(stretch.begin);
        panel.mark(Mark::Rule { at, colour: Colour::GRID, dashed: false }).line(line)
    })
}

/// Names of the jobs in the middle of their stretches.
fn names(shown: &[CourseStretch<'_>], end: f64) -> Vec<(f64, f64, Words)> {
    let name = |(i, stretch): (usize, &CourseStretch<'_>)| {
        let next = shown.get(i + 1).map_or(end, |s| s.begin);
        let text = shortened(stretch.job, 12);
        ((stretch.begin + next) / 2.0, next - stretch.begin, Words::note(text))
    };
    shown.iter().enumerate().map(name).collect()
}
