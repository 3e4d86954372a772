//! Which commit the program is built from: that of the checkout, or `POWERGS_COMMIT` where there is
//! none, as in a source package.

use std::env;
use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=POWERGS_COMMIT");
    // It grows with every commit and every change of branch.
    for log in [".git/logs/HEAD", ".git/HEAD"] {
        if Path::new(log).exists() {
            println!("cargo::rerun-if-changed={log}");
        }
    }
    println!("cargo::rerun-if-changed=build.rs");
    let given = env::var("POWERGS_COMMIT").ok();
    let commit = given.or_else(of_checkout).filter(|commit| is_hash(commit));
    println!("cargo::rustc-env=POWERGS_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}

/// The commit of this checkout, not of one around it.
fn of_checkout() -> Option<String> {
    if !Path::new(".git").exists() {
        return None;
    }
    let done = Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output().ok()?;
    let hash = String::from_utf8(done.stdout).ok()?;
    done.status.success().then(|| hash.trim().to_owned())
}

fn is_hash(text: &str) -> bool {
    (7..=64).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}
