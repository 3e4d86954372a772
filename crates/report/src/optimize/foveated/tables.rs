//! Tables as CSV: the record that everything else is derived from. What was not measured is an
//! empty cell.

use crate::document::{Cell, Table};
use powergs_frame::fovea::REGIONS;
use powergs_optimize::foveated::LevelState;
use powergs_optimize::results::Results;

/// `levels.csv`: every model of every variant and level.
pub fn levels_csv(r: &Results) -> Vec<u8> {
    let mut table = Table::record(
        "variant level model role rho gaussians target_hvsq gate_hvsq test_hvsq test_psnr_db \
         test_ssim display_w render_w total_w passed iterations",
    );
    for m in &r.models {
        table.row([
            m.variant.as_str().into(),
            u32::from(m.level).into(),
            m.name.as_str().into(),
            m.role.name().into(),
            m.rho.into(),
            m.gaussians.into(),
            m.target_hvsq.into(),
            m.gate.hvsq.into(),
            m.test.hvsq.into(),
            m.test.psnr_db.into(),
            m.test.ssim.into(),
            m.display_w.into(),
            m.render_w.into(),
            m.total_w().into(),
            m.passed.into(),
            m.iterations.into(),
        ]);
    }
    table.csv()
}

/// `foveated.csv`: every method and variant. Quality in decibels, SSIM, FLIP and LPIPS is that of
/// level 1 over whole test views, behind the filter where there is one; no target is held to that,
/// and its levels have no state. HVSQ of R1 to R4 is that of the shown frames, of L1 to L4 that of
/// the model of the level over whole test views. FPS are those of the accelerator.
pub fn foveated_csv(r: &Results) -> Vec<u8> {
    let mut table = Table::record(
        "method variant fps total_w display_w render_w filter_w hvsq_r1 hvsq_r2 hvsq_r3 hvsq_r4 \
         hvsq_l1 hvsq_l2 hvsq_l3 hvsq_l4 gaussians_l1 gaussians_l2 gaussians_l3 gaussians_l4 \
         state_l1 state_l2 state_l3 state_l4 test_psnr_db test_ssim flip_test lpips_test",
    );
    for f in &r.foveated {
        let like = f.likeness(r);
        let mut cells: Vec<Cell> =
            vec![f.method.name().into(), f.variant.as_str().into(), f.fps.into()];
        cells.extend([f.total_w(), f.display_w, f.render_w, f.filter_w].map(Cell::from));
        cells.extend(f.hvsq.iter().map(|v| Cell::from(*v)));
        cells.extend(f.level_hvsq(r).into_iter().map(Cell::from));
        cells.extend(f.gaussians.iter().map(|n| Cell::from(*n)));
        cells.extend(f.shown_states().map(|state| Cell::from(state.map(LevelState::name))));
        cells.extend([like.psnr_db, like.ssim, like.flip, like.lpips].map(Cell::from));
        table.row(cells);
    }
    table.csv()
}

/// `regions.csv`: tiles, energy of sorting and rendering on the machine, and HVSQ of each region.
pub fn regions_csv(r: &Results) -> Vec<u8> {
    let mut table = Table::record("method variant region tiles joules_per_frame watts hvsq");
    for f in &r.foveated {
        for (i, region) in REGIONS.into_iter().enumerate() {
            table.row([
                f.method.name().into(),
                f.variant.as_str().into(),
                region.into(),
                f.tiles[i].into(),
                f.region_j[i].into(),
                (f.region_j[i] * r.fps).into(),
                f.hvsq[i].into(),
            ]);
        }
    }
    table.csv()
}
