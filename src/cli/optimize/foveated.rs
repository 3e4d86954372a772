//! The foveated part of a report.

use super::super::Failure;
use super::folder::Folder;
use powergs_optimize::campaign::{Campaign, Finished, FoveatedModels};
use powergs_optimize::job::Place;
use powergs_report::Drawing;
use powergs_report::document::Document;
use powergs_report::optimize::foveated::{
    Show, charts, document, foveated_csv, levels_csv, regions_csv,
};

/// Writes tables and charts; returns the foveated part of the summary.
pub fn report(
    campaign: &Campaign,
    finished: &Finished,
    found: &FoveatedModels,
    folder: &Folder,
    drawing: &Drawing,
) -> Result<Document, Failure> {
    let results = &finished.results;
    folder.write("levels.csv", levels_csv(results))?;
    folder.write("foveated.csv", foveated_csv(results))?;
    folder.write("regions.csv", regions_csv(results))?;
    let fit = |level: u8| {
        let place = Place { variant: 0, level };
        let fit = campaign.plan.conclusion(&finished.outcomes, place).fit.ok()?;
        Some((format!("level {}", level + 1), fit))
    };
    let fits = (0..campaign.plan.levels).filter_map(fit).collect();
    let show = Show { results, fits, album: found.album.clone() };
    let drawn = charts(&show);
    folder.draw(&drawn, drawing)?;
    Ok(document(&show, &drawn))
}
