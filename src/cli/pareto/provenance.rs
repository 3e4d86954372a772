//! Where the report of a sweep comes from.

use powergs_base::shell;
use powergs_report::sweep::Provenance;
use powergs_study::analysis::SweepFacts;
use powergs_study::sweep::run::HandOut;
use powergs_study::sweep::run::confirm::CONFIRMED_MAX;

/// Where a report comes from: the sweep as it was typed, and what was typed for this report.
/// Nothing in it depends on where the folder is.
pub(super) fn provenance(sweep: &SweepFacts, typed: &[String]) -> Provenance {
    let title = sweep.sweeps.first().map_or("", |name| name.trim_end_matches(".toml"));
    let mut commands: Vec<String> = made_by(sweep).iter().map(shell::line).collect();
    commands.push(match typed {
        [] => "powergs-sim pareto DIR".into(),
        typed => shell::line(without_folder(typed)),
    });
    Provenance {
        title: format!("Sweep {title}").trim().to_owned(),
        commands,
        hand_out: sweep.hand_out.clone(),
    }
}

/// The command of the sweep; `None` where nothing is known of it.
fn made_by(sweep: &SweepFacts) -> Option<Vec<String>> {
    let Some(HandOut { sweep: typed, is_calibrated, .. }) = &sweep.hand_out else {
        // Of another version, or made without a sweep file: the names of its files.
        sweep.sweeps.first()?;
        let words = ["powergs-sim".to_owned(), "sweep".to_owned()].into_iter();
        let words = words.chain(sweep.sweeps.iter().cloned()).chain(["--traces".to_owned()]);
        let words = words.chain(sweep.traces.iter().cloned());
        let options = sweep.options.iter().filter_map(|option| option.split_once(' '));
        let options = options.flat_map(|(flag, value)| [flag.to_owned(), value.to_owned()]);
        return Some(words.chain(options).collect());
    };
    let usual = if *is_calibrated { CONFIRMED_MAX } else { 0 };
    let confirm = sweep.confirm.filter(|most| *most != usual);
    let confirm = confirm.map(|most| ["--confirm".to_owned(), most.to_string()]);
    Some(typed.iter().cloned().chain(confirm.into_iter().flatten()).collect())
}

/// What was typed, with the program without its folder.
fn without_folder(typed: &[String]) -> impl Iterator<Item = &str> {
    let shown = |(i, word)| if i == 0 { file_name(word) } else { word };
    typed.iter().map(String::as_str).enumerate().map(shown)
}

fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}
