//! What each task is called with.

use std::ffi::OsString;

use powergs_base::budget::Budget;

use super::super::args::{Definition, SweepArgs};

/// The words after `sweep`, without `--out` and `--shard`.
pub fn of(args: &SweepArgs, memory: Budget) -> Vec<OsString> {
    let SweepArgs { definition, store, .. } = args;
    let Definition { file, traces, frames, sets, points, dram_model } = definition;
    let mut words: Vec<OsString> = file.iter().map(OsString::from).collect();
    // One word each: a value that begins with a dash stays a value.
    words.extend(traces.iter().map(|t| format!("--traces={t}").into()));
    words.extend(frames.map(|f| {
        let end = f.end.map_or(String::new(), |end| end.to_string());
        format!("--frames={}..{end}", f.start).into()
    }));
    words.extend(sets.iter().map(|s| format!("--set={s}").into()));
    words.extend(points.map(|n| format!("--points={n}").into()));
    words.extend(dram_model.map(|model| format!("--dram-model={}", model.key()).into()));
    words.extend(store.as_ref().map(|path| {
        let mut word = OsString::from("--store=");
        word.push(path);
        word
    }));
    words.push(format!("--memory={memory}").into());
    words
}
