//! What the unit computes, as graphs.
//!
//! Numbers of a Gaussian come as a host can prepare them once for a scene: standard deviations and
//! opacity as such (not as logarithms), the quaternion with length sqrt(2), so that its products
//! need no doubling, and coefficients with the factors of their basis functions, those of degree 0
//! with the one half that is added to every colour. A camera's focal lengths are in its rotation.

use super::graph::{Graph, Operand};

/// The low-pass filter on both diagonal entries of the covariance, pixels².
pub const LOW_PASS: f32 = 0.3;
/// Gaussians nearer than this are culled.
pub const NEAR: f32 = 0.2;
/// The least half difference of variances for which a box has a direction, twice: pixels².
const ROUND: f32 = 1.0 / 1024.0;
/// Entries of the root of a conic are at most this, as in the volume-rendering core.
const ROOT_MOST: f32 = 2.0;

/// Settings: eye; rows of the rotation, the first two times a focal length; principal point; least
/// and greatest slope inside the Jacobian, across and down, pixels.
pub const SETTINGS: usize = 18;

/// Inputs of [`project`].
pub const PROJECT_INPUTS: usize = 12;

/// Outputs of [`project`], in their order.
pub mod projected {
    /// Depth, world units.
    pub const DEPTH: usize = 0;
    /// Centre, pixels, two numbers.
    pub const MEAN: usize = 1;
    /// Radius before it is rounded up, pixels.
    pub const RADIUS: usize = 3;
    /// Half of the box's extent along the image's axes, pixels.
    pub const REACH: usize = 4;
    /// Half lengths of the box, pixels.
    pub const HALF: usize = 6;
    /// Direction of the box: cosine and sine.
    pub const AXIS: usize = 8;
    /// Root of the conic.
    pub const ROOT: usize = 10;
    /// Opacity.
    pub const OPACITY: usize = 13;
    /// Direction from the eye, of length 1.
    pub const DIRECTION: usize = 14;
    /// How many there are.
    pub const COUNT: usize = 17;
}

/// Distances from the eye and depth of a mean; the last output is negative where it is far enough.
///
/// Inputs: mean. Outputs: place from the eye, depth, near plane less depth.
pub fn cull() -> Graph {
    let mut g = Graph::new("cull", [3, 0, SETTINGS]);
    let d = [0, 1, 2].map(|i| {
        let (p, eye) = (g.input(i), g.setting(i));
        g.sub(p, eye)
    });
    let row = [9, 10, 11].map(|i| g.setting(i));
    let z = g.dot(row, d);
    let near = g.literal(NEAR);
    let verdict = g.sub(near, z);
    d.into_iter().chain([z, verdict]).for_each(|out| g.output(out));
    g
}

/// From a Gaussian to a splat: EWA projection, box, record.
///
/// Inputs: place from the eye, depth, standard deviations, quaternion, opacity. Outputs:
/// [`projected`].
///
/// The determinant of the covariance C Cᵀ + 0.3 is that of the vectors of C, |u x v|², and
/// 0.3 (u² + v²) + 0.09: nothing cancels. The lesser half length of the box is the determinant over
/// the greater one.
pub fn project() -> Graph {
    let mut g = Graph::new("project", [PROJECT_INPUTS, 0, SETTINGS]);
    let d = [0, 1, 2].map(|i| g.input(i));
    let z = g.input(3);
    let inverse_z = g.reciprocal(z);
    let turned = rotation(&mut g);
    let scales = [4, 5, 6].map(|i| {
        let s = g.input(i);
        g.mul(s, inverse_z)
    });
    let (mut mean, mut vectors) = (Vec::new(), Vec::new());
    for axis in 0..2 {
        let row = [0, 1, 2].map(|i| g.setting(3 + 3 * axis + i));
        let along = g.dot(row, d);
        let slope = g.mul(along, inverse_z);
        let principal = g.setting(12 + axis);
        mean.push(g.add(slope, principal));
        let (low, high) = (g.setting(14 + 2 * axis), g.setting(15 + 2 * axis));
        let least = g.max(slope, low);
        let held = g.min(least, high);
        let t = [0, 1, 2].map(|i| {
            let depth_row = g.setting(9 + i);
            let part = g.mul(held, depth_row);
            g.sub(row[i], part)
        });
        vectors.push([0, 1, 2].map(|k| {
            let of_axis = g.dot(t, [turned[0][k], turned[1][k], turned[2][k]]);
            g.mul(of_axis, scales[k])
        }));
    }
    let (u, v) = (vectors[0], vectors[1]);
    let (uu, vv, b) = (g.dot(u, u), g.dot(v, v), g.dot(u, v));
    let low_pass = g.literal(LOW_PASS);
    let (a, d2) = (g.add(uu, low_pass), g.add(vv, low_pass));
    let determinant = determinant(&mut g, [u, v], [uu, vv]);
    let inverse_root = g.reciprocal_root(determinant);
    let root = conic_root(&mut g, [b, d2], inverse_root);
    let root_of_determinant = g.mul(determinant, inverse_root);
    let shape = shape(&mut g, [a, b, d2], root_of_determinant);
    let direction = direction(&mut g, d);
    let opacity = g.input(11);
    g.output(z);
    mean.into_iter().chain(shape).chain(root).for_each(|out| g.output(out));
    g.output(opacity);
    direction.into_iter().for_each(|out| g.output(out));
    g
}

