//! The JSON schema of `--json`, written from the catalogue of statistics.

use serde_json::{Map, Value as Json, json};

use powergs_core::sim::statistics::{Aggregate, Kind, Statistic, catalogue};
use powergs_study::run_record::SCHEMA_VERSION;

/// The schema (draft 2020-12) of what [`super::json::report`] returns.
pub fn schema() -> Json {
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": format!("powergs-sim-report-{SCHEMA_VERSION}"),
        "title": "Report of powergs-sim replay",
        "description": "What `replay --json` prints. Null: not measured by this model or trace.",
        "type": "object",
        "additionalProperties": false,
        "required": required(&top()),
        "properties": top(),
        "$defs": definitions(),
    })
}

fn top() -> Map<String, Json> {
    let entries = [
        ("schema_version", constant(SCHEMA_VERSION, "Version of this schema.")),
        ("tool_version", plain("string", "Version of powergs-sim.")),
        ("model_version", plain("integer", "Raised when the same inputs give other numbers.")),
        ("model", json!({"enum": ["paper", "cycle"], "description": "Which model counted."})),
        ("machine", object(machine(), "The machine.")),
        ("trace", object(trace(), "The trace.")),
        ("inputs", array(object(input(), "A file that was read."), "Files that were read.")),
        ("fps", plain("number", "Display rate that powers and deadlines are for, 1/s.")),
        ("incomplete", plain("boolean", "Whether the run ended before its last frame.")),
        (
            "throughput_fps",
            nullable("number", "Frames over the simulated time of all of them, 1/s."),
        ),
        (
            "throughput_power_w",
            nullable("number", "Energy of all frames over their simulated time: full rate, W."),
        ),
        ("deadline_misses", nullable("integer", "Frames that took longer than 1 / `fps`.")),
        ("bottleneck", or_null(object(bottleneck(), "What limits the run; null without time."))),
        ("what_if", or_null(object(what_if(), "Resources doubled; null where none was tried."))),
        ("dram_models", or_null(object(dram_models(), "Two models of the DRAM; else null."))),
        ("roofline", or_null(object(roofline(), "Peaks and points; null without time."))),
        ("not_modelled", array(object(effect(), "An effect that is left out."), "Left out.")),
        (
            "assumptions_that_mattered",
            array(object(mattered(), "An assumption."), "Those that mattered most in this run."),
        ),
        (
            "prices",
            or_null(object(prices(), "Price assumptions in use; null where none is known.")),
        ),
        ("aggregate", object(statistics(aggregate), "Over all frames, each with equal weight.")),
        ("frames", array(object(frame(), "One frame."), "Reported frames, in order.")),
    ];
    entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn machine() -> Map<String, Json> {
    map([
        ("name", plain("string", "Name of the machine.")),
        ("energy_table", plain("string", "Name of the energy table.")),
        ("clock_hz", nullable("number", "Clock, Hz.")),
        ("dram_peak_gb_s", nullable("number", "Peak DRAM rate, 10⁹ bytes per second.")),
        (
            "doubts",
            array(
                plain("string", "A sentence without its end."),
                "What is right in its files and doubtful, as prices for another clock.",
            ),
        ),
    ])
}

fn trace() -> Map<String, Json> {
    map([
        ("name", plain("string", "File name without its ending.")),
        ("frames", plain("integer", "Frames of the display that were asked for.")),
        ("eyes", plain("integer", "Views of a frame: 2 where they are in pairs, else 1.")),
        ("width_px", plain("integer", "Width of the first view, pixels.")),
        ("height_px", plain("integer", "Height of the first view, pixels.")),
        ("sh_degree", nullable("integer", "SH degree of the scene; null without frames.")),
        (
            "sh_degree_assumed",
            nullable("boolean", "Whether the trace does not say it, so that it counts as 3."),
        ),
    ])
}

fn input() -> Map<String, Json> {
    map([
        ("role", plain("string", "What it was used as.")),
        ("name", plain("string", "File name without folders.")),
        ("bytes", plain("integer", "Size, bytes.")),
        ("xxh3_128", plain("string", "XXH3, 128 bits, hexadecimal.")),
    ])
}

fn bottleneck() -> Map<String, Json> {
    let bound = map([
        ("unit", plain("string", "Name of the unit.")),
        ("frame_frac", plain("number", "Share of the frame in which it leads and works.")),
    ]);
    let root = map([
        ("unit", plain("string", "Name of the slow unit.")),
        ("cause", nullable("string", "What it waits for; null where it works.")),
        ("frame_frac", plain("number", "Share of the frame.")),
    ]);
    let wait = map([
        ("cause", plain("string", "What for.")),
        ("frame_frac", plain("number", "Share of the frame.")),
        ("row_miss_frac", nullable("number", "Bursts of the stage that waits that opened a row.")),
        ("roots", array(object(root, "A slow unit."), "Where a wait for another unit begins.")),
    ]);
    map([
        ("limit", plain("string", "A unit, or `dram`.")),
        ("sentence", plain("string", "For people.")),
        ("bounds", array(object(bound, "A unit."), "Leading units at work.")),
        ("waits", array(object(wait, "A cause."), "Leading units waiting.")),
        ("without_work_frac", plain("number", "Leading units without work, share of the frame.")),
    ])
}

fn what_if() -> Map<String, Json> {
    let frame = || plain("number", "Time of a frame, ms.");
    let energy = || plain("number", "Energy of a frame, pJ.");
    let power = || plain("number", "Power at the display rate, W.");
    let area = || nullable("number", "Area of the die, mm².");
    let merit = || nullable("number", "Frames per second and mm² of that area.");
    let text = || plain("string", "One of them.");
    let step = map([
        ("resource", plain("string", "What was doubled.")),
        ("set", array(text(), "The `--set` values that double it.")),
        ("frame_time_ms", frame()),
        ("energy_pj", energy()),
        ("power_w", power()),
        ("area_mm2", area()),
        ("fps_per_mm2", merit()),
        ("frame_time_change_frac", plain("number", "Relative change; negative is faster.")),
        ("energy_change_frac", plain("number", "Relative change; negative is less.")),
        ("power_change_frac", plain("number", "Relative change; negative is less.")),
        ("area_change_frac", nullable("number", "Relative change; negative is less.")),
        ("fps_per_mm2_change_frac", nullable("number", "Relative change; positive is better.")),
    ]);
    let skipped = map([
        ("resource", plain("string", "What was to be doubled.")),
        ("reason", plain("string", "Why that configuration is invalid.")),
    ]);
    map([
        ("frames", array(plain("integer", "Position in the trace."), "Frames that were tried.")),
        (
            "is_calibrated",
            plain("boolean", "The DRAM model is `calibrated` here, and `banked` elsewhere."),
        ),
        ("frame_time_ms", frame()),
        ("energy_pj", energy()),
        ("power_w", power()),
        ("area_mm2", area()),
        ("fps_per_mm2", merit()),
        ("doubled", array(object(step, "A resource."), "By the time that is saved, most first.")),
        ("skipped", array(object(skipped, "A resource."), "What could not be doubled.")),
    ])
}

fn dram_models() -> Map<String, Json> {
    map([
        ("calibrated_frame_time_ms", plain("number", "Frame time of the `calibrated` model, ms.")),
        ("banked_frame_time_ms", plain("number", "Frame time of the `banked` model, ms.")),
        ("calibrated_moved_bytes", plain("number", "Bytes that the `calibrated` model moved, B.")),
        ("banked_moved_bytes", plain("number", "Bytes that the `banked` model moved, B.")),
        ("frame_time_difference_frac", plain("number", "`calibrated` over `banked`, less 1.")),
        ("moved_bytes_difference_frac", plain("number", "`calibrated` over `banked`, less 1.")),
    ])
}

fn roofline() -> Map<String, Json> {
    let point = map([
        ("stage", plain("string", "A stage, or `frame`.")),
        ("flop_per_byte", plain("number", "Operations per DRAM byte.")),
        ("flop_s", plain("number", "Operations per second, 1/s.")),
        ("roof_flop_s", plain("number", "The most that its units and the DRAM allow, 1/s.")),
        ("roof", json!({"enum": ["units", "dram"], "description": "Which of the two that is."})),
        ("attained_frac", plain("number", "Share of its roof.")),
    ]);
    let units = map([
        ("stage", plain("string", "A stage.")),
        ("unit", plain("string", "The units that work for it.")),
        ("peak_flop_s", plain("number", "Operations per second when all are busy, 1/s.")),
    ]);
    map([
        ("units", array(object(units, "The units of a stage."), "Peaks by stage.")),
        ("dram_bytes_s", plain("number", "Peak DRAM rate, B/s.")),
        ("points", array(object(point, "A stage."), "Stages with operations, and the frame.")),
    ])
}

fn effect() -> Map<String, Json> {
    map([
        ("effect", plain("string", "What is left out.")),
        ("bias", json!({"enum": ["optimistic", "pessimistic", "either"], "description": "Bias."})),
        ("assumption", nullable("string", "Where it is explained.")),
        (
            "rtl",
            or_null(object(rtl_error(), "By how much the chip of rtl/ takes longer, of a phase.")),
        ),
    ])
}

fn rtl_error() -> Map<String, Json> {
    map([
        ("of", plain("string", "The phase.")),
        ("low_percent", plain("number", "The least of all runs.")),
        ("high_percent", plain("number", "The most of all runs.")),
    ])
}

fn mattered() -> Map<String, Json> {
    map([
        ("assumption", plain("string", "Number of the assumption, or key of a reference.")),
        ("why", plain("string", "Why it mattered.")),
    ])
}

fn prices() -> Map<String, Json> {
    let bar = map([
        ("assumption", plain("string", "Number of the assumption.")),
        ("keys", array(json!({"type": "string"}), "Keys of its knob.")),
        ("low_power_w", plain("number", "Least power with the knob turned, W.")),
        ("high_power_w", plain("number", "Greatest power with the knob turned, W.")),
    ]);
    map([
        ("power_w", plain("number", "Power at the display rate with the prices as they are, W.")),
        ("bars", array(object(bar, "An assumption, alone."), "Those that move it, widest first.")),
    ])
}

fn frame() -> Map<String, Json> {
    let mut entries = map([
        ("frame", plain("integer", "Position in the trace.")),
        ("name", plain("string", "Name of the view.")),
    ]);
    entries.extend(statistics(|s| {
        let mut value = nullable(number_type(s), &s.definition);
        value["unit"] = s.unit.into();
        value
    }));
    entries
}

/// The two shapes of an aggregate, referred to by [`aggregate`].
fn definitions() -> Json {
    let shape = |kind: &str| {
        let parts = Aggregate::PARTS.map(|part| {
            let kind = if part == "mean" { "number" } else { kind };
            (part, json!({ "type": kind }))
        });
        let mut shape = object(map(parts), "Null unless every frame has the value.");
        shape["type"] = json!(["object", "null"]);
        shape
    };
    json!({ "count": shape("integer"), "measure": shape("number") })
}

fn aggregate(statistic: &Statistic) -> Json {
    let shape = match statistic.kind {
        Kind::Count => "count",
        Kind::Real => "measure",
    };
    json!({ "$ref": format!("#/$defs/{shape}") })
}

fn number_type(statistic: &Statistic) -> &'static str {
    match statistic.kind {
        Kind::Count => "integer",
        Kind::Real => "number",
    }
}

