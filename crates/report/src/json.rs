//! `--json`: the whole run as one object. `schema` describes it.

use serde_json::{Map, Value as Json, json};

use super::csv::shown_of;
use super::limits::measured;
use super::record_of;
use powergs_base::TOOL_VERSION;
use powergs_core::sim::MODEL_VERSION;
use powergs_core::sim::statistics::{self, Aggregate, Kind, Statistic, Value, catalogue};
use powergs_core::stage::Stall;
use powergs_core::stage::stage;
use powergs_energy::action::Phase;
use powergs_study::findings::{Bottleneck, Record, bottleneck, limits};
use powergs_study::run_record::{Run, SCHEMA_VERSION, hash_text};

/// The run as JSON. Statistics are nested by the dots of their names; what was not measured is
/// null.
///
/// # Panics
/// Without frames.
pub fn report(run: &Run) -> Json {
    let (facts, record) = (&run.facts, record_of(run));
    let found = bottleneck::of(&record);
    let mattered = limits::mattered(&record, &facts.machine, found.as_ref(), &run.experiments);
    let shown = shown_of(&record);
    let row = |frame| self::frame(frame, &statistics::values(frame, facts.display_fps), &shown);
    let frames: Vec<Json> = run.frames.iter().map(row).collect();
    json!({
        "schema_version": SCHEMA_VERSION,
        "tool_version": TOOL_VERSION,
        "model_version": MODEL_VERSION,
        "model": facts.model.name(),
        "machine": {
            "name": facts.machine.name,
            "energy_table": facts.machine.energy_table,
            "clock_hz": facts.machine.clock_hz,
            "dram_peak_gb_s": facts.machine.dram_peak_gb_s,
            "doubts": facts.machine.doubts,
        },
        "trace": {
            "name": facts.trace.name,
            "frames": facts.trace.frames,
            "eyes": facts.trace.shown.eyes,
            "width_px": facts.trace.shown.width,
            "height_px": facts.trace.shown.height,
            "sh_degree": run.sh_degree().map(|(degree, _)| degree.get()),
            "sh_degree_assumed": run.sh_degree().map(|(_, is_assumed)| is_assumed),
        },
        "inputs": facts.inputs.iter().map(|input| json!({
            "role": input.role,
            "name": input.name,
            "bytes": input.bytes,
            "xxh3_128": hash_text(input),
        })).collect::<Vec<_>>(),
        "fps": facts.display_fps,
        "incomplete": run.incomplete(),
        "throughput_fps": record.throughput_fps(),
        "throughput_power_w": record.throughput_power_w(),
        "deadline_misses": record.deadline_misses(),
        "bottleneck": bottleneck_json(found.as_ref()),
        "what_if": what_if(run),
        "dram_models": dram_models(run),
        "roofline": roofline(run),
        "not_modelled": not_modelled(run),
        "assumptions_that_mattered": mattered.iter().map(|m| json!({
            "assumption": m.assumption,
            "why": super::limits::why(&m.why),
        })).collect::<Vec<_>>(),
        "prices": prices(run),
        "aggregate": aggregates(&record, &shown),
        "frames": frames,
    })
}

