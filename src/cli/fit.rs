//! `fit`: curves through samples that reach a quality, and the pruning ratio with the fewest watts.

use std::fs::File;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::chart_args::{self, ChartArgs};
use super::output_file::Overwrite;
use super::{Context, Exit, Failure, OrExit, out};
use powergs_base::format::counted;
use powergs_chart::Style;
use powergs_optimize::fit::{Curve, Fit, Optimum, fit, optimum, read_samples};
use powergs_report as report;

/// Shown under `fit --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim fit samples.csv
  powergs-sim fit runs/snow/samples.csv -o fit.png
  powergs-sim fit samples.csv --json

The table has the columns rho (0 to 1), display_w and render_w, one row per
model that reaches the quality; rows that say false under `passed` are left
out, and display_spent_w counts in place of display_w where it is given.";

/// The arguments of `fit`.
#[derive(Debug, clap::Args)]
pub struct FitArgs {
    /// The table of samples: CSV
    pub samples: PathBuf,
    /// Draw samples, curves and optimum: a PNG, SVG or PDF file
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Whether a file is replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
    /// How charts are drawn.
    #[command(flatten)]
    pub charts: ChartArgs,
}

/// Runs `fit`.
pub fn run(args: &FitArgs, context: &Context) -> Result<Exit, Failure> {
    args.output.iter().try_for_each(|path| args.overwrite.check(path))?;
    let name = args.samples.display();
    let file = File::open(&args.samples).or_exit(Exit::BadInput, &name)?;
    let (samples, left_out) = read_samples(file).or_exit(Exit::BadInput, &name)?;
    let fitted = fit(&samples).or_exit(Exit::BadInput, &name)?;
    if let Some(path) = &args.output {
        draw(path, &fitted, &args.samples, args.charts.style())?;
    }
    let best = optimum(&fitted);
    if context.global.json {
        out::json(&object(&fitted, &best, left_out))?;
    } else if !context.global.quiet {
        out::text(&summary(&fitted, &best, left_out))?;
    }
    Ok(Exit::Done)
}

fn draw(path: &Path, fitted: &Fit, samples: &Path, style: Style) -> Result<(), Failure> {
    let title = samples.file_stem().unwrap_or_default().to_string_lossy();
    let drawing = report::fit::chart(fitted, &title);
    chart_args::write(path, &drawing, style)
}

/// The worse of two values; `None` if one is missing.
fn worse(a: Option<f64>, b: Option<f64>, pick: fn(f64, f64) -> f64) -> Option<f64> {
    Some(pick(a?, b?))
}

fn object(fitted: &Fit, best: &Optimum, left_out: usize) -> Value {
    let (d, r) = (&fitted.display, &fitted.render);
    let curve = |c: &Curve| {
        let finite = |v: f64| v.is_finite().then_some(v);
        json!({
            "v": finite(c.v()),
            "k": finite(c.k()),
            "shape": c.shape().name(),
            "low_w": c.low_w,
            "high_w": c.high_w,
            "r2": c.r2,
            "mre": c.mre,
        })
    };
    json!({
        "optimum_rho": best.rho,
        "optimum_place": best.place.name(),
        "optimum_display_w": best.display_w,
        "optimum_render_w": best.render_w,
        "optimum_total_w": best.total_w(),
        "trusted": best.is_trusted(),
        "chosen_rho": best.chosen_rho(),
        "best_sample_rho": best.best_sample_rho,
        "best_sample_total_w": best.best_sample_w,
        "r2": worse(d.r2, r.r2, f64::min),
        "mre": worse(d.mre, r.mre, f64::max),
        "r2_display": d.r2,
        "r2_render": r.r2,
        "mre_display": d.mre,
        "mre_render": r.mre,
        "samples": fitted.samples.len(),
        "samples_left_out": left_out,
        "rho_min": fitted.rho_min(),
        "rho_max": fitted.rho_max(),
        "display": curve(d),
        "render": curve(r),
        "notes": fitted.notes(),
    })
}

fn summary(fitted: &Fit, best: &Optimum, left_out: usize) -> String {
    let watts = |w: f64| powergs_report::format::engineering(w, "W");
    let mut text = format!(
        "optimum  rho {:.4} ({}): display {} + rendering {} = {}\n\
         sample   rho {:.4} is the best of {}: {}\n",
        best.rho,
        best.place.name().replace('_', " "),
        watts(best.display_w),
        watts(best.render_w),
        watts(best.total_w()),
        best.best_sample_rho,
        fitted.samples.len(),
        watts(best.best_sample_w),
    );
    let or_none = |v: Option<f64>| v.map_or("none".into(), |v| format!("{v:.4}"));
    for (name, c) in [("display", &fitted.display), ("render ", &fitted.render)] {
        let (r2, mre) = (or_none(c.r2), or_none(c.mre));
        let (v, k) = (c.v(), c.k());
        text += &format!("{name}  V {v:.4}, K {k:.4}; R² {r2}, mean relative error {mre}\n");
    }
    if left_out > 0 {
        text += &format!("note     left out: {} below the target\n", counted(left_out, "sample"));
    }
    for note in fitted.notes() {
        text += &format!("note     {note}\n");
    }
    text
}
