//! A strip of images: the dense model, the optimised one, their difference, and what each channel
//! lost.

use powergs_pixels::RgbImage;

use super::Story;
use powergs_chart::{Chart, Colour, Columns, Panel, Words};
use powergs_optimize::pictures::BeforeAfter;

pub(super) const NAME: &str = "strip";
const TITLE: &str = "Before and after";
/// Differences are shown this many times as large.
const GAIN: f32 = 8.0;

fn pixels(strip: &BeforeAfter) -> impl Iterator<Item = ([f32; 3], [f32; 3])> {
    let colour = |p: &[u8; 3]| p.map(f32::from);
    let (dense, ours) = (strip.dense.as_chunks().0, strip.ours.as_chunks().0);
    dense.iter().zip(ours).map(move |(a, b)| (colour(a), colour(b)))
}

pub(super) fn chart(story: &Story<'_>) -> Option<Chart> {
    let strip = story.strip.as_ref()?;
    let what = format!("view {}", super::shortened(&strip.view, 40));
    let code = |v: f32| v.clamp(0.0, 255.0).round() as u8;
    let distance = |a: [f32; 3], b: [f32; 3]| {
        let d = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        [code(GAIN * d); 3]
    };
    let change =
        |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|c| code(128.0 + GAIN * (b[c] - a[c])));
    type Look<'a> = &'a dyn Fn([f32; 3], [f32; 3]) -> [u8; 3];
    let looks: [(String, Look<'_>); 4] = [
        ("dense".into(), &|a, _| a.map(code)),
        (strip.name.clone(), &|_, b| b.map(code)),
        (format!("worst channel, x{GAIN}"), &distance),
        (format!("change, x{GAIN} (grey: none)"), &change),
    ];
    let mut chart = story.chart(NAME, TITLE, &what);
    chart.columns = Columns::Fitting;
    for (caption, look) in looks {
        let pixels: Vec<u8> = pixels(strip).flat_map(|(a, b)| look(a, b)).collect();
        let image = RgbImage::from_bytes(strip.width, strip.height, pixels)?;
        chart = chart.panel(Panel::picture(image, caption));
    }
    chart.notes = vec![changes(strip)];
    Some(chart)
}

/// The pictures of both.
pub(super) fn pictures(story: &Story<'_>) -> Option<[RgbImage; 2]> {
    let strip = story.strip.as_ref()?;
    let image = |bytes: &[u8]| RgbImage::from_bytes(strip.width, strip.height, bytes.to_vec());
    Some([image(&strip.dense)?, image(&strip.ours)?])
}

/// Mean change of each channel.
fn changes(strip: &BeforeAfter) -> Vec<Words> {
    let mut parts = vec![Words::note("mean change, of 255 (grey above is none):")];
    let colours = [Colour::VERMILION, Colour::GREEN, Colour::BLUE];
    let names = ["red", "green", "blue"].into_iter().zip(strip.mean_change());
    let words = |((name, v), colour)| Words::new(format!("{name} {v:+.2}"), colour);
    parts.extend(names.zip(colours).map(words));
    parts
}
