//! The frames of a trace file.

use std::fs::File;
use std::io::{BufReader, Seek};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use powergs_base::budget::Budget;
use powergs_base::format::counted;
use powergs_frame::scene::{Eye, PairOrder};
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
    is_paired: bool,
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
        let path = place.into();
        let mut file = TraceFile { reader, path, name, range, is_paired: false, input, budget };
        file.is_paired = file.head(0)?.facts.camera.eye.is_some();
        if file.is_paired {
            file.check_pairs()?;
        }
        Ok(file)
    }

    /// Left and right eyes in turn: the heads of all frames are read.
    fn check_pairs(&mut self) -> Result<(), RunError> {
        let mut order = PairOrder::default();
        for position in self.range.clone() {
            let camera = self.head(position)?.facts.camera;
            order.next(&camera).map_err(|what| self.unpaired(&camera.name, what))?;
        }
        order.end().map_err(|what| self.unpaired("the last", what))
    }

    fn unpaired(&self, view: &str, what: &str) -> RunError {
        let message = format!("view {view}: {what}; extract the trace again");
        RunError::Input { place: self.path.to_string(), message }
    }

    /// Whether its frames were written as plain views, and have the names of pairs: a trace of a
    /// version that knew no pairs.
    ///
    /// # Errors
    /// [`RunError::Input`]: a frame that cannot be read.
    pub fn looks_paired(&mut self) -> Result<bool, RunError> {
        if self.is_paired || self.reader.len() < 2 {
            return Ok(false);
        }
        let names = [self.head(0)?, self.head(1)?].map(|head| head.facts.camera.name);
        let [left, right] = [Eye::Left.strip(&names[0]), Eye::Right.strip(&names[1])];
        Ok(left.is_some() && left == right)
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
        let end = end.map_or(len, |end| end.min(len));
        let cuts = !(start.is_multiple_of(2) && end.is_multiple_of(2));
        if self.is_paired && cuts {
            let (even, whole) = (start - start % 2, end + end % 2);
            let message = format!(
                "--frames {start}..{end}: {} has pairs of views, 0 and 1, 2 and 3 and so on, and \
                 this cuts one; write {even}..{whole}",
                self.path
            );
            return Err(RunError::Request(message));
        }
        self.range = start..end;
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

    fn eyes(&self) -> usize {
        if self.is_paired { Eye::ALL.len() } else { 1 }
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
        let camera = &block.facts().camera;
        if camera.eye.is_some() != self.is_paired {
            let what = "some views are eyes of pairs and others are not";
            return Err(self.unpaired(&camera.name, what));
        }
        let name = &camera.name;
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
