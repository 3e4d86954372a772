//! The axes of an SPZ file, turned to those of PLY: x right, y down, z forward.

use super::super::Gaussians;
use super::super::error::{DAMAGED, SceneError};
use super::u32_at;

/// The extension record that states the axes (Adobe's coordinate system).
const COORDINATE_SYSTEM: u32 = 0xadbe_0003;
/// Right, up, back: what a file without the record means.
const RIGHT_UP_BACK: u32 = 4;

/// Signs that turn the stored axes to those of PLY.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axes([f32; 3]);

impl Axes {
    /// The axes of a file with these extension records: `type, length, payload` each. Records of
    /// unknown types are passed over.
    pub(crate) fn of(mut records: &[u8]) -> Result<Self, SceneError> {
        let mut system = RIGHT_UP_BACK;
        while !records.is_empty() {
            let payload = (records.len() >= 8)
                .then(|| (u32_at(records, 4) as usize).checked_add(8))
                .flatten()
                .and_then(|end| records.get(8..end));
            let Some(payload) = payload else {
                return Err(SceneError::truncated("SPZ extensions", "a record is cut off"));
            };
            if u32_at(records, 0) == COORDINATE_SYSTEM && payload.len() >= 4 {
                system = u32_at(payload, 0);
            }
            records = &records[8 + payload.len()..];
        }
        match system {
            // The writer did not say; files like that are turned as all others.
            0 => Ok(Self::from_code(RIGHT_UP_BACK)),
            1..=8 => Ok(Self::from_code(system)),
            _ => {
                let what = format!("unknown coordinate system {system}");
                Err(SceneError::malformed("SPZ extensions", what, DAMAGED))
            }
        }
    }

    /// Code minus one: bit 0 is right, bit 1 up, bit 2 front.
    fn from_code(code: u32) -> Self {
        let bit = |n: u32| (code - 1) >> n & 1 == 1;
        let sign = |keep: bool| if keep { 1.0 } else { -1.0 };
        Self([sign(bit(0)), sign(!bit(1)), sign(bit(2))])
    }

    /// Turns means, rotations and SH coefficients. SH basis functions change their sign as the
    /// product of the coordinates in which they are odd.
    pub(crate) fn turn(self, scene: &mut Gaussians) {
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
