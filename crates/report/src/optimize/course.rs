//! λ and the quality over the iterations of all fine-tunes with a display term.

use super::{Story, around, dashed};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::shortened;
use crate::plot::{Align, Canvas, Drawn, GREY, GRID, Panel, Scale, palette, text_width};

const NAME: &str = "course";
const TITLE: &str = "λ and PSNR while tuning";

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
    /// PSNR over the gate views, decibels.
    pub psnr_db: f64,
}

/// The jobs that are shown, with where each begins on the axis.
struct Stretch<'a> {
    job: &'a str,
    begin: f64,
    moments: Vec<&'a Moment>,
}

pub(super) fn chart(story: &Story<'_>) -> Result<Option<Chart>, ReportError> {
    let shown = stretches(story);
    let Some(last) = shown.last() else { return Ok(None) };
    let Some(end) = last.moments.last().map(|m| last.begin + f64::from(m.iteration)) else {
        return Ok(None);
    };
    let target = story.target.map_or(String::new(), |t| format!("; dashed: {:.2} dB", t.psnr_db));
    let what = format!("gate views; samples in order, then the final model{target}");
    let drawing = story.page(NAME, TITLE, &what).draw(|c| draw(c, story, &shown, end))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn stretches<'a>(story: &'a Story<'_>) -> Vec<Stretch<'a>> {
    let mut shown: Vec<Stretch<'a>> = Vec::new();
    let is_shown = |m: &&Moment| m.job == "final" || m.job.starts_with("sample-");
    for moment in story.course.iter().filter(is_shown) {
        if shown.last().is_none_or(|s| s.job != moment.job) {
            let end = |s: &Stretch<'_>| {
                s.begin + s.moments.last().map_or(0.0, |m| f64::from(m.iteration) + 1.0)
            };
            let begin = shown.last().map_or(0.0, end);
            shown.push(Stretch { job: &moment.job, begin, moments: Vec::new() });
        }
        if let Some(stretch) = shown.last_mut() {
            stretch.moments.push(moment);
        }
    }
    shown
}

fn draw(canvas: &Canvas, story: &Story<'_>, shown: &[Stretch<'_>], end: f64) -> Drawn {
    let upper = Panel { left: 150.0, top: 130.0, right: 1240.0, bottom: 360.0 };
    let lower = Panel { top: 400.0, bottom: 630.0, ..upper };
    let x = Scale::exact(0.0, end.max(1.0), upper.horizontal());
    let all = || shown.iter().flat_map(|s| &s.moments);
    let target = story.target.map(|t| t.psnr_db);
    // The first checks against its own renders are near perfect: they would flatten the rest.
    let ceiling = target.map_or(f64::INFINITY, |t| t + 12.0);
    let psnr = all().map(|m| m.psnr_db.min(ceiling));
    let y = around(psnr.chain(target), 0.08, upper.vertical());
    upper.vertical_axis(canvas, &y, "PSNR, dB")?;
    let positive = || all().map(|m| m.lambda).filter(|l| *l > 0.0);
    let high = positive().fold(0.0, f64::max);
    let low = positive().fold(f64::INFINITY, f64::min).max(SHOWN * high);
    let weight = if low <= high {
        Scale::logarithmic(low, high, lower.vertical())
    } else {
        Scale::from_zero(1.0, lower.vertical())
    };
    lower.vertical_axis(canvas, &weight, "λ, 1/W (logarithmic)")?;
    lower.horizontal_axis(canvas, &x, &x.whole_ticks(10), "iteration")?;
    for stretch in shown {
        let at = x.at(stretch.begin);
        canvas.line(&[(at, upper.top), (at, upper.bottom)], GRID, 1)?;
        canvas.line(&[(at, lower.top), (at, lower.bottom)], GRID, 1)?;
        curve(canvas, stretch, &x, |m| Some(y.at(m.psnr_db)), palette::BLUE)?;
        let height = |m: &Moment| (m.lambda > 0.0).then(|| weight.at(m.lambda));
        curve(canvas, stretch, &x, height, palette::ORANGE)?;
    }
    names(canvas, story, shown, &x, end)?;
    let Some(target) = target else { return Ok(()) };
    let height = y.at(target);
    dashed(canvas, (upper.left, height), (upper.right, height), palette::VERMILION)
}

/// Names of the jobs above their stretch, where there is room.
fn names(canvas: &Canvas, story: &Story<'_>, shown: &[Stretch<'_>], x: &Scale, end: f64) -> Drawn {
    for (i, stretch) in shown.iter().enumerate() {
        let next = shown.get(i + 1).map_or(end, |s| s.begin);
        let rho = story.done.iter().find(|o| o.name == stretch.job).map(|o| o.rho);
        let text = match rho {
            Some(rho) if stretch.job == "final" => format!("final, ρ {rho:.2}"),
            Some(rho) => format!("ρ {rho:.2}"),
            None => shortened(stretch.job, 12),
        };
        let middle = (x.at(stretch.begin) + x.at(next)) / 2.0;
        if text_width(&text) + 6.0 < x.at(next) - x.at(stretch.begin) {
            canvas.text(&text, (middle, 112.0), Align::Centre, GREY)?;
        }
    }
    Ok(())
}

fn curve(
    canvas: &Canvas,
    stretch: &Stretch<'_>,
    x: &Scale,
    height: impl Fn(&Moment) -> Option<f64>,
    colour: plotters::style::RGBColor,
) -> Drawn {
    let point = |m: &&Moment| Some((x.at(stretch.begin + f64::from(m.iteration)), height(m)?));
    let points: Vec<(f64, f64)> = stretch.moments.iter().filter_map(point).collect();
    if points.len() > 1 { canvas.line(&points, colour, 2) } else { Ok(()) }
}
