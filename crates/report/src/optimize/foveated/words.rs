//! The foveated part of `summary.md`.

use std::fmt::Write as _;

use super::Show;
use crate::format::{engineering, watt_unit};
use powergs_chart::Chart;
use powergs_frame::fovea::{LEVELS, REGIONS};
use powergs_optimize::job::RoleKind;
use powergs_optimize::results::{FovealRecord, ModelRecord, Results};

/// The part; empty if nothing was measured.
pub fn markdown(show: &Show<'_>, charts: &[Chart]) -> String {
    let r = show.results;
    if r.foveated.is_empty() {
        return String::new();
    }
    let mut text = "# Foveated\n\n".to_owned();
    methods(&mut text, r);
    regions(&mut text, r);
    plain(&mut text, r);
    levels(&mut text, r);
    for chart in charts {
        let _ = writeln!(text, "## {0}\n\n![{0}]({1}.png)\n", chart.title, chart.name);
    }
    text
}

/// The same for a terminal: a line a method, of at most 80 columns; empty if nothing was measured.
pub fn headline(r: &Results) -> String {
    if r.foveated.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "{:14} {:>28}   {:>9}  {}\n",
        "foveated", "total = render + display", "machine FPS", "HVSQ R1-R4, 1e-5"
    );
    for f in &r.foveated {
        let watts = [f.total_w(), f.render_w, f.display_w].map(|w| engineering(w, "W"));
        let [total, render, display] = watts;
        let power = format!("{total} = {render} + {display}");
        let fps = f.fps.map_or(String::new(), |v| format!("{v:.0}"));
        let shown = |v: &Option<f64>| v.map_or("-".into(), |v| format!("{:.2}", 1e5 * v));
        let hvsq = f.hvsq.iter().map(shown).collect::<Vec<String>>().join(" ");
        let _ = writeln!(text, "{:14} {power:>28}   {fps:>11}  {hvsq}", f.label());
    }
    text
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or(String::new(), |v| format!("{v:.digits$}"))
}

fn e5(value: Option<f64>) -> String {
    number(value.map(|v| 1e5 * v), 2)
}

/// Table 1 in kind.
fn methods(text: &mut String, r: &Results) {
    let most = r.foveated.iter().map(FovealRecord::total_w).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let speed = r.dense_fps.map_or(String::new(), |fps| {
        format!(" The dense model, not foveated, runs at {fps:.0} FPS.")
    });
    let note = r.regions_note().unwrap_or_default();
    let _ = writeln!(
        text,
        "## Methods\n\nFPS: the accelerator's speed at full rate, not a GPU's.{speed} Power: \
         at {} FPS, over the gaze cycle. HVSQ of R1 to R4: of the shown frames. {note} HVSQ of \
         L1 to L4: of the level's model over whole test views, as published. PSNR and \
         SSIM: of the model of level 1 on whole test views.\n",
        r.fps
    );
    let _ = writeln!(
        text,
        "| method | FPS | total, {unit} | display, {unit} | rendering, {unit} | of that filter, \
         {unit} | HVSQ R1, 1e-5 | R2 | R3 | R4 | HVSQ of L1 to \
         L4, 1e-5 | Gaussians of L1 to L4 | levels | PSNR, dB | SSIM \
         | FLIP | LPIPS |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
    for f in &r.foveated {
        let first = r.model(&f.jobs[0]);
        let quality =
            |of: fn(&ModelRecord) -> Option<f64>, digits| number(first.and_then(of), digits);
        let watts = |w: f64| format!("{:.2}", per_watt * w);
        let hvsq: Vec<String> = f.hvsq.iter().map(|v| e5(*v)).collect();
        let or_none = |v: &Option<f64>| v.map_or("none".into(), |v| e5(Some(v)));
        let whole: Vec<String> = f.level_hvsq(r).iter().map(or_none).collect();
        let counts: Vec<String> = f.gaussians.iter().map(u64::to_string).collect();
        let states: Vec<String> = f.states.iter().map(|s| s.name().replace('_', " ")).collect();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            f.label(),
            number(f.fps, 0),
            watts(f.total_w()),
            watts(f.display_w),
            watts(f.render_w),
            watts(f.filter_w),
            hvsq.join(" | "),
            whole.join(", "),
            counts.join(", "),
            states.join(", "),
            quality(|m| m.test.psnr_db, 2),
            quality(|m| m.test.ssim, 4),
            quality(|m| m.flip_test, 4),
            quality(|m| m.lpips_test, 4),
        );
    }
    text.push('\n');
}

