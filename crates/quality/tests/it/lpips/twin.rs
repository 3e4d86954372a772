//! The definition word for word, in double precision.

use powergs_base::picture::Picture;
use powergs_testkit::lpips::{Layer, Made};

/// Planes of one size.
struct Planes {
    width: usize,
    height: usize,
    planes: Vec<Vec<f64>>,
}

impl Planes {
    fn of(picture: &Picture) -> Planes {
        let shift = [-0.030, -0.088, -0.188];
        let scale = [0.458, 0.448, 0.450];
        let plane = |c: usize| {
            let value = |p: &[f32; 3]| (2.0 * f64::from(p[c]) - 1.0 - shift[c]) / scale[c];
            picture.pixels.iter().map(value).collect()
        };
        let (width, height) = (picture.width as usize, picture.height as usize);
        Planes { width, height, planes: (0..3).map(plane).collect() }
    }

    fn pooled(&self, side: usize) -> Planes {
        let (width, height) = ((self.width - side) / 2 + 1, (self.height - side) / 2 + 1);
        let pool = |plane: &Vec<f64>| {
            let mut out = Vec::new();
            for y in 0..height {
                for x in 0..width {
                    let all = (0..side * side)
                        .map(|i| plane[(2 * y + i / side) * self.width + 2 * x + i % side]);
                    out.push(all.fold(f64::NEG_INFINITY, f64::max));
                }
            }
            out
        };
        Planes { width, height, planes: self.planes.iter().map(pool).collect() }
    }

    fn convolved(&self, l: &Layer, weights: &[f32], bias: &[f32]) -> Planes {
        let size = |n: usize| (n + 2 * l.pad - l.side) / l.stride + 1;
        let (width, height) = (size(self.width), size(self.height));
        let mut planes = Vec::new();
        for (o, bias) in bias.iter().enumerate() {
            let mut plane = vec![f64::from(*bias); width * height];
            for (i, input) in self.planes.iter().enumerate() {
                for k in 0..l.side * l.side {
                    let weight = f64::from(weights[(o * l.inputs + i) * l.side * l.side + k]);
                    for (at, out) in plane.iter_mut().enumerate() {
                        let y = (at / width * l.stride + k / l.side).wrapping_sub(l.pad);
                        let x = (at % width * l.stride + k % l.side).wrapping_sub(l.pad);
                        if y < self.height && x < self.width {
                            *out += weight * input[y * self.width + x];
                        }
                    }
                }
            }
            planes.push(plane.into_iter().map(|v| v.max(0.0)).collect());
        }
        Planes { width, height, planes }
    }

    fn unit(&self, at: usize) -> Vec<f64> {
        let length = self.planes.iter().map(|p| p[at] * p[at]).sum::<f64>().sqrt();
        self.planes.iter().map(|p| p[at] / (length + 1e-10)).collect()
    }
}

pub fn distance(layers: &[Layer], made: &Made, a: &Picture, b: &Picture) -> f64 {
    let mut maps = [Planes::of(a), Planes::of(b)];
    let (mut sum, mut head) = (0.0, 0);
    for l in layers {
        let weights = made.values(&format!("net.{}.weight", l.name));
        let bias = made.values(&format!("net.{}.bias", l.name));
        for map in &mut maps {
            if l.pool > 0 {
                *map = map.pooled(l.pool);
            }
            *map = map.convolved(l, weights, bias);
        }
        if l.is_compared {
            let weights = made.values(&format!("lin{head}.model.1.weight"));
            let places = maps[0].width * maps[0].height;
            for at in 0..places {
                let (a, b) = (maps[0].unit(at), maps[1].unit(at));
                let terms = a.iter().zip(&b).zip(weights);
                let here: f64 = terms.map(|((a, b), w)| f64::from(*w) * (a - b).powi(2)).sum();
                sum += here / places as f64;
            }
            head += 1;
        }
    }
    sum
}
