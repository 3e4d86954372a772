//! The commands of the documentation: those that need nothing run, in the order of their page, on
//! what the page itself makes; all others are checked for commands, flags, keys and names.
//!
//! `testkit::docs` says which lines are commands.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::{CommandFactory, Parser};
use powergs_sim::cli::Cli;
use powergs_sim::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES, SWEEPS, find};
use powergs_sim::dram::Device;
use powergs_sim::machine::Machine;
use powergs_sim::optimize::settings::{SETTINGS, Setting};
use powergs_testkit::docs::{self, Block, commands, words};

const PROGRAM: &str = "powergs-sim";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn pages() -> Vec<PathBuf> {
    docs::pages(root(), &["README.md", "arch-configs/README.md", "traces/README.md"])
}

/// The blocks of a page with commands of the program.
fn blocks(page: &Path) -> Vec<Block> {
    docs::blocks(root(), page, PROGRAM)
}

fn is_ours(command: &str) -> bool {
    command.starts_with("powergs-sim ")
}

/// What is wrong with a command that is not run.
fn mistakes(command: &str) -> Vec<String> {
    let words = words(command);
    let mut wrong = Vec::new();
    if let Err(e) = Cli::try_parse_from(&words)
        && e.use_stderr()
    {
        wrong.push(e.to_string());
    }
    let is_dram = words.get(1).is_some_and(|w| w == "dram");
    let sets: Vec<String> =
        words.windows(2).filter(|w| w[0] == "--set").map(|w| w[1].clone()).collect();
    let checked = match is_dram {
        true => Device::parse_with(DRAM[0].text, &sets).map(drop),
        false => {
            let arch = words.windows(2).find(|w| w[0] == "--arch").map(|w| w[1].as_str());
            let text = arch.and_then(|name| find(MACHINES, name)).unwrap_or(MACHINES[0].text);
            Machine::parse_with(text, &sets).map(drop)
        }
    };
    wrong.extend(checked.err().map(|e| e.to_string()));
    for pair in words.windows(2) {
        let files = match pair[0].as_str() {
            "--arch" => MACHINES,
            "--energy" => ENERGY,
            "--device" => DRAM,
            "--display" | "--preset" => DISPLAYS,
            "sweep" if !["status", "merge", "show"].contains(&pair[1].as_str()) => SWEEPS,
            _ => continue,
        };
        let own = pair[1].contains(['.', '/']);
        if !own && find(files, &pair[1]).is_none() {
            wrong.push(format!("{} {}: there is no such file", pair[0], pair[1]));
        }
    }
    wrong
}

/// Runs the blocks of a page in a folder of their own, with the trace of the repository.
#[cfg(unix)]
fn run(page: &str) {
    let home = tempfile::tempdir().expect("a folder");
    let traces = home.path().join("traces");
    fs::create_dir(&traces).expect("a folder");
    fs::copy(root().join("traces/demo.bin"), traces.join("demo.bin")).expect("a trace");
    let program = Path::new(env!("CARGO_BIN_EXE_powergs-sim")).parent().expect("a folder");
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    let blocks = blocks(&root().join(page));
    assert!(blocks.iter().any(|b| !b.skipped), "{page}: nothing runs");
    for block in blocks.iter().filter(|b| !b.skipped) {
        for command in block.first.iter().chain(&block.commands) {
            let mut shell = Command::new("bash");
            shell.args(["-c", command]).current_dir(home.path());
            shell.env("PATH", &path).env("HOME", home.path());
            let output = shell.output().expect("a shell");
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}: {command}\n{said}", block.place);
        }
    }
}

#[cfg(unix)]
#[test]
fn the_readme_runs() {
    run("README.md");
}

#[cfg(unix)]
#[test]
fn the_tutorial_runs() {
    run("docs/tutorial.md");
}

#[cfg(unix)]
#[test]
fn other_pages_run() {
    let done = ["README.md", "docs/tutorial.md"];
    for page in pages() {
        let name = page.strip_prefix(root()).expect("a page of ours").display().to_string();
        let runs = blocks(&page).iter().any(|block| !block.skipped);
        if runs && !done.contains(&name.as_str()) {
            run(&name);
        }
    }
}

#[test]
fn commands_that_are_not_run_have_flags_keys_and_names_that_exist() {
    let mut seen = 0;
    let mut wrong = Vec::new();
    for page in pages() {
        for block in blocks(&page).iter().filter(|b| b.skipped) {
            for command in block.commands.iter().filter(|c| is_ours(c)) {
                seen += 1;
                let found = mistakes(command);
                wrong.extend(found.iter().map(|m| format!("{}: {command}\n{m}", block.place)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 20, "{seen}");
}

#[test]
fn examples_of_the_help_have_flags_keys_and_names_that_exist() {
    let mut wrong = Vec::new();
    let mut seen = 0;
    for command in Cli::command().get_subcommands() {
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let examples: Vec<&str> = help.lines().filter_map(|l| l.strip_prefix("  ")).collect();
        for line in commands(&examples.join("\n"), PROGRAM).iter().filter(|c| is_ours(c)) {
            seen += 1;
            wrong.extend(mistakes(line).into_iter().map(|m| format!("{line}\n{m}")));
        }
        let long = help.lines().find(|line| line.chars().count() > 80);
        wrong.extend(long.map(|line| format!("{}: wraps: {line}", command.get_name())));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 60, "{seen}");
}

#[test]
fn python_has_the_settings_of_the_optimiser() {
    let read = |file: &str| fs::read_to_string(root().join("python").join(file)).unwrap();
    let (stub, help) = (read("powergs/_powergs.pyi"), read("src/optimize.rs"));
    for Setting { key, .. } in SETTINGS {
        assert!(stub.contains(&format!("\n    {key}: ")), "_powergs.pyi: {key}");
        assert!(help.contains(&format!("``{key}``")), "docstring of optimize: {key}");
    }
}

#[test]
fn mistakes_are_found() {
    for good in [
        "powergs-sim replay toy.bin --arch gscore --set vru.cores=8 | head",
        "powergs-sim sweep tiles --traces 'traces/*.bin' # all",
    ] {
        assert_eq!(mistakes(good), [""; 0], "{good}");
    }
    for bad in [
        "powergs-sim replay toy.bin --set geometry.intersection=aabb",
        "powergs-sim replay toy.bin --arch gscor",
        "powergs-sim replay toy.bin --archs gscore",
        "powergs-sim sweep tile --traces a.bin",
        "powergs-sim dram a.trace --set vru.cores=8",
        "powergs-sim replays toy.bin",
    ] {
        assert!(!mistakes(bad).is_empty(), "{bad}");
    }
}

/// Pages that the site writes have their titles from it.
#[test]
fn pages_have_the_titles_of_the_sidebar() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).expect("the sidebar");
    let mut wrong = Vec::new();
    for line in summary.lines() {
        let Some((title, target)) = line.split_once("](") else { continue };
        let title = title.trim_start_matches(['-', ' ', '[']);
        let Ok(page) = fs::read_to_string(root().join("docs").join(target.trim_end_matches(')')))
        else {
            assert!(target.starts_with("../look-up/"), "docs/SUMMARY.md: no page {target}");
            continue;
        };
        let heading = page.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or_default();
        if heading != title {
            wrong.push(format!("{target}: `{heading}` on the page, `{title}` in the sidebar"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_citation_is_of_this_version() {
    let citation = fs::read_to_string(root().join("CITATION.cff")).expect("it");
    let version = concat!("\nversion: ", env!("CARGO_PKG_VERSION"), "\n");
    assert!(citation.contains(version), "CITATION.cff: not{version}");
}
