//! Designs of a sweep on `calibrated` DRAM that were simulated again with `banked`: what became of
//! them, and how far the two models are apart.
//!
//! The front is confirmed from its knee outward, and designs that miss the display rate by less
//! than the models differ. Their results with `banked` take the place of the others in the table,
//! so that every conclusion about them is drawn from these; the front may then have other designs,
//! which are confirmed in turn.

use powergs_core::machine::DramModel;
use serde::{Deserialize, Serialize};

use super::Analysis;
use super::designs::{self, DesignSlice};
use super::front::{beats, is_alike};
use super::question::{Question, Scope};
use super::table::{Over, Table};

/// Columns that are compared besides the objectives.
const COLUMNS: [&str; 5] =
    ["frame_time_ms.mean", "fps.mean", "energy_pj.mean", "power_w.mean", "area_mm2"];

/// What became of the designs with `banked`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confirmation {
    /// Designs of the front, after it was confirmed.
    pub front: usize,
    /// Label of the energy table.
    pub energy_table: String,
    /// Which rows were compared, in words.
    pub scope: String,
    /// The designs, those of the front of `calibrated` first, from its knee outward.
    pub designs: Vec<Confirmed>,
    /// The knee of the sweep with `calibrated` alone.
    pub knee_before: u64,
    /// The knee once designs are confirmed.
    pub knee: u64,
    /// The order of the designs in each objective.
    pub orders: Vec<Order>,
}

/// A design with both models.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confirmed {
    /// Number in the space.
    pub point: u64,
    /// Its hash in the sweep.
    pub id: String,
    /// Where it stands with `banked`.
    pub standing: Standing,
    /// Its numbers: frame time, rate, energy, power and area, then the other objectives.
    pub values: Vec<Compared>,
    /// Its frame time on each trace, whose label stands for the column.
    pub traces: Vec<Compared>,
}

impl Confirmed {
    /// The largest difference of its frame time on any trace, a share without sign.
    pub fn error(&self) -> f64 {
        let differences = self.traces.iter().chain(&self.values[..1]);
        differences.filter_map(Compared::difference).map(f64::abs).fold(0.0, f64::max)
    }
}

/// Where a design stands with `banked`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// It is on the front.
    Front,
    /// Another one beats it.
    Beaten,
    /// It misses the display rate.
    Late,
    /// It does not meet the condition.
    Unmet,
    /// Its simulation went wrong.
    Failed,
}

impl Standing {
    /// As files have it.
    pub const fn name(self) -> &'static str {
        match self {
            Standing::Front => "front",
            Standing::Beaten => "beaten",
            Standing::Late => "late",
            Standing::Unmet => "unmet",
            Standing::Failed => "failed",
        }
    }
}

/// A column of the results with both models.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Compared {
    /// Its name.
    pub column: String,
    /// With `calibrated`, in the unit of the column.
    pub calibrated: Option<f64>,
    /// With `banked`.
    pub banked: Option<f64>,
}

impl Compared {
    /// By which share `calibrated` differs from `banked`: 0.02 is two percent too much.
    pub fn difference(&self) -> Option<f64> {
        let (calibrated, banked) = (self.calibrated?, self.banked?);
        if calibrated == banked {
            return Some(0.0);
        }
        Some((calibrated - banked) / banked.abs()).filter(|share| share.is_finite())
    }
}

/// The order of the designs in one objective.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// The objective.
    pub objective: String,
    /// Pairs of designs that differ by more than noise with `calibrated`.
    pub pairs: usize,
    /// Those of them that differ by more than noise the other way with `banked`.
    pub swapped: usize,
    /// The best of the designs with `calibrated`.
    pub best: Option<u64>,
    /// The best with `banked`; the same one if the two are alike there.
    pub best_banked: Option<u64>,
}

impl Analysis<'_> {
    /// At most `most` designs of the front by their points: the knee, its neighbours along the
    /// front, and outward.
    pub fn from_knee(&self, most: usize) -> Vec<u64> {
        let front = &self.front;
        let knee = front.iter().position(|row| *row == self.knee).unwrap_or(0);
        let mut places: Vec<usize> = (0..front.len()).collect();
        places.sort_by_key(|&place| (place.abs_diff(knee), place));
        places.iter().take(most).map(|&place| self.table.points[front[place] as usize]).collect()
    }

    /// At most `most` designs, the nearest first, that miss the display rate by less than the share
    /// `error`, and that no design of the front would beat if they met it.
    pub fn nearly_met(&self, error: f64, most: usize) -> Vec<u64> {
        let Some(fps) = self.question.display_fps else { return Vec::new() };
        let period_ms = 1e3 / fps;
        let epsilon = self.question.epsilon;
        let (rows, costs) =
            designs::with_costs(self.table, &self.question.objectives, &self.behind);
        let mut near = Vec::new();
        for (place, &row) in rows.iter().enumerate() {
            let point = self.table.points[row as usize];
            let missed = self.late.slowest_ms(point).map_or(0.0, |ms| ms / period_ms - 1.0);
            let is_beaten =
                self.members.iter().any(|&m| beats(self.costs.of(m), costs.of(place), epsilon));
            if missed <= error && !is_beaten {
                near.push((missed, point));
            }
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.into_iter().take(most).map(|(_, point)| point).collect()
    }
}

