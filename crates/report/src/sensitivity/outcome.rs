//! What frames cost, as JSON.

use powergs_study::findings::cost::Cost;
use powergs_study::findings::sensitivity::Traced;
use serde_json::{Value, json};

/// An outcome as JSON.
pub fn outcome_json(outcome: &Cost) -> Value {
    json!({
        "frame_time_ms": outcome.frame_time_ms,
        "fps": outcome.fps(),
        "energy_pj": outcome.energy_pj,
        "power_display_rate_w": outcome.power_w,
        "area_mm2": outcome.area_mm2,
    })
}

/// The traces as JSON.
pub fn traces_json(traces: &[Traced]) -> Vec<Value> {
    let one = |t: &Traced| {
        json!({
            "name": t.name,
            "frames": t.frames,
            "frames_asked_for": t.asked,
            "base": outcome_json(&t.base),
        })
    };
    traces.iter().map(one).collect()
}
