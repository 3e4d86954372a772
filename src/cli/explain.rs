//! `explain`: definitions of everything that has a name in a report, a table or a file: statistics,
//! keys, columns, assumptions, sources, words.

use super::{Context, Exit, Failure, out};
use powergs_base::config::embedded::SYNTH;
use powergs_base::config::key_docs;
use powergs_report::explain::{self, Entry, Keys, find, matching};
use powergs_scene::synth::Preset;

/// Shown under `explain --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim explain vru.cores
  powergs-sim explain frame_time_ms.p99
  powergs-sim explain A26
  powergs-sim explain gscore
  powergs-sim explain 'FPS per W'
  powergs-sim explain dram";

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct ExplainArgs {
    /// A statistic (`power_w.total`), a key (`vru.cores`), the start of several (`dram`), a
    /// column of a table (`busy`), an assumption (`A26`), a source (`powergs`), a term (`knee`)
    pub name: String,
}

/// Prints what is known about a name.
pub fn run(args: &ExplainArgs, context: &Context) -> Result<Exit, Failure> {
    let entries = entries();
    let found = find(&entries, &args.name).map_err(|e| Failure::new(Exit::Usage, e))?;
    if context.global.json {
        return out::json(&found.iter().map(|e| e.json()).collect::<Vec<_>>()).map(|()| Exit::Done);
    }
    out::document(&explain::document(&found)).map(|()| Exit::Done)
}

/// Everything that has a definition.
fn entries() -> Vec<Entry> {
    let docs = key_docs::<Preset>();
    explain::entries([Keys { kind: "key of synthetic scenes", docs, example: &SYNTH[0] }])
}

/// Every name with its definition.
pub fn names() -> Vec<(String, String)> {
    entries().into_iter().map(|e| (e.name, e.definition)).collect()
}

/// Those of `names` that mean nothing here.
pub fn unknown<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let entries = entries();
    names.into_iter().filter(|name| matching(&entries, name).is_empty()).collect()
}
