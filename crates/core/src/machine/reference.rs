//! The machine whose run on the device says how the memory of others is calibrated
//! ([`calibration`](crate::kernel::calibration)).

use std::sync::Arc;

use super::{DramModel, GatingSpec, Machine};
use crate::kernel::calibration::{Calibration, CalibrationRecorder, Recording};
use crate::kernel::stream::Streams;
use crate::kernel::{Memo, MemoKey};

/// The machine on its device whose run says what the memory of others does: the same requests, by
/// units and buffers that are always the same.
#[derive(Debug, PartialEq)]
pub struct Reference(Machine);

impl MemoKey for Reference {
    type Value = Calibration;
    const MOST: usize = 1024;
}

impl Reference {
    /// What its run says of the memory of `machine`, where that is `calibrated`: once a frame for
    /// all machines with the same reference. `change` makes the same what does not decide which
    /// requests there are; `run` takes the reference through, and gives what the device did
    /// ([`Memory::recording`](crate::kernel::memory::Memory::recording)). Whether preprocessing
    /// ends before the other phases begin is what
    /// [`Dataflow::overlaps`](crate::flow::Dataflow::overlaps) says.
    ///
    /// # Panics
    /// When the run has no recording, or the machine was never linked to its device.
    pub fn calibration(
        machine: &Machine,
        memo: &Memo,
        change: impl FnOnce(&mut Machine),
        run: impl FnOnce(&Machine, &mut CalibrationRecorder) -> Option<Recording>,
        streams: &'static Streams,
    ) -> Option<Arc<Calibration>> {
        if machine.dram.timed() != DramModel::Calibrated {
            return None;
        }
        let mut reference = machine.clone();
        reference.dram.model = DramModel::Banked;
        reference.gating = GatingSpec::default();
        for name in [&mut reference.name, &mut reference.description, &mut reference.energy] {
            name.clear();
        }
        change(&mut reference);
        Some(memo.get(Reference(reference), |Reference(reference)| {
            let recording = run(reference, &mut CalibrationRecorder);
            let recording = recording.expect("a run with a device has a recording");
            let device = reference.device.as_deref().expect("a machine is linked to its device");
            let is_apart = !reference.flow().overlaps(reference);
            Calibration::of(&recording, streams, device, is_apart)
        }))
    }
}
