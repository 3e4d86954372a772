//! What was once wrong, a test each, named after it.

use powergs_chart::{
    Axis, Bar, Beside, Chart, Colour, Mark, Panel, Part, Scale, Style, Words, dark_declarations,
};
use powergs_pixels::RgbImage;

/// A picture in the colours of a scale, with that scale next to it, and a bar with text on it.
fn heat_map() -> Chart {
    let Colour(r, g, b) = Colour::at(0.25);
    let tiles = RgbImage::from_fn(4, 4, |_, _| [r, g, b]);
    let labels = vec![(0.0, "0".to_owned()), (1.0, "800".to_owned())];
    let part = Part { value: 1.0, colour: Colour::ORANGE, label: "inside".into() };
    let bars = Panel::new(Axis::new("", Scale::from_zero(1.0)), Axis::names(["a"]))
        .mark(Mark::Bars(vec![Bar::new(0, vec![part])]))
        .heading(Words::bold("a heading"));
    Chart::new("heat", "Heat", "of tiles")
        .panel(Panel::mosaic(tiles, "tiles"))
        .panel(bars)
        .beside(Beside::Scale { title: "list length".into(), labels })
}

fn hex(Colour(r, g, b): Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// In the dark a filter turned the bar of colours round, and left the picture as it was.
#[test]
fn a_scale_of_colours_is_the_same_in_every_page() {
    let chart = heat_map();
    let page = chart.page_svg(Style::default()).expect("drawn");
    let file = chart.svg(Style::default()).expect("drawn");
    // Every band of the bar has its own value in a page as in a file, and never a name.
    let bands: Vec<String> =
        (0..50).map(|i| hex(Colour::at((f64::from(i) + 0.5) / 50.0))).collect();
    let declared = dark_declarations();
    for band in bands {
        let fill = format!("fill=\"{band}\"");
        assert!(file.contains(&fill) && page.contains(&fill), "{band}");
        assert!(!declared.contains(&band), "{band} has a second value");
    }
}

#[test]
fn text_lines_and_paper_follow_the_page() {
    let chart = heat_map();
    let page = chart.page_svg(Style::default()).expect("drawn");
    assert!(page.contains("fill=\"var(--chart-t222222,#222222)\">a heading<"), "{page}");
    assert!(page.contains("fill=\"var(--chart-mffffff,#ffffff)\""), "the paper");
    // Letters on a colour that stays do not turn with the page.
    assert!(page.contains("fill=\"#212121\">inside<"), "{page}");
    let file = chart.svg(Style::default()).expect("drawn");
    assert!(!file.contains("var("), "a file has its colours in it");
    // Whatever is named is declared for dark pages.
    let declared = dark_declarations();
    for name in page.split("var(").skip(1).filter_map(|rest| rest.split([',', ')']).next()) {
        assert!(declared.contains(&format!("{name}: #")), "{name}");
    }
}
