//! What each published number is worth as evidence: `tests/validation/ledger.csv`.
//!
//! A row of published numbers is entered once, before its first run: as a *prediction*, or as
//! *calibrated* where the number, or a look at ours, has decided anything that ours depends on. The
//! file is append-only. Another definition of a row (workload, machine, metric, published value,
//! tolerance) is another entry, calibrated, since it was made by somebody who had seen what the old
//! one gave. A prediction that misses stays.
//!
//! A prediction beats its null if ours is at most half as far from the published value as what a
//! model without the mechanism gives. Rows of one experiment are a family and count once, by the
//! mean of their distances.

use std::collections::BTreeMap;

use serde::Deserialize;
use xxhash_rust::xxh3::xxh3_64;

use super::numbers::{NumberPlace, TablesError, records};
use super::row::{Row, Status, Tolerance};
use super::{Judged, Verdict};

/// What a row may be used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowStanding {
    /// Said before it was seen.
    Prediction,
    /// The number, or a look at ours, has decided something.
    Calibrated,
}

impl RowStanding {
    /// The name in the file.
    pub const fn name(self) -> &'static str {
        match self {
            RowStanding::Prediction => "prediction",
            RowStanding::Calibrated => "calibrated",
        }
    }
}

/// A row as it was entered.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LedgerRow {
    /// Name of the row.
    pub row: String,
    /// Hash of what defines it: see [`definition`].
    pub definition: u64,
    /// The day, as `2026-11-29`.
    pub entered: String,
    /// Version of the models on that day.
    pub model: u32,
    /// What it may be used for.
    pub standing: RowStanding,
    /// What a model without the mechanism gives, where that can be said.
    pub null: Option<f64>,
    /// How that was found.
    pub null_how: String,
    /// The experiment that it is of; rows of one are one.
    pub family: String,
    /// Whether it counts: no target of its workload, no arithmetic on other rows, no machine that
    /// it does not run.
    pub counts: bool,
    /// What decided the standing.
    pub why: String,
}

/// The entries, in the order in which they were made.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RowLedger {
    entries: Vec<LedgerRow>,
}

