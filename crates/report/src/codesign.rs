//! What a co-design leaves: the five pairs, every pair as a table, charts and a page.

mod breakdown;
mod front;
mod map;
mod page;
mod strip;
mod tables;
mod words;

pub use page::{document, headline};
pub use tables::{found_machines, models_csv, pairs_csv, ways};

use powergs_chart::{Chart, Colour};
use powergs_codesign::Finished;
use powergs_codesign::compare::Way;
use powergs_optimize::pictures::BeforeAfter;

/// The colour of a way in every chart.
fn colour(way: Way) -> Colour {
    match way {
        Way::Dense => Colour::GREY,
        Way::Base => Colour::SKY,
        Way::MachineFirst => Colour::ORANGE,
        Way::ModelFirst => Colour::GREEN,
        Way::Joint => Colour::VERMILION,
    }
}

/// All charts: the front, the map, where the watts go, and the joint model beside the dense one.
pub fn charts(finished: &Finished, picture: Option<&BeforeAfter>) -> Vec<Chart> {
    let charts = [
        Some(front::chart(finished)),
        map::chart(finished),
        Some(breakdown::chart(finished)),
        picture.and_then(|picture| strip::chart(finished, picture)),
    ];
    charts.into_iter().flatten().collect()
}
