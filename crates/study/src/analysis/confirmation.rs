//! The front of a sweep on `calibrated` DRAM, against the same designs on `banked`.
//!
//! The knee comes first, then its neighbours along the front, then outward. With `banked` the
//! designs are ranked among themselves, with the scaling of the sweep's own front: so the knee
//! stays the knee unless another of them has a smaller merit.

use serde::{Deserialize, Serialize};

use super::Analysis;
use super::designs::{self, Slice};
use super::front::is_alike;
use super::question::{AnalysisError, Misses, Named, Question};
use super::table::Table;

/// Columns that are compared besides the objectives.
const COLUMNS: [&str; 5] =
    ["frame_time_ms.mean", "fps.mean", "energy_pj.mean", "power_w.mean", "area_mm2"];

/// What became of the front of a sweep with `banked`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confirmation {
    /// Designs of the whole front.
    pub front: usize,
    /// Label of the energy table.
    pub energy_table: String,
    /// Which rows were compared, in words.
    pub scope: String,
    /// The designs, the knee of the sweep first.
    pub designs: Vec<Confirmed>,
    /// The knee with `banked`; `None` if none of them can be ranked.
    pub knee: Option<u64>,
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
}

/// Where a design of the front stands with `banked`, among those that were confirmed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// None of them beats it.
    Front,
    /// Another one beats it.
    Beaten,
    /// It misses the display rate, which it met.
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
}

impl Confirmation {
    /// Compares designs of an analysis, by their points, with the same ones in `banked`: a table
    /// with the same columns.
    ///
    /// # Errors
    /// Those of [`Analysis::of`], unless no design can be ranked.
    pub fn of(
        analysis: &Analysis<'_>,
        points: &[u64],
        banked: &Table,
    ) -> Result<Confirmation, AnalysisError> {
        let table = &analysis.energy_table;
        let question = Question {
            energy_table: Some(table.clone()),
            design: Named::Baseline,
            ..analysis.question.clone()
        };
        let ranked = match banked.is_empty() {
            true => None,
            false => match Analysis::of(banked, &question) {
                Ok(ranked) => Some(ranked),
                Err(AnalysisError::Unmet { .. } | AnalysisError::Nothing { .. }) => None,
                Err(error) => return Err(error),
            },
        };
        let slices = Sides { analysis, banked, slice: slice(banked, table, &question) };
        let knee = ranked.as_ref().map(|ranked| knee(analysis, ranked));
        let standing = |point| slices.standing(ranked.as_ref(), point);
        let designs = points.iter().filter_map(|&point| slices.design(point, standing(point)));
        let designs = designs.collect();
        let objectives = 0..question.objectives.len();
        Ok(Confirmation {
            front: analysis.front.len(),
            energy_table: table.clone(),
            scope: question.scope.to_string(),
            designs,
            knee,
            orders: objectives.map(|j| slices.order(points, j)).collect(),
        })
    }

    /// The knee of the sweep.
    pub fn knee_before(&self) -> Option<u64> {
        self.designs.first().map(|design| design.point)
    }

    /// Whether it is of this analysis: of the same objectives and rows, with the same knee.
    pub fn fits(&self, analysis: &Analysis<'_>) -> bool {
        let names = analysis.question.objectives.iter().map(|o| &o.name);
        self.energy_table == analysis.energy_table
            && self.scope == analysis.question.scope.to_string()
            && self.orders.iter().map(|order| &order.objective).eq(names)
            && self.designs.iter().map(|d| d.point).eq(analysis.from_knee(self.designs.len()))
    }
}

/// The rows of an energy table; none where it has no results.
fn slice(table: &Table, label: &str, question: &Question) -> Slice {
    let none = Slice { rows: Vec::new(), baseline: None };
    let code = table.energy_tables.find(label);
    code.map_or(none, |code| Slice::of(table, code, &question.scope))
}

/// The knee with `banked`; that of the sweep if it is alike.
fn knee(analysis: &Analysis<'_>, ranked: &Analysis<'_>) -> u64 {
    let merit = |place: &usize| analysis.scaling.merit(ranked.costs.of(ranked.members[*place]));
    let best = (0..ranked.front.len()).min_by(|a, b| merit(a).total_cmp(&merit(b)));
    let best = best.expect("finite costs have a front");
    let point = |row: &u32| ranked.table.points[*row as usize];
    let before = analysis.table.points[analysis.knee as usize];
    match ranked.twins[best].iter().any(|row| point(row) == before) {
        true => before,
        false => point(&ranked.front[best]),
    }
}

/// Both sides of a comparison.
struct Sides<'a, 't> {
    analysis: &'a Analysis<'t>,
    banked: &'a Table,
    slice: Slice,
}

impl Sides<'_, '_> {
    fn row(&self, point: u64) -> Option<u32> {
        let is_it = |row: &&u32| self.analysis.table.points[**row as usize] == point;
        self.analysis.front.iter().find(is_it).copied()
    }

    fn standing(&self, ranked: Option<&Analysis<'_>>, point: u64) -> Standing {
        let Some(row) = self.slice.row(self.banked, point) else { return Standing::Failed };
        let objectives = &self.analysis.question.objectives;
        if designs::values(self.banked, objectives, row).is_none() {
            return Standing::Failed;
        }
        let Some(ranked) = ranked else { return Standing::Unmet };
        let was_late = self.row(point).is_some_and(|row| self.analysis.is_late(row));
        let behind = self.analysis.question.misses == Misses::Behind;
        match row {
            row if ranked.unmet.contains(&row) => Standing::Unmet,
            row if behind && !was_late && ranked.is_late(row) => Standing::Late,
            row if ranked.front.contains(&row) => Standing::Front,
            row if ranked.twins.iter().flatten().any(|twin| *twin == row) => Standing::Front,
            row if ranked.behind.contains(&row) => Standing::Late,
            _ => Standing::Beaten,
        }
    }

    fn design(&self, point: u64, standing: Standing) -> Option<Confirmed> {
        let row = self.row(point)?;
        let objectives = self.analysis.question.objectives.iter().map(|o| o.name.as_str());
        let others = objectives.filter(|name| !COLUMNS.contains(name));
        let values = COLUMNS.into_iter().chain(others).map(|column| self.compared(column, point));
        Some(Confirmed {
            point,
            id: format!("{:032x}", self.analysis.table.ids[row as usize]),
            standing,
            values: values.collect(),
        })
    }

    fn compared(&self, column: &str, point: u64) -> Compared {
        let of = |table: &Table, row: Option<u32>| table.number(column, row?);
        Compared {
            column: column.to_owned(),
            calibrated: of(self.analysis.table, self.row(point)),
            banked: of(self.banked, self.slice.row(self.banked, point)),
        }
    }

    fn order(&self, points: &[u64], objective: usize) -> Order {
        let question = &self.analysis.question;
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
