//! D and R over the pruning ratio, a panel a level.

use super::Show;
use crate::ReportError;
use crate::charts::Chart;
use crate::fit;
use crate::plot::{Canvas, Drawn, Panel};

const NAME: &str = "foveated_fits";
const TITLE: &str = "Power over the pruning ratio, level by level";
/// Panels on the page.
const MOST: usize = 4;

pub(super) fn chart(show: &Show<'_>) -> Result<Option<Chart>, ReportError> {
    if show.fits.len() < 2 {
        return Ok(None);
    }
    let what = format!("variant {}, ρ of a level is a share of the level before", show.variant());
    let drawing = show.page(NAME, TITLE, &what).draw(|canvas| draw(canvas, show))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn draw(canvas: &Canvas, show: &Show<'_>) -> Drawn {
    fit::legend(canvas, (40.0, 106.0), 1240.0)?;
    for (i, (heading, fit)) in show.fits.iter().take(MOST).enumerate() {
        let (column, row) = ((i % 2) as f64, (i / 2) as f64);
        let (left, top) = (120.0 + 620.0 * column, 160.0 + 280.0 * row);
        let panel = Panel { left, top, right: left + 500.0, bottom: top + 180.0 };
        fit::small(canvas, fit, panel, heading)?;
    }
    Ok(())
}
