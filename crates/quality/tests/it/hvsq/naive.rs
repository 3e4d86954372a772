//! HVSQ straight from its definition, in double precision: every step on whole maps.

use powergs_base::picture::Picture;

/// A map, row-major.
#[derive(Clone)]
struct Map {
    width: usize,
    height: usize,
    values: Vec<f64>,
}

/// Three channels of a picture.
#[derive(Clone)]
pub struct Image([Map; 3]);

impl Image {
    pub fn of(picture: &Picture) -> Image {
        Image([0, 1, 2].map(|c| Map {
            width: picture.width as usize,
            height: picture.height as usize,
            values: picture.pixels.iter().map(|p| f64::from(p[c])).collect(),
        }))
    }

    pub fn add(&mut self, direction: &Picture, scale: f64) {
        for (c, map) in self.0.iter_mut().enumerate() {
            for (v, d) in map.values.iter_mut().zip(&direction.pixels) {
                *v += scale * f64::from(d[c]);
            }
        }
    }
}

impl Map {
    fn made(width: usize, height: usize, value: impl Fn(usize, usize) -> f64) -> Map {
        let values = (0..width * height).map(|i| value(i % width, i / width)).collect();
        Map { width, height, values }
    }

    fn at(&self, x: usize, y: usize) -> f64 {
        self.values[y * self.width + x]
    }

    fn zip(&self, other: &Map, f: impl Fn(f64, f64) -> f64) -> Map {
        Map::made(self.width, self.height, |x, y| f(self.at(x, y), other.at(x, y)))
    }

    fn correlated(&self, filter: &[[f64; 5]; 5]) -> Map {
        let inside = |at: i64, n: usize| {
            let last = n as i64 - 1;
            let at = at.abs();
            (if at > last { 2 * last - at } else { at }) as usize
        };
        Map::made(self.width, self.height, |x, y| {
            let mut sum = 0.0;
            for (dy, row) in filter.iter().enumerate() {
                for (dx, weight) in row.iter().enumerate() {
                    let at_x = inside(x as i64 + dx as i64 - 2, self.width);
                    let at_y = inside(y as i64 + dy as i64 - 2, self.height);
                    sum += weight * self.at(at_x, at_y);
                }
            }
            sum
        })
    }

    fn halved(&self) -> Map {
        Map::made(self.width / 2, self.height / 2, |x, y| {
            let of = |dx, dy| self.at(2 * x + dx, 2 * y + dy);
            (of(0, 0) + of(1, 0) + of(0, 1) + of(1, 1)) / 4.0
        })
    }

    fn resized(&self, width: usize, height: usize) -> Map {
        let place = |i: usize, n: usize, full: usize| {
            let at = ((i as f64 + 0.5) * n as f64 / full as f64 - 0.5).max(0.0);
            let low = (at as usize).min(n - 1);
            (low, (low + 1).min(n - 1), at - low as f64)
        };
        Map::made(width, height, |x, y| {
            let (x0, x1, wx) = place(x, self.width, width);
            let (y0, y1, wy) = place(y, self.height, height);
            let row = |y| self.at(x0, y) * (1.0 - wx) + self.at(x1, y) * wx;
            row(y0) * (1.0 - wy) + row(y1) * wy
        })
    }

    fn pooled(&self, q: f64) -> Map {
        let count = |n: usize| ((n as f64 * (1.0 / q)).floor() as usize).max(1);
        let (columns, rows) = (count(self.width), count(self.height));
        let cell = |i: usize, n: usize, count: usize| i * n / count..((i + 1) * n).div_ceil(count);
        let coarse = Map::made(columns, rows, |x, y| {
            let (xs, ys) = (cell(x, self.width, columns), cell(y, self.height, rows));
            let n = (xs.len() * ys.len()) as f64;
            ys.flat_map(|y| xs.clone().map(move |x| (x, y)))
                .map(|(x, y)| self.at(x, y))
                .sum::<f64>()
                / n
        });
        coarse.resized(self.width, self.height)
    }

    fn statistics(&self, q: f64) -> [Map; 2] {
        let mean = self.pooled(q);
        let square = self.zip(self, |a, b| a * b).pooled(q);
        let deviation = square.zip(&mean, |s, m| (s - m * m).max(1e-7).sqrt());
        [mean, deviation]
    }
}

type Filter = [[f64; 5]; 5];

