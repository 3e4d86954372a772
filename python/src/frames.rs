//! Frames that several threads and reports use at the same time.

use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard};

use crate::error::Fault;
use crate::watch::Shared;
use powergs_base::budget::Budget;
use powergs_core::run::{Frames, Input, Pending, RunError, TraceFile};
use powergs_frame::trace::Frame;

/// Where frames come from.
#[derive(Clone)]
enum Source {
    /// A file; `None` when it is closed. Held while a block is read, not while it is decoded.
    File(Arc<Mutex<Option<TraceFile>>>),
    /// Memory: the frames from the position on.
    Memory(Arc<Vec<Arc<Frame>>>, usize),
}

/// A list of frames that costs nothing to clone.
#[derive(Clone)]
pub struct SharedFrames {
    name: Arc<str>,
    range: Range<usize>,
    size: (u32, u32),
    eyes: usize,
    identity: Input,
    budget: Budget,
    source: Source,
}

impl SharedFrames {
    /// The frames of a file.
    pub fn of_file(mut file: TraceFile) -> Result<SharedFrames, RunError> {
        Ok(SharedFrames {
            name: file.name().into(),
            range: file.range(),
            size: file.size()?,
            eyes: file.eyes(),
            identity: file.identity()?,
            budget: file.budget(),
            source: Source::File(Arc::new(Mutex::new(Some(file)))),
        })
    }

    /// Frames in memory.
    pub fn of_memory(frames: &mut dyn Frames, list: Vec<Arc<Frame>>) -> Result<Self, RunError> {
        Ok(SharedFrames {
            name: frames.name().into(),
            range: frames.range(),
            size: frames.size()?,
            eyes: frames.eyes(),
            identity: frames.identity()?,
            budget: frames.budget(),
            source: Source::Memory(Arc::new(list), frames.range().start),
        })
    }

    /// The same frames, decoded and kept in memory.
    pub fn loaded(&self, shared: &Shared) -> Result<SharedFrames, Fault> {
        let mut frames = self.clone();
        shared.total(self.range.len() as u64);
        let (mut list, mut bytes) = (Vec::new(), 0_u64);
        for position in self.range.clone() {
            if shared.is_over() {
                break;
            }
            let pending = frames.take(position)?;
            bytes = bytes.saturating_add(pending.bytes);
            self.budget.check(bytes).map_err(|over| RunError::Input {
                place: self.name.to_string(),
                message: format!("its frames in memory: {over}"),
            })?;
            list.push(pending.get()?);
            shared.advance(1);
        }
        Ok(SharedFrames::of_memory(&mut frames, list)?)
    }

    /// A part of the list.
    pub fn part(&self, range: Range<usize>) -> SharedFrames {
        SharedFrames { range, ..self.clone() }
    }

    /// Closes the file for everybody.
    pub fn close(&self) {
        if let Source::File(file) = &self.source {
            drop(lock(file).take());
        }
    }

    /// Whether frames can still be read.
    pub fn is_open(&self) -> bool {
        match &self.source {
            Source::File(file) => lock(file).is_some(),
            Source::Memory(..) => true,
        }
    }

    /// Whether the frames are in memory.
    pub fn is_loaded(&self) -> bool {
        matches!(self.source, Source::Memory(..))
    }

    /// Width and height of the first frame, pixels.
    pub fn first_size(&self) -> (u32, u32) {
        self.size
    }
}

/// The lock, whoever panicked with it.
fn lock(file: &Mutex<Option<TraceFile>>) -> MutexGuard<'_, Option<TraceFile>> {
    file.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

impl Frames for SharedFrames {
    fn name(&self) -> &str {
        &self.name
    }

    fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    fn size(&mut self) -> Result<(u32, u32), RunError> {
        Ok(self.size)
    }

    fn take(&mut self, position: usize) -> Result<Pending, RunError> {
        match &self.source {
            Source::Memory(list, first) => {
                let frame = Arc::clone(&list[position - first]);
                Ok(Pending::new(0, move || Ok(frame)))
            }
            Source::File(file) => match &mut *lock(file) {
                Some(file) => {
                    file.allow(self.budget);
                    file.take(position)
                }
                None => Err(RunError::Request("the trace was closed meanwhile".into())),
            },
        }
    }

    /// A part that cuts a pair has views, each a frame of its own.
    fn eyes(&self) -> usize {
        let whole = |n: usize| n.is_multiple_of(self.eyes);
        if whole(self.range.start) && whole(self.range.end) { self.eyes } else { 1 }
    }

    fn budget(&self) -> Budget {
        self.budget
    }

    fn allow(&mut self, budget: Budget) {
        self.budget = budget;
    }

    fn identity(&mut self) -> Result<Input, RunError> {
        Ok(self.identity.clone())
    }
}
