//! Two or more runs beside each other: measures, differences, ratios, and what else differs.

mod charts;
mod output;
mod side;
mod text;

pub use charts::charts;
pub use output::{compare_csv, json, run_toml};
pub use side::{Side, SideError};
pub use text::{markdown, terminal};

use super::compare::side::number;
use powergs_core::energy::Component;

/// Which way is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    /// A smaller value.
    Less,
    /// A larger value.
    More,
    /// Neither by itself.
    Neither,
}

/// One row of the comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// snake_case with its unit, as in JSON and CSV.
    pub name: &'static str,
    /// For people, with its unit.
    pub words: String,
    /// Which way is better.
    pub better: Better,
    /// One value per side; `None` where a side does not have it.
    pub values: Vec<Option<f64>>,
}

impl Measure {
    /// The value of side `i` over that of the first side.
    pub fn ratio(&self, i: usize) -> Option<f64> {
        let (first, other) = (self.values[0]?, self.values[i]?);
        (first != 0.0).then(|| other / first)
    }
}

/// Runs beside each other; the first is what the others are compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// At least two, with labels of their own.
    pub sides: Vec<Side>,
    /// The measures, in report order.
    pub measures: Vec<Measure>,
    /// What else differs, so that differences may not be of the machines alone; one sentence each.
    pub notes: Vec<String>,
}

impl Comparison {
    /// Compares `sides`. Sides of one name are numbered.
    pub fn new(mut sides: Vec<Side>) -> Comparison {
        let names: Vec<String> = sides.iter().map(|s| s.label.clone()).collect();
        for (i, side) in sides.iter_mut().enumerate() {
            if names.iter().filter(|n| **n == side.label).count() > 1 {
                side.label = format!("{}-{}", side.label, i + 1);
            }
        }
        let (measures, notes) = (measures(&sides), notes(&sides));
        Comparison { sides, measures, notes }
    }

    /// Labels of the sides.
    pub fn labels(&self) -> Vec<&str> {
        self.sides.iter().map(|s| s.label.as_str()).collect()
    }

    /// The measure called `name`.
    pub fn measure(&self, name: &str) -> Option<&Measure> {
        self.measures.iter().find(|m| m.name == name)
    }

    /// Frames per second of the slowest other side over those of the first; `None` without times.
    pub fn least_speedup(&self) -> Option<f64> {
        let fps = self.measure("throughput_fps")?;
        let ratios: Option<Vec<f64>> = (1..self.sides.len()).map(|i| fps.ratio(i)).collect();
        ratios?.into_iter().reduce(f64::min)
    }
}

fn measures(sides: &[Side]) -> Vec<Measure> {
    use Better::{Less, More, Neither};
    let mut all = Vec::new();
    let mut add = |name, words: &str, better, of: &dyn Fn(&Side) -> Option<f64>| {
        let finite = |side: &Side| of(side).filter(|x| x.is_finite());
        let values = sides.iter().map(finite).collect();
        all.push(Measure { name, words: words.into(), better, values });
    };
    let mean = |name: &'static str| move |s: &Side| s.means.get(name);
    let fps = |s: &Side| s.means.get("frame_time_ms").filter(|t| *t > 0.0).map(|t| 1e3 / t);
    let area = Side::area_mm2;
    let peak = |s: &Side| s.dram_peak_gb_s;
    let energy_j = |s: &Side| s.means.get("energy_pj.total").map(|e| e * 1e-12);
    add("frame_time_ms", "frame time, ms", Less, &mean("frame_time_ms"));
    add("frame_time_p99_ms", "frame time, p99, ms", Less, &|s| s.frame_time_p99_ms);
    add("throughput_fps", "frames per second", More, &fps);
    add("energy_per_frame_mj", "energy per frame, mJ", Less, &|s| Some(energy_j(s)? * 1e3));
    let rate = super::format::rate(sides.first().map_or(60.0, |s| s.display_fps));
    let power = format!("power at {rate} FPS, W");
    add("power_w", &power, Less, &mean("power_w.total"));
    add("power_full_rate_w", "power at full rate, W", Neither, &|s| Some(energy_j(s)? * fps(s)?));
    add("dram_mb_per_frame", "DRAM, MB per frame", Less, &|s| {
        Some((s.means.get("dram_read_bytes")? + s.means.get("dram_write_bytes")?) * 1e-6)
    });
    add("dram_peak_gb_s", "DRAM peak, GB/s", Neither, &peak);
    add("area_mm2", "area, mm2", Less, &area);
    add("fps_per_w", "FPS per W (frames per J)", More, &|s| Some(1.0 / energy_j(s)?));
    add("fps_per_mm2", "FPS per mm2", More, &|s| Some(fps(s)? / area(s)?));
    add("fps_per_gb_s", "FPS per GB/s of peak", More, &|s| Some(fps(s)? / peak(s)?));
    if let Some(first) = sides.first() {
        add("iso_area_fps", "FPS at the area of the first", More, &|s| {
            Some(fps(s)? * area(first)? / area(s)?)
        });
        add("iso_bandwidth_fps", "FPS at the GB/s of the first", More, &|s| {
            Some(fps(s)? * peak(first)? / peak(s)?)
        });
    }
    all
}

/// What else differs between the sides.
fn notes(sides: &[Side]) -> Vec<String> {
    let mut notes = Vec::new();
    let mut differs = |what: &str, values: Vec<String>, so: &str| {
        if values.iter().any(|v| *v != values[0]) {
            let mut shown = values.clone();
            shown.dedup();
            notes.push(format!("{what} differ ({}): {so}", shown.join(", ")));
        }
    };
    let each = |of: &dyn Fn(&Side) -> String| sides.iter().map(of).collect::<Vec<_>>();
    let trace = |s: &Side| format!("{} {:.8}", s.trace, s.trace_hash);
    differs("traces", each(&trace), "the frames are not the same");
    differs("frame counts", each(&|s| s.frames.to_string()), "means are over other frames");
    differs("models", each(&|s| s.model.clone()), "one of them has no time of its own");
    differs("energy tables", each(&|s| s.energy_table.clone()), "joules have other prices");
    let of_table = |s: &Side| format!("{} {:.8}", s.energy_table, s.energy_hash);
    if sides.iter().all(|s| s.energy_table == sides[0].energy_table) {
        differs("files of the energy table", each(&of_table), "joules have other prices");
    }
    differs("display rates", each(&|s| number(s.display_fps)), "powers are for other rates");
    let versions = |s: &Side| format!("{} model {}", s.tool_version, s.model_version);
    differs("versions", each(&versions), "the same inputs may give other numbers");
    let schemas = |s: &Side| s.schema_version.to_string();
    differs("schema versions", each(&schemas), "some names have changed their meaning");
    let dram = |s: &Side| s.dram_model.clone();
    differs("DRAM models", each(&dram), "times of DRAM are counted differently");
    for side in sides.iter().filter(|s| s.incomplete) {
        notes.push(format!("{} is INCOMPLETE: {} frames only", side.label, side.frames));
    }
    notes
}

/// Energy per frame by component, millijoules.
fn component_mj(side: &Side, component: Component) -> Option<f64> {
    side.means.get(&format!("energy_pj.{}", component.name())).map(|pj| pj * 1e-9)
}