impl Confirmation {
    /// Compares designs, by their points: `before` is the analysis of the sweep with `calibrated`
    /// alone, `after` that of the table in which they have the place of the others.
    pub fn of(before: &Analysis<'_>, after: &Analysis<'_>, points: &[u64]) -> Confirmation {
        let question = &before.question;
        let tables = [before.table, after.table];
        let label = &before.energy_table;
        let slices = tables.map(|table| slice(table, label, question));
        let sides = Sides { before, after, slices };
        let point = |analysis: &Analysis<'_>| analysis.table.points[analysis.knee as usize];
        let objectives = 0..question.objectives.len();
        Confirmation {
            front: after.front.len(),
            energy_table: label.clone(),
            scope: question.scope.to_string(),
            designs: points.iter().filter_map(|&point| sides.design(point)).collect(),
            knee_before: point(before),
            knee: point(after),
            orders: objectives.map(|j| sides.order(points, j)).collect(),
        }
    }

    /// The largest difference of a frame time on any trace, a share without sign.
    pub fn error(&self) -> f64 {
        self.designs.iter().map(Confirmed::error).fold(0.0, f64::max)
    }

    /// Whether it is of this analysis: of the same objectives and rows.
    pub fn fits(&self, analysis: &Analysis<'_>) -> bool {
        let names = analysis.question.objectives.iter().map(|o| &o.name);
        self.energy_table == analysis.energy_table
            && self.scope == analysis.question.scope.to_string()
            && self.orders.iter().map(|order| &order.objective).eq(names)
    }
}

/// The rows of an energy table; none where it has no results.
fn slice(table: &Table, label: &str, question: &Question) -> DesignSlice {
    let none = DesignSlice { rows: Vec::new(), baseline: None };
    let code = table.energy_tables.find(label);
    code.map_or(none, |code| DesignSlice::of(table, code, &question.scope))
}

/// Both sides of a comparison.
struct Sides<'a, 't> {
    before: &'a Analysis<'t>,
    after: &'a Analysis<'t>,
    slices: [DesignSlice; 2],
}

impl Sides<'_, '_> {
    fn rows(&self, point: u64) -> [Option<u32>; 2] {
        [self.slices[0].row(self.before.table, point), self.slices[1].row(self.after.table, point)]
    }

    fn standing(&self, row: Option<u32>) -> Standing {
        let after = self.after;
        let Some(row) = row else { return Standing::Failed };
        if designs::values(after.table, &after.question.objectives, row).is_none()
            || after.table.models.word(row) != DramModel::Banked.name()
        {
            return Standing::Failed;
        }
        match row {
            row if after.unmet.contains(&row) => Standing::Unmet,
            row if after.front.contains(&row) => Standing::Front,
            row if after.twins.iter().flatten().any(|twin| *twin == row) => Standing::Front,
            row if after.behind.contains(&row) || after.is_late(row) => Standing::Late,
            _ => Standing::Beaten,
        }
    }

    fn design(&self, point: u64) -> Option<Confirmed> {
        let [row, new] = self.rows(point);
        let row = row?;
        let objectives = self.before.question.objectives.iter().map(|o| o.name.as_str());
        let others = objectives.filter(|name| !COLUMNS.contains(name));
        let values = COLUMNS.into_iter().chain(others).map(|column| self.compared(column, point));
        Some(Confirmed {
            point,
            id: format!("{:032x}", self.before.table.ids[row as usize]),
            standing: self.standing(new),
            values: values.collect(),
            traces: self.traces(point),
        })
    }

    fn compared(&self, column: &str, point: u64) -> Compared {
        let of = |table: &Table, row: Option<u32>| table.number(column, row?);
        let [old, new] = self.rows(point);
        Compared {
            column: column.to_owned(),
            calibrated: of(self.before.table, old),
            banked: of(self.after.table, new),
        }
    }

    /// The frame time of a point on every trace.
    fn traces(&self, point: u64) -> Vec<Compared> {
        let table = self.before.table;
        let is_of_trace = |row: &u32| {
            table.points[*row as usize] == point
                && table.over[*row as usize] == Over::Trace
                && table.energy_tables.word(*row) == self.before.energy_table
        };
        let rows = (0..table.len() as u32).filter(is_of_trace);
        let one = |row: u32| {
            // Results take the place of others row by row.
            let of = |table: &Table| table.number("frame_time_ms.mean", row);
            let column = table.traces.word(row).to_owned();
            Compared { column, calibrated: of(table), banked: of(self.after.table) }
        };
        match self.before.question.scope {
            Scope::Trace(_) => Vec::new(),
            Scope::Mean | Scope::Worst => rows.map(one).collect(),
        }
    }

    fn order(&self, points: &[u64], objective: usize) -> Order {
        let question = &self.before.question;
        let objective = &question.objectives[objective];
        let known: Vec<(u64, f64, f64)> = points
            .iter()
            .filter_map(|&point| {
                let Compared { calibrated, banked, .. } = self.compared(&objective.name, point);
                let cost = |value: f64| objective.goal.cost(value);
                Some((point, cost(calibrated?), cost(banked?)))
            })
            .collect();
        let (mut pairs, mut swapped) = (0, 0);
        for (i, a) in known.iter().enumerate() {
            for b in &known[i + 1..] {
                if is_alike(a.1, b.1, question.epsilon) {
                    continue;
                }
                pairs += 1;
                let is_turned = (a.1 < b.1) != (a.2 < b.2);
                swapped += usize::from(is_turned && !is_alike(a.2, b.2, question.epsilon));
            }
        }
        let best = known.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let banked = known.iter().min_by(|a, b| a.2.total_cmp(&b.2));
        let best_banked = match (best, banked) {
            (Some(best), Some(other)) if is_alike(best.2, other.2, question.epsilon) => Some(best),
            _ => banked,
        };
        Order {
            objective: objective.name.clone(),
            pairs,
            swapped,
            best: best.map(|design| design.0),
            best_banked: best_banked.map(|design| design.0),
        }
    }
}
