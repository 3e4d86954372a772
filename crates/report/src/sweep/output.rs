//! The answer for programs: JSON, and the rows of the front as CSV.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

use serde_json::{Map, Value as Json, json};

use powergs_base::TOOL_VERSION;
use powergs_base::format::spreadsheet_safe;
use powergs_study::analysis::axes::Axis;
use powergs_study::analysis::distance::Better;
use powergs_study::analysis::marginal::{Marginal, Neighbour};
use powergs_study::analysis::stability::Alternative;
use powergs_study::analysis::{Analysis, Goal, Misses, Scope};
use powergs_study::run_record::SCHEMA_VERSION;

/// The answer as one object. Values are in the units of their columns.
pub fn json(analysis: &Analysis) -> Json {
    let question = &analysis.question;
    let counts = analysis.table.counts;
    let front: Vec<Json> = analysis.front.iter().map(|&row| design(analysis, row)).collect();
    let named = analysis.named.as_ref().map(|named| {
        let better = |b: &Better| better(analysis, b);
        json!({
            "design": design(analysis, named.row),
            "meets_condition": named.meets,
            "on_front": named.on_front,
            "same_as": named.twin.map(|row| label(analysis, row)),
            "nearest_better": named.distance.nearest.as_ref().map(better),
            "best_per_objective": named.distance.best.iter().map(better).collect::<Vec<_>>(),
        })
    });
    let objective = |o: &powergs_study::analysis::Objective| {
        let goal = match o.goal {
            Goal::Minimize => "minimize",
            Goal::Maximize => "maximize",
        };
        json!({ "name": o.name, "goal": goal })
    };
    let around = |steps: &[Neighbour]| -> Vec<Json> {
        steps.iter().map(|step| neighbour(analysis, step)).collect()
    };
    json!({
        "schema_version": SCHEMA_VERSION,
        "tool_version": TOOL_VERSION,
        "question": question.text,
        "objectives": question.objectives.iter().map(objective).collect::<Vec<_>>(),
        "where": question.condition.as_ref().map(|c| c.text()),
        "scope": scope(&question.scope),
        "energy_table": analysis.energy_table,
        "epsilon": question.epsilon,
        "display_fps": question.display_fps,
        "misses": match question.misses {
            Misses::Behind => "behind",
            Misses::Included => "included",
        },
        "points": {
            "simulated": analysis.simulated,
            "meeting_condition": analysis.rows.len() + analysis.behind.len(),
            "behind": analysis.behind.len(),
            "invalid": counts.invalid,
            "failed": counts.failed,
            "excluded": counts.excluded,
            "missing": counts.missing,
        },
        "front": front,
        "knee": {
            "design": design(analysis, analysis.knee),
            "reason": super::words::knee(analysis).join(" "),
        },
        "doubts": question.doubts,
        "without_cost": question.free.iter().map(|f| {
            json!({ "axis": f.axis, "is_policy": f.is_policy })
        }).collect::<Vec<_>>(),
        "best_rate_reached": analysis.unreached().map(|(row, fps)| {
            json!({ "point": label(analysis, row), "fps_min": fps })
        }),
        "at_end_of_axis": analysis.at_ends.iter().map(|end| {
            let side = if end.is_largest { "largest" } else { "smallest" };
            json!({ "key": end.axis, "value": end.value, "side": side })
        }).collect::<Vec<_>>(),
        "ends": analysis.ends.iter().map(|&row| label(analysis, row)).collect::<Vec<_>>(),
        "named": named,
        "marginal": analysis.marginals.iter().map(|m| marginal(analysis, m)).collect::<Vec<_>>(),
        "around_knee": around(&analysis.around_knee),
        "around_baseline": around(&analysis.around_baseline),
        "stability": stability(analysis),
        "axes": analysis.axes.iter().map(|axis| self::axis(analysis, axis)).collect::<Vec<_>>(),
    })
}

fn label(analysis: &Analysis, row: u32) -> Json {
    if analysis.table.is_baseline(row) {
        return "baseline".into();
    }
    analysis.table.points[row as usize].into()
}

fn scope(scope: &Scope) -> Json {
    match scope {
        Scope::Mean => json!({ "kind": "mean" }),
        Scope::Worst => json!({ "kind": "worst" }),
        Scope::Trace(label) => json!({ "kind": "trace", "trace": label }),
    }
}

/// Objectives by name.
fn by_objective(analysis: &Analysis, values: impl Iterator<Item = Option<f64>>) -> Json {
    let names = analysis.question.objectives.iter().map(|o| o.name.clone());
    Json::Object(names.zip(values.map(|v| json!(v))).collect::<Map<_, _>>())
}

fn design(analysis: &Analysis, row: u32) -> Json {
    let table = analysis.table;
    let objectives = 0..analysis.question.objectives.len();
    let settings: Map<String, Json> =
        table.settings(row).into_iter().map(|(k, v)| (k.to_owned(), v.into())).collect();
    json!({
        "point": label(analysis, row),
        "id": format!("{:032x}", table.ids[row as usize]),
        "values": by_objective(analysis, objectives.map(|j| Some(analysis.value(j, row)))),
        "misses_display_rate": analysis.is_late(row),
        "same_as": twins(analysis, row).iter().map(|&r| label(analysis, r)).collect::<Vec<_>>(),
        "settings": settings,
    })
}

/// Rows of the designs that are equal to an entry of the front.
fn twins<'a>(analysis: &'a Analysis, row: u32) -> &'a [u32] {
    let place = analysis.front.iter().position(|r| *r == row);
    place.map_or(&[], |place| analysis.twins[place].as_slice())
}

