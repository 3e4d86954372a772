//! The program itself: usage, help, completions, internal errors, dates.

use std::time::Duration;

use assert_cmd::Command;
use clap::CommandFactory;
use powergs_sim::cli::{Cli, Exit, invocation, out, startup};
use predicates::prelude::*;

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_powergs-sim"))
}

#[test]
fn definitions_are_consistent() {
    Cli::command().debug_assert();
}

#[test]
fn usage_errors_exit_2() {
    program().assert().code(2);
    let typo = program().arg("completion").assert().code(2);
    typo.stderr(predicate::str::contains("completions"));
    program().args(["completions", "bash", "--jobs", "0"]).assert().code(2);
}

#[test]
fn a_wrong_number_is_told_as_one() {
    for (words, told) in [
        ("replay t.bin --fps -5", "'-5' for '--fps <RATE>': must be 1 to 1000"),
        ("sweep tiles --points -5", "'-5' for '--points <N>': must be a whole number"),
        ("replay t.bin -j 0", "'0' for '--jobs <N>': must be at least 1"),
        ("replay t.bin -j 18446744073709551615", "--jobs 18446744073709551615: at most"),
        ("camera convert --orbit 2 --every 0 -o c.json", "'0' for '--every <K>': must be at least"),
    ] {
        let refused = program().args(words.split(' ')).assert().code(2);
        refused.stderr(predicate::str::contains(told));
    }
}

#[cfg(unix)]
#[test]
fn the_end_of_a_time_limit_is_an_interruption() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_powergs-sim"))
        .current_dir(folder.path())
        .args(["optimize", "--demo", "--iterations", "100000", "--out", "run"])
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    while !folder.path().join("run/history.csv").is_file() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

#[test]
fn every_command_has_help_that_fits_and_an_example() {
    for command in Cli::command().get_subcommands() {
        let name = command.get_name();
        let help = program().args([name, "--help"]).assert().code(0);
        let text = String::from_utf8_lossy(&help.get_output().stdout).into_owned();
        assert!(text.contains(&format!("  powergs-sim {name}")), "{name}: no example:\n{text}");
        for line in text.lines().take_while(|l| !l.starts_with("Examples")) {
            assert!(line.chars().count() <= 80, "{name}: {line}");
        }
    }
}

#[test]
fn a_closed_pipe_is_success() {
    let e = std::io::Error::from(std::io::ErrorKind::BrokenPipe);
    assert!(out::forgive(Err(e)).is_ok());
    let full = std::io::Error::from(std::io::ErrorKind::StorageFull);
    assert_eq!(out::forgive(Err(full)).map_err(|f| f.exit).err(), Some(Exit::Usage));
}

#[test]
fn an_assertion_that_fires_exits_4() {
    assert_eq!(startup::guarded(|| panic!("busy + idle is not the frame")), Exit::Internal);
    assert_eq!(startup::guarded(|| Exit::GoalMissed), Exit::GoalMissed);
    let text = startup::internal_error(&"bytes do not add up", Some("src/sim.rs:7"));
    assert!(text.starts_with("internal error: bytes do not add up\n  at src/sim.rs:7"), "{text}");
    assert!(text.contains("please report"));
    let owned = startup::internal_error(&String::from("owned"), None);
    assert!(owned.starts_with("internal error: owned"));
}

#[test]
fn dates() {
    for (seconds, text) in [
        (0, "1970-01-01T00:00:00Z"),
        (951_782_399, "2000-02-28T23:59:59Z"),
        (951_782_400, "2000-02-29T00:00:00Z"),
        (1_709_251_199, "2024-02-29T23:59:59Z"),
        (4_107_542_400, "2100-03-01T00:00:00Z"),
    ] {
        assert_eq!(invocation::format_utc(Duration::from_secs(seconds)), text);
    }
}

#[test]
fn a_trace_behind_a_sweep_is_no_subcommand() {
    let run = program().args(["sweep", "gscore-units", "traces/demo.bin"]).output().unwrap();
    let text = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(2));
    assert!(text.contains("traces are given with --traces traces/demo.bin"), "{text}");
}

/// Bug reports and papers say what was run.
#[test]
fn the_version_says_models_traces_and_commit() {
    let output = Command::new(env!("CARGO_BIN_EXE_powergs-sim")).arg("--version").assert().code(0);
    let said = String::from_utf8(output.get_output().stdout.clone()).expect("UTF-8");
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines[0], concat!("powergs-sim ", env!("CARGO_PKG_VERSION")));
    let models = format!("models    version {}", powergs_sim::sim::MODEL_VERSION);
    assert_eq!(lines[1], models);
    assert!(lines[2].starts_with("traces    version "), "{said}");
    let commit = lines[3].strip_prefix("commit    ").expect("the last line");
    assert!(commit == "unknown" || commit.len() == 12, "{said}");
    let short = Command::new(env!("CARGO_BIN_EXE_powergs-sim")).arg("-V").assert().code(0);
    short.stdout(predicates::str::contains("commit").not());
}
