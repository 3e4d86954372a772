//! Colours of charts in pages that may be dark: those with a name have a second value, and colours
//! of a scale, whose values are read off, never have one.

use std::fmt::Write;

use crate::Colour;
use crate::render::scene::Rgb;

/// A colour in the dark.
struct DarkColour {
    light: Colour,
    /// Of lines and areas.
    mark: Colour,
    /// Of letters, which need more contrast.
    text: Colour,
}

const fn dark(light: Colour, mark: Colour, text: Colour) -> DarkColour {
    DarkColour { light, mark, text }
}

/// The second list of values, for a page of `#16181b`. Colours that are not in it stay.
const DARK: [DarkColour; 13] = [
    dark(Colour::INK, Colour(230, 230, 230), Colour(230, 230, 230)),
    dark(Colour::NOTE, Colour(169, 169, 169), Colour(169, 169, 169)),
    dark(Colour::GRID, Colour(58, 61, 66), Colour(169, 169, 169)),
    dark(Colour::PAPER, Colour(22, 24, 27), Colour(22, 24, 27)),
    dark(Colour::PALE, Colour(95, 100, 108), Colour(169, 169, 169)),
    dark(Colour::GREY, Colour(143, 149, 156), Colour(169, 169, 169)),
    dark(Colour::NAVY, Colour(70, 135, 190), Colour(120, 180, 230)),
    dark(Colour::INDIGO, Colour(124, 108, 214), Colour(176, 164, 245)),
    dark(Colour::BLUE, Colour::BLUE, Colour(108, 182, 234)),
    dark(Colour::GREEN, Colour::GREEN, Colour(47, 199, 154)),
    dark(Colour::PINE, Colour::PINE, Colour(47, 181, 143)),
    dark(Colour::VERMILION, Colour::VERMILION, Colour(255, 138, 61)),
    dark(Colour::PURPLE, Colour::PURPLE, Colour(224, 163, 198)),
];

/// The outline of dots, which has none in the light: some dots of a scale are as dark as the page.
const DOT_EDGE: &str = "--chart-dot";

/// Where the colours of an SVG come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SchemeColours {
    /// They are in it: for files.
    Fixed,
    /// Those with a name follow the page.
    OfPage,
}

impl SchemeColours {
    /// A colour of lines and areas.
    pub(crate) fn mark(self, (r, g, b): Rgb) -> String {
        self.written("m", Colour(r, g, b))
    }

    /// A colour of letters.
    pub(crate) fn text(self, (r, g, b): Rgb) -> String {
        self.written("t", Colour(r, g, b))
    }

    /// The attribute that outlines a dot; nothing in files.
    pub(crate) fn dot(self) -> String {
        match self {
            SchemeColours::Fixed => String::new(),
            SchemeColours::OfPage => format!(" stroke=\"var({DOT_EDGE},none)\""),
        }
    }

    fn written(self, kind: &str, colour: Colour) -> String {
        let own = hex(colour);
        let is_named = DARK.iter().any(|dark| dark.light == colour);
        match self {
            SchemeColours::OfPage if is_named => format!("var({},{own})", variable(kind, colour)),
            SchemeColours::OfPage | SchemeColours::Fixed => own,
        }
    }
}

fn hex(Colour(r, g, b): Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn variable(kind: &str, Colour(r, g, b): Colour) -> String {
    format!("--chart-{kind}{r:02x}{g:02x}{b:02x}")
}

/// The declarations of a dark page for charts from [`Chart::page_svg`](crate::Chart::page_svg).
pub fn dark_declarations() -> String {
    let mut out = format!("{DOT_EDGE}: #8f959c;");
    for DarkColour { light, mark, text } in &DARK {
        for (kind, value) in [("m", mark), ("t", text)] {
            let _ = write!(out, " {}: {};", variable(kind, *light), hex(*value));
        }
    }
    out
}
