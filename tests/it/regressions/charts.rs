//! Charts that said what the table withholds, or contradicted the answer.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

/// Runs the program in a folder with the demo trace, twice under other names.
fn bench() -> (tempfile::TempDir, impl Fn(&Path, &[&str])) {
    let home = tempfile::tempdir().expect("a folder");
    for name in ["one.bin", "two.bin"] {
        let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
        fs::copy(demo, home.path().join(name)).expect("the demo trace");
    }
    let run = |home: &Path, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        command.current_dir(home).args(arguments).env_remove("POWERGS_SHARD").assert().success();
    };
    (home, run)
}

fn chart(home: &Path, name: &str) -> String {
    let path: PathBuf = home.join(name);
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Machines of other nodes were each divided by themselves, so that all ended at 1.00.
#[test]
fn only_the_first_machine_is_one() {
    let (home, run) = bench();
    let items = ["compare", "gscore", "edge", "orin-nx", "one.bin", "two.bin", "--frames", "..1"];
    run(home.path(), &[&items[..], &["-q", "--out", "c"]].concat());
    let breakdown = chart(home.path(), "c/breakdown.svg");
    let texts = |text: &str| breakdown.matches(&format!(">{text}<")).count();
    // By component and by stage, on two traces.
    assert_eq!(texts("1.00"), 4, "{breakdown}");
    assert_eq!(texts("energy per frame, gscore = 1"), 2, "{breakdown}");
    assert_eq!(texts("share of its own energy per frame, %"), 2, "{breakdown}");
    assert!(breakdown.contains(" mJ<"), "{breakdown}");
    let speedup = chart(home.path(), "c/speedup.svg");
    assert!(speedup.contains(">another node<"), "{speedup}");
}

/// Bars of energy at full rate, in the order of the power at the display rate.
#[test]
fn bars_along_the_front_are_of_the_objective() {
    let (home, run) = bench();
    let text = "question = \"Which?\"\nbase = \"gscore\"\n\
                [[axes]]\nkey = \"vru.cores\"\nvalues = [1, 2, 4]\n";
    fs::write(home.path().join("cores.toml"), text).expect("written");
    let sweep = ["sweep", "cores.toml", "--traces", "one.bin", "--frames", "..1"];
    run(home.path(), &[&sweep[..], &["-q", "--out", "s"]].concat());
    let front = chart(home.path(), "s/analysis/energy_front.svg");
    assert!(front.contains("<title>Power at the display rate, along the Pareto front"), "{front}");
    let asked = ["pareto", "s", "-q", "--minimize", "energy_pj.mean,power_w.mean"];
    run(home.path(), &[&asked[..], &["--out", "e"]].concat());
    let front = chart(home.path(), "e/energy_front.svg");
    assert!(front.contains("<title>Energy per frame at full rate, along the"), "{front}");
}
