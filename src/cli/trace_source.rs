//! The frames of a trace file, opened and checked: read in order, worked on in parallel, and handed
//! on in order; at most one frame a thread is in memory.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::ops::{ControlFlow, Range};
use std::path::Path;

use xxhash_rust::xxh3::Xxh3;

use super::camera_file::FrameRange;
use super::machine_file::read;
use super::{Exit, Failure, OrExit};
use powergs_base::config::embedded::DISPLAYS;
use powergs_core::sim::{Label, frames};
use powergs_frame::display::Display;
use powergs_frame::trace::{EncodedFrame, Frame, Reader};
use powergs_report::{Input, TraceFacts};

/// A trace file, some of its frames, and the display that shows them.
pub struct TraceSource {
    reader: Reader<BufReader<File>>,
    path: String,
    range: Range<u64>,
    display: Display,
    /// What reports say about the trace.
    pub facts: TraceFacts,
    /// The trace file and the display preset, hashed.
    pub inputs: [Input; 2],
    /// The display preset as it was read.
    pub display_toml: toml::Table,
}

/// A frame of the trace, decoded.
pub struct TraceFrame {
    /// What a report says about it.
    pub label: Label,
    /// The frame.
    pub frame: Frame,
}

/// Why the frames ended early.
enum Stop {
    Asked,
    Failed(Failure),
}

impl TraceSource {
    /// Opens and checks a trace and a display preset.
    ///
    /// # Errors
    /// Exit code 3 for the trace, 2 for the display and for a range that it has no frames in.
    pub fn open(
        trace: &Path,
        range: Option<FrameRange>,
        display: &str,
    ) -> Result<TraceSource, Failure> {
        let display_file = read("display preset", display, DISPLAYS, None)?;
        let display =
            Display::parse(&display_file.text).or_exit(Exit::Usage, &display_file.origin)?;
        let display_toml = display_file.text.parse().or_exit(Exit::Usage, &display_file.origin)?;
        let path = trace.display().to_string();
        let mut file = BufReader::new(File::open(trace).or_exit(Exit::BadInput, &path)?);
        let trace_input = hashed("trace", &file_name(trace), &mut file, &path)?;
        let mut text = display_file.text.as_bytes();
        let origin = &display_file.origin;
        let inputs = [trace_input, hashed("display", origin, &mut text, origin)?];
        file.rewind().or_exit(Exit::BadInput, &path)?;
        let mut reader = Reader::open(file).or_exit(Exit::BadInput, &path)?;
        let range = selected(range, reader.len(), &path)?;
        let first = reader.info(range.start).or_exit(Exit::BadInput, &path)?;
        let camera = &first.head.facts.camera;
        let facts = TraceFacts {
            name: trace.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            frames: (range.end - range.start) as usize,
            width: camera.width,
            height: camera.height,
        };
        Ok(TraceSource { reader, path, range, display, facts, inputs, display_toml })
    }

    /// Positions in the trace of the frames.
    pub fn range(&self) -> Range<usize> {
        self.range.start as usize..self.range.end as usize
    }

    /// At most `count` positions, spread evenly over the frames.
    pub fn spread(&self, count: usize) -> Vec<usize> {
        let range = self.range();
        let n = count.min(range.len());
        (0..n).map(|i| range.start + (2 * i + 1) * range.len() / (2 * n)).collect()
    }

    /// One frame.
    ///
    /// # Errors
    /// Exit code 3: a frame that cannot be read.
    pub fn frame(&mut self, number: usize) -> Result<TraceFrame, Failure> {
        let block = self.reader.read_block(number as u64).or_exit(Exit::BadInput, &self.path)?;
        decoded(&self.display, &self.path, number, &block)
    }

    /// Works on all frames in parallel and hands the results to `each` in order, until it breaks
    /// off.
    ///
    /// # Errors
    /// The first of the work, or exit code 3: a frame that cannot be read.
    pub fn in_order<R: Send>(
        &mut self,
        work: impl Fn(TraceFrame) -> Result<R, Failure> + Sync,
        mut each: impl FnMut(R) -> ControlFlow<()>,
    ) -> Result<(), Failure> {
        let (display, path, reader) = (&self.display, &self.path, &mut self.reader);
        let blocks = self.range.clone().map(|k| {
            let block = reader.read_block(k).or_exit(Exit::BadInput, path);
            block.map(|block| (k as usize, block)).map_err(Stop::Failed)
        });
        let work = |(number, block): (usize, EncodedFrame)| {
            decoded(display, path, number, &block).and_then(&work).map_err(Stop::Failed)
        };
        let outcome = frames::in_order(blocks, work, |result| match each(result) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Stop::Asked),
        });
        match outcome {
            Ok(()) | Err(Stop::Asked) => Ok(()),
            Err(Stop::Failed(failure)) => Err(failure),
        }
    }

    /// As [`TraceSource::in_order`], one frame after the other: for work that builds on the frame
    /// before.
    ///
    /// # Errors
    /// As [`TraceSource::in_order`].
    pub fn in_sequence<R>(
        &mut self,
        mut work: impl FnMut(TraceFrame) -> Result<R, Failure>,
        mut each: impl FnMut(R) -> ControlFlow<()>,
    ) -> Result<(), Failure> {
        for k in self.range.clone() {
            let block = self.reader.read_block(k).or_exit(Exit::BadInput, &self.path)?;
            let frame = decoded(&self.display, &self.path, k as usize, &block)?;
            if each(work(frame)?).is_break() {
                break;
            }
        }
        Ok(())
    }
}

fn decoded(
    display: &Display,
    path: &str,
    number: usize,
    block: &EncodedFrame,
) -> Result<TraceFrame, Failure> {
    let frame = block.decode().or_exit(Exit::BadInput, path)?;
    let label = Label {
        frame: number,
        name: frame.facts.camera.name.clone(),
        display_w: frame.facts.mean_linear_rgb.map(|mean| display.power(mean).0),
    };
    Ok(TraceFrame { label, frame })
}

/// The frames that `--frames` leaves.
fn selected(range: Option<FrameRange>, len: u64, path: &str) -> Result<Range<u64>, Failure> {
    if len == 0 {
        let what = format!("{path}: the trace has no frames; extract it again");
        return Err(Failure::new(Exit::BadInput, what));
    }
    let Some(range) = range else { return Ok(0..len) };
    let start = range.start as u64;
    if start >= len {
        let what = format!("--frames {start}..: {path} has {len} frames, from 0");
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok(start..range.end.map_or(len, |end| (end as u64).min(len)))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Hashes everything that `input` gives.
pub fn hashed(
    role: &'static str,
    name: &str,
    input: &mut impl Read,
    place: &str,
) -> Result<Input, Failure> {
    let (mut hash, mut bytes) = (Xxh3::new(), 0u64);
    let mut buffer = vec![0u8; 1 << 18];
    loop {
        let n = input.read(&mut buffer).or_exit(Exit::BadInput, place)?;
        if n == 0 {
            break;
        }
        hash.update(&buffer[..n]);
        bytes += n as u64;
    }
    // Folders are not part of the record: the same file elsewhere gives the same report.
    let name = file_name(Path::new(name));
    Ok(Input { role, name, bytes, xxh3: hash.digest128() })
}