fn regions(text: &mut String, r: &Results) {
    let watts = |f: &FovealRecord, i: usize| f.region_j[i] * r.fps;
    let most = r.foveated.iter().flat_map(|f| (0..LEVELS).map(move |i| watts(f, i)));
    let (per_watt, unit) = watt_unit(most.fold(0.0, f64::max));
    let _ = write!(
        text,
        "## Regions\n\nTiles, and sorting and rendering of them on the machine, {unit}; \
         preprocessing, standing power and the filter belong to no region.\n\n| method |"
    );
    for region in REGIONS {
        let _ = write!(text, " {region}, tiles | {region}, {unit} |");
    }
    let _ = writeln!(text, "\n|---|{}", "---|---|".repeat(LEVELS));
    for f in &r.foveated {
        let _ = write!(text, "| {} |", f.label());
        for i in 0..LEVELS {
            let _ = write!(text, " {:.1} | {:.2} |", f.tiles[i], per_watt * watts(f, i));
        }
        text.push('\n');
    }
    text.push('\n');
}

/// Table 2 in kind: level 1 everywhere.
fn plain(text: &mut String, r: &Results) {
    let variant = &r.variants[0].name;
    let ours = r.ours(variant).map(|m| m.name.clone());
    let is_shown = |m: &&ModelRecord| {
        let compared = matches!(m.role, RoleKind::Dense | RoleKind::External);
        let is_own = m.role == RoleKind::Baseline && m.variant == *variant;
        m.level == 1 && (compared || is_own || Some(&m.name) == ours.as_ref())
    };
    let mut shown: Vec<&ModelRecord> = r.models.iter().filter(is_shown).collect();
    shown.sort_by(|a, b| b.total_w().total_cmp(&a.total_w()));
    let (per_watt, unit) = watt_unit(shown.first().map_or(0.0, |m| m.total_w()));
    let _ = writeln!(
        text,
        "## Without foveation\n\n| model | PSNR, dB | SSIM | FLIP | LPIPS | total, {unit} |\n\
         |---|---|---|---|---|---|"
    );
    for m in shown {
        let name = match Some(&m.name) == ours.as_ref() {
            true => format!("PowerGS-{variant} ({})", m.name),
            false => m.name.clone(),
        };
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {:.2} |",
            number(m.test.psnr_db, 2),
            number(m.test.ssim, 4),
            number(m.flip_test, 4),
            number(m.lpips_test, 4),
            per_watt * m.total_w()
        );
    }
    text.push('\n');
}

/// The models that are not in the table of level 1.
fn levels(text: &mut String, r: &Results) {
    let first = &r.variants[0].name;
    let rest: Vec<&ModelRecord> =
        r.models.iter().filter(|m| m.level > 1 || m.variant != *first).collect();
    if rest.is_empty() {
        return;
    }
    let (per_watt, unit) = watt_unit(rest.iter().map(|m| m.total_w()).fold(0.0, f64::max));
    let _ = writeln!(
        text,
        "## Levels and variants\n\nPruned: of the level before. HVSQ at the pooling of the level, \
         over whole views; power of the level shown everywhere.\n\n| variant | level | model | \
         pruned, % | Gaussians | target HVSQ, 1e-5 | gate | test | PSNR, dB | SSIM | display, \
         {unit} | rendering, {unit} | total, {unit} | passed |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
    for m in rest {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.1} | {} | {} | {} | {} | {} | {} | {:.2} | {:.2} | {:.2} | {} |",
            m.variant,
            m.level,
            m.name,
            100.0 * m.rho,
            m.gaussians,
            e5(m.target_hvsq),
            e5(m.gate.hvsq),
            e5(m.test.hvsq),
            number(m.test.psnr_db, 2),
            number(m.test.ssim, 4),
            per_watt * m.display_w,
            per_watt * m.render_w,
            per_watt * m.total_w(),
            if m.passed { "yes" } else { "no" },
        );
    }
    text.push('\n');
}
