//! The axes that an SPZ file states.

use super::super::axes::StoredAxes;
use super::super::error::{DAMAGED, SceneError};
use super::u32_at;

/// The extension record that states the axes (Adobe's coordinate system).
const COORDINATE_SYSTEM: u32 = 0xadbe_0003;

/// The axes of a file with these extension records: `type, length, payload` each. Records of
/// unknown types are passed over.
pub(super) fn stated(mut records: &[u8]) -> Result<StoredAxes, SceneError> {
    let mut system = 0;
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
        0 => Ok(StoredAxes::RIGHT_UP_BACK),
        1..=8 => Ok(of_code(system)),
        _ => {
            let what = format!("unknown coordinate system {system}");
            Err(SceneError::malformed("SPZ extensions", what, DAMAGED))
        }
    }
}

/// Code minus one: bit 0 is right, bit 1 up, bit 2 front.
fn of_code(code: u32) -> StoredAxes {
    let bit = |n: u32| (code - 1) >> n & 1 == 1;
    let sign = |keep: bool| if keep { 1.0 } else { -1.0 };
    StoredAxes::of_signs([sign(bit(0)), sign(!bit(1)), sign(bit(2))])
}
