//! The top designs under every ranking: a line per design that rises and falls (a bump chart).

use super::words;
use crate::format::significant;
use powergs_chart::{
    Axis, Chart, Colour, Line, Panel, Place, Points, Scale, Side, Size, Weight, Words,
};
use powergs_study::analysis::Analysis;

const NAME: &str = "stability";
const TITLE: &str = "Do the top designs stay on top?";
/// Rankings in one chart besides the reference.
const MOST: usize = 8;
/// Lines in one chart.
const LINES: usize = 10;

/// Colours of the lines, the first the boldest.
const COLOURS: [Colour; LINES] = [
    Colour::VERMILION,
    Colour::BLUE,
    Colour::GREEN,
    Colour::ORANGE,
    Colour::PURPLE,
    Colour::SKY,
    Colour(120, 94, 40),
    Colour(70, 70, 150),
    Colour(150, 60, 80),
    Colour::GREY,
];

/// The chart; `None` without another ranking.
pub fn chart(analysis: &Analysis) -> Option<Chart> {
    let stability = &analysis.stability;
    if stability.alternatives.is_empty() || stability.top.len() < 2 {
        return None;
    }
    // What fits under a title; the page has it whole.
    let words = words::stability(analysis);
    let subtitle = words.split("; ").take(2).collect::<Vec<_>>().join("; ");
    Some(Chart::new(NAME, TITLE, subtitle).panel(panel(analysis)))
}

fn panel(analysis: &Analysis) -> Panel {
    let stability = &analysis.stability;
    let alternatives = &stability.alternatives[..stability.alternatives.len().min(MOST)];
    let top = &stability.top[..stability.top.len().min(LINES)];
    // Ranks 1 to `top`, then a band for what fell out.
    let lanes = top.len() + 1;
    let height = |rank: usize| rank.min(lanes) as f64 - 0.5;
    let coloured =
        |line: usize, text: String| Words { bold: true, ..Words::new(text, COLOURS[line]) };
    let label = |line: usize| analysis.table.label(top[line]);
    let mut names: Vec<Words> = (0..top.len())
        .map(|line| coloured(line, format!("{}  {}", label(line), line + 1)))
        .collect();
    names.push(Words::note(format!("not in top {}", top.len())));
    // Room for how many fell out.
    names.push(Words::note(""));
    let mut ticks = vec![(0.0, "reference".to_owned())];
    ticks.extend(alternatives.iter().enumerate().map(|(i, a)| {
        (i as f64 + 1.0, format!("τ {}", a.kendall.map_or("-".into(), significant)))
    }));
    let last = alternatives.len() as f64;
    let x = Axis::new("", Scale::linear(-0.15 * last.sqrt(), last + 0.05));
    let mut y = Axis::names(names);
    y.title = "rank by merit".into();
    let mut panel = Panel::new(x.labelled(ticks).plain(), y);
    let own = |label: &str| match label {
        "" | "own" => "machine file".to_owned(),
        label => label.to_owned(),
    };
    let heads = std::iter::once(own(&analysis.energy_table))
        .chain(alternatives.iter().map(|a| own(&a.label)));
    panel.over = heads.enumerate().map(|(i, head)| (i as f64, 1.0, Words::bold(head))).collect();
    for rank in 1..=lanes {
        let line = vec![(0.0, height(rank)), (last, height(rank))];
        panel = panel.line(Line { weight: Weight::Hair, ..Line::curve(line, Colour::GRID) });
    }
    for (i, alternative) in alternatives.iter().enumerate() {
        let fallen = alternative.ranks.iter().take(top.len()).flatten();
        let fallen = fallen.filter(|r| **r > top.len()).count();
        if fallen > 0 {
            let at = (i as f64 + 1.0, height(lanes));
            panel = panel.label(Words::note(format!("{fallen} of {}", top.len())), at, Side::Below);
        }
    }
    for line in (0..top.len()).rev() {
        let ranks = alternatives.iter().map(|a| a.ranks[line]);
        let ranks: Vec<Option<usize>> = std::iter::once(Some(line + 1)).chain(ranks).collect();
        let at = |(i, rank): (usize, &Option<usize>)| (i as f64, rank.map_or(f64::NAN, height));
        let points: Vec<Place> = ranks.iter().enumerate().map(at).collect();
        let (weight, size) =
            if line == 0 { (Weight::Bold, Size::Huge) } else { (Weight::Curve, Size::Large) };
        if let Some(&(_, end)) = points.last()
            && end < height(lanes)
        {
            panel.right.push((end, vec![coloured(line, label(line))]));
        }
        panel = panel
            .line(Line { weight, ..Line::curve(points.clone(), COLOURS[line]) })
            .points(Points::dots(points, COLOURS[line], size));
    }
    panel
}
