//! Tables as CSV: the record that everything else is derived from.

use powergs_optimize::plan::{Outcome, Role};
use powergs_optimize::study::RatioRow;

fn optional(value: Option<f64>) -> String {
    value.map_or(String::new(), |v| format!("{v:.6e}"))
}

/// `samples.csv`, which `powergs-sim fit` reads: a row per sample of the iso-quality curve.
pub fn samples_csv(done: &[Outcome]) -> String {
    let mut text = "sample,rho,display_w,render_w,total_w,psnr_db,ssim,passed,lambda_per_w,\
                    gaussians,iterations,kept_at\n"
        .to_owned();
    for o in done.iter().filter(|o| o.role == Role::Sample) {
        text += &format!(
            "{},{:.6},{:.8},{:.8},{:.8},{:.4},{:.6},{},{},{},{},{}\n",
            o.name,
            o.rho,
            o.watts.display_w,
            o.watts.render_w,
            o.watts.total_w(),
            o.gate.quality.psnr_db,
            o.gate.quality.ssim,
            o.passed,
            optional(o.lambda),
            o.points,
            o.iterations,
            o.kept_at.map_or(String::new(), |k| k.to_string()),
        );
    }
    text
}

/// `models.csv`: every model of the run, with its quality on both splits and its power. LPIPS has a
/// column if it was measured.
pub fn models_csv(done: &[Outcome]) -> String {
    let mut text = "model,rho,gaussians,iterations,lambda_per_w,gate_psnr_db,gate_ssim,passed,\
                    test_psnr_db,test_ssim,display_w,render_w,total_w,flip_test"
        .to_owned();
    let has_lpips = done.iter().any(|o| o.lpips_test.is_some());
    text += if has_lpips { ",lpips_test\n" } else { "\n" };
    for o in done {
        text += &format!(
            "{},{:.6},{},{},{},{:.4},{:.6},{},{:.4},{:.6},{:.8},{:.8},{:.8},{:.6}",
            o.name,
            o.rho,
            o.points,
            o.iterations,
            optional(o.lambda),
            o.gate.quality.psnr_db,
            o.gate.quality.ssim,
            o.passed,
            o.test.quality.psnr_db,
            o.test.quality.ssim,
            o.watts.display_w,
            o.watts.render_w,
            o.watts.total_w(),
            o.flip_test,
        );
        if has_lpips {
            text += &o.lpips_test.map_or(",".into(), |v| format!(",{v:.6}"));
        }
        text.push('\n');
    }
    text
}

/// `ratios.csv`: the study of display-to-render ratios.
pub fn ratios_csv(rows: &[RatioRow]) -> String {
    let mut text = "display_to_render,display_scale,rho,ours_w,saved_over_render_only,\
                    saved_over_display_only,saved_over_dense\n"
        .to_owned();
    let share = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.6}"));
    for r in rows {
        text += &format!(
            "{:.4},{:.6},{:.6},{:.8},{},{},{:.6}\n",
            r.ratio,
            r.scale,
            r.rho,
            r.ours_w,
            share(r.over_render_only),
            share(r.over_display_only),
            r.over_dense
        );
    }
    text
}