/// What defines a row: another value of any of these is another question.
pub fn definition(row: &Row) -> u64 {
    let against = row.against.as_ref().map_or(String::new(), ToString::to_string);
    let tolerance = row.tolerance.map_or(String::new(), |tolerance| tolerance.to_string());
    let text = [
        row.workloads.join(" "),
        row.machine.to_string(),
        against,
        row.metric.name().to_owned(),
        row.published.to_string(),
        tolerance,
    ];
    xxh3_64(text.join("\n").as_bytes())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EntryRecord {
    row: String,
    definition: String,
    entered: String,
    model: u32,
    status: String,
    null: Option<f64>,
    null_how: String,
    family: String,
    counts: String,
    why: String,
}

impl RowLedger {
    /// Reads the text (CSV with a header line), and holds it to the rows that there are.
    ///
    /// # Errors
    /// The first entry that cannot be understood or that says twice what may be said once, and the
    /// first row without an entry of its own.
    pub fn parse(text: &str, rows: &[Row]) -> Result<RowLedger, TablesError> {
        let mut entries: Vec<LedgerRow> = Vec::new();
        for record in records::<EntryRecord>(NAME, text)? {
            let entry = entry(record)?;
            let place = NumberPlace { table: NAME, id: &entry.row };
            let earlier = || entries.iter().filter(|known| known.row == entry.row);
            if earlier().any(|known| known.definition == entry.definition) {
                let what =
                    "this definition of the row is there already, and a status is given once";
                return Err(place.fault("definition", &hex(entry.definition), what));
            }
            if earlier().next().is_some() && entry.standing == RowStanding::Prediction {
                let what = "must be calibrated: the row was there before with another definition, \
                            and what that gave was seen";
                return Err(place.fault("status", entry.standing.name(), what));
            }
            entries.push(entry);
        }
        let ledger = RowLedger { entries };
        for row in rows {
            if ledger.of(row).is_none() {
                let place = NumberPlace { table: NAME, id: &row.id };
                let what = "has no entry with this definition: append one before the row is run";
                return Err(place.fault("definition", &hex(definition(row)), what));
            }
        }
        Ok(ledger)
    }

    /// The entries, in the order in which they were made.
    pub fn entries(&self) -> &[LedgerRow] {
        &self.entries
    }

    /// The entry of a row as it is defined now.
    pub fn of(&self, row: &Row) -> Option<&LedgerRow> {
        let own = definition(row);
        self.entries.iter().find(|entry| entry.row == row.id && entry.definition == own)
    }

    /// What rows that were measured come to.
    pub fn standing(&self, judged: &[Judged]) -> Evidence {
        let mut evidence = Evidence::default();
        let mut families: BTreeMap<&str, Vec<Scored>> = BTreeMap::new();
        for judged in judged {
            let Some((entry, ours)) = self.of(judged.row).zip(judged.ours) else { continue };
            let is_near = judged.row.is_near(ours);
            if entry.standing == RowStanding::Calibrated {
                evidence.calibrated += 1;
                evidence.calibrated_missed += u64::from(!is_near);
                continue;
            }
            if !entry.counts {
                continue;
            }
            let row = judged.row;
            let of = |value| distance(row, value);
            let Some(error) = of(ours) else { continue };
            evidence.predictions += 1;
            evidence.inside += u64::from(is_near && judged.verdict != Verdict::Dropped);
            evidence.within_quarter += u64::from(error <= QUARTER.ln_1p());
            let is_narrow =
                row.tolerance.is_some_and(|t| t.width(row.published) <= Status::NEAR + 1e-9);
            let scored =
                Scored { row: row.id.clone(), error, null: entry.null.and_then(of), is_narrow };
            families.entry(&entry.family).or_default().push(scored);
        }
        let all: Vec<&Scored> = families.values().flatten().collect();
        let mean = all.iter().map(|scored| scored.error).sum::<f64>() / all.len().max(1) as f64;
        evidence.error = (!all.is_empty()).then_some(mean.exp());
        let mut worst: Vec<(String, f64)> =
            all.iter().map(|scored| (scored.row.clone(), scored.error.exp())).collect();
        worst.sort_by(|a, b| b.1.total_cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        worst.truncate(WORST);
        evidence.worst = worst.into_iter().map(|(row, times)| RowOff { row, times }).collect();
        evidence.families = families.into_iter().map(|(name, rows)| family(name, &rows)).collect();
        evidence
    }
}

/// The name of the file in messages.
const NAME: &str = "ledger.csv";
/// Rows that are named as the worst.
const WORST: usize = 10;
/// What is near, as a share.
const QUARTER: f64 = 0.25;

/// A prediction with its distances: logarithms of how many times too large or too small.
struct Scored {
    row: String,
    error: f64,
    null: Option<f64>,
    is_narrow: bool,
}

/// A row with how many times too large or too small ours is.
#[derive(Debug, Clone, PartialEq)]
pub struct RowOff {
    /// Name of the row.
    pub row: String,
    /// How many times.
    pub times: f64,
}

/// Rows of one experiment.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Family {
    /// Its name.
    pub name: String,
    /// How many rows were measured.
    pub rows: usize,
    /// How many times too large or too small ours is: the geometric mean.
    pub error: f64,
    /// The same of its worst row.
    pub worst: f64,
    /// The same of what a model without the mechanism gives; `None` where that cannot be said of
    /// all of its rows.
    pub null: Option<f64>,
    /// Whether it is evidence: all of its tolerances are 25 % at most, its error is inside of that,
    /// and at most half of that of the null, by logarithms.
    pub is_evidence: bool,
}

/// What predictions come to.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Evidence {
    /// Predictions that count and were measured.
    pub predictions: u64,
    /// Those inside of their tolerance.
    pub inside: u64,
    /// Those that are at most 25 % away.
    pub within_quarter: u64,
    /// How many times too large or too small ours is: the geometric mean; `None` without any.
    pub error: Option<f64>,
    /// The farthest.
    pub worst: Vec<RowOff>,
    /// By family, in the order of their names.
    pub families: Vec<Family>,
    /// Calibrated rows that were measured.
    pub calibrated: u64,
    /// Those outside of their tolerance: a number that has decided something need not be met.
    pub calibrated_missed: u64,
}

