//! The frames of a trace file.

use std::fs::File;
use std::io::{BufReader, Seek};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use powergs_base::budget::Budget;
use powergs_base::format::counted;
use powergs_frame::trace::{FrameHead, Reader};

use super::error::RunError;
use super::frames::{Frames, Pending};
use super::input::Input;

/// A trace file, opened and checked, and the frames of it that are used.
#[derive(Debug)]
pub struct TraceFile {
    reader: Reader<BufReader<File>>,
    path: Arc<str>,
    name: String,
    range: Range<usize>,
    input: Input,
    budget: Budget,
}

impl TraceFile {
    /// Opens a trace, all frames of it.
    ///
    /// # Errors
    /// [`RunError::Input`]: it cannot be read, is damaged or has no frames.
    pub fn open(path: &Path) -> Result<TraceFile, RunError> {
        let place = path.display().to_string();
        let wrong = |e| RunError::input(&place, e);
        // Opening a pipe waits for somebody who writes, and a trace is read from its end.
        if !std::fs::metadata(path).map_err(wrong)?.is_file() {
            let message = "not a regular file; copy the trace to one".to_owned();
            return Err(RunError::Input { place, message });
        }
        let mut file = BufReader::new(File::open(path).map_err(wrong)?);
        let input = Input::hash("trace", &place, &mut file).map_err(wrong)?;
        file.rewind().map_err(wrong)?;
        let reader = Reader::open(file).map_err(|e| RunError::input(&place, e))?;
        if reader.is_empty() {
            let message = "the trace has no frames; extract it again".to_owned();
            return Err(RunError::Input { place, message });
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let range = 0..reader.len() as usize;
        let budget = Budget::DEFAULT;
        Ok(TraceFile { reader, path: place.into(), name, range, input, budget })
    }

    /// Leaves only frames from `start` to `end` (excluded; `None`: the end).
    ///
    /// # Errors
    /// [`RunError::Request`]: the trace ends before `start`.
    pub fn select(&mut self, start: usize, end: Option<usize>) -> Result<(), RunError> {
        let len = self.reader.len() as usize;
        if start >= len {
            let path = &self.path;
            let message =
                format!("--frames {start}..: {path} has {}, from 0", counted(len, "frame"));
            return Err(RunError::Request(message));
        }
        self.range = start..end.map_or(len, |end| end.min(len));
        Ok(())
    }

    /// The hash of the file.
    pub fn input(&self) -> &Input {
        &self.input
    }

    /// The head of a frame: camera, image means.
    ///
    /// # Errors
    /// [`RunError::Input`]: it cannot be read.
    pub(crate) fn head(&mut self, position: usize) -> Result<FrameHead, RunError> {
        let info = self.reader.info(position as u64);
        Ok(info.map_err(|e| RunError::input(&self.path, e))?.head)
    }
}

impl Frames for TraceFile {
    fn identity(&mut self) -> Result<Input, RunError> {
        Ok(self.input.clone())
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    fn size(&mut self) -> Result<(u32, u32), RunError> {
        let head = self.head(self.range.start)?;
        Ok((head.facts.camera.width, head.facts.camera.height))
    }

    fn budget(&self) -> Budget {
        self.budget
    }

    fn allow(&mut self, budget: Budget) {
        self.budget = budget;
    }

    fn take(&mut self, position: usize) -> Result<Pending, RunError> {
        let block = self.reader.read_block(position as u64);
        let block = block.map_err(|e| RunError::input(&self.path, e))?;
        let path = Arc::clone(&self.path);
        let bytes = block.decoding_bytes();
        let name = &block.facts().camera.name;
        self.budget.check(bytes).map_err(|over| RunError::Input {
            place: path.to_string(),
            message: format!("frame {name}: {over}"),
        })?;
        Ok(Pending::new(bytes, move || {
            let frame = block.decode().map_err(|e| RunError::input(&path, e))?;
            Ok(Arc::new(frame))
        }))
    }
}
