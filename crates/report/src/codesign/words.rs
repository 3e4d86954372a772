//! How models, machines and prices are called.

use powergs_codesign::Finished;
use powergs_codesign::compare::Pair;
use powergs_codesign::pricing::{MachinePoint, Row};

/// A model by its name.
pub fn model(finished: &Finished, place: usize) -> String {
    finished.models.get(place).map_or_else(String::new, |model| model.point.name())
}

/// A machine by its number; the base machine by its name.
pub fn machine(finished: &Finished, machine: MachinePoint) -> String {
    machine.map_or_else(|| finished.about.base.clone(), |point| format!("#{point}"))
}

/// A machine by its number and what it has on the axes: `#7 (cores=2 channels=4)`.
pub fn whole_machine(finished: &Finished, point: MachinePoint) -> String {
    let id = machine(finished, point);
    match (point, name(finished, point)) {
        (Some(_), name) if !name.is_empty() => format!("{id} ({name})"),
        _ => id,
    }
}

/// What a machine has on the axes: `cores=2 channels=4`.
pub fn name(finished: &Finished, point: MachinePoint) -> String {
    row_with(finished, point).map_or_else(String::new, |row| row.name(point))
}

/// A pair in a few words.
pub fn pair(finished: &Finished, (place, point): Pair) -> String {
    format!("{} on {}", model(finished, place), machine(finished, point))
}

/// The columns of the axes: places and names.
pub fn axes(finished: &Finished) -> Vec<(usize, &str)> {
    finished.rows.first().map_or_else(Vec::new, Row::axes)
}

/// What a machine has in the columns of the axes.
pub fn settings(finished: &Finished, point: MachinePoint) -> Option<&[String]> {
    row_with(finished, point)?.settings.get(&point).map(Vec::as_slice)
}

/// The first row that has a machine on the most axes: models without a codebook have it without
/// those of the codebook.
fn row_with(finished: &Finished, point: MachinePoint) -> Option<&Row> {
    let values = |row: &&Row| {
        let settings = row.settings.get(&point);
        settings.map(|all| all.iter().filter(|value| !value.is_empty()).count())
    };
    let rows = finished.rows.iter().rev().filter(|row| row.settings.contains_key(&point));
    rows.max_by_key(values)
}

/// The keys of a machine that differ from another: `vru.cores 4 → 2`.
pub fn changes(finished: &Finished, from: MachinePoint, to: MachinePoint) -> Vec<String> {
    let (Some(a), Some(b)) = (settings(finished, from), settings(finished, to)) else {
        return Vec::new();
    };
    let changed = axes(finished).into_iter().filter(|(i, _)| a[*i] != b[*i]);
    changed.map(|(i, name)| format!("{name} {} → {}", a[i], b[i])).collect()
}

/// Letters of ways together: `(c)(d)(e)`.
pub fn letters(letters: impl Iterator<Item = char>) -> String {
    letters.map(|letter| format!("({letter})")).collect()
}
