//! Threads, parts, interruptions and stores: the results are the same bytes.

use std::fs;

use predicates::str::contains;

use super::{Bench, assert_same};

#[test]
fn threads_parts_and_lost_records_change_nothing() {
    let bench = Bench::new();
    bench.sweep(&["--out", "one", "-j", "1", "-q"]).assert().success();
    bench.sweep(&["--out", "two", "-j", "2", "-q", "--memory", "3 MiB"]).assert().success();
    assert_same(&bench.path("one"), &bench.path("two"));

    // Parts in any order, one of them twice, then put together.
    for shard in ["3/3", "1/3", "3/3"] {
        bench.sweep(&["--out", "parts", "--shard", shard, "-q"]).assert().success();
    }
    let merge = ["sweep", "merge", "parts"];
    bench.program(&merge).assert().code(1).stderr(contains("in parts 2 of 3"));
    bench
        .program(&["sweep", "status", "parts"])
        .assert()
        .success()
        .stdout(contains("in parts 2 of 3"));
    bench.sweep(&["--out", "elsewhere", "-q"]).env("POWERGS_SHARD", "2/3").assert().success();
    bench.program(&["sweep", "merge", "parts", "--from", "elsewhere", "-q"]).assert().success();
    assert_same(&bench.path("one"), &bench.path("parts"));

    // What a kill leaves: a journal that is cut anywhere, and no results.
    let journal = "records/shard-00001-of-00001.jsonl";
    let whole = fs::read(bench.path("one").join(journal)).unwrap();
    for cut in [0, 1, whole.len() / 3, whole.len() / 2 + 7, whole.len() - 1] {
        let _ = fs::remove_dir_all(bench.path("cut"));
        bench.sweep(&["--out", "cut", "--shard", "1/24", "-q"]).assert().success();
        fs::remove_dir_all(bench.path("cut/records")).unwrap();
        fs::create_dir(bench.path("cut/records")).unwrap();
        fs::write(bench.path("cut").join(journal), &whole[..cut]).unwrap();
        bench.sweep(&["--out", "cut", "--resume", "-q"]).assert().success();
        assert_same(&bench.path("one"), &bench.path("cut"));
    }
}

#[test]
fn a_store_is_shared_by_sweeps_and_failures_are_not() {
    let bench = Bench::new();
    bench.sweep(&["--out", "one", "--store", "store", "-q"]).assert().success();
    let lines = || -> usize {
        let versions = fs::read_dir(bench.path("store")).unwrap();
        let journals = versions.flat_map(|v| fs::read_dir(v.unwrap().path()).unwrap());
        journals.map(|j| fs::read_to_string(j.unwrap().path()).unwrap().lines().count()).sum()
    };
    let before = lines();
    assert!(before > 0);
    // Fewer axes, the same machines: nothing is simulated again.
    let smaller = super::SWEEP.replace("values = [2, 4, 8]", "values = [4, 2]");
    fs::write(bench.path("smaller.toml"), smaller).unwrap();
    let arguments = ["sweep", "smaller.toml", "--traces", "demo.bin", "--store", "store", "-q"];
    bench.program(&arguments).args(["--out", "two"]).assert().success();
    assert_eq!(lines(), before);
    bench.program(&arguments[..4]).args(["--out", "three", "-q"]).assert().success();
    assert_same(&bench.path("two"), &bench.path("three"));
}

#[test]
fn a_store_of_another_version_is_kept_and_not_used() {
    let bench = Bench::new();
    fs::create_dir_all(bench.path("store/model-0.1")).unwrap();
    fs::write(bench.path("store/model-0.1/old.jsonl"), "old").unwrap();
    bench
        .sweep(&["--out", "one", "--store", "store"])
        .assert()
        .success()
        .stderr(contains("written by other versions (model-0.1)"));
    assert_eq!(fs::read_to_string(bench.path("store/model-0.1/old.jsonl")).unwrap(), "old");
}

#[test]
fn an_adaptive_search_resumes_where_it_was() {
    let bench = Bench::new();
    let adaptive = format!(
        "{}\n[sampling]\nmethod = \"nsga2\"\npopulation = 4\ngenerations = 3\n",
        super::SWEEP
    );
    fs::write(bench.path("cores.toml"), adaptive).unwrap();
    bench.sweep(&["--out", "one", "-j", "1", "-q"]).assert().success();
    bench.sweep(&["--out", "two", "-j", "2", "-q"]).assert().success();
    assert_same(&bench.path("one"), &bench.path("two"));
    let journal = bench.path("two/records/shard-00001-of-00001.jsonl");
    let whole = fs::read(&journal).unwrap();
    fs::write(&journal, &whole[..whole.len() / 2]).unwrap();
    fs::remove_file(bench.path("two/finished.toml")).unwrap();
    bench.sweep(&["--out", "two", "--resume", "-q"]).assert().success();
    assert_same(&bench.path("one"), &bench.path("two"));
    let shard = bench.sweep(&["--out", "three", "--shard", "1/2"]).assert();
    shard.code(2).stderr(contains("runs in one process"));
}