/// A filter from its first three rows; the others are their point reflections times `sign`.
fn whole(rows: [[f64; 5]; 3], sign: f64) -> Filter {
    let turned = |row: [f64; 5]| std::array::from_fn(|i| sign * row[4 - i]);
    [rows[0], rows[1], rows[2], turned(rows[1]), turned(rows[0])]
}

fn transposed(f: Filter) -> Filter {
    std::array::from_fn(|y| std::array::from_fn(|x| f[x][y]))
}

fn mirrored(f: Filter) -> Filter {
    f.map(|row| std::array::from_fn(|x| row[4 - x]))
}

/// Low-pass, high-pass and the six bands.
fn filters() -> (Filter, Filter, [Filter; 6]) {
    let low = whole(
        [
            [0.00341614, -0.01551246, -0.03848215, -0.01551246, 0.00341614],
            [-0.01551246, 0.05586982, 0.1592557, 0.05586982, -0.01551246],
            [-0.03848215, 0.1592557, 0.40304148, 0.1592557, -0.03848215],
        ],
        1.0,
    );
    let high = whole(
        [
            [-0.00290081, -0.00673482, -0.00981051, -0.00673482, -0.00290081],
            [-0.00673482, -0.07027679, -0.11435863, -0.07027679, -0.00673482],
            [-0.00981051, -0.11435863, 0.813802, -0.11435863, -0.00981051],
        ],
        1.0,
    );
    let b0 = whole(
        [
            [-0.00893064, -0.03075356, 0.0, 0.03075356, 0.00893064],
            [0.01189859, -0.08226445, 0.0, 0.08226445, -0.01189859],
            [0.02755155, -0.11732297, 0.0, 0.11732297, -0.02755155],
        ],
        -1.0,
    );
    let b1 = whole(
        [
            [-0.01977507, 0.01486305, 0.04435647, -0.00853965, -0.01161195],
            [-0.04084211, -0.04819057, 0.09454202, 0.05394139, -0.03930573],
            [-0.00228219, -0.1222723, 0.0, 0.1222723, 0.00228219],
        ],
        -1.0,
    );
    let b2 = whole(
        [
            [0.01977507, 0.04084211, 0.00228219, -0.03930573, -0.01161195],
            [-0.01486305, 0.04819057, 0.1222723, 0.05394139, -0.00853965],
            [-0.04435647, -0.09454202, 0.0, 0.09454202, 0.04435647],
        ],
        -1.0,
    );
    let b3 = transposed(b0).map(|row| row.map(|v| -v));
    (low, high, [b0, b1, b2, b3, mirrored(b2), mirrored(b1)])
}

/// All 51 maps of a channel.
fn maps(channel: &Map, p: f64) -> Vec<Map> {
    let (low_pass, high_pass, bands) = filters();
    let mut maps = Vec::from(channel.correlated(&high_pass).statistics(p));
    let mut low = channel.correlated(&low_pass);
    for level in 0..4 {
        if level > 0 {
            low = low.halved();
        }
        for band in &bands {
            maps.extend(low.correlated(band).statistics(p / f64::from(1 << level)));
        }
    }
    maps.push(low.halved());
    maps
}

fn channels(image: &Image) -> [Map; 3] {
    let up = |n: usize| n.next_multiple_of(32);
    let [r, g, b] =
        [0, 1, 2].map(|c| image.0[c].resized(up(image.0[c].width), up(image.0[c].height)));
    let y = Map::made(r.width, r.height, |i, j| {
        0.299 * r.at(i, j) + 0.587 * g.at(i, j) + 0.114 * b.at(i, j)
    });
    let red = r.zip(&y, |r, y| 0.5 + 0.713 * (r - y));
    let blue = b.zip(&y, |b, y| 0.5 + 0.564 * (b - y));
    [y, red, blue]
}

pub fn hvsq(a: &Picture, b: &Picture, p: f64) -> f64 {
    hvsq_of(&Image::of(a), &Image::of(b), p)
}

pub fn hvsq_of(a: &Image, b: &Image, p: f64) -> f64 {
    let (a, b) = (channels(a), channels(b));
    let mut total = 0.0;
    for (a, b) in a.iter().zip(&b) {
        for (a, b) in maps(a, p).iter().zip(&maps(b, p)) {
            let square: f64 = a.zip(b, |a, b| (a - b) * (a - b)).values.iter().sum();
            total += square / (3 * a.values.len()) as f64;
        }
    }
    total / 51.0
}
