//! One frame on one machine, for those who want more than its report: what every unit did when, and
//! the requests to the DRAM.

use std::io::{self, Write};

use crate::flow::tile_wise::FrameReplay;
use crate::kernel::timeline::{Observer, Span};
use crate::machine::Machine;
use crate::sim::{Measured, observed};
use crate::workload::FrameWorkload;
use powergs_dram::address_trace::write_request;

/// A frame as a machine sees it when it comes to it, made by
/// [`Session::frame_on`](super::Session::frame_on).
#[derive(Debug)]
pub struct FrameOn<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// The frame, binned.
    pub workload: FrameWorkload,
    /// What was measured of it.
    pub measured: Measured,
}

impl FrameOn<'_> {
    /// Takes the frame through the machine and tells `observer` what every unit did when.
    pub fn observe(&self, observer: &mut impl Observer) -> FrameReplay {
        observed(&self.workload, &self.measured, self.machine, observer)
    }

    /// Writes the DRAM requests of the frame as an address trace, in the order in which they are
    /// made; returns how many there are.
    ///
    /// # Errors
    /// Those of `out`; nothing is written after the first.
    pub fn write_dram_requests(&self, out: &mut dyn Write) -> io::Result<u64> {
        let mut writer = RequestWriter { out, written: Ok(0) };
        self.observe(&mut writer);
        writer.written
    }
}

/// Writes requests until one fails.
struct RequestWriter<'a> {
    out: &'a mut dyn Write,
    written: io::Result<u64>,
}

impl Observer for RequestWriter<'_> {
    const WANTS_REQUESTS: bool = true;

    fn span(&mut self, _: Span) {}

    fn request(&mut self, is_write: bool, address: u64, bytes: u64) {
        if let Ok(n) = self.written {
            self.written = write_request(self.out, is_write, address, bytes).map(|()| n + 1);
        }
    }
}
