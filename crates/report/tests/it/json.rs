//! `--json` against its own schema, and the paths that programs rely on.

use powergs_report::{json, schema};
use powergs_study::run_record::Run;
use serde_json::Value;

use crate::builder;

fn report(run: &Run) -> Value {
    let value = json::report(run);
    // As a reader sees it: through text.
    serde_json::from_str(&value.to_string()).expect("JSON")
}

/// The subset of JSON Schema that our schema uses; the first violation, with its path.
fn violation(root: &Value, schema: &Value, value: &Value, path: &str) -> Option<String> {
    if let Some(target) = schema.get("$ref").and_then(Value::as_str) {
        let target = root.pointer(target.trim_start_matches('#')).expect("a definition");
        return violation(root, target, value, path);
    }
    if let Some(constant) = schema.get("const") {
        return (constant != value).then(|| format!("{path}: {value} is not {constant}"));
    }
    if let Some(options) = schema.get("enum").and_then(Value::as_array) {
        return (!options.contains(value)).then(|| format!("{path}: {value} is not an option"));
    }
    let is = |kind: &str| match kind {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("{path}: unknown type {other}"),
    };
    let fits = match &schema["type"] {
        Value::String(kind) => is(kind),
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).any(is),
        other => panic!("{path}: no type: {other}"),
    };
    if !fits {
        return Some(format!("{path}: {value} is not {}", schema["type"]));
    }
    if let (Some(items), Some(values)) = (schema.get("items"), value.as_array()) {
        let each = values.iter().enumerate();
        return each.filter_map(|(i, v)| violation(root, items, v, &format!("{path}[{i}]"))).next();
    }
    let (properties, object) = (schema.get("properties")?.as_object()?, value.as_object()?);
    let required = schema["required"].as_array().expect("required");
    if let Some(missing) =
        required.iter().filter_map(Value::as_str).find(|r| !object.contains_key(*r))
    {
        return Some(format!("{path}: {missing} is missing"));
    }
    object.iter().find_map(|(name, v)| match properties.get(name) {
        None => Some(format!("{path}: {name} is not in the schema")),
        Some(s) => violation(root, s, v, &format!("{path}.{name}")),
    })
}

#[test]
fn reports_follow_the_schema() {
    let schema = schema::schema();
    let mut stopped = builder::garden();
    stopped.frames.truncate(5);
    for run in [builder::garden(), builder::paper(), stopped] {
        assert_eq!(violation(&schema, &schema, &report(&run), "$"), None);
    }
    let mut broken = report(&builder::garden());
    broken["frames"][1]["power_w"]["total"] = "much".into();
    let found = violation(&schema, &schema, &broken, "$").expect("this is against the schema");
    assert!(found.starts_with("$.frames[1].power_w.total"), "{found}");
}

#[test]
fn promised_paths() {
    let json = report(&builder::garden());
    assert_eq!(json["model"], "cycle");
    assert_eq!(json["fps"], 60.0);
    assert_eq!(json["incomplete"], false);
    assert_eq!(json["machine"]["name"], "gscore");
    for path in [
        "/frames/0/frame_time_ms",
        "/frames/0/power_w/total",
        "/frames/23/energy_pj/rendering",
        "/aggregate/frame_time_ms/mean",
        "/aggregate/power_w/total/p99",
        "/aggregate/dram_read_bytes/mean",
    ] {
        assert!(json.pointer(path).is_some_and(Value::is_number), "{path}");
    }
    let blends = &json["frames"][0]["counters"]["blends"];
    assert!(blends.is_u64(), "counts stay integers: {blends}");
    assert!(json["aggregate"]["counters"]["blends"]["max"].is_u64());
}

#[test]
fn what_is_not_measured_is_null() {
    let json = report(&builder::paper());
    assert_eq!(json["model"], "paper");
    for path in ["/frames/0/frame_time_ms", "/aggregate/frame_time_ms", "/throughput_fps"] {
        assert_eq!(json.pointer(path), Some(&Value::Null), "{path}");
    }
    assert!(json["frames"][0]["flops"].is_u64());
}

#[test]
fn an_interrupted_run_is_marked() {
    let mut run = builder::garden();
    run.frames.truncate(2);
    let json = report(&run);
    assert_eq!(json["incomplete"], true);
    assert_eq!(json["trace"]["frames"], 24);
    assert_eq!(json["frames"].as_array().map(Vec::len), Some(2));
}
