//! What an optimisation leaves: tables, charts and a summary, as functions from its outcomes.

mod breakdown;
mod course;
pub mod foveated;
mod plane;
mod quality;
mod ratio;
mod strip;
mod summary;
mod sweep;
mod tables;

use plotters::style::RGBColor;

use super::ReportError;
use super::charts::Chart;
use super::format::{shortened, significant};
use super::plot::{Align, Canvas, Drawn, INK, Page, Scale, palette, text_width};
use powergs_optimize::claims::Book;
use powergs_optimize::plan::{Baseline, Outcome, Role};
use powergs_optimize::search::Conclusion;
use powergs_optimize::study::RatioRow;
use powergs_optimize::target::Quality;

pub use course::Moment;
pub use strip::Strip;
pub use summary::{Facts, markdown};
pub use tables::{models_csv, ratios_csv, samples_csv};

/// Everything that the charts and the summary of a run show.
#[derive(Debug, Clone)]
pub struct Story<'a> {
    /// Name of the scene.
    pub name: String,
    /// What counted the power: a machine, or `paper`.
    pub oracle: String,
    /// The panel.
    pub display: String,
    /// Frames shown per second.
    pub fps: f64,
    /// All outcomes, in order.
    pub done: &'a [Outcome],
    /// What was to be reached, if the dense model was measured.
    pub target: Option<Quality>,
    /// What the samples say.
    pub conclusion: &'a Conclusion,
    /// Checks of the quality, in order.
    pub course: Vec<Moment>,
    /// The study of display-to-render ratios; empty if it was not asked for.
    pub ratios: Vec<RatioRow>,
    /// Pictures of one view.
    pub strip: Option<Strip>,
    /// What the run says about the published claims.
    pub claims: Book,
}

impl Story<'_> {
    fn page(&self, name: &'static str, title: &str, what: &str) -> Page {
        page(name, title, (&self.name, &self.oracle, self.fps), what)
    }

    fn of(&self, role: Role) -> Option<&Outcome> {
        self.done.iter().find(|o| o.role == role)
    }

    fn samples(&self) -> impl Iterator<Item = &Outcome> {
        self.done.iter().filter(|o| o.role == Role::Sample)
    }

    /// The model that the run ends with.
    fn best(&self) -> Option<&Outcome> {
        let name = self.conclusion.best.as_ref()?;
        self.done.iter().find(|o| o.name == *name)
    }
}

/// A page about a scene, what counts its power, and frames shown per second.
fn page(
    name: &'static str,
    title: &str,
    (scene, oracle, fps): (&str, &str, f64),
    what: &str,
) -> Page {
    let scene = shortened(scene, 24);
    let oracle = shortened(oracle, 20);
    let oracle = if oracle == "paper" { "the paper model".into() } else { oracle };
    let fps = super::format::rate(fps);
    let subtitle = format!("{scene} on {oracle} at {fps} FPS, {what}");
    Page { name, title: title.into(), subtitle, underlay: None }
}

/// All charts that the run has data for, in the order of the summary.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn charts(story: &Story<'_>) -> Result<Vec<Chart>, ReportError> {
    let drawn = [
        curves(story)?,
        plane::chart(story)?,
        quality::chart(story)?,
        breakdown::chart(story)?,
        course::chart(story)?,
        strip::chart(story)?,
        ratio::chart(story)?,
        sweep::chart(story)?,
    ];
    Ok(drawn.into_iter().flatten().collect())
}

/// D and R with their fits, and the total with its optimum.
fn curves(story: &Story<'_>) -> Result<Option<Chart>, ReportError> {
    let Ok(fit) = &story.conclusion.fit else { return Ok(None) };
    let drawing = super::fit::chart(fit, &story.name)?;
    Ok(Some(Chart { name: "curves", title: "Power over the pruning ratio", drawing }))
}

