//! The run folder: the store, tables, the joint pair, charts, pages.

use super::super::slurm;
use super::super::store_folder::Layout;

pub use super::super::store_folder::{Existing, Folder};

/// Models and pairs by content, and what a finished run leaves.
pub const LAYOUT: Layout = Layout {
    marker: "run.toml",
    stores: &["models", "pairs"],
    jobs: &[slurm::FOLDER],
    files: &[
        "run.toml",
        "space.toml",
        "invocation.toml",
        "pairs.csv",
        "models.csv",
        "summary.md",
        "report.html",
        "joint.ply",
        "joint.sog",
        "joint.compressed.ply",
        "joint.spz",
        "joint.toml",
        "joint.bin",
    ],
    charts: &["front", "map", "breakdown", "strip"],
    further_charts: "",
};
