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

pub use tables::{foveated_csv, levels_csv, regions_csv};
pub use words::{document, headline, saving};

use powergs_chart::{Chart, Colour};
use powergs_optimize::fit::Fit;
use powergs_optimize::foveated::Method;
use powergs_optimize::pictures::Album;
use powergs_optimize::results::Results;
use powergs_optimize::role::{Baseline, Role};

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
    fn chart(&self, name: &'static str, title: &'static str, what: &str) -> Chart {
        let r = self.results;
        let chart = Chart::new(name, title, super::subtitle(&r.scene, &r.oracle, r.fps, what));
        match &r.counted {
            Some(counted) => chart.note(super::power_note(counted, &r.oracle)),
            None => chart,
        }
    }

    /// The variant of the run.
    fn variant(&self) -> &str {
        &self.results.variants[0].name
    }
}

/// All charts that the run has data for, in the order of the summary.
pub fn charts(show: &Show<'_>) -> Vec<Chart> {
    let charts = [
        quality::chart(show),
        regions::chart(show),
        album::chart(show),
        levels::chart(show),
        ratio::chart(show),
        fits::chart(show),
    ];
    charts.into_iter().flatten().collect()
}

/// The colour of a foveated method in every chart.
fn colour(method: Method) -> Colour {
    match method {
        Method::PowerGs => Colour::VERMILION,
        Method::FrRender => Colour::ORANGE,
        Method::FrDisplay => Colour::BLUE,
        Method::RtgsD22 => Colour::PURPLE,
    }
}

/// The colour of the model of level 1 that is shown without foveation.
fn plain_colour(baseline: Option<Baseline>, is_dense: bool, is_ours: bool) -> Colour {
    match baseline {
        Some(baseline) => super::colour(Role::Baseline(baseline)),
        None if is_dense => super::colour(Role::Dense),
        None if is_ours => colour(Method::PowerGs),
        None => Colour::GREY,
    }
}
