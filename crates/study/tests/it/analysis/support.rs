//! Tables of results made by hand.

use std::fmt::Write;

use powergs_study::analysis::Table;

/// Label of an energy table and what it multiplies the parts of the energy with: DRAM, the rest.
pub type Prices = (&'static str, f64, f64);

/// A sweep over cores, a buffer and a test, with a model that is easy to think about:
///
/// - time: work over cores, or the DRAM if it is slower; a small buffer moves more bytes;
/// - area: 0.1 mm² and 0.05 for every core and 64 KiB;
/// - `trace` B has three times the bytes of A and half the work.
pub struct Sweep {
    pub cores: Vec<u32>,
    pub kib: Vec<u32>,
    pub tests: Vec<&'static str>,
    pub tables: Vec<Prices>,
    pub traces: Vec<(&'static str, f64, f64)>,
    pub baseline: bool,
}

impl Default for Sweep {
    fn default() -> Self {
        Sweep {
            cores: vec![1, 2, 4, 8, 16],
            kib: vec![16, 32, 64, 128, 256],
            tests: vec!["obb", "aabb"],
            tables: vec![("lpddr4", 10.88, 1.0), ("hbm2", 64.0, 1.0)],
            traces: vec![("garden", 1.0, 1.0), ("room", 0.5, 3.0)],
            baseline: true,
        }
    }
}

/// What a design costs on a trace.
struct Outcome {
    time_ms: f64,
    parts: [f64; 6],
    area: f64,
    bytes: f64,
}

fn outcome(
    cores: f64,
    kib: f64,
    test: &str,
    (_, work, bytes): (&str, f64, f64),
    p: Prices,
) -> Outcome {
    let extra = if test == "aabb" { 1.25 } else { 1.0 };
    let bytes = bytes * extra * 4e6 * (1.0 + 64.0 / kib);
    let compute = work * extra * 40.0 / cores;
    let memory = bytes / 4e6;
    let time_ms = compute.max(memory) + 0.1 * compute.min(memory);
    let area = 0.1 + 0.05 * cores + 0.05 * kib / 64.0 + if test == "obb" { 0.02 } else { 0.0 };
    let dram = bytes * p.1;
    let parts = [dram, 2e8 * work * p.2, 5e8 * work * extra * p.2, area * time_ms * 1e7, 1e6, 5e5];
    Outcome { time_ms, parts, area, bytes }
}

impl Sweep {
    /// `results.csv`.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "point,is_baseline,id,status,reason,energy_table,trace,scope,vru.cores,\
             buffers.feature.capacity,geometry.test,frames,frame_time_ms.mean,\
             frame_time_ms.p99,fps.mean,energy_pj.mean,\
             energy_pj.dram,energy_pj.sram,energy_pj.flop,energy_pj.leakage,energy_pj.background,\
             energy_pj.refresh,power_w.mean,area_mm2,dram_bytes.mean,bottleneck\n",
        );
        if self.baseline {
            self.point(&mut text, "baseline", (3.0, 512.0, "aabb"));
        }
        let mut point = 0;
        for &cores in &self.cores {
            for &kib in &self.kib {
                for &test in &self.tests {
                    self.point(&mut text, &point.to_string(), (cores.into(), kib.into(), test));
                    point += 1;
                }
            }
        }
        let _ = writeln!(text, "{point},false,,failed,\"buffer, too small\"{}", ",".repeat(21));
        text
    }

    fn point(&self, text: &mut String, point: &str, (cores, kib, test): (f64, f64, &str)) {
        for &table in &self.tables {
            let each: Vec<Outcome> =
                self.traces.iter().map(|&t| outcome(cores, kib, test, t, table)).collect();
            let n = each.len() as f64;
            let mean = Outcome {
                time_ms: each.iter().map(|o| o.time_ms).sum::<f64>() / n,
                parts: std::array::from_fn(|i| each.iter().map(|o| o.parts[i]).sum::<f64>() / n),
                area: each[0].area,
                bytes: each.iter().map(|o| o.bytes).sum::<f64>() / n,
            };
            let worst = each.iter().max_by(|a, b| a.time_ms.total_cmp(&b.time_ms)).expect("one");
            let traced = self.traces.iter().zip(&each).map(|(t, o)| (t.0, "trace", o));
            let number = if point == "baseline" { "" } else { point };
            let first = format!("{number},{}", number.is_empty());
            for (trace, scope, o) in traced.chain([("", "mean", &mean), ("", "worst", worst)]) {
                let energy: f64 = o.parts.iter().sum();
                let (table, trace) = (quoted(table.0), quoted(trace));
                let _ = write!(text, "{first},{:032x},ok,,{table},{trace},{scope},", hash(point));
                let _ =
                    write!(text, "{cores},{kib} KiB,{test},4,{},{},", o.time_ms, o.time_ms * 1.2);
                let _ = write!(text, "{},{energy}", 1e3 / o.time_ms);
                o.parts.iter().for_each(|p| write!(text, ",{p}").expect("memory"));
                let bound = if o.time_ms > 10.0 { "vru" } else { "dram" };
                let _ = writeln!(text, ",{},{},{},{bound}", energy * 6e-11, o.area, o.bytes);
            }
        }
    }

    /// The table with all columns; a constraint has left out one design.
    pub fn table(&self) -> Table {
        let mut table = Table::read(self.csv().as_bytes(), |_| true).expect("a table");
        table.leave_out(1);
        table
    }
}

/// A cell of any text.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// A hash that spreads.
fn hash(point: &str) -> u128 {
    let byte = |h: u128, b: u8| {
        (h ^ u128::from(b)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b)
    };
    point.bytes().fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d, byte)
}
