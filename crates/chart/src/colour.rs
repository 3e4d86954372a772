//! Colours of charts.

/// An opaque colour: red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Colour(pub u8, pub u8, pub u8);

/// Colours that people with any common colour vision can tell apart (Okabe and Ito), and greys.
impl Colour {
    /// Text.
    pub const INK: Colour = Colour(34, 34, 34);
    /// Text that is less important, and axes.
    pub const NOTE: Colour = Colour(96, 96, 96);
    /// Grid lines.
    pub const GRID: Colour = Colour(222, 222, 222);
    /// The page.
    pub const PAPER: Colour = Colour(255, 255, 255);
    /// Blue.
    pub const BLUE: Colour = Colour(0, 114, 178);
    /// Dark blue.
    pub const NAVY: Colour = Colour(0, 62, 110);
    /// Sky blue.
    pub const SKY: Colour = Colour(86, 180, 233);
    /// Bluish green.
    pub const GREEN: Colour = Colour(0, 158, 115);
    /// A darker green, beside the other.
    pub const PINE: Colour = Colour(0, 120, 88);
    /// Orange.
    pub const ORANGE: Colour = Colour(230, 159, 0);
    /// Yellow.
    pub const YELLOW: Colour = Colour(240, 228, 66);
    /// Vermilion.
    pub const VERMILION: Colour = Colour(213, 94, 0);
    /// Reddish purple.
    pub const PURPLE: Colour = Colour(204, 121, 167);
    /// Indigo (Tol), the darkest.
    pub const INDIGO: Colour = Colour(51, 34, 136);
    /// Light grey, for what is not there.
    pub const PALE: Colour = Colour(221, 221, 221);
    /// Middle grey.
    pub const GREY: Colour = Colour(140, 140, 140);

    /// Colours of series that have no meaning of their own, told apart by most eyes.
    pub const SERIES: [Colour; 8] = [
        Colour::BLUE,
        Colour::ORANGE,
        Colour::GREEN,
        Colour::VERMILION,
        Colour::SKY,
        Colour::PURPLE,
        Colour::INDIGO,
        Colour::YELLOW,
    ];

    /// Dark text on a colour that is the same in the light and in the dark.
    const ON_LIGHT: Colour = Colour(33, 33, 33);
    /// Light text on such a colour.
    const ON_DARK: Colour = Colour(254, 254, 254);

    /// The colour of text on this one, which goes with it into the dark.
    pub(crate) fn text(self) -> Colour {
        if [Colour::PAPER, Colour::PALE, Colour::GRID].contains(&self) {
            return Colour::INK;
        }
        let Colour(r, g, b) = self;
        let [r, g, b] = [r, g, b].map(f64::from);
        if 0.299 * r + 0.587 * g + 0.114 * b > 125.0 { Colour::ON_LIGHT } else { Colour::ON_DARK }
    }

    /// The outline of a mark of this colour that stands out from the page three to one, as WCAG 2.1
    /// asks of graphics; `None` where the colour itself does.
    pub(crate) fn edge(self) -> Option<Colour> {
        const CONTRAST: f64 = 3.0;
        let on_paper = |colour: Colour| 1.05 / (colour.luminance() + 0.05);
        let darker = |share: f64| {
            let Colour(r, g, b) = self;
            let [r, g, b] = [r, g, b].map(|part| (f64::from(part) * share).round() as u8);
            Colour(r, g, b)
        };
        let mut steps = (0..20).map(|step| darker(1.0 - 0.05 * f64::from(step)));
        let edge = steps.find(|colour| on_paper(*colour) >= CONTRAST)?;
        (edge != self).then_some(edge)
    }

    /// Relative luminance, 0 to 1 (WCAG 2.1).
    fn luminance(self) -> f64 {
        let Colour(r, g, b) = self;
        let linear = |part: u8| {
            let part = f64::from(part) / 255.0;
            if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
    }

    /// The colour at a share from 0 to 1 of a scale from dark to light in equal steps of
    /// brightness, for any colour vision (viridis).
    pub fn at(share: f64) -> Colour {
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
        let place = share * (STOPS.len() - 1) as f64;
        let i = (place as usize).min(STOPS.len() - 2);
        let part = place - i as f64;
        let (a, b) = (STOPS[i], STOPS[i + 1]);
        let mix =
            |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
        Colour(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
    }
}

const STOPS: [Colour; 7] = [
    Colour(68, 1, 84),
    Colour(68, 58, 131),
    Colour(49, 104, 142),
    Colour(33, 145, 140),
    Colour(53, 183, 121),
    Colour(143, 215, 68),
    Colour(240, 220, 40),
];
