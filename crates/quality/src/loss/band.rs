//! One band of rows: SSIM, L1, squared error, display power, and the gradient of their sum.
//!
//! SSIM of x and y needs five windowed means; with s = x + y and d = x − y four do:
//! `4 E[xy] = E[s²] − E[d²]`, `2 (E[x²] + E[y²]) = E[s²] + E[d²]`. Its gradient at pixel j is
//! `B(M)_j + 2 x_j B(P)_j + y_j B(Q)_j`, where B is the window and M, P, Q are the derivatives of
//! the local value by the mean of x, E[x²] and E[xy].

use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use fearless_simd_macros::simd;

use super::lanes;
use super::light::light;
use super::window::{LANES, PAD, RADIUS, Ring, TAPS, across, along, padded, weights};

/// Constants that keep the quotients of SSIM finite, for a peak of 1.
const C1: f32 = 1e-4;
const C2: f32 = 9e-4;

/// What all bands share.
#[derive(Debug)]
pub struct BandJob<'a> {
    width: usize,
    height: usize,
    picture: &'a [f32],
    reference: &'a [f32],
    /// Whether both pictures are clamped to 0..1 first.
    clamped: bool,
    weights: [f32; TAPS],
    /// Watts of linear light 1 in one channel of one pixel.
    pub watts: [f32; 3],
    /// The same times λ.
    pub slopes: [f32; 3],
    /// Gradient of the loss by the absolute difference of one value.
    pub l1_slope: f32,
    /// Gradient of the loss by the SSIM around one value.
    pub ssim_slope: f32,
}

impl<'a> BandJob<'a> {
    /// A job without gradient and watts.
    pub(crate) fn new(
        width: usize,
        height: usize,
        picture: &'a [f32],
        reference: &'a [f32],
        clamped: bool,
    ) -> Self {
        BandJob {
            width,
            height,
            picture,
            reference,
            clamped,
            weights: weights(),
            watts: [0.0; 3],
            slopes: [0.0; 3],
            l1_slope: 0.0,
            ssim_slope: 0.0,
        }
    }

    /// Values of a row.
    fn n(&self) -> usize {
        3 * self.width
    }
}

/// Sums over values.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Sums {
    /// Absolute differences; NaN if a value is not finite.
    pub l1: f64,
    /// Squared differences of clamped values.
    pub square: f64,
    /// SSIM.
    pub ssim: f64,
    /// Watts.
    pub watts: f64,
}

impl Sums {
    /// The sums of both.
    pub(crate) fn plus(&self, other: &Sums) -> Sums {
        Sums {
            l1: self.l1 + other.l1,
            square: self.square + other.square,
            ssim: self.ssim + other.ssim,
            watts: self.watts + other.watts,
        }
    }

    /// Everything divided by `n`.
    pub(crate) fn over(&self, n: f64) -> Sums {
        Sums {
            l1: self.l1 / n,
            square: self.square / n,
            ssim: self.ssim / n,
            watts: self.watts / n,
        }
    }
}

/// Rows in flight of one band.
#[derive(Debug)]
pub struct BandWork {
    /// s, d, s², d² of one row, padded.
    source: [Vec<f32>; 4],
    /// The same after the window along the row.
    means: Ring<4>,
    /// M, P, Q of one row, padded.
    slopes: [Vec<f32>; 3],
    /// The same after the window along the row.
    spread: Ring<3>,
    /// A row of the gradient.
    gradient: Vec<f32>,
}

impl BandWork {
    /// Work space for pictures of `width` pixels.
    pub(crate) fn new(width: usize) -> BandWork {
        let n = 3 * width;
        BandWork {
            source: std::array::from_fn(|_| padded(n)),
            means: Ring::new(n),
            slopes: std::array::from_fn(|_| padded(n)),
            spread: Ring::new(n),
            gradient: vec![0.0; lanes(n)],
        }
    }
}

