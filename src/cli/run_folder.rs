//! The folder of a report: it appears complete or not at all, and never in place of something else.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::{Exit, Failure, OrExit};
use powergs_chart::Chart;
use powergs_report::{FILE_NAMES, chart_files, sweep};

/// A folder being written: a hidden one beside the final place, renamed at the end, removed if it
/// is dropped before.
#[derive(Debug)]
pub struct RunFolder {
    staging: TempDir,
    target: Target,
}

/// Where the folder will be.
#[derive(Debug, Clone)]
enum Target {
    /// Where the user said.
    Given { path: PathBuf, force: bool },
    /// The first free one of `path`, `path-2`, `path-3`, …
    Counted(PathBuf),
}

/// Names that end with a counter are tried up to here.
const MOST: usize = 10_000;

impl RunFolder {
    /// A new folder at `out`, or at the first free of `reports/NAME`, `reports/NAME-2`, …
    ///
    /// Refused with [`Exit::Usage`] before any work is done: a finished report without `force`,
    /// and, whatever the flags, a folder with files that are not of a report.
    pub fn create(out: Option<&Path>, name: &str, force: bool) -> Result<RunFolder, Failure> {
        let target = match out {
            Some(path) => {
                check_given(path, force)?;
                Target::Given { path: path.to_owned(), force }
            }
            None => Target::Counted(Path::new("reports").join(file_name(name))),
        };
        let path = target.path();
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
        let parent = parent.unwrap_or(Path::new("."));
        fs::create_dir_all(parent).map_err(|e| cannot(path, &e))?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(".report-");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        let staging = builder.tempdir_in(parent).map_err(|e| cannot(path, &e))?;
        Ok(RunFolder { staging, target })
    }

    /// Writes a file.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        debug_assert!(is_ours(name), "{name} is not a file of a report");
        let path = self.staging.path().join(name);
        fs::write(path, bytes).map_err(|e| cannot(self.target.path(), &e))
    }

    /// Writes a PNG and an SVG of every chart.
    pub fn write_charts(&self, charts: &[Chart]) -> Result<(), Failure> {
        for file in chart_files(charts).or_exit(Exit::Internal, "charts")? {
            self.write(&file.name, &file.bytes)?;
        }
        Ok(())
    }

    /// Makes a file that is written as a stream.
    pub fn stream(&self, name: &str) -> Result<fs::File, Failure> {
        debug_assert!(is_ours(name), "{name} is not a file of a report");
        let path = self.staging.path().join(name);
        fs::File::create(path).map_err(|e| cannot(self.target.path(), &e))
    }

    /// Moves the folder to its place and returns that.
    pub fn finish(self) -> Result<PathBuf, Failure> {
        match &self.target {
            Target::Given { path, force } => {
                check_given(path, *force)?;
                replace(self.staging.path(), path).map_err(|e| cannot(path, &e))?;
                Ok(path.clone())
            }
            Target::Counted(base) => {
                for i in 1..MOST {
                    let path = numbered(base, i);
                    // Renaming over a folder with files fails, so of two runs one takes the next.
                    if !path.exists() && fs::rename(self.staging.path(), &path).is_ok() {
                        return Ok(path);
                    }
                }
                let what = "no free name for a report; delete old reports or use --out";
                Err(Failure::new(Exit::Usage, format!("{}: {what}", base.display())))
            }
        }
    }
}

impl Target {
    fn path(&self) -> &Path {
        match self {
            Target::Given { path, .. } | Target::Counted(path) => path,
        }
    }
}

fn numbered(base: &Path, i: usize) -> PathBuf {
    if i == 1 {
        return base.to_owned();
    }
    let mut name = base.as_os_str().to_owned();
    name.push(format!("-{i}"));
    name.into()
}

/// A name that is one plain component of a path.
fn file_name(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name: String = name.chars().take(100).map(plain).collect();
    let name = name.trim_start_matches('.');
    if name.is_empty() { "report".into() } else { name.into() }
}

/// Whether a report may have a file of this name.
fn is_ours(name: &str) -> bool {
    FILE_NAMES.contains(&name) || sweep::FILE_NAMES.contains(&name)
}

/// Whether a report may be put at `path`.
fn check_given(path: &Path, force: bool) -> Result<(), Failure> {
    let refuse = |what: String| Failure::new(Exit::Usage, format!("{}: {what}", path.display()));
    let entries = match fs::read_dir(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(e) if e.kind() == io::ErrorKind::NotADirectory => {
            return Err(refuse("is a file; give --out a folder".into()));
        }
        Err(e) => return Err(cannot(path, &e)),
        Ok(entries) => entries,
    };
    let mut names = Vec::new();
    for entry in entries {
        names.push(entry.map_err(|e| cannot(path, &e))?.file_name());
    }
    names.sort();
    let foreign = |name: &&std::ffi::OsString| !name.to_str().is_some_and(is_ours);
    if let Some(name) = names.iter().find(foreign) {
        let name = name.to_string_lossy();
        return Err(refuse(format!(
            "holds `{name}`, which is not of a report; use another folder"
        )));
    }
    if !names.is_empty() && !force {
        let what = "holds a report already; use --force to replace it, or another folder";
        return Err(refuse(what.into()));
    }
    Ok(())
}

/// Puts `staging` in the place of `path`, which is absent, empty, or a report to be replaced.
fn replace(staging: &Path, path: &Path) -> io::Result<()> {
    if !path.exists() {
        return fs::rename(staging, path);
    }
    let old = staging.with_extension("old");
    fs::rename(path, &old)?;
    if let Err(e) = fs::rename(staging, path) {
        fs::rename(&old, path)?;
        return Err(e);
    }
    fs::remove_dir_all(old)
}

fn cannot(path: &Path, e: &io::Error) -> Failure {
    Failure::new(Exit::Usage, format!("{}: the report cannot be written: {e}", path.display()))
}
