//! Tables as CSV: the record that everything else is derived from. What was not measured is an
//! empty cell.

use powergs_frame::fovea::REGIONS;
use powergs_optimize::results::Results;

fn optional(value: Option<f64>) -> String {
    value.map_or(String::new(), |v| v.to_string())
}

fn joined<T>(values: &[T], cell: impl Fn(&T) -> String) -> String {
    values.iter().map(cell).collect::<Vec<String>>().join(",")
}

/// `levels.csv`: every model of every variant and level.
pub fn levels_csv(r: &Results) -> String {
    let mut text = "variant,level,model,role,rho,gaussians,target_hvsq,gate_hvsq,test_hvsq,\
                    test_psnr_db,test_ssim,display_w,render_w,total_w,passed,iterations\n"
        .to_owned();
    for m in &r.models {
        text += &format!(
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
            m.variant,
            m.level,
            m.name,
            m.role.name(),
            m.rho,
            m.gaussians,
            optional(m.target_hvsq),
            optional(m.gate.hvsq),
            optional(m.test.hvsq),
            optional(m.test.psnr_db),
            optional(m.test.ssim),
            m.display_w,
            m.render_w,
            m.total_w(),
            m.passed,
            m.iterations,
        );
    }
    text
}

/// `foveated.csv`: every method and variant. Quality in decibels, SSIM, FLIP and LPIPS is that of
/// level 1 over whole test views. HVSQ of R1 to R4 is that of the shown frames, of L1 to L4 that of
/// the model of the level over whole test views. FPS are those of the accelerator.
pub fn foveated_csv(r: &Results) -> String {
    let mut text = "method,variant,fps,total_w,display_w,render_w,filter_w,hvsq_r1,hvsq_r2,\
                    hvsq_r3,hvsq_r4,hvsq_l1,hvsq_l2,hvsq_l3,hvsq_l4,\
                    gaussians_l1,gaussians_l2,gaussians_l3,gaussians_l4,state_l1,\
                    state_l2,state_l3,state_l4,test_psnr_db,test_ssim,flip_test,lpips_test\n"
        .to_owned();
    for f in &r.foveated {
        let first = r.model(&f.jobs[0]);
        let of = |value: fn(&powergs_optimize::results::ModelRecord) -> Option<f64>| {
            optional(first.and_then(value))
        };
        text += &format!(
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
            f.method.name(),
            f.variant,
            optional(f.fps),
            f.total_w(),
            f.display_w,
            f.render_w,
            f.filter_w,
            joined(&f.hvsq, |v| optional(*v)),
            joined(&f.level_hvsq(r), |v| optional(*v)),
            joined(&f.gaussians, u64::to_string),
            joined(&f.states, |s| s.name().to_owned()),
            of(|m| m.test.psnr_db),
            of(|m| m.test.ssim),
            of(|m| m.flip_test),
            of(|m| m.lpips_test),
        );
    }
    text
}

/// `regions.csv`: tiles, energy of sorting and rendering on the machine, and HVSQ of each region.
pub fn regions_csv(r: &Results) -> String {
    let mut text = "method,variant,region,tiles,joules_per_frame,watts,hvsq\n".to_owned();
    for f in &r.foveated {
        for (i, region) in REGIONS.iter().enumerate() {
            text += &format!(
                "{},{},{},{},{},{},{}\n",
                f.method.name(),
                f.variant,
                region,
                f.tiles[i],
                f.region_j[i],
                f.region_j[i] * r.fps,
                optional(f.hvsq[i]),
            );
        }
    }
    text
}