/// Works through the rows from `first` on, one per entry of `sums`, and as many rows around them
/// as the window needs. `gradient` has the rows of `sums`.
pub(crate) fn run<S: Simd>(
    simd: S,
    job: &BandJob,
    first: usize,
    work: &mut BandWork,
    sums: &mut [Sums],
    mut gradient: Option<&mut [f32]>,
) {
    let end = first + sums.len();
    sums.fill(Sums::default());
    // Rows whose SSIM counts: those whose windows reach into the band, if there is a gradient.
    let reach = if gradient.is_some() { RADIUS } else { 0 };
    let (top, bottom) = (first.saturating_sub(reach), (end + reach).min(job.height));
    let read = top.saturating_sub(RADIUS)..(bottom + RADIUS).min(job.height);
    for y in read.start..end + 2 * RADIUS {
        if y < read.end {
            let own = (first..end).contains(&y).then(|| &mut sums[y - first]);
            read_row(simd, job, y, work, own);
        }
        if let Some(middle) = y.checked_sub(RADIUS).filter(|m| (top..bottom).contains(m)) {
            let ssim = compare_row(simd, job, middle, work, gradient.is_some());
            if (first..end).contains(&middle) {
                sums[middle - first].ssim = ssim;
            }
        }
        let Some(gradient) = gradient.as_deref_mut() else { continue };
        if let Some(done) = y.checked_sub(2 * RADIUS).filter(|d| (first..end).contains(d)) {
            let at = (done - first) * job.n();
            let watts = gradient_row(simd, job, done, work, &mut gradient[at..at + job.n()]);
            sums[done - first].watts = watts;
        }
    }
}

/// Sixteen values from `i` on; zeros where the row has ended.
#[inline(always)]
fn load<S: Simd>(simd: S, row: &[f32], i: usize) -> f32x16<S> {
    match row.get(i..i + LANES) {
        Some(values) => f32x16::from_slice(simd, values),
        None => {
            let mut values = [0.0; LANES];
            values[..row.len() - i].copy_from_slice(&row[i..]);
            f32x16::from_slice(simd, &values)
        }
    }
}

/// Reads row `y`, windows it along the row into the ring, and adds its differences to `sums`.
#[simd]
fn read_row<S: Simd>(
    simd: S,
    job: &BandJob,
    y: usize,
    work: &mut BandWork,
    sums: Option<&mut Sums>,
) {
    let n = job.n();
    let (x_row, y_row) = (&job.picture[y * n..(y + 1) * n], &job.reference[y * n..(y + 1) * n]);
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let (mut l1, mut square) = (zero, zero);
    for i in (0..n).step_by(LANES) {
        let (mut x, mut y) = (load(simd, x_row, i), load(simd, y_row, i));
        let (shown_x, shown_y) = (x.max(zero).min(one), y.max(zero).min(one));
        if job.clamped {
            // Clamping loses NaN and infinity: they go into the sum as NaN.
            l1 += (x - y) * 0.0;
            (x, y) = (shown_x, shown_y);
        }
        let (s, d) = (x + y, x - y);
        for (row, value) in work.source.iter_mut().zip([s, d, s * s, d * d]) {
            value.store_slice(&mut row[PAD + i..PAD + i + LANES]);
        }
        l1 += d.abs();
        let error = shown_x - shown_y;
        square = error.mul_add(error, square);
    }
    if let Some(sums) = sums {
        sums.l1 = total(l1);
        sums.square = total(square);
    }
    for (map, row) in work.source.iter().enumerate() {
        let out = work.means.row_mut(map, y);
        for i in (0..n).step_by(LANES) {
            along(simd, &job.weights, row, i).store_slice(&mut out[i..i + LANES]);
        }
    }
}

/// The sum of the lanes, in order.
pub(super) fn total<S: Simd>(lanes: f32x16<S>) -> f64 {
    let lanes: [f32; LANES] = lanes.into();
    lanes.iter().map(|&v| f64::from(v)).sum()
}

/// The sum of SSIM over row `y`; its derivatives go into the second ring.
#[simd]
fn compare_row<S: Simd>(
    simd: S,
    job: &BandJob,
    y: usize,
    work: &mut BandWork,
    slopes: bool,
) -> f64 {
    let n = job.n();
    let rows: [_; 4] = std::array::from_fn(|map| work.means.around(map, y, job.height));
    // 1 − SSIM is summed: it is small where pictures are alike, and keeps its digits.
    let mut loss = f32x16::splat(simd, 0.0);
    for i in (0..n).step_by(LANES) {
        // Closures would lose the target's features: arrays of lanes are written out.
        let means = [
            across(simd, &job.weights, &rows[0], i),
            across(simd, &job.weights, &rows[1], i),
            across(simd, &job.weights, &rows[2], i),
            across(simd, &job.weights, &rows[3], i),
        ];
        let local = Local::of(means);
        let unlike = f32x16::splat(simd, 1.0) - local.ssim;
        let live = n - i;
        loss += if live < LANES { only(simd, live, unlike) } else { unlike };
        if slopes {
            for (row, value) in work.slopes.iter_mut().zip(local.slopes(means)) {
                let value = if live < LANES { only(simd, live, value) } else { value };
                value.store_slice(&mut row[PAD + i..PAD + i + LANES]);
            }
        }
    }
    if slopes {
        for (map, row) in work.slopes.iter().enumerate() {
            let out = work.spread.row_mut(map, y);
            for i in (0..n).step_by(LANES) {
                along(simd, &job.weights, row, i).store_slice(&mut out[i..i + LANES]);
            }
        }
    }
    n as f64 - total(loss)
}

