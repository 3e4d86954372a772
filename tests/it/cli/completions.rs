//! Completion in shells: bash is driven as its user drives it; zsh and fish ask the same program.

use std::path::Path;
use std::process::Command;

use clap::ArgAction;
use powergs_sim::cli::completions;

/// The folder with the program.
fn folder() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_powergs-sim")).parent().expect("a folder")
}

fn has(shell: &str) -> bool {
    Command::new(shell).arg("--version").output().is_ok()
}

/// What TAB offers behind each of `lines` in a bash that has loaded the script. `|` stands where
/// bash itself would have split a word.
fn bash(lines: &[&str]) -> Vec<Vec<String>> {
    let mut script = String::from("source <(powergs-sim completions bash)\n");
    for line in lines {
        let typed = line.replace('|', "");
        let words: Vec<String> = line.split([' ', '|']).map(|w| format!("'{w}'")).collect();
        let last = words.len() - 1;
        let current = match words[last].as_str() {
            "'='" => "''",
            current => current,
        };
        let array = words.join(" ");
        script += &format!(
            "COMP_WORDS=({array}) COMP_CWORD={last} COMP_LINE='{typed}' COMPREPLY=()\n\
             _complete_powergs_sim powergs-sim {current} ''\n\
             printf '%s\\n' \"${{COMPREPLY[@]}}\" --end--\n"
        );
    }
    let home = tempfile::tempdir().expect("a folder");
    for name in ["scene.bin", "mine.toml", "two words.bin"] {
        std::fs::write(home.path().join(name), "").expect("a file");
    }
    std::fs::create_dir(home.path().join("reports")).expect("a folder");
    let path = std::env::var("PATH").unwrap_or_default();
    let mut command = Command::new("bash");
    command.args(["--norc", "--noprofile", "-c", &script]).current_dir(home.path());
    let output = command.env("PATH", format!("{}:{path}", folder().display())).output();
    let output = output.expect("bash runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("text");
    let answers: Vec<Vec<String>> = text
        .split("--end--\n")
        .map(|a| a.lines().filter(|l| !l.is_empty()).map(str::to_owned).collect())
        .collect();
    answers[..lines.len()].to_vec()
}

#[test]
fn bash_completes_at_every_level() {
    if !has("bash") {
        return;
    }
    let cases: &[(&str, &[&str])] = &[
        ("powergs-sim rep", &["replay"]),
        ("powergs-sim replay --ar", &["--arch"]),
        ("powergs-sim replay --dram-model ", &["bandwidth", "calibrated", "banked", "both"]),
        ("powergs-sim replay scene.bin --arch gscore-1", &["gscore-16core"]),
        ("powergs-sim replay scene.bin --arch|=|gscore-1", &["gscore-16core"]),
        ("powergs-sim replay scene.bin --arch mi", &["mine.toml"]),
        ("powergs-sim replay --chart-size ", &["slide", "page", "column", "3.5in"]),
        ("powergs-sim replay sc", &["scene.bin"]),
        ("powergs-sim replay tw", &["two words.bin"]),
        ("powergs-sim replay --out rep", &["reports"]),
        ("powergs-sim replay scene.bin --energy gscore-7nm-", &["gscore-7nm-neo"]),
        ("powergs-sim replay scene.bin --display oled-d", &["oled-d22"]),
        ("powergs-sim replay scene.bin --set vru.cor", &["vru.cores="]),
        ("powergs-sim replay scene.bin --set geometry.test|=|ob", &["obb"]),
        ("powergs-sim replay scene.bin --set energy|=|gscore-16", &["gscore-16nm"]),
        ("powergs-sim compare gscore ed", &["edge"]),
        ("powergs-sim arch show lpddr5-6400-x16x1", &["lpddr5-6400-x16x16"]),
        ("powergs-sim arch sch", &["schema"]),
        ("powergs-sim arch check sram", &["sram-bandwidth"]),
        ("powergs-sim dram --device hbm", &["hbm2-8ch"]),
        ("powergs-sim dram --set controller.read-q", &["controller.read-queue="]),
        ("powergs-sim sweep node", &["node-choice", "node-energy"]),
        ("powergs-sim sweep stat", &["status"]),
        ("powergs-sim synth leg", &["lego"]),
        (
            "powergs-sim pareto reports --minimize energy_pj.mean,power_full",
            &["energy_pj.mean,power_full_rate_w"],
        ),
        ("powergs-sim explain vru.cor", &["vru.cores"]),
        ("powergs-sim completions fi", &["fish"]),
        ("./powergs-sim nosuch ", &[]),
    ];
    let lines: Vec<&str> = cases.iter().map(|(line, _)| *line).collect();
    for ((line, expected), answer) in cases.iter().zip(bash(&lines)) {
        assert_eq!(answer, *expected, "{line}<TAB>");
    }
    let several = bash(&["powergs-sim arch show gscore", "powergs-sim replay --arch "]);
    for name in ["gscore", "gscore-16core", "gscore-28nm", "gscore-units"] {
        assert!(several[0].iter().any(|v| v == name), "{name}: {several:?}");
    }
    assert!(several[1].iter().all(|v| !v.starts_with('-')), "{several:?}");
}

/// The question that the scripts of zsh and fish ask.
fn asked(shell: &str, words: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
    command.env("POWERGS_SIM_COMPLETE", shell).env("_CLAP_IFS", "\n");
    command.env("_CLAP_COMPLETE_INDEX", (words.len() - 1).to_string());
    let output = command.arg("--").args(words).output().expect("it runs");
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn zsh_and_fish_get_names_with_their_meaning() {
    for shell in ["zsh", "fish"] {
        let machines = asked(shell, &["powergs-sim", "replay", "x.bin", "--arch", "gscore-1"]);
        assert!(machines.starts_with("gscore-16core"), "{shell}: {machines}");
        assert!(machines.trim().len() > "gscore-16core".len() + 8, "{shell}: {machines}");
        let keys = asked(shell, &["powergs-sim", "replay", "x.bin", "--set", "vru.cores"]);
        assert!(keys.starts_with("vru.cores="), "{shell}: {keys}");
    }
}

/// A script that its own shell cannot read completes nothing.
#[test]
fn shells_can_read_their_scripts() {
    for shell in ["bash", "zsh", "fish"] {
        let script = Command::new(env!("CARGO_BIN_EXE_powergs-sim"))
            .args(["completions", shell])
            .output()
            .expect("it runs");
        assert!(script.status.success() && script.stdout.len() > 50, "{shell}");
        if !has(shell) {
            continue;
        }
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), script.stdout).expect("written");
        let read = Command::new(shell).arg("-n").arg(file.path()).output().expect("it runs");
        assert!(read.status.success(), "{shell}: {}", String::from_utf8_lossy(&read.stderr));
    }
}

