//! What `dram` prints for people.

use powergs_report::dram::share;

use super::DramArgs;
use powergs_dram::Device;
use powergs_dram::stream::StreamRun;
use powergs_report::document::{Cell, Column, Document, Table};
use powergs_report::format::engineering;

/// The run.
pub(super) fn document(args: &DramArgs, device: &Device, result: &StreamRun) -> Document {
    let (o, name) = (&device.organisation, &device.name);
    let pins = format!(
        "{} pins of {:.2} Gb/s",
        o.channels * o.pseudo_channels * o.width,
        device.pin_gbit_s()
    );
    let title =
        format!("{name}, {:.1} GB/s peak on {pins}, mode {}", device.peak_gb_s(), args.mode);
    let mut table = Table::new([Column::text(""), Column::count("banked")]);
    let mut row = |name: &str, value: &dyn Fn(&StreamRun) -> String| {
        table.row([Cell::from(name), Cell::from(value(result))]);
    };
    let total = |r: &StreamRun| r.run.stats.total;
    let ns = |r: &StreamRun| device.ns(r.run.cycles).max(f64::MIN_POSITIVE);
    let period = device.clock_period.0;
    row("time", &|r| engineering(device.ns(r.run.cycles) * 1e-9, "s"));
    row("requested", &|r| bytes(total(r).requested_bytes()));
    row("moved", &|r| bytes(total(r).moved_bytes));
    row("bandwidth", &|r| format!("{:.2} GB/s", total(r).requested_bytes() as f64 / ns(r)));
    row("data bus busy", &|r| format!("{:.1} %", 100.0 * share(r.run.stats.busy_mean, r)));
    row("busiest data bus", &|r| format!("{:.1} %", 100.0 * share(r.run.stats.busy_max as f64, r)));
    row("row-hit rate", &|r| format!("{:.4}", r.run.stats.row_hit_rate()));
    if result.run.stats.latency.count() > 0 {
        row("read latency, mean", &|r| format!("{:.1} ns", r.run.stats.latency.mean() * period));
        for (name, fraction) in [("  p50", 0.5), ("  p95", 0.95), ("  p99", 0.99)] {
            row(name, &|r| {
                format!("{:.1} ns", r.run.stats.latency.percentile(fraction) as f64 * period)
            });
        }
    }
    for (i, (name, _)) in result.run.stats.commands().into_iter().enumerate() {
        if result.run.stats.commands()[i].1 > 0 {
            row(name, &|r| r.run.stats.commands()[i].1.to_string());
        }
    }
    row("energy", &|r| engineering(r.energy.total().0 * 1e-12, "J"));
    for (i, (name, _)) in result.energy.parts().into_iter().enumerate() {
        if result.energy.parts()[i].1.0 > 0.0 {
            row(&format!("  {}", name.replace('_', " ")), &|r| {
                let total = r.energy.total().0.max(f64::MIN_POSITIVE);
                let part = r.energy.parts()[i].1.0;
                format!("{} {:>4.1} %", engineering(part * 1e-12, "J"), 100.0 * part / total)
            });
        }
    }
    row("energy per byte", &|r| {
        format!("{:.2} pJ/B", r.energy.total().0 / total(r).requested_bytes().max(1) as f64)
    });
    let mut page = Document::new();
    page.title(title);
    page.table(table);
    page.paragraph(
        "The energy is that of the device's currents over the time of this trace, background and \
         refresh included, so that a byte costs less the faster requests arrive. replay prices \
         bytes with the energy table of its machine, and standby apart.",
    );
    page
}

/// A number of bytes.
pub(super) fn bytes(n: u64) -> String {
    match n {
        n if n >= 10 << 20 => format!("{:.1} MiB", n as f64 / f64::from(1 << 20)),
        n if n >= 10 << 10 => format!("{:.1} KiB", n as f64 / 1024.0),
        n => format!("{n} B"),
    }
}
