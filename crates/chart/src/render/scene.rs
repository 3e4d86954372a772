//! A page as shapes: what plotters drew, in page units, before it becomes SVG, PNG or PDF.

use powergs_pixels::RgbImage;

use crate::Sheet;

/// A point of the page, units from its upper left corner.
pub type ScenePoint = (f64, f64);

/// An opaque colour.
pub type Rgb = (u8, u8, u8);

/// A rectangle: left, top, right, bottom, page units.
pub type Area = [f64; 4];

/// One thing on a page. Later shapes cover earlier ones.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A filled rectangle.
    Rectangle {
        /// Its place.
        area: Area,
        /// Its colour.
        fill: Rgb,
    },
    /// A line through points.
    Line {
        /// Its corners.
        points: Vec<ScenePoint>,
        /// Its colour.
        stroke: Rgb,
        /// Its width, page units.
        width: f64,
    },
    /// A filled polygon.
    Polygon {
        /// Its corners.
        points: Vec<ScenePoint>,
        /// Its colour.
        fill: Rgb,
    },
    /// A filled circle.
    Circle {
        /// Its centre.
        centre: ScenePoint,
        /// Its radius, page units.
        radius: f64,
        /// Its colour.
        fill: Rgb,
    },
    /// A line of text.
    Text(Text),
    /// A raster image.
    Image {
        /// Its place.
        area: Area,
        /// Its pixels.
        image: RgbImage,
        /// Whether they have sharp edges when they are shown large.
        sharp: bool,
    },
}

/// A line of text.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// The words.
    pub text: String,
    /// Left end of the base line; of text that reads upwards its lower end.
    pub start: ScenePoint,
    /// Width, page units.
    pub width: f64,
    /// Size of an em, page units.
    pub size: f64,
    /// Whether it is bold.
    pub bold: bool,
    /// Whether it reads upwards.
    pub upwards: bool,
    /// Its colour.
    pub fill: Rgb,
    /// Width of the white around the letters, so that lines below do not strike them through; 0
    /// for none, [`HALO`] for labels.
    pub halo: f64,
}

/// Width of the white around labels, page units.
pub const HALO: f64 = 4.0;

impl Text {
    /// The rectangle that its letters lie in.
    pub fn area(&self) -> Area {
        let (x, y) = self.start;
        let (above, below) = (0.76 * self.size, 0.22 * self.size);
        if self.upwards {
            [x - above, y - self.width, x + below, y]
        } else {
            [x, y - above, x + self.width, y + below]
        }
    }
}

/// A finished page.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Width and height, page units.
    pub size: (f64, f64),
    /// How large that is in print.
    pub sheet: Sheet,
    /// What it shows, for readers who do not see it.
    pub title: String,
    /// A line of context.
    pub description: String,
    /// From the lowest to the uppermost.
    pub shapes: Vec<Shape>,
    /// What marks say to a pointer, where a format can: the uppermost, at most [`HINTS`].
    pub hints: Vec<Hint>,
}

/// More marks than this are a crowd: nobody points at one of them, and a page stays small.
pub const HINTS: usize = 1000;

/// What a mark says to a pointer.
#[derive(Debug, Clone, PartialEq)]
pub struct Hint {
    /// Where.
    pub area: Area,
    /// Its name and its values.
    pub words: String,
}
