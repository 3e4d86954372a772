//! The run folder: written while the run goes on, every file aside and then renamed, the history
//! appended. What is in it after a kill is a run that `--resume` continues.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::super::{Exit, Failure, OrExit};
use powergs_core::run::store::atomic::write_atomically;
use powergs_optimize::checkpoint::{Progress, read_whole_model, write_progress, write_whole_model};
use powergs_optimize::plan::{Job, Outcome};
use powergs_optimize::setup::Setup;
use powergs_optimize::tune::{Model, Row, State};

/// The checkpoint of the run as a whole.
const PROGRESS: &str = "checkpoints/progress.ckpt";
/// The history of all iterations.
const HISTORY: &str = "history.csv";
/// The columns of the history.
const COLUMNS: &str = "job,iteration,view,gaussians,loss,l1,ssim,psnr_db,lambda,display_w,\
                       gate_psnr_db,gate_ssim,gate_display_w,gate_passed,hvsq,gate_hvsq\n";

/// A run folder.
pub struct Folder {
    path: PathBuf,
    fingerprint: u128,
    history: BufWriter<File>,
    bytes: u64,
}

impl Folder {
    /// Opens a new folder, or with `resume` the folder of a run with the same `fingerprint`, and
    /// says where that run is.
    ///
    /// # Errors
    /// Exit code 2: a folder that holds something else, a run without `resume`, no run with it;
    /// 3: a damaged checkpoint.
    pub fn open(
        path: &Path,
        fingerprint: u128,
        resume: bool,
    ) -> Result<(Folder, Progress), Failure> {
        let place = path.display();
        let refuse = |what: &str| Failure::new(Exit::Usage, format!("{place}: {what}"));
        let file = path.join(PROGRESS);
        if resume && !file.is_file() {
            return Err(refuse("no run to go on with: no checkpoints/progress.ckpt"));
        }
        if !resume && path.exists() {
            let empty = fs::read_dir(path).map(|mut d| d.next().is_none()).unwrap_or(false);
            if file.is_file() {
                return Err(refuse("holds a run; go on with --resume, or give another --out"));
            }
            if !empty {
                return Err(refuse("is not empty; give --out a new folder"));
            }
        }
        let progress = if resume {
            let mut from = File::open(&file).or_exit(Exit::BadInput, file.display())?;
            let read = Progress::read(&mut from, fingerprint);
            read.or_exit(Exit::BadInput, file.display())?
        } else {
            Progress::default()
        };
        fs::create_dir_all(path.join("checkpoints")).or_exit(Exit::Usage, place)?;
        let (history, bytes) = history(&path.join(HISTORY), progress.history_bytes)?;
        Ok((Folder { path: path.to_owned(), fingerprint, history, bytes }, progress))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds an iteration to the history.
    pub fn record(&mut self, setup: &Setup<'_>, job: &Job, row: &Row) -> Result<(), Failure> {
        let loss = &row.loss;
        let view = setup.cameras[row.view].name.replace([',', '"', '\n', '\r'], "_");
        let check = row.check.map_or_else(
            || ",,,".to_owned(),
            |c| {
                let seen = &c.seen;
                let (psnr_db, ssim) = (seen.quality.psnr_db, seen.quality.ssim);
                format!("{psnr_db:.4},{ssim:.6},{:.6},{}", seen.display_w, c.passed)
            },
        );
        let likeness = loss.likeness.map_or_else(
            || ",,".to_owned(),
            |[l1, ssim, psnr_db]| format!("{l1:.8},{ssim:.6},{psnr_db:.4}"),
        );
        let shown = |hvsq: Option<f64>| hvsq.map_or(String::new(), |v| format!("{v:.6e}"));
        let (hvsq, gate) = (shown(loss.hvsq), shown(row.check.and_then(|c| c.seen.quality.hvsq)));
        let line = format!(
            "{},{},{view},{},{:.8},{likeness},{:.6e},{:.6},{check},{hvsq},{gate}\n",
            job.name, row.iteration, row.points, loss.total, row.lambda, loss.display_w,
        );
        self.bytes += line.len() as u64;
        self.history.write_all(line.as_bytes()).or_exit(Exit::Usage, self.place(HISTORY))
    }

    /// Writes where the run is: what is done, and the job in flight.
    pub fn save(
        &mut self,
        outcomes: &[Outcome],
        current: Option<(&str, &State)>,
    ) -> Result<(), Failure> {
        let place = self.place(HISTORY);
        self.history.flush().or_exit(Exit::Usage, place)?;
        let (print, bytes) = (self.fingerprint, self.bytes);
        Ok(write_atomically(&self.path.join(PROGRESS), |mut w| {
            write_progress(&mut w, print, outcomes, bytes, current)
        })?)
    }

    /// Writes the model of a finished job.
    pub fn save_model(&self, job: &str, model: &Model) -> Result<(), Failure> {
        let print = self.fingerprint;
        Ok(write_atomically(&self.model(job), |mut w| write_whole_model(&mut w, print, model))?)
    }

    /// Reads the model of a finished job.
    ///
    /// # Errors
    /// Exit code 3: it is missing or damaged.
    pub fn load_model(&self, job: &str) -> Result<Model, Failure> {
        let path = self.model(job);
        let mut from = File::open(&path).or_exit(Exit::BadInput, path.display())?;
        read_whole_model(&mut from, self.fingerprint).or_exit(Exit::BadInput, path.display())
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
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        Ok(write_atomically(&self.path.join(name), |w| w.write_all(bytes))?)
    }

    /// The history so far.
    pub fn history(&mut self) -> Result<String, Failure> {
        let place = self.place(HISTORY);
        self.history.flush().or_exit(Exit::Usage, &place)?;
        fs::read_to_string(self.path.join(HISTORY)).or_exit(Exit::BadInput, place)
    }

    fn model(&self, job: &str) -> PathBuf {
        self.path.join("checkpoints").join(format!("{job}.ckpt"))
    }

    fn place(&self, name: &str) -> String {
        self.path.join(name).display().to_string()
    }
}

/// The history, cut to what belongs to the checkpoint.
fn history(path: &Path, bytes: u64) -> Result<(BufWriter<File>, u64), Failure> {
    let shown = path.display();
    let mut options = OpenOptions::new();
    options.create(true).write(true).truncate(false);
    let mut file = options.open(path).or_exit(Exit::Usage, shown.to_string())?;
    let length = file.metadata().or_exit(Exit::Usage, shown.to_string())?.len();
    if length < bytes {
        let what = format!("{shown}: is shorter than when the checkpoint was written");
        return Err(Failure::new(Exit::BadInput, what));
    }
    file.set_len(bytes).or_exit(Exit::Usage, shown.to_string())?;
    file.seek(SeekFrom::End(0)).or_exit(Exit::Usage, shown.to_string())?;
    let mut writer = BufWriter::new(file);
    let mut bytes = bytes;
    if bytes == 0 {
        writer.write_all(COLUMNS.as_bytes()).or_exit(Exit::Usage, shown.to_string())?;
        bytes = COLUMNS.len() as u64;
    }
    Ok((writer, bytes))
}
