//! Pictures, scenes and traces.

use super::{Term, term};

pub(super) const PICTURES: &[Term] = &[
    term(
        &["red_w", "green_w", "blue_w", "static_w"],
        "W",
        "Parts of the display power: the light of a channel, and what the panel takes for black.",
    ),
    term(&["MSE"], "", "Mean squared error of sRGB values from 0 to 1."),
];

pub(super) const INPUTS: &[Term] = &[
    term(&["survivors of culling"], "", "Splats that are in front of the camera and in the image."),
    term(&["visible"], "", "Splats of a frame that survive culling and overlap a tile."),
    term(&["B/splat", "bytes a visible splat"], "B", "Bytes in the trace file per visible splat."),
    term(&["B/pixel", "bytes a pixel"], "B", "Bytes in the trace file per pixel."),
    term(&["other B"], "B", "Bytes of a frame that are neither splats nor pixels."),
    term(
        &["SH degree"],
        "",
        "Degree of the spherical harmonics of the colour, 0 to 3: 1, 4, 9 or 16 coefficients a \
         channel.",
    ),
];