/// The first `live` lanes; 0 in the others.
#[inline(always)]
fn only<S: Simd>(simd: S, live: usize, value: f32x16<S>) -> f32x16<S> {
    let index: f32x16<S> = f32x16::from_fn(simd, |lane| lane as f32);
    index.simd_lt(f32x16::splat(simd, live as f32)).select(value, f32x16::splat(simd, 0.0))
}

/// SSIM at sixteen places: `A1 A2 / (B1 B2)`.
struct Local<S: Simd> {
    a1: f32x16<S>,
    a2: f32x16<S>,
    inverse: f32x16<S>,
    b1: f32x16<S>,
    b2: f32x16<S>,
    ssim: f32x16<S>,
}

impl<S: Simd> Local<S> {
    /// From the windowed means of s, d, s², d².
    #[inline(always)]
    fn of([s, d, ss, dd]: [f32x16<S>; 4]) -> Self {
        let (s2, d2) = (s * s, d * d);
        let a1 = (s2 - d2) * 0.5 + C1;
        let b1 = (s2 + d2) * 0.5 + C1;
        let (vs, vd) = (ss - s2, dd - d2);
        let a2 = (vs - vd) * 0.5 + C2;
        let b2 = (vs + vd) * 0.5 + C2;
        let inverse = 1.0 / (b1 * b2);
        let ssim = a1 * a2 * inverse;
        Local { a1, a2, inverse, b1, b2, ssim }
    }

    /// Derivatives of SSIM by the mean of x, by E[x²] and by E[xy].
    #[inline(always)]
    fn slopes(&self, [s, d, _, _]: [f32x16<S>; 4]) -> [f32x16<S>; 3] {
        // 2 μx and 2 μy.
        let (x2, y2) = (s + d, s - d);
        let (inverse_b1, inverse_b2) = (self.b2 * self.inverse, self.b1 * self.inverse);
        let by_square = -(self.ssim * inverse_b2);
        let by_product = self.a1 * self.inverse * 2.0;
        let like = y2 * (self.a2 - self.a1) * self.inverse;
        let by_mean = like - x2 * self.ssim * (inverse_b1 - inverse_b2);
        [by_mean, by_square, by_product]
    }
}

/// Values of channels for three vectors in a row.
pub(super) fn pattern(values: &[f32; 3]) -> [[f32; LANES]; 3] {
    std::array::from_fn(|phase| std::array::from_fn(|lane| values[(phase + lane) % 3]))
}

/// The gradient of row `y` into `out`; returns the watts of the row.
#[simd]
fn gradient_row<S: Simd>(
    simd: S,
    job: &BandJob,
    y: usize,
    work: &mut BandWork,
    out: &mut [f32],
) -> f64 {
    let n = job.n();
    let (x_row, y_row) = (&job.picture[y * n..(y + 1) * n], &job.reference[y * n..(y + 1) * n]);
    let rows: [_; 3] = std::array::from_fn(|map| work.spread.around(map, y, job.height));
    let zero = f32x16::splat(simd, 0.0);
    // Lane l of vector v is of channel (16 v + l) mod 3, and 16 mod 3 = 1.
    let (watts, slopes) = (pattern(&job.watts), pattern(&job.slopes));
    let l1_slope = f32x16::splat(simd, job.l1_slope);
    let mut sum = zero;
    for (v, i) in (0..n).step_by(LANES).enumerate() {
        let (x, y) = (load(simd, x_row, i), load(simd, y_row, i));
        let by_mean = across(simd, &job.weights, &rows[0], i);
        let by_square = across(simd, &job.weights, &rows[1], i);
        let by_product = across(simd, &job.weights, &rows[2], i);
        let structure = by_mean + by_square * (x + x) + by_product * y;
        let (linear, slope) = light(simd, x);
        sum = linear.mul_add(f32x16::from_slice(simd, &watts[v % 3]), sum);
        let sign = x.simd_gt(y).select(l1_slope, x.simd_lt(y).select(-l1_slope, zero));
        let gradient = slope.mul_add(f32x16::from_slice(simd, &slopes[v % 3]), sign)
            + structure * job.ssim_slope;
        gradient.store_slice(&mut work.gradient[i..i + LANES]);
    }
    out.copy_from_slice(&work.gradient[..n]);
    total(sum)
}
