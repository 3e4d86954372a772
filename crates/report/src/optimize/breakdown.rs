//! Where the power goes before and after: a bar per model, rendering by stage, and the display.

use super::Story;
use crate::format::{engineering, watt_unit};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale};
use powergs_energy::action::Phase;
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::Role;

const NAME: &str = "breakdown";
const TITLE: &str = "Where the power goes";
const DISPLAY: Colour = Colour::SKY;

pub(super) fn chart(story: &Story<'_>) -> Option<Chart> {
    let is_shown = |o: &&Outcome| {
        let other = matches!(o.role, Role::Dense | Role::Baseline(_) | Role::External(_));
        other || story.is_result(o)
    };
    let shown: Vec<&Outcome> = story.done.iter().filter(is_shown).collect();
    if shown.len() < 2 {
        return None;
    }
    let entries = Phase::ALL.map(|s| Entry::fill(s.name(), stage_colour(s)));
    let what = format!("display {}", story.display);
    let chart = story.chart(NAME, TITLE, &what).panel(panel(story, &shown));
    Some(chart.legend(entries.into_iter().chain([Entry::fill("display", DISPLAY)])))
}

fn stage_colour(stage: Phase) -> Colour {
    match stage {
        Phase::Preprocessing => Colour::GREEN,
        Phase::Sorting => Colour::ORANGE,
        Phase::Rendering => Colour::VERMILION,
        Phase::Standby => Colour::GREY,
    }
}

fn panel(story: &Story<'_>, shown: &[&Outcome]) -> Panel {
    let highest = shown.iter().map(|o| o.watts.total_w()).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(highest);
    let bar = |(i, outcome): (usize, &&Outcome)| {
        let watts = &outcome.watts;
        let stage = |s| (watts.parts.stage_w(s), stage_colour(s));
        let all = Phase::ALL.map(stage).into_iter().chain([(watts.display_w, DISPLAY)]);
        let parts: Vec<Part> = all.map(|(w, colour)| Part::new(per_watt * w, colour)).collect();
        let sum = parts.iter().map(|p| p.value).sum::<f64>() / per_watt;
        Bar::new(i, parts).end(engineering(sum, "W"))
    };
    let name = |o: &&Outcome| story.label(o);
    let x = Axis::new(format!("power, {unit}"), Scale::from_zero(per_watt * highest)).ticks(8);
    Panel::new(x, Axis::names(shown.iter().map(name)))
        .mark(Mark::Bars(shown.iter().enumerate().map(bar).collect()))
}