/// What a user can name, a shell can complete.
#[test]
fn every_argument_that_takes_a_name_completes_it() {
    let mut missing = Vec::new();
    walk(&completions::command(), &mut |command, arg| {
        let names = arg.get_value_names().unwrap_or_default().iter().any(|n| n.contains("NAME"));
        let listed = arg.get_help().is_some_and(|help| help.to_string().contains("`arch list`"));
        let setting = arg.get_long() == Some("set");
        let completes = arg.get::<clap_complete::engine::ArgValueCompleter>().is_some();
        if (names || listed || setting) && !completes && EXCEPT.iter().all(|e| arg.get_id() != e) {
            missing.push(format!("{command}: {}", arg.get_id()));
        }
    });
    assert!(missing.is_empty(), "{missing:#?}");
}

/// Names that the user gives, that stand in the help of the flag, or of which a part is enough.
const EXCEPT: [&str; 5] = ["others", "screen", "fov", "only", "headset"];

fn walk(command: &clap::Command, visit: &mut impl FnMut(&str, &clap::Arg)) {
    let takes = |arg: &&clap::Arg| matches!(arg.get_action(), ArgAction::Set | ArgAction::Append);
    command.get_arguments().filter(takes).for_each(|arg| visit(command.get_name(), arg));
    command.get_subcommands().for_each(|c| walk(c, visit));
}
