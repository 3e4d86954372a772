//! Which commit the program is built from: that of the checkout, of the source package, or
//! `POWERGS_COMMIT`.

use std::env;
use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=POWERGS_COMMIT");
    // It grows with every commit and every change of branch. The Python package is a folder below.
    for log in [".git/logs/HEAD", ".git/HEAD", "../.git/logs/HEAD", "../.git/HEAD"] {
        if Path::new(log).exists() {
            println!("cargo::rerun-if-changed={log}");
        }
    }
    println!("cargo::rerun-if-changed=build.rs");
    let given = env::var("POWERGS_COMMIT").ok();
    let commit = given.or_else(of_checkout).or_else(of_package).filter(|commit| is_hash(commit));
    println!("cargo::rustc-env=POWERGS_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}

/// The commit of this checkout, not of one around it.
fn of_checkout() -> Option<String> {
    if ![".git", "../.git"].iter().any(|folder| Path::new(folder).exists()) {
        return None;
    }
    let done = Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output().ok()?;
    let hash = String::from_utf8(done.stdout).ok()?;
    done.status.success().then(|| hash.trim().to_owned())
}

/// The commit that `cargo package` has written down, or whoever made the Python source.
fn of_package() -> Option<String> {
    let files = ["COMMIT", "../COMMIT"].iter();
    let noted = files.map(std::fs::read_to_string).find_map(Result::ok);
    if let Some(commit) = noted {
        return Some(commit.trim().to_owned());
    }
    let text = std::fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let hash = text.split("\"sha1\": \"").nth(1)?;
    Some(hash.get(..12)?.to_owned())
}

fn is_hash(text: &str) -> bool {
    (7..=64).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}
