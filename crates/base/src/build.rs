//! Which build of the program made a result: for run records and the metadata of pictures.

use std::sync::OnceLock;

/// Version of the program: all crates of the workspace carry the same one.
pub const TOOL_VERSION: &str = env!("CARGO_PKG_VERSION");

/// What a build is made of besides its version.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Build {
    /// The commit, or `unknown`.
    pub commit: &'static str,
    /// Version of the models.
    pub models: u32,
    /// Major and minor version of the traces that it writes.
    pub traces: [u16; 2],
}

static BUILD: OnceLock<Build> = OnceLock::new();

/// Says what the program is made of, once, before it writes anything. Libraries that say nothing
/// are known by their version alone.
pub fn is(build: Build) {
    // A second call, of another test in this process, says the same.
    let _ = BUILD.set(build);
}

/// The commit, or `unknown`.
pub fn commit() -> &'static str {
    BUILD.get().map_or("unknown", |build| build.commit)
}

/// All of it in a line: `powergs-sim 0.2.0, models 12, traces 2.2, commit 0123456789ab`.
pub fn line() -> String {
    let name = format!("powergs-sim {TOOL_VERSION}");
    match BUILD.get() {
        None => name,
        Some(Build { commit, models, traces: [major, minor] }) => {
            format!("{name}, models {models}, traces {major}.{minor}, commit {commit}")
        }
    }
}
