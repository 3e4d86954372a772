//! Charts: valid images of the promised size, for ordinary and for degenerate runs.

use powergs_chart::Style;
use powergs_testkit::charts::covered;
use std::path::Path;

use powergs_chart::Chart;
use powergs_report::charts::all;
use powergs_study::run_record::Run;

use crate::builder;

/// All charts, in report order.
const ALL: [&str; 7] =
    ["energy", "cycles", "roofline", "buffers", "frame_time", "tiles", "tile_load"];

/// A drawn chart.
struct Drawn {
    name: &'static str,
    svg: String,
}

/// Draws all charts of `run` and leaves them in the target folder, to be looked at. Rasterising
/// takes most of a second each in this profile, so PNGs are made for the ordinary run only, or for
/// all with `RUN_SLOW_TESTS=1`.
fn draw(name: &str, run: &Run) -> Vec<Drawn> {
    let charts = all(run);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("charts").join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let rasterised = name == "garden" || std::env::var_os("RUN_SLOW_TESTS").is_some();
    charts.iter().map(|chart| check(name, &folder, chart, rasterised)).collect()
}

fn check(name: &str, folder: &Path, chart: &Chart, rasterised: bool) -> Drawn {
    assert_eq!(covered(chart), Vec::<String>::new(), "{name}");
    let svg = chart.svg(Style::default()).expect("SVG");
    for nonsense in ["NaN", "inf", "-0"] {
        assert!(!svg.contains(&format!(">{nonsense}")), "{name}/{}", chart.name);
    }
    std::fs::write(folder.join(format!("{}.svg", chart.name)), &svg).expect("written");
    if rasterised {
        let png = chart.png(Style::default()).expect("PNG");
        std::fs::write(folder.join(format!("{}.png", chart.name)), &png).expect("written");
        let limits = powergs_pixels::Limits { side: 1920, bytes: 1 << 24 };
        let image = powergs_pixels::decode(&png, limits).expect("a PNG");
        // Pages of pictures are as high as those.
        let high = if chart.name == "tile_load" { 500..=1080 } else { 1080..=1080 };
        let size = (image.width, high.contains(&image.height));
        assert_eq!(size, (1920, true), "{name}/{}: {}", chart.name, image.height);
        let mut colours = image.rgba8();
        colours.sort_unstable();
        colours.dedup();
        assert!(colours.len() > 30, "{name}/{} is nearly empty", chart.name);
    }
    Drawn { name: chart.name, svg }
}

fn names(charts: &[Drawn]) -> Vec<&str> {
    charts.iter().map(|c| c.name).collect()
}

#[test]
fn ordinary_run_has_all_charts() {
    let charts = draw("garden", &builder::garden());
    assert_eq!(names(&charts), ALL);
    for chart in &charts {
        assert!(chart.svg.contains("garden on gscore"), "{}", chart.name);
        assert!(!chart.svg.contains("INCOMPLETE"));
    }
    assert!(charts[0].svg.contains("preprocessing") && charts[0].svg.contains("display"));
    assert!(charts[4].svg.contains("deadline 16.7 ms"));
}

#[test]
fn paper_model_has_no_charts_of_time() {
    let charts = draw("paper", &builder::paper());
    assert_eq!(names(&charts), ["energy", "tiles", "tile_load"]);
    assert!(!charts[0].svg.contains("standby"), "nothing is paid for time");
}

#[test]
fn interrupted_run_says_so_on_every_chart() {
    let mut run = builder::run(&[4.0, 4.1, 3.9]);
    run.facts.trace.frames = 24;
    for chart in draw("incomplete", &run) {
        assert!(chart.svg.contains("INCOMPLETE: 3 of 24 frames"), "{}", chart.name);
    }
}

#[test]
fn one_frame() {
    let mut run = builder::run(&[2.5]);
    run.tiles = Some(builder::tiles(300, 900, 64));
    assert_eq!(draw("one", &run).len(), 7);
}

#[test]
fn all_zero_and_long_names() {
    let mut run = builder::run(&[0.0, 0.0]);
    run.facts.trace.name = "an absurdly long <name> & with \"signs\" in it, ".repeat(8);
    for frame in &mut run.frames {
        frame.standby = Default::default();
        frame.display_w = None;
    }
    if let Some(tiles) = &mut run.tiles {
        tiles.entries.iter_mut().for_each(|n| *n = 0);
        tiles.picture = None;
    }
    let charts = draw("zero", &run);
    assert!(charts.iter().all(|c| !c.svg.contains("<name>")), "text is escaped");
}

#[test]
fn huge_range_and_far_deadline() {
    let wide: Vec<f64> = (0..12).map(|i| 0.002 * 3.1f64.powi(i)).collect();
    draw("wide", &builder::run(&wide));
    let charts = draw("fast", &builder::run(&[0.30, 0.35, 0.31]));
    assert!(charts[4].svg.contains("above this chart"));
}

#[test]
fn two_thousand_frames() {
    let noise = |i: usize| 3.0 + ((i * 7919) % 1000) as f64 / 800.0 + 14.0 * f64::from(i % 97 == 5);
    let run = builder::run(&(0..2000).map(noise).collect::<Vec<_>>());
    let charts = draw("long", &run);
    assert!(charts[4].svg.len() < 200_000, "{} bytes of SVG", charts[4].svg.len());
}
