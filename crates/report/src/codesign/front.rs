//! Watts against area: every pair, the front, and what the five ways find.

use super::{colour, words};
use crate::format::watt_unit;
use powergs_chart::{
    Axis, Chart, Colour, Entry, Form, Line, Panel, Points, Rule, Scale, Side, Size, Symbol,
};
use powergs_codesign::Finished;
use powergs_codesign::compare::{Comparison, Pair, Way};
use powergs_codesign::pricing::{Fate, Price};

const NAME: &str = "front";
const TITLE: &str = "Models and machines together";
const PAIR: Colour = Colour(190, 200, 210);
/// Areas shown beyond the budget, as a share of it.
const BEYOND: f64 = 1.6;

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
        Axis::new("area, mm²", x).ticks(8),
        Axis::new(format!("display, rendering and standby, {unit}"), y),
    )
    .points(crowd)
    .dashed(Rule::X(budget.area_mm2), Colour::NOTE)
    .line(Line::curve(front, Colour::BLUE));
    let mut found: Vec<(Pair, Vec<Way>, (f64, f64))> = Vec::new();
    for Comparison { way, found: one } in &finished.comparisons {
        let Ok(one) = one else { continue };
        let Some(at) = place(&one.calibrated) else { continue };
        match found.iter_mut().find(|(pair, ..)| *pair == one.pair) {
            Some((_, ways, _)) => ways.push(*way),
            None => found.push((one.pair, vec![*way], at)),
        }
    }
    for (pair, ways, at) in found {
        let Some(&last) = ways.last() else { continue };
        let size = if last == Way::Joint { Size::Huge } else { Size::Large };
        let letters: Vec<String> = ways.iter().map(|way| format!("({})", way.letter())).collect();
        let label = format!("{} {}", letters.join(" "), words::pair(finished, pair));
        panel = panel.points(Points::dots([at], colour(last), size)).label(label, at, Side::Free);
    }
    let mut entries = vec![
        Entry::new("pair that keeps the deadline", Symbol::Dot(PAIR)),
        Entry::new("front", Symbol::Line(Colour::BLUE)),
        Entry::new("area to keep to", Symbol::Dashed(Colour::NOTE)),
    ];
    entries.extend(Way::ALL.map(|way| {
        Entry::new(format!("({}) {}", way.letter(), way.words()), Symbol::Dot(colour(way)))
    }));
    let about = format!(
        "{}: {} models, calibrated DRAM, at {} Hz",
        finished.about.scene,
        finished.models.len(),
        finished.about.fps
    );
    let (first, second) = entries.split_at(3);
    Chart::new(NAME, TITLE, about).legend(first.to_vec()).legend(second.to_vec()).panel(panel)
}