impl Evidence {
    /// The families that are evidence.
    pub fn of_worth(&self) -> impl Iterator<Item = &Family> {
        self.families.iter().filter(|family| family.is_evidence)
    }
}

fn family(name: &str, rows: &[Scored]) -> Family {
    let n = rows.len().max(1) as f64;
    let error = rows.iter().map(|row| row.error).sum::<f64>() / n;
    let null: Option<Vec<f64>> = rows.iter().map(|row| row.null).collect();
    let null = null.map(|all| all.iter().sum::<f64>() / n);
    let worst = rows.iter().map(|row| row.error).fold(0.0, f64::max);
    let is_near = rows.iter().all(|row| row.is_narrow) && error <= QUARTER.ln_1p();
    Family {
        name: name.to_owned(),
        rows: rows.len(),
        error: error.exp(),
        worst: worst.exp(),
        null: null.map(f64::exp),
        is_evidence: is_near && null.is_some_and(|null| null > 0.0 && error <= 0.5 * null),
    }
}

/// How far a value is from what was published: the logarithm of the quotient, of a published range
/// that to its nearer end; where one is not above zero, the difference as a share.
fn distance(row: &Row, value: f64) -> Option<f64> {
    let aim = match row.tolerance {
        Some(Tolerance::Range(low, high)) => value.clamp(low, high),
        Some(Tolerance::Share(_)) | None => row.published,
    };
    if value > 0.0 && aim > 0.0 {
        return Some((value / aim).ln().abs());
    }
    (aim != 0.0).then(|| ((value - aim) / aim).abs())
}

fn hex(definition: u64) -> String {
    format!("{definition:016x}")
}

fn entry(record: EntryRecord) -> Result<LedgerRow, TablesError> {
    let place = NumberPlace { table: NAME, id: &record.row };
    let standing = [RowStanding::Prediction, RowStanding::Calibrated];
    let standing = standing.into_iter().find(|standing| standing.name() == record.status);
    let standing =
        place.need("status", &record.status, standing, "must be prediction or calibrated")?;
    let definition = u64::from_str_radix(&record.definition, 16).ok();
    let definition = definition.filter(|_| record.definition.len() == 16);
    let what = "must be 16 hexadecimal digits: `validate` says those of a row without an entry";
    let definition = place.need("definition", &record.definition, definition, what)?;
    let digits = |text: &str, n: usize| text.len() == n && text.bytes().all(|b| b.is_ascii_digit());
    let parts: Vec<&str> = record.entered.split('-').collect();
    if !matches!(parts[..], [y, m, d] if digits(y, 4) && digits(m, 2) && digits(d, 2)) {
        return Err(place.fault("entered", &record.entered, "must be a day: 2026-11-29"));
    }
    let counts = match record.counts.as_str() {
        "yes" => true,
        "no" => false,
        other => return Err(place.fault("counts", other, "must be yes or no")),
    };
    if let Some(null) = record.null.filter(|null| !null.is_finite()) {
        return Err(place.fault("null", &null.to_string(), "must be finite"));
    }
    let is_prediction = standing == RowStanding::Prediction && counts;
    if is_prediction && record.null.is_none() && record.null_how.is_empty() {
        let what = "a prediction needs what a model without the mechanism gives, or in `null_how` \
                    why that cannot be said";
        return Err(place.fault("null", "", what));
    }
    for (column, text) in [("family", &record.family), ("why", &record.why)] {
        if text.is_empty() {
            return Err(place.fault(column, "", "must be there"));
        }
    }
    Ok(LedgerRow {
        definition,
        standing,
        counts,
        row: record.row,
        entered: record.entered,
        model: record.model,
        null: record.null,
        null_how: record.null_how,
        family: record.family,
        why: record.why,
    })
}
