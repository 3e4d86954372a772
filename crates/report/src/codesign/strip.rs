//! The joint model beside the dense one.

use powergs_pixels::RgbImage;

use powergs_chart::{Chart, Columns, Panel};
use powergs_codesign::Finished;
use powergs_optimize::pictures::BeforeAfter;

const NAME: &str = "strip";
const TITLE: &str = "The dense model and the joint one";
/// Differences are shown this many times as large.
const GAIN: f32 = 8.0;

pub(super) fn chart(finished: &Finished, picture: &BeforeAfter) -> Option<Chart> {
    let (width, height) = (picture.width, picture.height);
    let image = |rgb: Vec<u8>| RgbImage::from_bytes(width, height, rgb);
    let change =
        |(a, b): (&u8, &u8)| (GAIN * (f32::from(*a) - f32::from(*b)).abs()).clamp(0.0, 255.0) as u8;
    let difference = picture.dense.iter().zip(&picture.ours).map(change).collect();
    let about = format!("{}, view {}", finished.about.scene, picture.view);
    let mut chart = Chart::new(NAME, TITLE, about)
        .panel(Panel::picture(image(picture.dense.clone())?, "dense"))
        .panel(Panel::picture(image(picture.ours.clone())?, picture.name.as_str()))
        .panel(Panel::picture(image(difference)?, format!("difference, ×{GAIN}")));
    chart.columns = Columns::Fitting;
    Some(chart)
}
