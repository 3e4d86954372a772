//! What a run leaves on its way: models without moments, and a disk that fills.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::sync::Mutex;

use powergs_core::run::store::{Journals, Lock, NewFile, Sharing};
use powergs_core::run::{MemoryStore, RunError, Store};
use powergs_optimize::campaign::{Campaign, CampaignError};
use powergs_optimize::checkpoint::model_bytes;
use powergs_optimize::references::ReferenceImages;
use powergs_optimize::request::{Goal, Goals, Request};
use powergs_optimize::role::Role;
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::Settings;
use powergs_optimize::target::Level;
use powergs_optimize::tune::Iteration;
use powergs_optimize::watch::CampaignWatch;

use super::campaign::{open, request};
use super::scenes::tiny;

/// A medium of limited size that remembers how full it was.
struct Medium {
    files: MemoryStore,
    /// Bytes of each file.
    sizes: Mutex<BTreeMap<String, u64>>,
    room: u64,
    most: Mutex<u64>,
}

/// A store on one.
#[derive(Clone, Copy)]
struct Disk(&'static Medium);

/// A file that fails when the disk is full; then the one of before stays.
struct DiskFile {
    disk: &'static Medium,
    name: String,
    bytes: Vec<u8>,
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let used: u64 = self.disk.sizes.lock().unwrap().values().sum();
        let needed = used + (self.bytes.len() + bytes.len()) as u64;
        if needed > self.disk.room {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let mut most = self.disk.most.lock().unwrap();
        *most = needed.max(*most);
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl NewFile for DiskFile {
    fn commit(self: Box<Self>) -> io::Result<()> {
        self.disk.sizes.lock().unwrap().insert(self.name.clone(), self.bytes.len() as u64);
        self.disk.files.write(&self.name, &self.bytes).map_err(io::Error::other)
    }
}

impl Store for Disk {
    fn place(&self, name: &str) -> String {
        self.0.files.place(name)
    }

    fn list(&self, folder: &str) -> Result<Vec<String>, RunError> {
        self.0.files.list(folder)
    }

    fn open(&self, name: &str) -> Result<Option<Box<dyn Read + Send>>, RunError> {
        self.0.files.open(name)
    }

    fn create(&self, name: &str) -> Result<Box<dyn NewFile>, RunError> {
        Ok(Box::new(DiskFile { disk: self.0, name: name.into(), bytes: Vec::new() }))
    }

    fn remove(&self, name: &str) -> Result<(), RunError> {
        self.0.sizes.lock().unwrap().remove(name);
        self.0.files.remove(name)
    }

    fn lock(&self, name: &str, sharing: Sharing) -> Result<Lock, RunError> {
        self.0.files.lock(name, sharing)
    }

    fn journals(&self, folder: &str, own: Option<&str>) -> Result<Box<dyn Journals>, RunError> {
        self.0.files.journals(folder, own)
    }
}

/// A disk with so much room.
fn disk(room: u64) -> Disk {
    let (sizes, most) = Default::default();
    let medium = Medium { files: MemoryStore::new(), sizes, room, most };
    Disk(Box::leak(Box::new(medium)))
}

/// Bytes of the models that are kept at the end, and of the checkpoint.
fn left(disk: Disk) -> (u64, u64) {
    let sizes = disk.0.sizes.lock().unwrap();
    let is_model = |name: &&String| name.ends_with(".ckpt") && !name.ends_with("progress.ckpt");
    let models = sizes.iter().filter(|(name, _)| is_model(name)).map(|(_, n)| n).sum();
    (models, sizes["checkpoints/progress.ckpt"])
}

/// Everything that a run says.
fn told(campaign: &Campaign, store: &dyn Store) -> Result<String, CampaignError> {
    struct Silent;
    impl powergs_core::run::Watch for Silent {}
    impl CampaignWatch for Silent {}
    let finished = campaign.run(store, &Silent)?.expect("nobody cancels");
    Ok(finished.results.to_json() + &format!("{:?}", finished.model))
}

#[test]
fn models_are_kept_without_moments() {
    let (needed, all) = (disk(u64::MAX), disk(u64::MAX));
    let whole = told(&open(request()), &needed).unwrap();
    let kept = told(&open(Request { keep_all: true, ..request() }), &all).unwrap();
    assert!(whole == kept, "what is kept changes no number");
    let dense = model_bytes(open(request()).dense.len(), 3);
    let (models, _) = left(needed);
    // Samples of 1, 0.8 and 0.6 of the Gaussians, the optimum, and two comparisons.
    assert!(2 * models < 11 * dense, "{models} bytes, {dense} a dense model");
    assert!(left(all).0 > 3 * models - dense, "all moments: {}, {models}", left(all).0);
    // On the way there are the moments of a model or two, and two checkpoints while one replaces
    // the other.
    let most = *needed.0.most.lock().unwrap();
    assert!(most < models + (2 * 2 + 2 * 7) * dense, "{most} bytes at once");
}

/// Counts the models on a disk whenever a job begins.
struct Counts {
    disk: Disk,
    most: Mutex<(u64, String)>,
}

impl powergs_core::run::Watch for Counts {}

impl CampaignWatch for Counts {
    fn iteration(&self, job: &str, row: &Iteration) {
        let sizes = self.disk.0.sizes.lock().unwrap();
        let is_model = |name: &&String| name.ends_with(".ckpt") && !name.ends_with("progress.ckpt");
        let models: u64 = sizes.iter().filter(|(name, _)| is_model(name)).map(|(_, n)| n).sum();
        let mut most = self.most.lock().unwrap();
        if row.iteration == 0 && models > most.0 {
            *most = (models, job.to_owned());
        }
    }
}

/// Photos and a share, so that samples crowd where nothing is pruned; with lower qualities after
/// it, what missed may reach them.
fn crowded(levels: &[Level]) -> Request {
    let asked = request();
    let references = ReferenceImages::Photos(Box::new(tiny(200, 3, (48, 36)).references));
    let goals = Goals {
        goal: Some(Goal::Levels(levels.to_vec())),
        schedule: Schedule::FIVE,
        baselines: Vec::new(),
        ratio_study: false,
        ..asked.goals
    };
    let settings = Settings { iterations: 10, final_iterations: 20, ..asked.settings };
    Request { goals, references, settings, ..asked }
}

#[test]
fn models_never_take_more_than_the_one_that_shares_are_shares_of_and_four_times_the_dense_one() {
    for levels in [vec![Level::High], Level::ALL.to_vec()] {
        let campaign = open(crowded(&levels));
        let disk = disk(u64::MAX);
        let counts = Counts { disk, most: Mutex::default() };
        let finished = campaign.run(&disk, &counts).unwrap().unwrap();
        let models: u64 = finished.outcomes.iter().map(|o| o.points as u64).sum();
        let (dense, degree) = (campaign.dense.len(), campaign.dense.sh_degree);
        assert!(models > 6 * dense as u64, "too little is made for the test to say anything");
        // The last model has its moments, twice its size: what follows goes on with them.
        let (most, job) = counts.most.into_inner().unwrap();
        let room = (1 + 4 + 2) * model_bytes(dense, degree) + 10_000;
        assert!(most <= room, "{most} of {room} bytes before {job}, {levels:?}");
        assert!(left(disk).0 <= 5 * model_bytes(dense, degree) + 10_000);
        // What is left is enough for another panel.
        let to = MemoryStore::new();
        let mut other = open(Request { display_ratio: Some(3.0), ..crowded(&levels) });
        let priced = other.reprice(&disk, &to, false, &()).unwrap().unwrap().priced().unwrap();
        assert!(priced.model.is_some() && priced.outcomes.len() > 3);
        assert!(priced.outcomes.iter().any(|o| o.role == Role::HeldOut));
        assert_eq!(
            priced.results.variants[0].target_psnr_db,
            finished.results.variants[0].target_psnr_db
        );
    }
}

#[test]
fn a_full_disk_keeps_the_last_checkpoint() {
    let enough = disk(u64::MAX);
    let whole = told(&open(request()), &enough).unwrap();
    let most = *enough.0.most.lock().unwrap();
    for share in [30, 60, 90] {
        let full = disk(most * share / 100);
        let failure = told(&open(request()), &full).unwrap_err().to_string();
        assert!(failure.contains("the disk is full: this file needs 1 MiB"), "{failure}");
        assert!(failure.contains("go on with --resume"), "{failure}");
        // With more room it goes on where it was.
        let more = with_more_room(full);
        assert!(told(&open(request()), &more).unwrap() == whole, "{share} % of the room");
    }
}

/// A disk without end that holds what another one does.
fn with_more_room(full: Disk) -> Disk {
    let more = disk(u64::MAX);
    for name in full.0.files.list("checkpoints").unwrap() {
        let name = format!("checkpoints/{name}");
        let bytes = full.0.files.read(&name).unwrap().unwrap();
        let mut file = more.create(&name).unwrap();
        file.write_all(&bytes).unwrap();
        file.commit().unwrap();
    }
    more
}

/// Wherever it was broken off: before the first model was copied, between two, before the last.
#[test]
fn pricing_anew_that_was_broken_off_ends_as_if_it_was_not() {
    let from = disk(u64::MAX);
    told(&open(request()), &from).unwrap();
    let price = |to: &dyn Store| -> Result<String, CampaignError> {
        let mut other = open(Request { display_ratio: Some(3.0), ..request() });
        let finished = other.reprice(&from, to, false, &())?.expect("nobody cancels").priced()?;
        Ok(finished.results.to_json() + &format!("{:?}", finished.model))
    };
    let enough = disk(u64::MAX);
    let whole = price(&enough).unwrap();
    let most = *enough.0.most.lock().unwrap();
    for share in (0..100).step_by(10) {
        let full = disk(most * share / 100);
        price(&full).unwrap_err();
        let more = with_more_room(full);
        assert!(price(&more).unwrap() == whole, "{share} % of the room");
        assert!(more.open("checkpoints/run.json").unwrap().is_some(), "{share} % of the room");
    }
}

/// A run that was stopped before it said what it is says so when it goes on.
#[test]
fn a_run_without_its_mark_gets_it_when_it_goes_on() {
    let store = disk(u64::MAX);
    let campaign = open(request());
    drop(campaign.begin(&store).unwrap());
    store.remove("checkpoints/run.json").unwrap();
    told(&campaign, &store).unwrap();
    assert!(store.open("checkpoints/run.json").unwrap().is_some());
    let mut other = open(Request { display_ratio: Some(3.0), ..request() });
    assert!(other.reprice(&store, &MemoryStore::new(), false, &()).unwrap().is_some());
}
