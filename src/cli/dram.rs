//! `dram`: a memory device alone, on a trace of addresses.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::PathBuf;

use super::failure::ConfigUsage;
use super::progress::Progress;
use super::{Context, Exit, Failure, OrExit, out};
use powergs_base::config::embedded::DRAM;
use powergs_core::run::files::read;
use powergs_dram::address_trace::Requests;
use powergs_dram::device::Order;
use powergs_dram::stream::{StreamRun, run_stream};
use powergs_dram::{Device, Mode};

mod table;

/// Shown under `dram --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim dram addresses.trace
  powergs-sim dram addresses.trace --device lpddr5-6400-x16x4 --mode mlp32
  powergs-sim dram addresses.trace --mapping mop --json
  powergs-sim dram addresses.trace --set controller.read-queue=64

A line of a trace is `R 0x1f40 64` (or W), `LD 0x1f40` (or ST), `0x1f40 R`, or
`0x1f40 READ 10` of DRAMsim3, whose cycle is left out.
powergs-sim arch list names the devices; docs/dram.md has the rules.";

/// Arguments of `dram`.
#[derive(Debug, clap::Args)]
pub struct DramArgs {
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

/// Runs `dram`.
pub fn run(args: &DramArgs, context: &Context) -> Result<Exit, Failure> {
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
    let Some(found) = simulate(args, &device, context)? else { return Ok(Exit::Interrupted) };
    if context.global.json {
        out::json(&powergs_report::dram::json(&device, args.mode, &found))?;
    } else if !context.global.quiet {
        out::document(&table::document(args, &device, &found))?;
    }
    Ok(Exit::Done)
}

/// Streams the trace through the device; `None` after Ctrl-C.
fn simulate(
    args: &DramArgs,
    device: &Device,
    context: &Context,
) -> Result<Option<StreamRun>, Failure> {
    let shown = args.trace.display();
    let (input, kib) = open(args)?;
    let progress = Progress::new(context, kib, "KiB");
    let mut requests = Requests::new(DramCounted { inner: input, bytes: 0, progress: &progress });
    let cancelled = || context.is_cancelled();
    let (capacity, mut all, mut beyond) = (device.capacity(), 0u64, 0u64);
    let counted = requests.by_ref().inspect(|request| {
        if let Ok(access) = request {
            all += 1;
            let last = access.address.saturating_add(u64::from(access.bytes).saturating_sub(1));
            beyond += u64::from(last >= capacity);
        }
    });
    let found =
        run_stream(device, args.mode, counted, cancelled).or_exit(Exit::BadInput, &shown)?;
    let has_cycles = requests.with_cycles() > 0;
    drop(requests);
    drop(progress);
    if !context.global.quiet {
        if has_cycles {
            out::complain(format_args!(
                "note: {shown}: the cycles of its lines are left out: requests arrive as --mode \
                 says, {}",
                args.mode
            ));
        }
        if beyond > 0 {
            out::complain(format_args!(
                "note: {shown}: {beyond} of {all} requests are beyond the {} of the device: their \
                 addresses wrap; a device with more `organisation.rows` or channels holds them",
                table::bytes(capacity)
            ));
        }
    }
    Ok(found)
}

/// The trace and its size in KiB; 0 if that is not known.
fn open(args: &DramArgs) -> Result<(Box<dyn BufRead>, u64), Failure> {
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
struct DramCounted<'a> {
    inner: Box<dyn BufRead>,
    bytes: u64,
    progress: &'a Progress,
}

impl io::Read for DramCounted<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.inner.read(buffer)
    }
}

impl BufRead for DramCounted<'_> {
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
