//! Colour spaces of FLIP: linear sRGB, YCxCz (CIELAB without its cube root), Hunt-adjusted CIELAB.

/// Linear sRGB to CIE XYZ.
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The inverse of [`TO_XYZ`].
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_232_976_358, -1.537_398_969_488_785, -0.498_615_881_996_363],
    [-0.969_224_252_202_516_4, 1.875_929_983_695_176, 0.041_554_226_340_084_76],
    [0.055_639_419_851_975_46, -0.204_011_206_123_910_6, 1.057_148_977_187_533],
];

/// XYZ of white: the sums of the rows of [`TO_XYZ`].
const WHITE: [f64; 3] = [
    (10_135_552.0 + 8_788_810.0 + 4_435_075.0) / 24_577_794.0,
    1.0,
    (1_425_312.0 + 8_788_810.0 + 70_074_185.0) / 73_733_382.0,
];

fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ relative to white.
fn relative(rgb: [f32; 3]) -> [f64; 3] {
    let xyz = times(&TO_XYZ, rgb.map(f64::from));
    std::array::from_fn(|i| xyz[i] / WHITE[i])
}

/// YCxCz of a linear colour.
pub fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)].map(|v| v as f32)
}

/// The linear colour of YCxCz.
pub fn linear_rgb(space: [f32; 3]) -> [f32; 3] {
    let [l, cx, cz] = space.map(f64::from);
    let y = (l + 16.0) / 116.0;
    let xyz = [(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]];
    times(&FROM_XYZ, xyz).map(|v| v as f32)
}

/// CIELAB of a linear colour, chroma scaled by lightness: dark colours differ less (Hunt).
pub(crate) fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let [x, y, z] = relative(rgb).map(|t| {
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    });
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)].map(|v| v as f32)
}
