//! `replay --timeline FRAME[:A..B]`: what every unit did when, as a picture and for Perfetto.

use std::io::{BufWriter, Write};
use std::ops::Range;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::run_folder::RunFolder;
use super::{Exit, Failure, OrExit};
use powergs_core::kernel::timeline::Observer;
use powergs_core::run::FrameOn;
use powergs_report::perfetto::{MOST_EVENTS, TraceWriter};
use powergs_report::timeline::{Picture, Window};
use powergs_report::{Drawing, charts, format};

/// A frame, and the tiles of it that the picture shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimelineRequest {
    /// Position in the trace.
    pub frame: usize,
    /// Tiles by number, row by row from the upper left; `None`: the whole frame.
    pub tiles: Option<Range<u32>>,
}

impl TimelineRequest {
    /// Checks it against the frames of a run and the tiles of its first frame.
    ///
    /// # Errors
    /// Exit code 2.
    pub fn check(&self, frames: Range<usize>, tiles: u32) -> Result<(), Failure> {
        if !frames.contains(&self.frame) {
            let what = format!("--timeline {}: this run has frames {frames:?}", self.frame);
            return Err(Failure::new(Exit::Usage, what));
        }
        let end = self.tiles.as_ref().map_or(0, |t| t.end);
        if end > tiles {
            let what = format!("--timeline: tiles up to {end}: a frame has {tiles}, from 0");
            return Err(Failure::new(Exit::Usage, what));
        }
        Ok(())
    }
}

/// Reads `3` or `3:100..140`.
pub fn asked(text: &str) -> Result<TimelineRequest, String> {
    let wrong = || "write FRAME or FRAME:A..B (tiles A to B, B excluded), as in 3:100..140";
    let (frame, tiles) = text.split_once(':').map_or((text, None), |(f, t)| (f, Some(t)));
    let frame = frame.parse().map_err(|_| wrong())?;
    let Some(tiles) = tiles else { return Ok(TimelineRequest { frame, tiles: None }) };
    let (first, last) = tiles.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str| text.parse::<u32>().map_err(|_| wrong());
    let tiles = number(first)?..number(last)?;
    if tiles.is_empty() {
        return Err("the range of tiles is empty".into());
    }
    Ok(TimelineRequest { frame, tiles: Some(tiles) })
}

/// Writes `trace.json.gz` of the whole frame, and the chart `timeline` of the tiles; returns
/// what the user should know.
///
/// # Errors
/// Exit code 2: tiles that no unit works on, or a folder that cannot be written.
pub fn write(
    folder: &RunFolder,
    asked: &TimelineRequest,
    trace: &str,
    frame: &FrameOn<'_>,
    drawing: &Drawing,
) -> Result<Option<String>, Failure> {
    let machine = frame.machine;
    let name = trace;
    let observe = |observer: &mut dyn Observer| frame.observe(observer).or_exit(Exit::Usage, name);
    let whole = observe(&mut ())?.timing.frame;
    let cycles = match &asked.tiles {
        None => 0..whole,
        Some(tiles) => {
            let mut window = Window::new(tiles.clone());
            observe(&mut window)?;
            window.cycles
        }
    };
    if cycles.is_empty() {
        let n = frame.work.tiles();
        let what = "no unit works on these tiles";
        let what = format!("--timeline: {what}; frame {} has {n} tiles, from 0", asked.frame);
        return Err(Failure::new(Exit::Usage, what));
    }
    let tiles = asked
        .tiles
        .as_ref()
        .map_or("all tiles".to_owned(), |t| format!("around tiles {} to {}", t.start, t.end - 1));
    let name = format::shortened(&machine.name, 40);
    let trace = format::shortened(trace, 40);
    let what = format!("frame {} of {trace} on {name}, {tiles}", asked.frame);
    let mut picture = Picture::new(cycles);
    observe(&mut picture)?;
    picture.finish();
    let chart = charts::timeline(&picture, machine.clock.0, &what);
    folder.write_charts(&[chart], drawing)?;
    let file = BufWriter::new(folder.stream("trace.json.gz")?);
    let dropped = stream(file, frame, &what).or_exit(Exit::Usage, "trace.json.gz")?;
    Ok((dropped > 0)
        .then(|| format!("trace.json.gz holds {MOST_EVENTS} events, {dropped} more were left out")))
}

/// The trace of a frame, compressed while it is simulated.
fn stream(file: impl Write, frame: &FrameOn<'_>, title: &str) -> std::io::Result<u64> {
    let mut gzip = GzEncoder::new(file, Compression::default());
    let mut writer = TraceWriter::new(&mut gzip, frame.machine.clock.0, title)?;
    frame.observe(&mut writer).map_err(std::io::Error::other)?;
    let dropped = writer.finish()?;
    gzip.finish()?.flush()?;
    Ok(dropped)
}
