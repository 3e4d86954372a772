//! Tile-wise machines keep the laws of every dataflow.

use powergs_base::config::embedded::MACHINES;
use powergs_base::config::inert::inert;
use powergs_core::sim::contract::{Trial, broken};

use crate::workload::support::{dense_frame, small_frame};

#[test]
fn tile_wise_machines_keep_the_laws() {
    let gscore = MACHINES.iter().find(|file| file.name == "gscore").expect("a machine").complete();
    // Keys with a condition, and those of foveated frames.
    let inert = inert().get("machine").into_iter().flatten().map(|(key, _)| key.as_str());
    let idle: Vec<&str> = inert.chain(["fovea.record", "fovea.feature"]).collect();
    let frames = [small_frame(0), small_frame(1), dense_frame(1)];
    let trial = Trial {
        machine: &gscore,
        files: &[],
        variants: &[
            &[],
            &["dram.model=bandwidth", "vru.impl=scan", "buffers.pixel-out.capacity=64 KiB"],
            &["gsu.impl=update", "binning.impl=free", "cache.capacity=32 KiB"],
            &["binning.impl=two-pass", "vru.impl=swap", "buffers.pixel-out.capacity=64 KiB"],
            &["codebook.entries=1024", "record.id-bits=1", "record.id-check=false"],
            &[
                "ccu.fetch=lazy-colour",
                "record.feature-source=nobody",
                "vru.colour-operations-per-cycle=133",
            ],
            &["schedule.overlap=tiles", "gsu.spill=all", "buffers.sorting.capacity=8 KiB"],
        ],
        frames: &frames,
        settled: &["vru.speculation=0"],
        slack: 0.05,
        idle_keys: &idle,
    };
    assert_eq!(broken(&trial), Vec::<String>::new());
}
