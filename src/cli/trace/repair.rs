//! `trace repair`: the intact frames of a damaged trace as a new one.

use std::io::BufWriter;
use std::path::Path;

use serde_json::json;

use super::{check, open_file};
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_base::format::counted;
use powergs_core::run::store::atomic::{persist, temporary};
use powergs_frame::trace::Writer;

/// Runs `trace repair`.
pub(super) fn run(path: &Path, output: &Path, context: &Context) -> Result<Exit, Failure> {
    let place = || format!("{}: cannot be written", output.display());
    let input = open_file(path)?;
    let file = temporary(output).or_exit(Exit::Usage, place())?;
    let mut file = Some(BufWriter::new(file));
    let mut writer = None;
    let report = check(path, input, context, |header, frame| {
        if let Some(file) = file.take() {
            writer = Some(Writer::new(file, header)?);
        }
        match &mut writer {
            Some(writer) => writer.write_encoded(frame).map(|_| ()),
            None => Ok(()),
        }
    })?;
    let Some(report) = report else { return Ok(Exit::Interrupted) };
    let Some(writer) = writer else {
        let what = format!("{}: no frame is intact; extract the trace again", path.display());
        return Err(Failure::new(Exit::BadInput, what));
    };
    let frames = writer.len();
    let buffer = writer.finish().or_exit(Exit::Usage, place())?;
    let file = buffer.into_inner().map_err(|e| e.into_error()).or_exit(Exit::Usage, place())?;
    persist(file, output).or_exit(Exit::Usage, place())?;
    if context.global.json {
        let (listed, lost) = (report.listed, report.listed.map(|n| n.saturating_sub(frames)));
        out::json(&json!({ "frames": frames, "frames_listed": listed, "frames_lost": lost }))?;
    } else if !context.global.quiet {
        let kept = match report.listed {
            Some(n) => format!("{frames} of {}", counted(n, "frame")),
            None => counted(frames, "frame"),
        };
        out::text(&format!("{}: {kept} kept\n", output.display()))?;
    }
    Ok(Exit::Done)
}
