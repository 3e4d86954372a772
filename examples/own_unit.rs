//! A unit of one's own: a machine whose VRU has another timing rule, beside the built-in one. It is
//! registered, and a machine names it: `rules.vru = "dual-issue"`.
//!
//! `cargo run --example own_unit [TRACE] [MACHINE]` (default `traces/demo.bin` on
//! `gscore-powergs`, whose units take one sub-tile after the other).

use std::error::Error;
use std::path::Path;

use powergs_sim::extend::kernel::Unit;
use powergs_sim::extend::tile_wise::vru::{Render, Vru};
use powergs_sim::extend::tile_wise::{self, UnitRule};
use powergs_sim::run::FrameReport;
use powergs_sim::run::files::DiskFiles;
use powergs_sim::run::{Session, Subject, System, SystemSpec, TraceFile};

/// A VRU that issues the (Gaussian, sub-tile) pairs of two Gaussians together: a sub-tile is
/// rotated through the units once for both. It leaves out what the built-in rule says of foveated
/// tiles and of `blend-stall`. Its actions are those of the built-in VRU.
pub struct DualIssue;

impl DualIssue {
    fn blend_cycles(vru: &Vru, work: &Render) -> u64 {
        let rotations = vru.pairs(&work.chunk).div_ceil(2);
        // Two entries leave the feature buffer in a cycle.
        let entries = u64::from(work.chunk.entries).div_ceil(2);
        (rotations * vru.pair_cycles()).max(entries)
    }

    fn finish_cycles(vru: &Vru, work: &Render) -> u64 {
        let pixels = work.last.map_or(0, |tile| u64::from(tile.pixels));
        pixels.div_ceil(u64::from(vru.spec.units_per_core))
    }
}

impl UnitRule<Vru> for DualIssue {
    fn name(&self) -> &str {
        "dual-issue"
    }

    fn cycles(&self, vru: &Vru, work: &Render) -> u64 {
        let drain = if work.drains { u64::from(vru.spec.latency) } else { 0 };
        (Self::blend_cycles(vru, work) + Self::finish_cycles(vru, work) + drain).max(1)
    }

    /// Features are read once while the chunk is blended; pixels are written while they finish.
    fn bank_stalls(&self, vru: &Vru, work: &Render) -> u64 {
        let words = vru.features.words_of_records(u64::from(work.chunk.entries), vru.feature);
        let features = vru.features.excess(words, words, Self::blend_cycles(vru, work));
        let Some(tile) = &work.last else { return features };
        let words = vru.pixels.words(vru.pixel_bytes(tile));
        features + vru.pixels.excess(0, words, Self::finish_cycles(vru, work))
    }
}

/// Replays a trace on a machine with the built-in VRU and with [`DualIssue`]: the reports of both,
/// frame by frame.
///
/// # Errors
/// The trace cannot be read, there is no such machine, or it cannot run the trace.
pub fn replay_both(trace: &Path, machine: &str) -> Result<[Vec<FrameReport>; 2], Box<dyn Error>> {
    let built_in = System::named(machine)?;
    let sets = vec!["rules.vru=dual-issue".to_owned()];
    let own = SystemSpec { sets, ..SystemSpec::named(machine) };
    let own = System::load(&own, &DiskFiles)?;
    let mut trace = TraceFile::open(trace)?;
    let subjects = [Subject::of(&built_in), Subject::of(&own)];
    let folded = Session::new(&mut trace, &()).fold(
        &subjects,
        |_| Vec::new(),
        |reports: &mut Vec<FrameReport>, view| reports.push(view.report),
    )?;
    Ok(folded.states.try_into().expect("one state per subject"))
}

fn main() -> Result<(), Box<dyn Error>> {
    tile_wise::register(DualIssue)?;
    let mut args = std::env::args().skip(1);
    let trace = args.next().unwrap_or_else(|| "traces/demo.bin".to_owned());
    let machine = args.next().unwrap_or_else(|| "gscore-powergs".to_owned());
    let both = replay_both(Path::new(&trace), &machine)?;
    println!("{:<12} {:>10} {:>10} {:>10}", machine, "ms/frame", "VRU busy", "mJ/frame");
    for (name, reports) in ["built-in", "dual-issue"].into_iter().zip(&both) {
        let n = reports.len() as f64;
        let seconds: f64 = reports.iter().filter_map(FrameReport::frame_time_s).sum();
        let millijoules: f64 = reports.iter().map(|r| r.energy.total().0 * 1e-9).sum();
        let (mut busy, mut cycles) = (0, 0);
        for timing in reports.iter().filter_map(FrameReport::timing) {
            let Some(vru) = timing.unit(Vru::STAGE) else { continue };
            busy += vru.busy;
            cycles += u64::from(vru.instances) * timing.frame;
        }
        let (ms, mj) = (seconds * 1e3 / n, millijoules / n);
        let busy = 100.0 * busy as f64 / cycles as f64;
        println!("{name:<12} {ms:>10.4} {busy:>9.1}% {mj:>10.4}");
    }
    Ok(())
}
