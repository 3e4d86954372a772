//! One frame on one machine, for those who want more than its report: what every unit did when, and
//! the requests to the DRAM.

use std::io::{self, Write};

use crate::flow::{FlowOutcome, FrameTask, Handed, Work};
use crate::kernel::Memo;
use crate::kernel::timeline::{Observer, Span};
use crate::machine::Machine;
use crate::sim::SimError;
use powergs_dram::address_trace::write_request;

/// A frame as a machine sees it when it comes to it, made by
/// [`Session::frame_on`](super::Session::frame_on).
#[derive(Debug)]
pub struct FrameOn<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// The frame, prepared for it.
    pub work: Box<dyn Work>,
    /// What it takes over from the frame before.
    pub(crate) before: Option<Handed>,
    pub(crate) memo: Memo,
}

impl FrameOn<'_> {
    /// Takes the frame through the machine and tells `observer` what every unit did when.
    ///
    /// # Errors
    /// [`SimError`]: a frame that the machine cannot run, or a defect of the simulator.
    pub fn observe(&self, observer: &mut dyn Observer) -> Result<FlowOutcome, SimError> {
        self.machine.flow().run(&self.task(), Some(observer))
    }

    /// The frame on the machine.
    pub fn task(&self) -> FrameTask<'_> {
        let first = FrameTask::first(self.machine, &*self.work, &self.memo);
        FrameTask { before: self.before.as_ref(), ..first }
    }

    /// Writes the DRAM requests of the frame as an address trace, in the order in which they are
    /// made; returns how many there are.
    ///
    /// # Errors
    /// Those of `out`; nothing is written after the first. A frame that the machine cannot run.
    pub fn write_dram_requests(&self, out: &mut dyn Write) -> io::Result<u64> {
        let mut writer = RequestWriter { out, written: Ok(0) };
        self.observe(&mut writer).map_err(io::Error::other)?;
        writer.written
    }
}

/// Writes requests until one fails.
struct RequestWriter<'a> {
    out: &'a mut dyn Write,
    written: io::Result<u64>,
}

impl Observer for RequestWriter<'_> {
    fn wants_requests(&self) -> bool {
        true
    }

    fn span(&mut self, _: Span) {}

    fn request(&mut self, is_write: bool, address: u64, bytes: u64) {
        if let Ok(n) = self.written {
            self.written = write_request(self.out, is_write, address, bytes).map(|()| n + 1);
        }
    }
}
