//! Checkpoints of the optimiser: any bytes are where a run is or an error, also behind a right
//! header and checksum.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_sim::optimize::checkpoint::Checkpoints;
use powergs_sim::run::{MemoryStore, Store};
use xxhash_rust::xxh3::xxh3_64;

const FINGERPRINT: u128 = 7;

fn read(bytes: &[u8]) {
    let store = MemoryStore::new();
    for name in ["progress", "job"] {
        store.write(&format!("checkpoints/{name}.ckpt"), bytes).expect("memory");
    }
    let checkpoints = Checkpoints::new(&store, FINGERPRINT);
    let _ = checkpoints.load();
    let _ = checkpoints.load_model("job");
}

fuzz_target!(|bytes: &[u8]| {
    read(bytes);
    let Some(end) = bytes.len().checked_sub(8).filter(|&end| end >= 38) else { return };
    let mut sealed = bytes.to_vec();
    sealed[..10].copy_from_slice(b"PGSOPT\x04\0\0\0");
    sealed[14..30].copy_from_slice(&FINGERPRINT.to_le_bytes());
    let sum = xxh3_64(&sealed[..end]).to_le_bytes();
    sealed[end..].copy_from_slice(&sum);
    read(&sealed);
});
