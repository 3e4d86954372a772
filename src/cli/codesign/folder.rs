//! The run folder: the store, tables, the joint pair, charts, pages.

use super::super::slurm;
use super::super::store_folder::FolderLayout;

pub use super::super::store_folder::{Existing, Folder};

/// Whether a name is one of content: a model, or a model and the machines of a space.
fn is_content(name: &str) -> bool {
    let is_hash = |part: &str| {
        part.len() == 16 && part.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
    };
    name.split_once('-').map_or_else(|| is_hash(name), |(a, b)| is_hash(a) && is_hash(b))
}

/// Models and pairs by content, and what a finished run leaves.
pub const LAYOUT: FolderLayout = FolderLayout {
    marker: "run.toml",
    stores: &["models", "pairs"],
    is_ours: is_content,
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
