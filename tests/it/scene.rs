//! Scene files as the user sees them: the command, real data, hostile files.

mod command;
mod data;

#[cfg(target_os = "linux")]
use std::process::Command;

#[cfg(target_os = "linux")]
use powergs_testkit::bombs::bombs;

/// The whole program in 400 MB of address space: a bomb that went off would abort it.
#[cfg(target_os = "linux")]
#[test]
fn bombs_take_no_memory() {
    let folder = tempfile::tempdir().unwrap();
    for (i, (what, bytes)) in bombs().into_iter().enumerate() {
        let path = folder.path().join(format!("{i}.bin"));
        std::fs::write(&path, bytes).unwrap();
        let run = Command::new("sh")
            .args(["-c", "ulimit -v 400000; exec \"$0\" scene info \"$1\""])
            .arg(env!("CARGO_BIN_EXE_powergs-sim"))
            .arg(&path)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(3), "{what}: {text}");
        assert!(text.starts_with("error: ") && text.contains(&format!("{i}.bin: ")), "{text}");
    }
}
