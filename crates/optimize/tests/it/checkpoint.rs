//! Checkpoints: exact, and hostile bytes are refused.

use std::io::Cursor;

use powergs_optimize::checkpoint::{
    CheckpointError, Progress, read_whole_model, write_progress, write_whole_model,
};
use powergs_optimize::lambda::Memory;
use powergs_optimize::plan::{Campaign, Outcome, Variant};
use powergs_optimize::schedule::Plan;
use powergs_optimize::target::{Quality, TargetRule};
use powergs_optimize::tune::{Check, Model, State};

use super::scenes::tiny;

const PRINT: u128 = 0x0123_4567_89ab_cdef_0011_2233_4455_6677;

fn read(bytes: &[u8], print: u128) -> Result<Progress, CheckpointError> {
    Progress::read(&mut Cursor::new(bytes), print)
}

fn progress() -> Progress {
    let tiny = tiny(20, 24, (16, 12));
    let setup = tiny.setup();
    let model = Model::fresh(&tiny.dense);
    let quality = Quality::likeness(30.0, 0.9);
    let campaign = Campaign {
        schedule: Plan::PUBLISHED,
        baselines: Vec::new(),
        externals: Vec::new(),
        sweep: Vec::new(),
        variants: vec![Variant { name: "own".into(), rule: TargetRule::Absolute(quality) }],
        holds_out: false,
        levels: 1,
    };
    let job = campaign.next(&tiny.settings, 20, &[]).unwrap();
    let dense =
        Outcome::measured(&setup, &job, &model, None, |q| campaign.judge(&[], &job, q)).unwrap();
    let check = Check { iteration: 3, seen: dense.gate, passed: true, lambda: 0.25 };
    let memory = Memory { lambda: 0.5, passing: Some(0.25), margin_db: Some(1.5), calm: 2 };
    let mut state = State::begin(model.clone());
    (state.iteration, state.pruned) = (7, 1);
    state.control = Some(memory);
    state.best = Some((model, check));
    state.last = Some(check);
    Progress {
        outcomes: vec![dense],
        history_bytes: 1234,
        current: Some(("sample-01".into(), state)),
    }
}

fn bytes_of(progress: &Progress) -> Vec<u8> {
    let mut bytes = Vec::new();
    let current = progress.current.as_ref().map(|(name, state)| (name.as_str(), state));
    let (outcomes, history) = (&progress.outcomes, progress.history_bytes);
    write_progress(&mut bytes, PRINT, outcomes, history, current).unwrap();
    bytes
}

#[test]
fn everything_comes_back_exactly() {
    let mut progress = progress();
    // Infinite: the dense model against its own renders.
    progress.outcomes[0].gate.quality.psnr_db = f64::INFINITY;
    progress.outcomes[0].watts.render_w = 0.1 + 0.2;
    progress.outcomes[0].lpips_test = Some(0.125);
    progress.outcomes[0].flip_test = 0.0625;
    let bytes = bytes_of(&progress);
    assert_eq!(read(&bytes, PRINT).unwrap(), progress);
    let (_, state) = progress.current.unwrap();
    let mut bytes = Vec::new();
    write_whole_model(&mut bytes, PRINT, &state.model).unwrap();
    assert_eq!(read_whole_model(&mut Cursor::new(&bytes), PRINT).unwrap(), state.model);
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

#[test]
fn other_files_other_versions_and_other_runs_are_told_apart() {
    let bytes = bytes_of(&progress());
    let error = |bytes: &[u8], print| read(bytes, print).unwrap_err();
    assert_eq!(error(b"ply\nformat", PRINT), CheckpointError::Foreign);
    assert_eq!(error(&bytes, PRINT + 1), CheckpointError::OtherRun);
    let mut newer = bytes.clone();
    newer[6] = 9;
    assert_eq!(error(&newer, PRINT), CheckpointError::Version { found: 9 });
    let wrong = read_whole_model(&mut Cursor::new(&bytes), PRINT).unwrap_err();
    assert!(wrong.to_string().contains("something else"), "{wrong}");
}

/// A file with a right checksum whose counts promise more than it holds.
#[test]
fn a_count_of_terabytes_allocates_nothing() {
    let mut bytes = bytes_of(&progress());
    bytes.truncate(bytes.len() - 8);
    // After magic, version, kind, fingerprint and the length of the history.
    let at = 6 + 4 + 4 + 16 + 8;
    bytes[at..at + 8].copy_from_slice(&(u64::MAX / 7).to_le_bytes());
    let sum = xxhash_rust::xxh3::xxh3_64(&bytes);
    bytes.extend(sum.to_le_bytes());
    let error = read(&bytes, PRINT).unwrap_err();
    assert!(error.to_string().contains("promises more"), "{error}");
}
