//! `DIR/slurm`: what outlives the program that follows a job.

use std::fs::{self, File, TryLockError};
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use super::Request;
use crate::cli::{Exit, Failure, OrExit};
use powergs_core::run::store::atomic::write_atomically;
use powergs_study::slurm::script::{exit_name, log_name};
use powergs_study::slurm::state::Submitted;
use powergs_study::slurm::{SHARDS_MAX, Settings};

/// The largest `job.toml` that is read, bytes.
const JOB_MAX: u64 = 64 << 20;

/// Bytes of the end of a log that are read.
const TAIL: u64 = 4096;

/// The jobs of a run. While it lives no other program follows them.
#[derive(Debug)]
pub struct Job {
    /// The output folder, absolute.
    out: PathBuf,
    record: JobRecord,
    _lock: File,
}

/// `job.toml`.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct JobRecord {
    /// Hash of the arguments, names of files among them.
    request: String,
    /// Parts of the work.
    shards: u32,
    /// In the order of their submission.
    #[serde(default)]
    jobs: Vec<JobEntry>,
}

/// One array job.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct JobEntry {
    id: String,
    cluster: Option<String>,
    parts: Vec<u32>,
}

impl Job {
    /// Opens or makes `DIR/slurm` and locks it.
    pub fn open(request: &Request<'_>, settings: &Settings) -> Result<Job, Failure> {
        let folder = request.out.join("slurm");
        fs::create_dir_all(&folder).or_exit(Exit::Usage, folder.display())?;
        let lock = lock(&folder.join("follow.lock"))?;
        let path = folder.join("job.toml");
        let fresh = JobRecord { request: hash(request), shards: settings.shards, jobs: Vec::new() };
        let record = read(&path)?.unwrap_or_else(|| fresh.clone());
        let name = path.display();
        if record.shards != fresh.shards {
            let (old, new) = (record.shards, fresh.shards);
            return Err(Failure::new(
                Exit::Usage,
                format!(
                    "{name}: the job has {old} parts, the settings say `shards = {new}`: set it \
                     back to {old}, or use another --out"
                ),
            ));
        }
        if record.request != fresh.request {
            return Err(Failure::new(
                Exit::Usage,
                format!(
                    "{name}: the job was submitted with other arguments: repeat those, or use \
                     another --out"
                ),
            ));
        }
        Ok(Job { out: request.out.to_owned(), record, _lock: lock })
    }

    /// The script.
    pub fn script(&self) -> PathBuf {
        self.out.join("slurm").join("job.sh")
    }

    /// Whether something was submitted before.
    pub fn is_submitted(&self) -> bool {
        !self.record.jobs.is_empty()
    }

    /// Notes a job.
    pub fn note(&mut self, job: Submitted, parts: &[u32]) -> Result<(), Failure> {
        let Submitted { id, cluster } = job;
        self.record.jobs.push(JobEntry { id, cluster, parts: parts.to_vec() });
        let path = self.out.join("slurm").join("job.toml");
        let text = toml::to_string(&self.record).or_exit(Exit::Internal, path.display())?;
        Ok(write_atomically(&path, |w| w.write_all(text.as_bytes()))?)
    }

    /// The jobs, each with the parts that no later one has.
    pub fn latest(&self) -> Vec<(Submitted, Vec<u32>)> {
        let mut owner = vec![None; self.record.shards as usize];
        for (index, entry) in self.record.jobs.iter().enumerate() {
            for part in &entry.parts {
                owner[*part as usize - 1] = Some(index);
            }
        }
        let parts_of = |index| {
            let mine = owner.iter().zip(1..).filter(|(o, _)| **o == Some(index));
            mine.map(|(_, part)| part).collect()
        };
        let jobs = self.record.jobs.iter().enumerate();
        let listed = jobs.map(|(index, e)| {
            (Submitted { id: e.id.clone(), cluster: e.cluster.clone() }, parts_of(index))
        });
        listed.filter(|(_, parts): &(_, Vec<u32>)| !parts.is_empty()).collect()
    }

    /// The numbers of the jobs that a part still belongs to.
    pub fn live(&self) -> impl Iterator<Item = String> {
        self.latest().into_iter().map(|(job, _)| job.id)
    }

    /// The exit code that a task has noted.
    pub fn exit_code(&self, job: &str, part: u32) -> Option<u8> {
        fs::read_to_string(self.out.join(exit_name(job, part))).ok()?.trim().parse().ok()
    }

    /// Where the log of a task is, and its last line with something on it.
    pub fn log(&self, job: &str, part: u32) -> (PathBuf, Option<String>) {
        let path = self.out.join(log_name(job, part));
        let last = tail(&path).and_then(|text| {
            text.lines().rev().map(str::trim).find(|l| !l.is_empty()).map(str::to_owned)
        });
        (path, last)
    }
}

fn tail(path: &Path) -> Option<String> {
    let mut file = File::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    std::io::Seek::seek(&mut file, std::io::SeekFrom::Start(length.saturating_sub(TAIL))).ok()?;
    let mut bytes = Vec::new();
    file.take(TAIL).read_to_end(&mut bytes).ok()?;
    Some(String::from_utf8_lossy(&bytes).into_owned())
}

fn hash(request: &Request<'_>) -> String {
    let mut hasher = Xxh3::new();
    for word in request.arguments {
        hasher.update(word.as_encoded_bytes());
        hasher.update(&[0]);
    }
    format!("{:032x}", hasher.digest128())
}

fn lock(path: &Path) -> Result<File, Failure> {
    let file = File::create(path).or_exit(Exit::Usage, path.display())?;
    match file.try_lock() {
        // A file system without locks cannot tell; two followers are then the user's own.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(Failure::new(
            Exit::Usage,
            format!("{}: another powergs-sim follows this job already", path.display()),
        )),
    }
}

fn read(path: &Path) -> Result<Option<JobRecord>, Failure> {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(e).or_exit(Exit::Usage, path.display()),
    };
    let mut text = String::new();
    file.take(JOB_MAX).read_to_string(&mut text).or_exit(Exit::BadInput, path.display())?;
    let record: JobRecord = toml::from_str(&text).or_exit(Exit::BadInput, path.display())?;
    let known = |part: &u32| (1..=record.shards).contains(part);
    let number = |id: &str| !id.is_empty() && id.bytes().all(|b| b.is_ascii_digit());
    let good = |e: &JobEntry| number(&e.id) && e.parts.iter().all(known);
    if record.shards > SHARDS_MAX || !record.jobs.iter().all(good) {
        let message = format!(
            "{}: parts or job numbers that cannot be: remove the file if no job runs",
            path.display()
        );
        return Err(Failure::new(Exit::BadInput, message));
    }
    Ok(Some(record))
}