/// The matrix of the quaternion (w, x, y, z) of length sqrt(2).
fn rotation(g: &mut Graph) -> [[Operand; 3]; 3] {
    let [w, x, y, z] = [7, 8, 9, 10].map(|i| g.input(i));
    let one = g.literal(1.0);
    let mut diagonal = |p: Operand, q: Operand| {
        let (pp, qq) = (g.mul(p, p), g.mul(q, q));
        let sum = g.add(pp, qq);
        g.sub(one, sum)
    };
    let [d0, d1, d2] = [diagonal(y, z), diagonal(x, z), diagonal(x, y)];
    let mut pair = |[p, q]: [Operand; 2], [r, s]: [Operand; 2]| {
        let (pq, rs) = (g.mul(p, q), g.mul(r, s));
        [g.sub(pq, rs), g.add(pq, rs)]
    };
    let [m01, m10] = pair([x, y], [w, z]);
    let [m20, m02] = pair([x, z], [w, y]);
    let [m12, m21] = pair([y, z], [w, x]);
    [[d0, m01, m02], [m10, d1, m12], [m20, m21, d2]]
}

fn determinant(g: &mut Graph, [u, v]: [[Operand; 3]; 2], [uu, vv]: [Operand; 2]) -> Operand {
    let cross = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let (p, q) = (g.mul(u[i], v[j]), g.mul(u[j], v[i]));
        g.sub(p, q)
    });
    let squared = g.dot(cross, cross);
    let trace = g.add(uu, vv);
    let (low_pass, square) = (g.literal(LOW_PASS), g.literal(LOW_PASS * LOW_PASS));
    let filtered = g.mul(trace, low_pass);
    let rest = g.add(filtered, square);
    g.add(squared, rest)
}

/// a, b, c of q = (a x + b y)² + (c y)², of the covariance [[., b], [b, d]] and the inverse root of
/// its determinant: c = k / sqrt(d), a = k sqrt(d / det), b = -a b / d with k² = log2(e) / 2.
fn conic_root(g: &mut Graph, [b, d]: [Operand; 2], inverse_root: Operand) -> [Operand; 3] {
    let k = g.literal((0.5 * std::f64::consts::LOG2_E).sqrt() as f32);
    let most = g.literal(ROOT_MOST);
    let inverse = g.reciprocal_root(d);
    let c = g.mul(inverse, k);
    let dc = g.mul(d, c);
    let a = g.mul(dc, inverse_root);
    let slope = g.mul(-b, inverse);
    let slope = g.mul(slope, inverse);
    let off = g.mul(a, slope);
    let (a, c) = (g.min(a, most), g.min(c, most));
    let off = g.max(off, -most);
    [a, g.min(off, most), c]
}