/// The catalogue, nested by the dots, with `leaf` as the schema of each statistic.
fn statistics(leaf: impl Fn(&Statistic) -> Json) -> Map<String, Json> {
    let mut map = Map::new();
    for statistic in catalogue() {
        let mut leaf = leaf(statistic);
        if !statistic.flows.is_empty() {
            leaf[FLOWS] = json!(statistic.flows);
        }
        insert(&mut map, &statistic.name, leaf);
    }
    map
}

fn insert(map: &mut Map<String, Json>, path: &str, value: Json) {
    let Some((head, rest)) = path.split_once('.') else {
        map.insert(path.to_owned(), value);
        return;
    };
    let group = map.entry(head).or_insert_with(|| object(Map::new(), ""));
    let inner = group["properties"].as_object_mut().expect("no statistic is a parent");
    insert(inner, rest, value);
    group["required"] = required(group["properties"].as_object().expect("just filled"));
}

/// Which dataflows a statistic is of; machines of others do not have it.
const FLOWS: &str = "x-dataflows";

fn required(properties: &Map<String, Json>) -> Json {
    let is_own = |value: &Json| {
        let nothing = |keys: &Json| keys.as_array().is_some_and(Vec::is_empty);
        value.get(FLOWS).is_some() || value.get("required").is_some_and(nothing)
    };
    let all = properties.iter().filter(|(_, value)| !is_own(value)).map(|(name, _)| name.clone());
    all.collect::<Vec<_>>().into()
}

fn object(properties: Map<String, Json>, description: &str) -> Json {
    let mut value = json!({
        "type": "object",
        "additionalProperties": false,
        "required": required(&properties),
        "properties": properties,
    });
    if !description.is_empty() {
        value["description"] = description.into();
    }
    value
}

fn map<const N: usize>(entries: [(&str, Json); N]) -> Map<String, Json> {
    entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn array(items: Json, description: &str) -> Json {
    json!({ "type": "array", "description": description, "items": items })
}

fn plain(kind: &str, description: &str) -> Json {
    json!({ "type": kind, "description": description })
}

/// As `schema`, or null.
fn or_null(mut schema: Json) -> Json {
    schema["type"] = json!(["object", "null"]);
    schema
}

fn nullable(kind: &str, description: &str) -> Json {
    json!({ "type": [kind, "null"], "description": description })
}

fn constant(value: u32, description: &str) -> Json {
    json!({ "const": value, "description": description })
}
