//! The run folder: what a finished run leaves beside its checkpoints.

use super::super::store_folder::FolderLayout;

pub use super::super::store_folder::Folder;

/// Checkpoints, tables, models, charts.
pub const LAYOUT: FolderLayout = FolderLayout {
    marker: "checkpoints/progress.ckpt",
    stores: &["checkpoints"],
    is_ours: |name| name == "run.json" || name.ends_with(".ckpt"),
    jobs: &[],
    files: &[
        "run.toml",
        "invocation.toml",
        "history.csv",
        "samples.csv",
        "models.csv",
        "ratios.csv",
        "levels.csv",
        "foveated.csv",
        "regions.csv",
        "results.json",
        "summary.md",
        "report.html",
        "final.ply",
        "final-H.ply",
        "final-M.ply",
        "final-L.ply",
        "final.bin",
        "model.fov",
        "fr.bin",
    ],
    charts: &["breakdown", "course", "curves", "plane", "quality", "ratio", "strip", "sweep"],
    further_charts: "foveated_",
};
