//! Watts against area: every pair, the front, and what the five ways find.

use super::{colour, words};
use crate::format::watt_unit;
use powergs_chart::{
    Axis, Chart, Colour, Entry, Form, Line, Panel, Place, Points, Rule, Scale, Side, Size, Symbol,
};
use powergs_codesign::Finished;
use powergs_codesign::compare::{Comparison, Pair, Way};
use powergs_codesign::pricing::{Fate, Price};

const NAME: &str = "front";
const TITLE: &str = "Models and machines together";
const PAIR: Colour = Colour(190, 200, 210);
/// Areas shown beyond the budget, as a share of it.
const BEYOND: f64 = 1.6;
/// Shares of the axes, across and up, below which two large dots touch.
const TOUCH: (f64, f64) = (0.02, 0.04);

pub(super) fn chart(finished: &Finished) -> Chart {
    let budget = finished.budget;
    let (mut cloud, mut most) = (Vec::new(), 0.0_f64);
    for row in &finished.rows {
        for fate in row.pairs.values() {
            let Fate::Priced(prices) = fate else { continue };
            let price = &prices[0][0];
            let is_shown = |area: &f64| *area <= BEYOND * budget.area_mm2;
            let Some(area) = price.area_mm2.filter(is_shown) else { continue };
            if price.frame_ms <= budget.frame_ms {
                cloud.push((area, price.total_w));
                most = most.max(price.total_w);
            }
        }
    }
    let (per_watt, unit) = watt_unit(most);
    let place = |price: &Price| Some((price.area_mm2?, per_watt * price.total_w));
    let front = finished.front.iter().filter_map(|pair| place(finished.price(*pair)?));
    let mut front: Vec<(f64, f64)> =
        front.filter(|(area, _)| *area <= BEYOND * budget.area_mm2).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The front is one of three numbers; the line is that of the two shown.
    let mut least = f64::INFINITY;
    front.retain(|(_, watts)| {
        let is_less = *watts < least;
        least = least.min(*watts);
        is_less
    });
    let cloud = cloud.into_iter().map(|(area, watts)| (area, per_watt * watts));
    let cloud: Vec<(f64, f64)> = cloud.collect();
    let x = Scale::around(cloud.iter().map(|p| p.0).chain([budget.area_mm2]), 0.06);
    let y = Scale::around(cloud.iter().map(|p| p.1), 0.06);
    let crowd = Points {
        points: cloud.iter().map(|p| (*p, PAIR)).collect(),
        form: Form::Dot,
        size: Size::Small,
        ring: None,
        crowd: true,
    };
    let mut panel = Panel::new(
        Axis::new("area, mm²", x.clone()).ticks(8),
        Axis::new(format!("display, rendering and standby, {unit}"), y.clone()),
    )
    .points(crowd)
    .dashed(Rule::X(budget.area_mm2), Colour::NOTE);
    let mut entries = vec![Entry::new("pair that keeps the deadline", Symbol::Dot(PAIR))];
    // One pair may be the best in both: a front of a single point has no line.
    if front.len() > 1 {
        panel = panel.line(Line::curve(staircase(&front), Colour::BLUE));
        entries.push(Entry::new("front of these two", Symbol::Line(Colour::BLUE)));
    }
    entries.push(Entry::new("area to keep to", Symbol::Dashed(Colour::NOTE)));
    let found = found(finished, &place);
    for Winner { ways, at } in &found {
        let dot = Points::dots([*at], shade(ways), size(ways));
        panel = panel.points(Points { ring: Some(Colour::PAPER), ..dot });
    }
    for (ways, at) in together(&found, &x, &y) {
        let letters = words::letters(ways.iter().map(|way| way.letter()));
        panel = panel.label(letters, at, Side::Free);
    }
    let mut chosen: Vec<(Way, Colour)> = Vec::new();
    for Winner { ways, .. } in &found {
        chosen.extend(ways.iter().map(|way| (*way, shade(ways))));
    }
    chosen.sort_by_key(|(way, _)| *way);
    let chosen = chosen.into_iter().map(|(way, colour)| {
        Entry::new(format!("({}) {}", way.letter(), way.words()), Symbol::Dot(colour))
    });
    let about = format!(
        "{}: {} models, calibrated DRAM, at {} Hz",
        finished.about.scene,
        finished.models.len(),
        finished.about.fps
    );
    Chart::new(NAME, TITLE, about).legend(entries).legend(chosen.collect::<Vec<_>>()).panel(panel)
}

/// A pair that ways find.
struct Winner {
    ways: Vec<Way>,
    at: Place,
}

/// The pairs that the five ways find, in the order of the first way that does.
fn found(finished: &Finished, place: &dyn Fn(&Price) -> Option<Place>) -> Vec<Winner> {
    let mut found: Vec<(Pair, Winner)> = Vec::new();
    for Comparison { way, found: one } in &finished.comparisons {
        let Ok(one) = one else { continue };
        let Some(at) = place(&one.calibrated) else { continue };
        match found.iter_mut().find(|(pair, _)| *pair == one.pair) {
            Some((_, winner)) => winner.ways.push(*way),
            None => found.push((one.pair, Winner { ways: vec![*way], at })),
        }
    }
    found.into_iter().map(|(_, winner)| winner).collect()
}

/// The letters that one label has: those of pairs whose dots touch are together, at the last.
fn together(found: &[Winner], x: &Scale, y: &Scale) -> Vec<(Vec<Way>, Place)> {
    let touch = |a: Place, b: Place| {
        let along = (x.share(a.0) - x.share(b.0)).abs() < TOUCH.0;
        along && (y.share(a.1) - y.share(b.1)).abs() < TOUCH.1
    };
    let mut labels: Vec<(Vec<Way>, Place)> = Vec::new();
    for Winner { ways, at } in found {
        match labels.iter_mut().find(|(_, there)| touch(*there, *at)) {
            Some(label) => {
                label.0.extend(ways);
                label.1 = *at;
            }
            None => labels.push((ways.clone(), *at)),
        }
    }
    labels.iter_mut().for_each(|(ways, _)| ways.sort_unstable());
    labels
}

/// The colour of a pair: that of the last way that finds it.
fn shade(ways: &[Way]) -> Colour {
    ways.last().map_or(PAIR, |way| colour(*way))
}

fn size(ways: &[Way]) -> Size {
    if ways.contains(&Way::Joint) { Size::Huge } else { Size::Large }
}

/// The corners of what can be had: as much area buys no less than the pair before it.
fn staircase(front: &[Place]) -> Vec<Place> {
    let corners = front.windows(2).flat_map(|two| [(two[1].0, two[0].1), two[1]]);
    front.first().copied().into_iter().chain(corners).collect()
}