/// The bottleneck, in numbers and as the sentence.
pub(super) fn bottleneck_json(found: Option<&Bottleneck>) -> Json {
    let Some(found) = found else { return Json::Null };
    json!({
        "limit": found.limit.name(),
        "sentence": super::bottleneck::sentence(found),
        "bounds": found.bounds.iter().map(|b| json!({
            "unit": stage(b.unit).key,
            "frame_frac": b.share,
        })).collect::<Vec<_>>(),
        "waits": found.waits.iter().map(|w| json!({
            "cause": w.cause.name(),
            "frame_frac": w.share,
            "row_miss_frac": w.row_miss,
            "roots": w.roots.iter().map(|root| json!({
                "unit": stage(root.unit).key,
                "cause": root.cause.map(Stall::name),
                "frame_frac": root.share,
            })).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "without_work_frac": found.without_work,
    })
}

fn what_if(run: &Run) -> Json {
    let Some(experiment) = &run.experiments.what_if else { return Json::Null };
    json!({
        "frames": experiment.frames,
        "is_calibrated": experiment.is_calibrated,
        "frame_time_ms": experiment.base.frame_time_ms,
        "energy_pj": experiment.base.energy_pj,
        "power_w": experiment.base.power_w,
        "area_mm2": experiment.base.area_mm2,
        "fps_per_mm2": experiment.base.fps_per_mm2(),
        "doubled": experiment.steps.iter().map(|step| json!({
            "resource": step.resource,
            "set": step.sets,
            "frame_time_ms": step.cost.frame_time_ms,
            "energy_pj": step.cost.energy_pj,
            "power_w": step.cost.power_w,
            "area_mm2": step.cost.area_mm2,
            "fps_per_mm2": step.cost.fps_per_mm2(),
            "frame_time_change_frac": experiment.time_change(step),
            "energy_change_frac": experiment.energy_change(step),
            "power_change_frac": experiment.power_change(step),
            "area_change_frac": experiment.area_change(step),
            "fps_per_mm2_change_frac": experiment.merit_change(step),
        })).collect::<Vec<_>>(),
        "skipped": experiment.skipped.iter().map(|s| json!({
            "resource": s.resource,
            "reason": s.reason,
        })).collect::<Vec<_>>(),
    })
}

fn dram_models(run: &Run) -> Json {
    let Some(models) = run.experiments.dram_models else { return Json::Null };
    let [time, bytes] = models.differences();
    json!({
        "calibrated_frame_time_ms": models.calibrated_ms,
        "banked_frame_time_ms": models.banked_ms,
        "calibrated_moved_bytes": models.calibrated_bytes,
        "banked_moved_bytes": models.banked_bytes,
        "frame_time_difference_frac": time,
        "moved_bytes_difference_frac": bytes,
    })
}

fn roofline(run: &Run) -> Json {
    let Some(roof) = &run.facts.machine.roofline else { return Json::Null };
    json!({
        "units": roof.units.iter().zip(Phase::WORK).map(|((name, peak), stage)| json!({
            "stage": stage.name(),
            "unit": name,
            "peak_flop_s": peak,
        })).collect::<Vec<_>>(),
        "dram_bytes_s": roof.dram_bytes_s,
        "points": roof.points(run).iter().map(|p| json!({
            "stage": p.name(),
            "flop_per_byte": p.flop_per_byte,
            "flop_s": p.flop_s,
            "roof_flop_s": p.roof_flop_s,
            "roof": p.roof.name(),
            "attained_frac": p.attained(),
        })).collect::<Vec<_>>(),
    })
}

fn prices(run: &Run) -> Json {
    let Some(prices) = &run.experiments.prices else { return Json::Null };
    json!({
        "power_w": prices.power_w,
        "bars": prices.bars.iter().map(|bar| json!({
            "assumption": bar.assumption,
            "keys": bar.keys,
            "low_power_w": bar.low_w,
            "high_power_w": bar.high_w,
        })).collect::<Vec<_>>(),
    })
}

fn not_modelled(run: &Run) -> Vec<Json> {
    let effects = &run.facts.machine.left_out;
    let entry = |e: &limits::Effect| {
        let see = (!e.assumption.is_empty()).then_some(e.assumption);
        let rtl = measured(e)
            .map(|rtl| json!({ "of": rtl.of, "low_percent": rtl.low, "high_percent": rtl.high }));
        json!({ "effect": e.what, "bias": e.bias.name(), "assumption": see, "rtl": rtl })
    };
    effects.iter().map(entry).collect()
}

fn frame(frame: &powergs_core::sim::FrameReport, row: &[Option<Value>], shown: &[usize]) -> Json {
    let mut map = Map::new();
    map.insert("frame".into(), frame.frame.into());
    map.insert("name".into(), frame.name.clone().into());
    for &i in shown {
        nest(&mut map, &catalogue()[i].name, row[i].map_or(Json::Null, number));
    }
    Json::Object(map)
}

fn aggregates(record: &Record, shown: &[usize]) -> Json {
    let mut map = Map::new();
    for &i in shown {
        let value = record.aggregates[i].as_ref().map_or(Json::Null, |a| {
            let parts = Aggregate::PARTS.iter().zip(a.parts());
            Json::Object(parts.map(|(name, v)| ((*name).to_owned(), number(v))).collect())
        });
        nest(&mut map, &catalogue()[i].name, value);
    }
    Json::Object(map)
}

fn number(value: Value) -> Json {
    match value {
        Value::Count(n) => n.into(),
        Value::Real(x) => x.into(),
    }
}

/// The statistics over the frames of a run that [`report`] wrote; what is missing is a gap.
pub fn record(report: &Json) -> Record {
    let aggregate = |s: &Statistic| {
        let all = at(&report["aggregate"], s);
        let [p50, p95, p99, max] = ["p50", "p95", "p99", "max"].map(|part| value(&all[part], s));
        let mean = all["mean"].as_f64()?;
        Some(Aggregate { mean, p50: p50?, p95: p95?, p99: p99?, max: max? })
    };
    Record {
        display_fps: report["fps"].as_f64().unwrap_or_default(),
        frames: report["frames"].as_array().map_or(0, |frames| frames.len() as u64),
        aggregates: catalogue().iter().map(aggregate).collect(),
    }
}

/// The values of all statistics of a frame that [`report`] wrote, in the order of the catalogue.
pub fn values(frame: &Json) -> Vec<Option<Value>> {
    catalogue().iter().map(|s| value(at(frame, s), s)).collect()
}

/// What is at the dots of a name.
fn at<'a>(json: &'a Json, statistic: &Statistic) -> &'a Json {
    statistic.name.split('.').fold(json, |at, part| &at[part])
}

fn value(json: &Json, statistic: &Statistic) -> Option<Value> {
    match statistic.kind {
        Kind::Count => json.as_u64().map(Value::Count),
        Kind::Real => json.as_f64().map(Value::Real),
    }
}

/// Puts `value` at a dotted path, making the objects on the way.
pub(super) fn nest(map: &mut Map<String, Json>, path: &str, value: Json) {
    match path.split_once('.') {
        None => {
            map.insert(path.to_owned(), value);
        }
        Some((head, rest)) => {
            let inner = map.entry(head).or_insert_with(|| Json::Object(Map::new()));
            let inner = inner.as_object_mut().expect("no statistic is the parent of another");
            nest(inner, rest, value);
        }
    }
}