fn better(analysis: &Analysis, better: &Better) -> Json {
    let row = analysis.rows[better.design];
    json!({
        "point": label(analysis, row),
        "gains": by_objective(analysis, better.gains.iter().map(|g| Some(*g))),
        "scaled_distance": better.distance,
    })
}

fn marginal(analysis: &Analysis, marginal: &Marginal) -> Json {
    let step = |s: &powergs_study::analysis::marginal::Step| {
        json!({
            "from": label(analysis, s.from),
            "to": label(analysis, s.to),
            "price": s.price,
            "gain": s.gain,
            "gain_per_price": s.value(),
        })
    };
    json!({
        "price": marginal.price.column(&analysis.question.objectives),
        "price_unit": marginal.price.unit(),
        "objective": marginal.objective.name,
        "steps": marginal.steps.iter().map(step).collect::<Vec<_>>(),
    })
}

fn neighbour(analysis: &Analysis, step: &Neighbour) -> Json {
    let (name, words) = &analysis.table.axes[step.axis];
    let [area, power] = step.prices;
    json!({
        "axis": name,
        "value": words.word(step.row),
        "point": label(analysis, step.row),
        "gains": by_objective(analysis, step.gains.iter().copied()),
        "area_mm2": area,
        "power_mw": power,
    })
}

fn stability(analysis: &Analysis) -> Json {
    let stability = &analysis.stability;
    let alternative = |a: &Alternative| {
        json!({
            "label": a.label,
            "energy_table": a.energy_table,
            "scope": scope(&a.scope),
            "designs": a.designs,
            "kendall_tau_b": a.kendall,
            "spearman_rho": a.spearman,
            "kendall_tau_b_by_objective": by_objective(analysis, a.objectives.iter().copied()),
            "top_kept": a.top_kept,
            "front_kept": a.front_kept,
            "front": a.front,
            "front_breaking_condition": a.broken,
            "ranks": a.ranks,
            "winner": a.winner.map(|row| label(analysis, row)),
            "why": super::words::flip(analysis, a),
        })
    };
    let member = |&(point, n): &(u64, usize)| json!({ "point": point, "fronts": n });
    json!({
        "top": stability.top.iter().map(|&row| label(analysis, row)).collect::<Vec<_>>(),
        "rankings": stability.rankings(),
        "alternatives": stability.alternatives.iter().map(alternative).collect::<Vec<_>>(),
        "alternatives_left_out": stability.left_out,
        "front_membership": stability.membership.iter().map(member).collect::<Vec<_>>(),
    })
}

fn axis(analysis: &Analysis, axis: &Axis) -> Json {
    json!({
        "key": axis.name,
        "values": axis.values,
        "dead": axis.is_dead(),
        "main_effect": by_objective(analysis, axis.effects.iter().map(|e| Some(e.main))),
        "largest_alone": by_objective(analysis, axis.effects.iter().map(|e| e.alone)),
    })
}

/// The rows of the table that [`pareto_csv`] has: those of the front, and that of the design whose
/// distance is told.
pub fn pareto_rows(analysis: &Analysis) -> BTreeSet<u32> {
    places(analysis).iter().map(|row| analysis.table.records[*row as usize]).collect()
}

/// Rows of the analysed table: the front, then the named design.
fn places(analysis: &Analysis) -> Vec<u32> {
    let named = analysis.named.as_ref().map(|n| n.row).filter(|r| !analysis.front.contains(r));
    analysis.front.iter().copied().chain(named).collect()
}

/// [`pareto_csv`] from the `results.csv` that the table was read from.
///
/// # Errors
/// Results that are no CSV.
pub fn pareto_csv_of(analysis: &Analysis, results: impl Read) -> Result<Vec<u8>, csv::Error> {
    let wanted = pareto_rows(analysis);
    let mut reader = csv::Reader::from_reader(results);
    let head: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    let mut rows = BTreeMap::new();
    let mut record = csv::StringRecord::new();
    let mut n = 0;
    while reader.read_record(&mut record)? {
        if wanted.contains(&n) {
            rows.insert(n, record.iter().map(str::to_owned).collect());
        }
        n += 1;
    }
    pareto_csv(analysis, &head, &rows)
}

/// `pareto.csv`: the rows of the front as they stand in the results, best in the first objective
/// first, with three columns before them: `role` (`knee`, `front`, or the label of the named
/// design), `misses_display_rate`, and `same_as` with the points that are equal but for noise.
/// `rows` are those of [`pareto_rows`] under `head`.
///
/// # Errors
/// Rows of different lengths.
pub fn pareto_csv(
    analysis: &Analysis,
    head: &[String],
    rows: &BTreeMap<u32, Vec<String>>,
) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let words = |first: [&str; 3], row: &[String]| {
        let cells = first.into_iter().map(str::to_owned).chain(row.to_vec());
        cells.map(spreadsheet_safe).collect::<Vec<String>>()
    };
    writer.write_record(words(["role", "misses_display_rate", "same_as"], head))?;
    for row in places(analysis) {
        let role = match row {
            row if row == analysis.knee => "knee".to_owned(),
            row if analysis.front.contains(&row) => "front".to_owned(),
            row => analysis.table.label(row),
        };
        let late = analysis.is_late(row).to_string();
        let point = |row: &u32| analysis.table.points[*row as usize].to_string();
        let same: Vec<String> = twins(analysis, row).iter().map(point).collect();
        let record = &rows[&analysis.table.records[row as usize]];
        writer.write_record(words([&role, &late, &same.join(" ")], record))?;
    }
    Ok(writer.into_inner().expect("writing to memory cannot fail"))
}
