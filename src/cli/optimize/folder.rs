//! The run folder: what a finished run leaves beside its checkpoints.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::super::{Exit, Failure, OrExit};
use powergs_chart::Chart;
use powergs_core::run::FileStore;
use powergs_core::run::store::atomic::write_atomically;
use powergs_optimize::campaign::{Campaign, CampaignError, Run};
use powergs_report::chart_files;

/// A run folder.
pub struct Folder {
    path: PathBuf,
    store: FileStore,
}

impl Folder {
    /// The folder; nothing is opened or made yet.
    pub fn new(path: &Path) -> Folder {
        Folder { path: path.to_owned(), store: FileStore::new(path) }
    }

    /// Begins a run in a new folder, or with `resume` goes on with the one that is there.
    ///
    /// # Errors
    /// Exit code 2: a folder that holds something else, a run without `resume`, no run with it;
    /// 3: a damaged checkpoint, or one of another run.
    pub fn open<'a>(&'a self, campaign: &'a Campaign, resume: bool) -> Result<Run<'a>, Failure> {
        let refuse =
            |what: &str| Failure::new(Exit::Usage, format!("{}: {what}", self.path.display()));
        let run = match resume {
            true => campaign.resume(&self.store),
            // Nothing is written beside the files of others.
            false if !self.is_free() => Err(CampaignError::HoldsRun),
            false => campaign.begin(&self.store),
        };
        run.map_err(|error| match error {
            CampaignError::NoRun => refuse("no run to go on with: no checkpoints/progress.ckpt"),
            CampaignError::HoldsRun if self.path.join("checkpoints/progress.ckpt").is_file() => {
                refuse("holds a run; go on with --resume, or give another --out")
            }
            CampaignError::HoldsRun => refuse("is not empty; give --out a new folder"),
            error => error.into(),
        })
    }

    /// Whether the folder is empty, or not there.
    fn is_free(&self) -> bool {
        let is_empty = |mut entries: fs::ReadDir| entries.next().is_none();
        !self.path.exists() || fs::read_dir(&self.path).is_ok_and(is_empty)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file of the folder, part by part.
    pub fn stream(
        &self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        Ok(write_atomically(&self.path.join(name), write)?)
    }

    /// Writes a file of the folder.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
        self.stream(name, |w| w.write_all(bytes.as_ref()))
    }

    /// Draws and writes charts.
    pub fn draw(&self, charts: &[Chart]) -> Result<(), Failure> {
        for file in chart_files(charts).or_exit(Exit::Internal, "charts")? {
            self.write(&file.name, file.bytes)?;
        }
        Ok(())
    }
}
