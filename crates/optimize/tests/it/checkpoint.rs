//! Checkpoints: exact, and hostile bytes are refused.

use powergs_core::run::{MemoryStore, Store};
use powergs_optimize::checkpoint::{Checkpoints, Progress};
use powergs_optimize::history::HistoryRow;
use powergs_optimize::lambda::ControllerState;
use powergs_optimize::outcome::Outcome;
use powergs_optimize::plan::{Plan, Variant};
use powergs_optimize::schedule::Schedule;
use powergs_optimize::target::{Quality, TargetRule};
use powergs_optimize::tune::{Check, Heat, Iteration, Model, Pace, State, Term};
use powergs_scene::Gaussians;

use super::scenes::tiny;

const PRINT: u128 = 0x0123_4567_89ab_cdef_0011_2233_4455_6677;
const FILE: &str = "checkpoints/progress.ckpt";

/// What a store with these bytes says.
fn read(bytes: &[u8], print: u128) -> Result<Progress, String> {
    let store = MemoryStore::new();
    store.write(FILE, bytes).unwrap();
    let read = Checkpoints::new(&store, print).load();
    read.map(|progress| progress.expect("there is a file")).map_err(|e| e.to_string())
}

fn progress() -> Progress {
    let tiny = tiny(20, 24, (16, 12));
    let setup = tiny.setup();
    let model = Model::fresh(&tiny.dense);
    let quality = Quality::likeness(30.0, 0.9);
    let campaign = Plan {
        schedule: Schedule::PUBLISHED,
        baselines: Vec::new(),
        externals: Vec::new(),
        sweep_weights: Vec::new(),
        variants: vec![Variant { name: "own".into(), rule: TargetRule::Absolute(quality) }],
        holds_out: false,
        reference: None,
        given: None,
        levels: 1,
    };
    let job = campaign.next(&tiny.settings, 20, &[]).unwrap();
    let dense = Outcome::measured(&setup, &job, &model, None, |q| {
        campaign.judge(&[], job.role, job.place, q)
    })
    .unwrap();
    let check = Check {
        iteration: 3,
        seen: dense.gate,
        passed: true,
        sure: true,
        confirmed: true,
        lambda: 0.25,
    };
    let memory = ControllerState {
        lambda: 0.5,
        passing: Some(0.25),
        margin_db: Some(1.5),
        trend_db: -0.25,
        slack_db: 2.5,
        settled_checks: 2,
        settled_at: (0.5, 0.125),
    };
    let mut state = State::begin(model.clone());
    state.model.adam.steps = (0..20).map(|i| 1000 * i + 7).collect();
    (state.iteration, state.pruned) = (7, 1);
    state.control = Some(memory);
    state.average = Some((model.scene.clone(), 5));
    state.gauge.all(&setup, &model.scene, None);
    state.unconfirmed = 3;
    state.heat = Some(Heat::begin(0.75, Pace::RECOVERING));
    state.stride.missed(-0.25);
    state.best = Some((model.scene, check));
    state.last = Some(check);
    let loss = Term { total: 0.5, display_w: 0.25, likeness: None, hvsq: Some(1e-5) };
    let iteration =
        Iteration { iteration: 6, view: 1, points: 20, loss, lambda: 0.1, check: Some(check) };
    Progress {
        outcomes: vec![dense],
        history: vec![HistoryRow { job: 1, iteration }],
        current: Some(("sample-01".into(), state)),
    }
}

fn bytes_of(progress: &Progress) -> Vec<u8> {
    let store = MemoryStore::new();
    let current = progress.current.as_ref().map(|(name, state)| (name.as_str(), state));
    let checkpoints = Checkpoints::new(&store, PRINT);
    checkpoints.save(&progress.outcomes, &progress.history, current).unwrap();
    store.read(FILE).unwrap().expect("it was written")
}

#[test]
fn everything_comes_back_exactly() {
    let mut progress = progress();
    // Infinite: the dense model against its own renders.
    progress.outcomes[0].gate.quality.psnr_db = f64::INFINITY;
    progress.outcomes[0].watts.render_w = 0.1 + 0.2;
    progress.outcomes[0].lpips_test = Some(0.125);
    progress.outcomes[0].flip_test = 0.0625;
    assert_eq!(read(&bytes_of(&progress), PRINT).unwrap(), progress);
    let (_, mut state) = progress.current.unwrap();
    let antialiased = Gaussians { antialiased: true, ..state.model.scene };
    state.model = Model::fresh(&antialiased);
    let store = MemoryStore::new();
    let checkpoints = Checkpoints::new(&store, PRINT);
    assert!(!checkpoints.has_run().unwrap() && checkpoints.load().unwrap().is_none());
    checkpoints.save_model("sample-01", &state.model).unwrap();
    assert_eq!(checkpoints.load_model("sample-01").unwrap(), state.model);
    let missing = checkpoints.load_model("sample-02").unwrap_err().to_string();
    assert_eq!(missing, "memory:checkpoints/sample-02.ckpt: is missing; begin the run anew");
}

#[test]
fn every_cut_and_every_flipped_byte_is_refused() {
    let bytes = bytes_of(&progress());
    for len in (0..bytes.len()).step_by(97).chain([bytes.len() - 1]) {
        assert!(read(&bytes[..len], PRINT).is_err(), "cut at {len}");
    }
    for at in (0..bytes.len()).step_by(101) {
        let mut bad = bytes.clone();
        bad[at] ^= 0x40;
        assert!(read(&bad, PRINT).is_err(), "flipped at {at}");
    }
}

#[track_caller]
fn fails(bytes: &[u8], print: u128, text: &str) {
    let error = read(bytes, print).unwrap_err();
    assert!(error.contains(text), "{error}");
}

#[test]
fn other_files_other_versions_and_other_runs_are_told_apart() {
    let bytes = bytes_of(&progress());
    fails(b"ply\nformat", PRINT, "not a checkpoint of an optimisation");
    fails(&bytes, PRINT + 1, "other inputs or settings");
    let mut newer = bytes.clone();
    newer[6] = 15;
    fails(&newer, PRINT, "checkpoint version 15, this program reads 14");
    let store = MemoryStore::new();
    store.write("checkpoints/a.ckpt", &bytes).unwrap();
    let wrong = Checkpoints::new(&store, PRINT).load_model("a").unwrap_err().to_string();
    assert!(wrong.contains("something else"), "{wrong}");
}

/// Files with a right checksum whose counts promise more than they hold.
#[test]
fn counts_of_terabytes_allocate_nothing() {
    let whole = bytes_of(&progress());
    // The length of the head, after magic, version, kind and fingerprint; then the head itself,
    // which begins with the number of outcomes.
    for (at, count) in [(30, u64::MAX / 7), (38, u64::MAX)] {
        let mut bytes = whole[..whole.len() - 8].to_vec();
        bytes[at..at + 8].copy_from_slice(&count.to_le_bytes());
        let sum = xxhash_rust::xxh3::xxh3_64(&bytes);
        bytes.extend(sum.to_le_bytes());
        fails(&bytes, PRINT, "damaged");
    }
}
