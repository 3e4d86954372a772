//! Tile-wise machines keep the laws of every dataflow.

use powergs_base::config::embedded::MACHINES;
use powergs_base::config::key_docs;
use powergs_core::machine::Machine;
use powergs_core::sim::contract::{Trial, broken};

use crate::workload::support::{dense_frame, small_frame};

#[test]
fn tile_wise_machines_keep_the_laws() {
    let gscore = MACHINES.iter().find(|file| file.name == "gscore").expect("a machine").complete();
    // `knobs::machine` turns every key of every machine, each under its condition.
    let turned = key_docs::<Machine>();
    let turned: Vec<&str> = turned.iter().map(|doc| doc.path.as_str()).collect();
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
            &["pixels.impl=warped", "pixels.per-cycle=2", "fovea=none"],
            &["pixels.impl=cached", "pixels.ids=2", "fovea=none", "schedule.overlap=frames"],
            &["training.interval=2", "training.densify=7"],
            &[
                "training.interval=3",
                "gradients.behind=true",
                "gradients.lanes=1",
                r#"gradients.buffer={ capacity = "1KiB", word = "8B", banks = 1, ports = "1rw" }"#,
                "schedule.overlap=tiles",
            ],
            &["schedule.overlap=tiles", "gsu.spill=all", "buffers.sorting.capacity=8 KiB"],
        ],
        frames: &frames,
        settled: &["vru.speculation=0"],
        slack: 0.05,
        idle_keys: &turned,
    };
    assert_eq!(broken(&trial), Vec::<String>::new());
}
