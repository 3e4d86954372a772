//! D and R over the pruning ratio, a panel a level.

use super::Show;
use crate::fit;
use powergs_chart::Chart;

const NAME: &str = "foveated_fits";
const TITLE: &str = "Power over the pruning ratio, level by level";
/// Panels on the page.
const MOST: usize = 4;

pub(super) fn chart(show: &Show<'_>) -> Option<Chart> {
    if show.fits.len() < 2 {
        return None;
    }
    let what = format!("variant {}, ρ of a level is a share of the level before", show.variant());
    let chart = show.chart(NAME, TITLE, &what).legend(fit::entries()).columns(2);
    let fits = show.fits.iter().take(MOST);
    Some(fits.fold(chart, |chart, (heading, of)| chart.panel(fit::small(of, heading))))
}
