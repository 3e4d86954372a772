//! A map of numbers with a margin around it.

/// Values of a SIMD vector.
pub(crate) const LANES: usize = 16;

/// A map. Rows are [`Plane::stride`] apart; a row begins with its left margin and ends in at least
/// sixteen values that vectors may touch. What lies beyond the width is 0 unless the margin holds
/// a reflection.
#[derive(Debug, Clone)]
pub struct Plane {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Columns and rows on each side.
    pub margin: usize,
    /// Values from one row to the next.
    pub stride: usize,
    /// All values, margins included.
    pub values: Vec<f32>,
}

/// `n` rounded up to whole vectors.
pub(crate) fn lanes(n: usize) -> usize {
    n.next_multiple_of(LANES)
}

impl Plane {
    /// A plane of zeros.
    pub(crate) fn new([width, height]: [usize; 2], margin: usize) -> Plane {
        let stride = lanes(width + 2 * margin) + LANES;
        let values = vec![0.0; stride * (height + 2 * margin)];
        Plane { width, height, margin, stride, values }
    }

    /// Number of values without margins.
    pub(crate) fn area(&self) -> f64 {
        (self.width * self.height) as f64
    }

    /// Row `y` with whole vectors, without the left margin.
    pub(crate) fn row(&self, y: usize) -> &[f32] {
        let at = (y + self.margin) * self.stride + self.margin;
        &self.values[at..at + lanes(self.width)]
    }

    /// Row `y` with whole vectors, without the left margin.
    pub(crate) fn row_mut(&mut self, y: usize) -> &mut [f32] {
        let at = (y + self.margin) * self.stride + self.margin;
        &mut self.values[at..at + lanes(self.width)]
    }

    /// All rows without the margins above and below, each with its margins left and right.
    pub(crate) fn body_mut(&mut self) -> &mut [f32] {
        let at = self.margin * self.stride;
        &mut self.values[at..at + self.height * self.stride]
    }

    /// Row `y` of all rows, the margin above included, with its margins.
    pub(crate) fn whole_row(&self, y: usize) -> &[f32] {
        &self.values[y * self.stride..(y + 1) * self.stride]
    }

    /// Fills the margin with the reflection of the plane; its edge is not repeated.
    pub(crate) fn reflect(&mut self) {
        let (m, w, h) = (self.margin, self.width, self.height);
        for y in 0..h {
            let row = &mut self.values[(y + m) * self.stride..(y + m + 1) * self.stride];
            for d in 1..=m {
                row[m - d] = row[m + d];
                row[m + w - 1 + d] = row[m + w - 1 - d];
            }
        }
        for d in 1..=m {
            for (to, from) in [(m - d, m + d), (m + h - 1 + d, m + h - 1 - d)] {
                let from = from * self.stride;
                self.values.copy_within(from..from + self.stride, to * self.stride);
            }
        }
    }

    /// Means of squares of four; `half` has half the sides. Its margin is not touched.
    pub(crate) fn halve(&self, half: &mut Plane) {
        for y in 0..half.height {
            let (above, below) = (self.row(2 * y), self.row(2 * y + 1));
            let out = &mut half.row_mut(y)[..self.width / 2];
            let pairs = above.as_chunks::<2>().0.iter().zip(below.as_chunks::<2>().0);
            for (out, (a, b)) in out.iter_mut().zip(pairs) {
                *out = (a[0] + a[1] + b[0] + b[1]) * 0.25;
            }
        }
    }

    /// Adds the adjoint of [`Plane::halve`].
    pub(crate) fn add_doubled(&mut self, half: &Plane) {
        for y in 0..self.height {
            let from = half.row(y / 2);
            let width = self.width;
            let pairs = self.row_mut(y)[..width].as_chunks_mut::<2>().0;
            for (out, v) in pairs.iter_mut().zip(from) {
                out[0] += v * 0.25;
                out[1] += v * 0.25;
            }
        }
    }

    /// The sum of squared differences; the differences times `scale` go into `gradient`.
    pub(crate) fn difference(
        &self,
        other: &Plane,
        scale: f32,
        mut gradient: Option<&mut Plane>,
    ) -> f64 {
        let mut sum = 0.0;
        for y in 0..self.height {
            let pairs = self.row(y)[..self.width].iter().zip(&other.row(y)[..self.width]);
            sum += pairs.clone().map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
            if let Some(gradient) = gradient.as_deref_mut() {
                for (out, (a, b)) in gradient.row_mut(y).iter_mut().zip(pairs) {
                    *out = (a - b) * scale;
                }
            }
        }
        sum
    }
}
