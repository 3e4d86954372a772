//! CSV, run.toml, and the generated documents.

use expect_test::{expect, expect_file};
use powergs_core::sim::statistics::{Key, find};
use powergs_report::{csv, docs, files, limits, record};
use powergs_study::findings::limits::not_modelled;

use crate::builder;

#[test]
fn results_page_is_up_to_date() {
    let page = docs::results_md() + &powergs_study::sweep::docs::results_md();
    expect_file!["../../../../docs/results.md"].assert_eq(&page);
}

#[test]
fn limits_page_is_up_to_date() {
    expect_file!["../../../../docs/limits.md"].assert_eq(&limits::page());
}

#[test]
fn assumptions_of_the_limits_are_documented() {
    let docs = [
        include_str!("../../../../docs/model.md"),
        include_str!("../../../../docs/model-accel.md"),
        include_str!("../../../../docs/model-resident.md"),
        include_str!("../../../../docs/model-gpu.md"),
        include_str!("../../../../docs/elsewhere.md"),
    ];
    for effect in not_modelled() {
        let number = effect.assumption;
        let known = number.is_empty() || docs.iter().any(|d| d.contains(&format!("**{number}.")));
        assert!(known, "{number}: no such assumption");
    }
}

#[test]
fn csv_header() {
    expect_file!["csv_header.txt"].assert_eq(&(csv::header(&builder::garden()).join("\n") + "\n"));
}

#[test]
fn csv_holds_frames_and_aggregates_exactly() {
    let run = builder::garden();
    let bytes = csv::results(&run);
    let mut reader = ::csv::Reader::from_reader(bytes.as_slice());
    let header = reader.headers().expect("a header").clone();
    let rows: Vec<_> = reader.records().map(|r| r.expect("a row")).collect();
    let kinds: Vec<&str> = rows.iter().map(|r| &r[0]).collect();
    assert_eq!(kinds[..24], ["frame"; 24]);
    assert_eq!(kinds[24..], ["mean", "p50", "p95", "p99", "max"]);
    assert_eq!((&rows[7][1], &rows[7][2], &rows[7][3]), ("7", "view_0007", "false"));
    let column = header.iter().position(|h| h == "power_w.total").expect("a column");
    let written: Vec<f64> =
        rows[..24].iter().map(|r| r[column].parse().expect("a number")).collect();
    let power = find("power_w.total").expect("a statistic");
    let values: Vec<f64> =
        run.frames.iter().filter_map(|f| power.of(f, 60.0)).map(|v| v.as_f64()).collect();
    assert_eq!(written, values, "numbers survive the text exactly");
    let mean: f64 = rows[24][column].parse().expect("a number");
    assert_eq!(Some(mean), run.statistics().and_then(|record| record.mean(Key::Power)));
}

#[test]
fn csv_quotes_names_and_leaves_the_unmeasured_empty() {
    let mut run = builder::paper();
    run.frames[0].name = "a \"view\", with\nall of it".into();
    run.frames.truncate(3);
    let bytes = csv::results(&run);
    let mut reader = ::csv::Reader::from_reader(bytes.as_slice());
    let header = reader.headers().expect("a header").clone();
    let time = header.iter().position(|h| h == "frame_time_ms").expect("a column");
    let rows: Vec<_> = reader.records().map(|r| r.expect("a row")).collect();
    assert_eq!(&rows[0][2], "a \"view\", with\nall of it");
    assert!(rows.iter().all(|r| r[time].is_empty() && &r[3] == "true"));
}

#[test]
fn run_toml() {
    let text = record::run_toml(&builder::garden()).expect("TOML");
    expect![[r##"
        # What this report was made from. The command that was typed: invocation.toml.
        schema-version = 3
        tool-version = "0.2.0"
        model-version = 15
        trace-version = "2.2"
        commit = "unknown"
        model = "cycle"
        display-fps = 60.0
        incomplete = false
        frames-asked-for = 24
        frames-reported = 24

        [facts]
        trace = "garden"
        eyes = 1
        width-px = 979
        height-px = 546
        machine = "gscore"
        task = "render"
        energy-table = "gscore-28nm"
        left-out = [
            "bursts, rows, banks, refresh and turnaround of the DRAM",
            "address translation and interconnect of the DRAM",
            "other users of the DRAM: GPU, display, camera",
            "reads of one unit served before older ones of another",
            "box tests uneven within a batch of Gaussians",
            "pivots that split a list unevenly and need another pass",
            "deeper prefetch while nobody knows that a tile is done",
            "the change of all units of a core from one sub-tile to another: pixel state, features",
            "the search for the live pixels of an entry, and their packing",
            "pairs that begin before a stop is known",
            "a buffer between the eyes that is full",
            "a depth for each pixel, which rendering units find",
            "regions whose cache is not there when their first tile is",
            "two cores that add to the sum of one Gaussian at once",
            "densification: Gaussians that are cloned, split and removed",
            "how pairs get from the order of the CCUs into the lists of tiles",
            "lists of early tiles used before preprocessing ends",
            "nodes of the cut that split or merge in a frame",
            "Gaussians without a pixel that are converted late",
            "pointers of the lists of regions that grow",
            "shapes of Gaussians before their regions are found",
            "lanes of a step that meet in a bank",
            "the search for pixels that have not stopped",
            "conflicts of banks of shared memory, misses of instruction caches",
            "kernels that overlap in their ends and beginnings",
            "clocks that fall under load",
            "a depth for each pixel, which the blending kernel finds",
            "densification: Gaussians that are cloned, split and removed",
            "what it takes to hand a frame to another chip",
            "quads that are on their way when their pixels stop",
            "an alpha of 11 bits, which stops pixels earlier",
            "what the simulator leaves out that made the run",
            "order of requests that another memory would bring about",
            "frame set-up: camera, command lists, the processor",
            "changes of clock and voltage in a frame, temperature, wake-up times",
        ]
        node-nm = 28.0
        clock-hz = 1000000000.0
        dram-peak-gb-s = 51.2

        [[inputs]]
        role = "trace"
        name = "garden.bin"
        bytes = 1234567
        xxh3-128 = "0123456789abcdef0011223344556677"

        [configuration.machine]
        clock = "1 GHz"

        [configuration.machine.vru]
        cores = 4
    "##]]
    .assert_eq(&text);
}

#[test]
fn same_run_same_bytes() {
    let run = builder::run(&[4.0, 5.0]);
    let first = files(&run, &Default::default()).expect("files");
    assert_eq!(first, files(&run, &Default::default()).expect("files"));
    let names: Vec<&str> = first.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names[..4], ["run.toml", "results.csv", "summary.md", "report.html"]);
    assert_eq!(names.len(), 18);
    assert!(names.iter().all(|n| powergs_report::is_file_name(n)));
}
