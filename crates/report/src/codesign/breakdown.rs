//! Where the watts went in (a) to (e): a stacked bar each.

use super::{tables, words};
use crate::format::{engineering, watt_unit};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Symbol, Words};
use powergs_codesign::Finished;
use powergs_codesign::compare::{Comparison, Found, Way};
use powergs_codesign::pricing::MachinePoint;

const NAME: &str = "breakdown";
const TITLE: &str = "Where the watts go";
const PARTS: [(&str, Colour); 5] = [
    ("preprocessing", Colour::GREEN),
    ("sorting", Colour::ORANGE),
    ("rendering", Colour::VERMILION),
    ("standby", Colour::GREY),
    ("display", Colour::SKY),
];

pub(super) fn chart(finished: &Finished) -> Chart {
    let most = finished.comparisons.iter().filter_map(Comparison::watts).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let found = finished.comparisons.iter().filter_map(|c| Some((c.way, c.found.as_ref().ok()?)));
    let found: Vec<(Way, &Found)> = found.collect();
    let bar = |(row, (_, found)): (usize, &(Way, &Found))| {
        let price = &found.confirmed;
        let watts = price.stages_w.into_iter().chain([price.display_w]);
        let parts = watts.zip(PARTS).map(|(w, (_, colour))| Part::new(per_watt * w, colour));
        Bar::new(row, parts.collect()).end(engineering(price.total_w, "W"))
    };
    let name = |(way, found): &(Way, &Found)| {
        Words::from(format!("({}) {}", way.letter(), words::pair(finished, found.pair)))
    };
    let x = Axis::new(
        format!("power at {} Hz, {unit}", finished.about.fps),
        Scale::from_zero(per_watt * most),
    )
    .ticks(8);
    let panel = Panel::new(x, Axis::names(found.iter().map(name)))
        .mark(Mark::Bars(found.iter().enumerate().map(bar).collect()));
    let about = format!("{}, display {}", finished.about.scene, finished.about.display);
    let machine = |point: MachinePoint| {
        let name = words::name(finished, point);
        let text = format!("{}: {name}", words::machine(finished, point));
        (!name.is_empty()).then(|| Entry::new(text, Symbol::None))
    };
    let machines: Vec<Entry> = tables::found(finished).into_iter().filter_map(machine).collect();
    Chart::new(NAME, TITLE, about)
        .legend(PARTS.map(|(name, colour)| Entry::fill(name, colour)))
        .legend(machines)
        .panel(panel)
}
