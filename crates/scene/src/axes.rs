//! The axes that the numbers of a file have, turned to those of PLY: x right, y down, z to the
//! front.

use std::fmt;
use std::str::FromStr;

use super::Gaussians;

/// Axes of a file, as the signs that turn them to those of PLY.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StoredAxes([f32; 3]);

impl StoredAxes {
    /// Right, down, front: of PLY and of every format that does not say otherwise.
    pub(super) const PLY: StoredAxes = StoredAxes([1.0; 3]);
    /// Right, up, back: of glTF, and of an SPZ file that says nothing.
    pub(super) const RIGHT_UP_BACK: StoredAxes = StoredAxes([1.0, -1.0, -1.0]);

    /// From the signs themselves.
    pub(super) const fn of_signs(signs: [f32; 3]) -> StoredAxes {
        StoredAxes(signs)
    }

    /// The turn that is left to do where those of `assumed` were turned already.
    pub(super) fn instead_of(self, assumed: StoredAxes) -> StoredAxes {
        // A sign is its own inverse.
        StoredAxes(std::array::from_fn(|axis| self.0[axis] * assumed.0[axis]))
    }

    /// Turns means, rotations and SH coefficients. SH basis functions change their sign as the
    /// product of the coordinates in which they are odd.
    pub(super) fn turn(self, scene: &mut Gaussians) {
        let [x, y, z] = self.0;
        scene.means.iter_mut().for_each(|m| *m = [m[0] * x, m[1] * y, m[2] * z]);
        for q in &mut scene.rotations {
            *q = [q[0], q[1] * y * z, q[2] * x * z, q[3] * x * y];
        }
        let (xy, yz, xz) = (x * y, y * z, x * z);
        let signs = [1.0, y, z, x, xy, yz, 1.0, xz, 1.0, y, xy * z, y, z, x, z, x];
        for channel in scene.sh.chunks_exact_mut((scene.sh_degree as usize + 1).pow(2)) {
            channel.iter_mut().zip(signs).for_each(|(c, sign)| *c *= sign);
        }
    }
}

impl fmt::Display for StoredAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letters = [["r", "l"], ["d", "u"], ["f", "b"]];
        let pick = |([plus, minus], sign): ([&'static str; 2], f32)| {
            if sign > 0.0 { plus } else { minus }
        };
        letters.into_iter().zip(self.0).map(pick).try_for_each(|letter| f.write_str(letter))
    }
}

impl FromStr for StoredAxes {
    type Err = String;

    /// `rdf`: where x, y and z point to, each with a letter of right or left, down or up, front or
    /// back; or `ply`, which is that.
    fn from_str(text: &str) -> Result<StoredAxes, String> {
        let lower = text.to_ascii_lowercase();
        if lower == "ply" {
            return Ok(StoredAxes::PLY);
        }
        let sign = |letter: u8, plus: u8, minus: u8| match letter {
            _ if letter == plus => Some(1.0),
            _ if letter == minus => Some(-1.0),
            _ => None,
        };
        let signs = match lower.as_bytes() {
            &[x, y, z] => {
                let signs = [sign(x, b'r', b'l'), sign(y, b'd', b'u'), sign(z, b'f', b'b')];
                signs.into_iter().collect::<Option<Vec<f32>>>()
            }
            _ => None,
        };
        match signs.as_deref() {
            Some(&[x, y, z]) => Ok(StoredAxes([x, y, z])),
            _ => Err("write where x, y and z point to: r or l, d or u, f or b; rdf (or ply) is \
                      right, down, front, rub is right, up, back"
                .into()),
        }
    }
}