/// Radius, reach along the image's axes, half lengths and direction of the box.
fn shape(g: &mut Graph, [a, b, d]: [Operand; 3], root_of_determinant: Operand) -> Vec<Operand> {
    let (sum, difference, twice_b) = (g.add(a, d), g.sub(a, d), g.add(b, b));
    let least = g.literal(ROUND);
    let wide = g.max(difference.abs(), least);
    let (ww, bb) = (g.mul(wide, wide), g.mul(twice_b, twice_b));
    let square = g.add(ww, bb);
    let inverse = g.reciprocal_root(square);
    let spread = g.mul(square, inverse);
    // Three sigma of twice the greater variance.
    let three = g.literal(3.0 * std::f32::consts::FRAC_1_SQRT_2);
    let six = g.literal(6.0 * std::f32::consts::FRAC_1_SQRT_2);
    let of_sum = |g: &mut Graph, spread: Operand| {
        let twice = g.add(sum, spread);
        (twice, g.reciprocal_root(twice))
    };
    // The published radius has a floor of 0.1 under the square of half the spread.
    let floor = g.literal(0.4f32.sqrt());
    let floored = g.max(spread, floor);
    let (twice, inverse_root) = of_sum(g, floored);
    let root = g.mul(twice, inverse_root);
    let radius = g.mul(root, three);
    let (twice, inverse_root) = of_sum(g, spread);
    let root = g.mul(twice, inverse_root);
    let major = g.mul(root, three);
    let minor = g.mul(root_of_determinant, inverse_root);
    let minor = g.mul(minor, six);
    let half = [g.select(difference, major, minor), g.select(difference, minor, major)];
    // Half-angle: 2 cos² = 1 + |cos 2θ|, where the first axis is the one nearer to x.
    let (cos2, sin2) = (g.mul(wide, inverse), g.mul(twice_b, inverse));
    let one = g.literal(1.0);
    let raised = g.add(cos2, one);
    let inverse = g.reciprocal_root(raised);
    let half_root = g.literal(std::f32::consts::FRAC_1_SQRT_2);
    let scale = g.mul(inverse, half_root);
    let (cos, sin) = (g.mul(raised, scale), g.mul(sin2, scale));
    let sin = g.select(difference, sin, -sin);
    let mut reach = |c: Operand, s: Operand| {
        let (p, q) = (g.mul(half[0], c.abs()), g.mul(half[1], s.abs()));
        g.add(p, q)
    };
    let (across, down) = (reach(cos, sin), reach(sin, cos));
    vec![radius, across, down, half[0], half[1], cos, sin]
}

fn direction(g: &mut Graph, d: [Operand; 3]) -> [Operand; 3] {
    let square = g.dot(d, d);
    let inverse = g.reciprocal_root(square);
    d.map(|part| g.mul(part, inverse))
}

/// Spherical harmonics of a degree, 0 to 3, without the factors of the basis.
///
/// Inputs: direction. Late inputs: three channels of each of the 16 coefficients. Outputs: colour,
/// not below black.
pub fn colour(degree: u32) -> Graph {
    const NAMES: [&str; 4] = ["colour_0", "colour_1", "colour_2", "colour_3"];
    let mut g = Graph::new(NAMES[degree as usize], [3, 48, 0]);
    let basis = basis(&mut g, degree);
    let zero = g.literal(0.0);
    for channel in 0..3 {
        let mut terms = vec![g.late(channel)];
        for (k, &function) in basis.iter().enumerate() {
            let coefficient = g.late(3 * (k + 1) + channel);
            terms.push(g.mul(coefficient, function));
        }
        // Neighbours first: the sum is short.
        while terms.len() > 1 {
            let pairs = terms.chunks(2);
            let next = pairs.map(|pair| match *pair {
                [a, b] => g.add(a, b),
                _ => pair[0],
            });
            terms = next.collect();
        }
        let out = g.max(terms[0], zero);
        g.output(out);
    }
    g
}

/// Basis functions from the second one on.
fn basis(g: &mut Graph, degree: u32) -> Vec<Operand> {
    let [x, y, z] = [0, 1, 2].map(|i| g.input(i));
    let mut basis = Vec::new();
    if degree >= 1 {
        basis.extend([y, z, x]);
    }
    if degree >= 2 {
        let (xx, yy, zz) = (g.mul(x, x), g.mul(y, y), g.mul(z, z));
        let (xy, yz, xz) = (g.mul(x, y), g.mul(y, z), g.mul(x, z));
        let (less, more) = (g.sub(xx, yy), g.add(xx, yy));
        let z2 = g.add(zz, zz);
        let middle = g.sub(z2, more);
        basis.extend([xy, yz, middle, xz, less]);
        if degree >= 3 {
            let x2 = g.add(xx, xx);
            let first = g.add(x2, less);
            basis.push(g.mul(y, first));
            basis.push(g.mul(xy, z));
            let wide = g.add(middle, z2);
            basis.push(g.mul(y, wide));
            let twice = g.add(more, more);
            let tall = g.sub(middle, twice);
            basis.push(g.mul(z, tall));
            basis.push(g.mul(x, wide));
            basis.push(g.mul(z, less));
            let y2 = g.add(yy, yy);
            let last = g.sub(less, y2);
            basis.push(g.mul(x, last));
        }
    }
    basis
}
