//! `dram`: a memory device alone, on a trace of addresses.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::PathBuf;

use serde_json::{Value, json};

use super::failure::ConfigUsage;
use super::progress::Progress;
use super::{Context, Exit, Failure, OrExit, out};
use powergs_base::config::embedded::DRAM;
use powergs_core::dram::address_trace::Requests;
use powergs_core::dram::device::Order;
use powergs_core::dram::levels::{Level, LevelRun, run_levels};
use powergs_core::dram::{Device, Mode};
use powergs_core::run::files::read;

mod table;

/// Shown under `dram --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim dram addresses.trace
  powergs-sim dram addresses.trace --device lpddr5-6400-x16x4 --mode mlp32
  powergs-sim dram addresses.trace --mapping mop --model both --json
  powergs-sim dram addresses.trace --set controller.read-queue=64

A line of a trace is `R 0x1f40 64` (or W), `LD 0x1f40` (or ST), or `0x1f40 R`.
powergs-sim arch list names the devices; docs/dram.md has the rules.";

/// Arguments of `dram`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Address trace; - for standard input
    #[arg(value_name = "TRACE")]
    pub trace: PathBuf,
    /// Device: a name of `arch list`, or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = "lpddr4-3200-x16x8")]
    pub device: String,
    /// How requests arrive: sat (at once), mlpN (N reads in flight), idle (one at a time, the first
    /// 8192), lookN (a window of N x 64 B), rateN (N GB/s)
    #[arg(long, default_value = "sat")]
    pub mode: Mode,
    /// Order of the address fields, instead of the device's
    #[arg(long, value_enum, value_name = "ORDER")]
    pub mapping: Option<MappingName>,
    /// Level of the model
    #[arg(long, value_enum, default_value = "banked")]
    pub model: Model,
    /// Change a key of the device; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
}

/// Named orders of address fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum MappingName {
    /// Row, bank, column, channel from the top
    #[value(name = "RoBaCoCh")]
    RoBaCoCh,
    /// Bank bits above four columns, exclusive-or'ed with the column
    #[value(name = "mop")]
    Mop,
    /// Bank-group bits above a 64-byte block
    #[value(name = "bg64")]
    Bg64,
}

/// Levels of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Model {
    /// Every command of every bank
    Banked,
    /// Counts in windows of 128 KiB: fast, no queues
    Window,
    /// Both, and the difference
    Both,
}

impl Model {
    fn levels(self) -> &'static [Level] {
        match self {
            Model::Banked => &[Level::Banked],
            Model::Window => &[Level::Window],
            Model::Both => &[Level::Banked, Level::Window],
        }
    }
}

/// Runs `dram`.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let file = read("DRAM device", &args.device, DRAM, None)?;
    let mut device = Device::parse_with(&file.text, &args.sets).usage(&file.origin)?;
    if let Some(mapping) = args.mapping {
        let order = match mapping {
            MappingName::RoBaCoCh => Order::RoBaCoCh,
            MappingName::Mop => Order::Mop,
            MappingName::Bg64 => Order::Bg64,
        };
        device = device
            .with_order(order)
            .map_err(|e| Failure::new(Exit::Usage, format!("--mapping: {}: {e}", file.origin)))?;
    }
    let Some(results) = simulate(args, &device, context)? else { return Ok(Exit::Interrupted) };
    if context.global.json {
        out::json(&as_json(args, &device, &results))?;
    } else if !context.global.quiet {
        out::document(&table::document(args, &device, &results))?;
    }
    Ok(Exit::Done)
}

/// Streams the trace through the levels at once; `None` after Ctrl-C.
fn simulate(
    args: &Args,
    device: &Device,
    context: &Context,
) -> Result<Option<Vec<LevelRun>>, Failure> {
    let shown = args.trace.display();
    let (input, kib) = open(args)?;
    let progress = Progress::new(context, kib, "KiB");
    let requests = Requests::new(Counted { inner: input, bytes: 0, progress: &progress });
    let cancelled = || context.is_cancelled();
    run_levels(device, args.mode, args.model.levels(), requests, cancelled)
        .or_exit(Exit::BadInput, &shown)
}

/// The trace and its size in KiB; 0 if that is not known.
fn open(args: &Args) -> Result<(Box<dyn BufRead>, u64), Failure> {
    if args.trace.as_os_str() == "-" {
        return Ok((Box::new(io::stdin().lock()), 0));
    }
    let shown = args.trace.display();
    let file = File::open(&args.trace).or_exit(Exit::BadInput, &shown)?;
    let facts = file.metadata().or_exit(Exit::BadInput, &shown)?;
    if facts.is_dir() {
        return Err(Failure::new(Exit::BadInput, format!("{shown}: a folder, no address trace")));
    }
    Ok((Box::new(BufReader::with_capacity(1 << 18, file)), facts.len() >> 10))
}

/// Moves the progress bar with the bytes that are read.
struct Counted<'a> {
    inner: Box<dyn BufRead>,
    bytes: u64,
    progress: &'a Progress,
}

impl io::Read for Counted<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.inner.read(buffer)
    }
}

impl BufRead for Counted<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.inner.fill_buf()
    }

    fn consume(&mut self, n: usize) {
        self.inner.consume(n);
        self.bytes += n as u64;
        let kib = self.bytes >> 10;
        // The bar moves in steps: a trace has millions of lines.
        if kib >= 64 {
            self.progress.advance(kib);
            self.bytes &= 1023;
        }
    }
}

fn as_json(args: &Args, device: &Device, results: &[LevelRun]) -> Value {
    let first = &results[0];
    let mut value = one_json(device, first);
    let map = value.as_object_mut().expect("an object");
    map.insert("device".to_owned(), json!(device.name));
    map.insert("mode".to_owned(), json!(args.mode.to_string()));
    map.insert("model".to_owned(), json!(first.level.name()));
    if let [banked, window] = results {
        map.insert("window".to_owned(), one_json(device, window));
        let change = |f: fn(&Device, &LevelRun) -> f64| f(device, window) / f(device, banked) - 1.0;
        map.insert(
            "window_error".to_owned(),
            json!({
                "time": change(|d, r| d.ns(r.run.cycles)),
                "row_hit_rate": window.run.stats.row_hit_rate() - banked.run.stats.row_hit_rate(),
                "energy": change(|_, r| r.energy.total().0),
            }),
        );
    }
    value
}

fn one_json(device: &Device, result: &LevelRun) -> Value {
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
pub(super) fn share(cycles: f64, result: &LevelRun) -> f64 {
    if result.run.cycles == 0 { 0.0 } else { cycles / result.run.cycles as f64 }
}