/// The colour of a model in every chart.
fn colour(role: Role) -> RGBColor {
    match role {
        Role::Dense => INK,
        Role::Sample => palette::SKY,
        Role::Final => palette::VERMILION,
        Role::Baseline(Baseline::RenderOnly) => palette::ORANGE,
        Role::Baseline(Baseline::DisplayOnly) => palette::BLUE,
        Role::Baseline(Baseline::TwoStage) => palette::PURPLE,
        Role::Baseline(Baseline::LightGaussian(_)) => palette::GREEN,
        Role::HeldOut | Role::External(_) | Role::Sweep(_) => palette::GREY,
    }
}

/// The label of a model in charts: samples by their ratio.
fn label(outcome: &Outcome) -> String {
    match outcome.role {
        Role::Sample => format!("ρ {}", significant(outcome.rho)),
        Role::Final => "ours".into(),
        Role::Dense | Role::HeldOut | Role::Baseline(_) | Role::External(_) | Role::Sweep(_) => {
            shortened(&outcome.name, 18)
        }
    }
}

/// A linear scale around values, with room at both ends; never below zero if no value is.
fn around(values: impl Iterator<Item = f64>, room: f64, page: (f64, f64)) -> Scale {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low > high {
        return Scale::exact(0.0, 1.0, page);
    }
    let width = (high - low).max(0.02 * high.abs()).max(1e-9);
    let below = low - room * width;
    Scale::exact(if low >= 0.0 { below.max(0.0) } else { below }, high + room * width, page)
}

/// A rectangle of the page: left, top, right, bottom.
type Area = [f64; 4];

/// Places labels beside points so that no two overlap, nor what is `taken`: each goes to the first
/// free place around its point.
fn labels(
    canvas: &Canvas,
    points: &[((f64, f64), String, RGBColor)],
    (left, right): (f64, f64),
    mut taken: Vec<Area>,
) -> Drawn {
    const HEIGHT: f64 = 20.0;
    taken.extend(points.iter().map(|((x, y), _, _)| [x - 9.0, y - 9.0, x + 9.0, y + 9.0]));
    for ((x, y), text, colour) in points {
        let width = text_width(text);
        let places = [
            (x + 14.0, *y),
            (x - 14.0 - width, *y),
            (x - width / 2.0, y - 20.0),
            (x - width / 2.0, y + 20.0),
            (x + 14.0, y - 20.0),
            (x - 14.0 - width, y - 20.0),
            (x + 14.0, y + 20.0),
            (x - 14.0 - width, y + 20.0),
            (x - width / 2.0, y - 40.0),
            (x - width / 2.0, y + 40.0),
        ];
        let box_of =
            |(x, y): (f64, f64)| [x - 2.0, y - HEIGHT / 2.0, x + width + 2.0, y + HEIGHT / 2.0];
        let free = |place: &&(f64, f64)| {
            let b = box_of(**place);
            let inside = b[0] >= left && b[2] <= right;
            let apart = |t: &Area| b[0] >= t[2] || b[2] <= t[0] || b[1] >= t[3] || b[3] <= t[1];
            inside && taken.iter().all(apart)
        };
        let Some(place) = places.iter().find(free) else { continue };
        taken.push(box_of(*place));
        clear(canvas, box_of(*place))?;
        canvas.text(text, *place, Align::Left, *colour)?;
    }
    Ok(())
}

/// White where text goes over lines.
fn clear(canvas: &Canvas, [left, top, right, bottom]: Area) -> Drawn {
    canvas.fill((left, top), (right, bottom), RGBColor(255, 255, 255))
}

/// A dashed line between two points.
fn dashed(canvas: &Canvas, (x0, y0): (f64, f64), (x1, y1): (f64, f64), colour: RGBColor) -> Drawn {
    let length = (x1 - x0).hypot(y1 - y0);
    let mut at = 0.0;
    while at < length {
        let point = |s: f64| {
            let t = (s / length).min(1.0);
            (x0 + t * (x1 - x0), y0 + t * (y1 - y0))
        };
        canvas.line(&[point(at), point(at + 10.0)], colour, 2)?;
        at += 18.0;
    }
    Ok(())
}
