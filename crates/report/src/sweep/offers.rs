//! What a page hands out of the designs of a sweep: commands that give their rows again, and
//! machine files.

use crate::document::{DesignOffer, DesignReplay};
use powergs_base::shell;
use powergs_study::analysis::{Analysis, Scope};
use powergs_study::sweep::run::{HandOut, HandedDesign, HandedRow};

/// All that is handed out.
#[derive(Debug, Clone, Default)]
pub(super) struct Offers {
    /// The base machine.
    pub base: String,
    /// The first trace.
    pub trace: String,
    /// Beginnings of commands, those of each model of the DRAM once.
    pub replays: Vec<DesignReplay>,
    /// What each design adds, in the order of the rows.
    pub offers: Vec<DesignOffer>,
    /// What several commands of a design are together.
    pub together: String,
}

impl Offers {
    /// Those of some rows.
    pub(super) fn of(analysis: &Analysis, hand_out: &HandOut, rows: &[u32]) -> Offers {
        let table = analysis.table;
        let trace = match &analysis.question.scope {
            Scope::Trace(label) => Some(label.as_str()),
            Scope::Mean | Scope::Worst => None,
        };
        let shown = hand_out.traces.iter().find(|t| trace.is_none_or(|label| label == t.label));
        let mut models: Vec<&str> = Vec::new();
        let mut all = Offers {
            base: hand_out.base.clone(),
            trace: shown.map_or_else(String::new, |trace| trace.path.clone()),
            together: hand_out.together(trace),
            ..Offers::default()
        };
        for &row in rows {
            let model = table.models.word(row);
            let of_model = HandedRow { table: &analysis.energy_table, model, trace };
            let replay = models.iter().position(|known| *known == model).unwrap_or_else(|| {
                models.push(model);
                let commands = hand_out.replays(of_model).iter().map(shell::line).collect();
                let comments = hand_out.head(of_model, &[]);
                all.replays.push(DesignReplay { commands, comments });
                models.len() - 1
            });
            let axes = table.axes.iter().chain(&table.followers);
            let counting = axes.filter(|(name, _)| table.counts(name, row));
            let cells = match table.is_baseline(row) {
                true => Vec::new(),
                false => counting.map(|(name, all)| (name.as_str(), all.word(row))).collect(),
            };
            let point = (!table.is_baseline(row)).then(|| table.points[row as usize]);
            let design = HandedDesign { point, cells };
            let words = hand_out.design(&design, &analysis.energy_table);
            all.offers.push(DesignOffer {
                replay,
                words: shell::line(words.machine.iter().chain(&words.others)),
                others: shell::line(&words.others).replace(char::is_control, " "),
                file: words.file,
            });
        }
        all
    }
}
