//! Where the report of a sweep comes from.

use powergs_report::sweep::Provenance;
use powergs_study::analysis::SweepFacts;

/// Where a report comes from: the sweep by the names of its files, and what was typed for this
/// report. Nothing in it depends on where the folder is.
pub(super) fn provenance(sweep: &SweepFacts, typed: &[String]) -> Provenance {
    let title = sweep.sweeps.first().map_or("", |name| name.trim_end_matches(".toml"));
    let words = ["powergs-sim".to_owned(), "sweep".to_owned()].into_iter();
    let words = words.chain(sweep.sweeps.iter().cloned()).chain(["--traces".to_owned()]);
    let words = words.chain(sweep.traces.iter().cloned());
    let options = sweep.options.iter().filter_map(|option| option.split_once(' '));
    let options = options.flat_map(|(flag, value)| [flag.to_owned(), value.to_owned()]);
    let mut commands = vec![line(words.chain(options))];
    if sweep.sweeps.is_empty() {
        commands.clear();
    }
    match typed {
        [] => commands.push("powergs-sim pareto DIR".into()),
        typed => commands.push(line(typed.iter().cloned())),
    }
    Provenance {
        title: format!("Sweep {title}").trim().to_owned(),
        commands,
        // A folder has the whole path of a file in its sweep.
        machine: sweep.machine.rsplit(['/', '\\']).next().unwrap_or_default().to_owned(),
        set: sweep.set.clone(),
        variants: sweep.variants.clone(),
        trace: sweep.traces.first().cloned().unwrap_or_default(),
    }
}

/// Words as one line of a shell; the program without its folder.
fn line(words: impl Iterator<Item = String>) -> String {
    let quoted = |(i, word): (usize, String)| {
        let word = match (i, word.rsplit(['/', '\\']).next()) {
            (0, Some(name)) => name.to_owned(),
            _ => word,
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    words.enumerate().map(quoted).collect::<Vec<_>>().join(" ")
}
