//! `docs/validation.md`, written from the tables and from what was measured.

use std::fmt::Write as _;

use super::judge::{Judged, Verdict};
use super::row::{Origin, Row, Status};
use super::table::{deviation, number, summary};
use super::{Tables, Workload};

const HEAD: &str = "\
# Validation

<!-- Written by `powergs-sim validate --write docs/validation.md`: change tests/validation/*.csv -->

Published numbers beside what the simulator says. `powergs-sim validate` makes this table in under
two minutes and fails when an enforced row leaves its tolerance, or when any row is farther from its
published value than `tests/validation/baseline.csv` says.

*Enforced* rows must hold. A *known gap* is outside of its tolerance for the reason in its note, and
stays in the table. *Calibrated* rows had a say in a default of a machine file, which the note
names; all others are *held out*. Workloads are synthetic scenes that match published statistics of
the scenes that were used ([synth.md](synth.md)): points, image size, opacities, shapes. None was
tuned to a row, so a few per cent of agreement on an absolute number is luck; ratios say more.
Published rows are of several models of GSCore that contradict each other in places; the notes do
the arithmetic.
";

/// The page.
pub fn page(tables: &Tables, judged: &[Judged]) -> String {
    let mut text = HEAD.to_owned();
    let _ = writeln!(text, "\n{}.", summary(judged));
    let mut section = "";
    for j in judged {
        if j.row.section != section {
            section = &j.row.section;
            let _ = write!(
                text,
                "\n## {section}\n\n| row | what | published | ours | off by | tolerance | status \
                 |\n|---|---|---|---|---|---|---|\n"
            );
        }
        line(&mut text, j);
    }
    text.push_str("\n## Settings and reasons\n\n");
    for j in judged {
        note(&mut text, j.row);
    }
    workloads(&mut text, tables);
    text
}

fn line(text: &mut String, j: &Judged) {
    let unit = j.row.metric.unit();
    let with_unit = |value: f64| format!("{} {unit}", number(value)).trim_end().to_owned();
    let status = match (j.row.status, j.verdict) {
        (_, Verdict::Fails) => "**fails**",
        (_, Verdict::Open) => "not measured",
        (_, Verdict::Closed) => "gap, closed",
        (Status::Enforced, _) => "enforced",
        (Status::KnownGap, _) => "known gap",
    };
    let origin = match j.row.origin {
        Origin::Calibrated => ", calibrated",
        Origin::HeldOut => "",
    };
    let _ = writeln!(
        text,
        "| `{}` | {} | {} | {} | {} | {} | {status}{origin} |",
        j.row.id,
        j.row.what,
        with_unit(j.row.published),
        j.ours.map_or_else(|| "-".to_owned(), with_unit),
        deviation(j),
        j.row.tolerance,
    );
}

fn note(text: &mut String, row: &Row) {
    let _ = write!(text, "* `{}` ({}): `{}`", row.id, row.source, row.machine);
    if let Some(against) = &row.against {
        let _ = write!(text, " against `{against}`");
    }
    if let Some(workload) = &row.workload {
        let _ = write!(text, " on `{workload}`");
    }
    let end = if row.note.is_empty() { "." } else { ". " };
    let _ = writeln!(text, ", {}{end}{}", row.metric.name(), row.note);
}

fn workloads(text: &mut String, tables: &Tables) {
    text.push_str(
        "\n## Workloads\n\n| name | preset | Gaussians | image | views | matches |\n\
         |---|---|---|---|---|---|\n",
    );
    for w in &tables.workloads {
        let Workload { name, preset, points, size: (x, y), why, .. } = w;
        let views = match w.path {
            0 => w.views.to_string(),
            n => format!("{} in a row of a path of {n}", w.views),
        };
        let points = *points as f64 * 1e-6;
        let _ =
            writeln!(text, "| `{name}` | {preset} | {points:.3} M | {x}x{y} | {views} | {why} |");
    }
}
