//! A memory device alone on a list of requests, as JSON.

use powergs_dram::stream::StreamRun;
use powergs_dram::{Device, Mode};
use serde_json::{Value, json};

/// The run of a device.
pub fn json(device: &Device, mode: Mode, result: &StreamRun) -> Value {
    let (stats, total) = (&result.run.stats, &result.run.stats.total);
    let time_ns = device.ns(result.run.cycles);
    let period = device.clock_period.0;
    let latency = |fraction: f64| stats.latency.percentile(fraction) as f64 * period;
    let read_latency = (stats.latency.count() > 0).then(|| {
        json!({
            "mean": stats.latency.mean() * period,
            "p50": latency(0.5), "p95": latency(0.95), "p99": latency(0.99),
            "max": stats.latency.max() as f64 * period,
        })
    });
    let commands: serde_json::Map<String, Value> =
        stats.commands().into_iter().map(|(name, n)| (name.to_owned(), json!(n))).collect();
    let mut energy: serde_json::Map<String, Value> =
        result.energy.parts().into_iter().map(|(name, e)| (name.to_owned(), json!(e.0))).collect();
    energy.insert("total".to_owned(), json!(result.energy.total().0));
    let per = |bytes: u64| if time_ns > 0.0 { bytes as f64 / time_ns } else { 0.0 };
    json!({
        "device": device.name,
        "mode": mode.to_string(),
        "model": "banked",
        "time_ns": time_ns,
        "bandwidth_gb_s": per(total.requested_bytes()),
        "bus_bandwidth_gb_s": per(total.bursts * device.organisation.burst.0),
        "peak_bandwidth_gb_s": device.peak_gb_s(),
        "pin_rate_gbit_s": device.pin_gbit_s(),
        "row_hit_rate": stats.row_hit_rate(),
        "read_latency_ns": read_latency,
        "requests": total.requests,
        "requested_bytes": total.requested_bytes(),
        "moved_bytes": total.moved_bytes,
        "bursts": total.bursts,
        "absorbed_writes": total.absorbed_writes,
        "forwarded_reads": total.forwarded_reads,
        "first_try": {
            "row_hits": total.row_hits,
            "row_misses": total.row_misses,
            "row_conflicts": total.row_conflicts,
        },
        "bus_busy": {
            "max": share(stats.busy_max as f64, result),
            "mean": share(stats.busy_mean, result),
        },
        "commands": commands,
        "energy_pj": energy,
    })
}

/// Part of the run for which a bus was busy.
pub fn share(cycles: f64, result: &StreamRun) -> f64 {
    if result.run.cycles == 0 { 0.0 } else { cycles / result.run.cycles as f64 }
}
