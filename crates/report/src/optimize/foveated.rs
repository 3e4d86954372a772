//! What a foveated run leaves: tables, charts and a part of the summary, as functions from its
//! results.

mod album;
mod fits;
mod levels;
mod quality;
mod ratio;
mod regions;
mod tables;
mod words;

pub use album::{Album, Shot};
pub use tables::{foveated_csv, levels_csv, regions_csv};
pub use words::{headline, markdown};

use plotters::style::RGBColor;

use super::{around, labels};
use crate::ReportError;
use crate::charts::Chart;
use crate::plot::{Canvas, Drawn, INK, Page, palette};
use powergs_optimize::fit::Fit;
use powergs_optimize::foveated::Method;
use powergs_optimize::results::Results;

/// Everything that the charts of a foveated run show.
#[derive(Debug, Clone)]
pub struct Show<'a> {
    /// What was found.
    pub results: &'a Results,
    /// The curves of the levels of the first variant: a heading, and the fit.
    pub fits: Vec<(String, Fit)>,
    /// Pictures of one view.
    pub album: Option<Album>,
}

impl Show<'_> {
    fn page(&self, name: &'static str, title: &str, what: &str) -> Page {
        let r = self.results;
        super::page(name, title, (&r.scene, &r.oracle, r.fps), what)
    }

    /// The variant of the run.
    fn variant(&self) -> &str {
        &self.results.variants[0].name
    }
}

/// All charts that the run has data for, in the order of the summary.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn charts(show: &Show<'_>) -> Result<Vec<Chart>, ReportError> {
    let drawn = [
        quality::chart(show)?,
        regions::chart(show)?,
        album::chart(show)?,
        levels::chart(show)?,
        ratio::chart(show)?,
        fits::chart(show)?,
    ];
    Ok(drawn.into_iter().flatten().collect())
}

/// The colour of a foveated method in every chart.
fn colour(method: Method) -> RGBColor {
    match method {
        Method::PowerGs => palette::VERMILION,
        Method::FrRender => palette::ORANGE,
        Method::FrDisplay => palette::BLUE,
        Method::RtgsD22 => palette::PURPLE,
    }
}

/// The colour of the model of level 1 that is shown without foveation.
fn plain_colour(baseline: Option<&str>, is_dense: bool, is_ours: bool) -> RGBColor {
    match baseline {
        Some("render-only") => palette::ORANGE,
        Some("display-only") => palette::BLUE,
        Some("two-stage") => palette::PURPLE,
        Some(_) => palette::GREEN,
        None if is_dense => INK,
        None if is_ours => palette::VERMILION,
        None => palette::GREY,
    }
}

/// A square around a point.
fn square(canvas: &Canvas, (x, y): (f64, f64), half: f64, colour: RGBColor) -> Drawn {
    canvas.fill((x - half, y - half), (x + half, y + half), colour)
}
