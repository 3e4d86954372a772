//! What commands compile, and whether they share it: the graphs of units that Cargo would build.
//! Nothing is built.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::process::Command;

use serde_json::Value;

use super::{none, root};

/// What one command compiles, by a hash of everything that decides whether Cargo can reuse it.
type Units = BTreeMap<u64, Unit>;

struct Unit {
    /// Where its package comes from.
    package: String,
    /// Package, target and features, for messages.
    text: String,
    /// Whether it is a library of this workspace, no test, example or program.
    library: bool,
}

/// What `cargo ARGS` would compile. `None`, with a word on why, where Cargo cannot say: packages
/// that no build so far has needed may be out of reach.
fn units(args: &str) -> Option<Units> {
    // The graph is an unstable output of the stable Cargo.
    let graph = Command::new(env!("CARGO"))
        .args(args.split(' '))
        .args(["--locked", "--unit-graph", "-Z", "unstable-options"])
        .env("RUSTC_BOOTSTRAP", "1")
        .current_dir(root())
        .output()
        .expect("Cargo runs");
    if !graph.status.success() {
        eprintln!("skipped: cargo {args}: {}", String::from_utf8_lossy(&graph.stderr));
        return None;
    }
    let graph: Value = serde_json::from_slice(&graph.stdout).expect("JSON");
    let all = graph["units"].as_array().expect("units");
    let mut hashes = vec![None; all.len()];
    let hashed = all.iter().enumerate().map(|(i, unit)| (hash(i, all, &mut hashes), unit));
    // Running a build script is no compilation.
    let compiled = hashed.filter(|(_, unit)| unit["mode"] != "run-custom-build");
    Some(compiled.map(|(hash, unit)| (hash, Unit::new(unit))).collect())
}

impl Unit {
    fn new(unit: &Value) -> Unit {
        let text = |value: &Value| value.as_str().expect("text").to_owned();
        let (package, name) = (text(&unit["pkg_id"]), text(&unit["target"]["name"]));
        let kind = text(&unit["target"]["kind"][0]);
        let library = package.starts_with("path+") && kind == "lib" && unit["mode"] == "build";
        let short = package.rsplit('/').next().unwrap_or(&package).to_owned();
        let text = format!("{short} ({kind} {name}, features {})", unit["features"]);
        Unit { package, text, library }
    }
}

/// A unit is another one if anything that it is built with is another one.
fn hash(index: usize, all: &[Value], known: &mut [Option<u64>]) -> u64 {
    if let Some(hash) = known[index] {
        return hash;
    }
    let unit = &all[index];
    let mut hasher = DefaultHasher::new();
    for key in ["pkg_id", "target", "profile", "platform", "mode", "features"] {
        unit[key].to_string().hash(&mut hasher);
    }
    for dependency in unit["dependencies"].as_array().expect("dependencies") {
        let index = dependency["index"].as_u64().expect("an index") as usize;
        hash(index, all, known).hash(&mut hasher);
    }
    known[index] = Some(hasher.finish());
    hasher.finish()
}

/// What `later` compiles that none of `earlier` has compiled.
fn compiled_again<'a>(later: &'a Units, earlier: &[&Units]) -> Vec<&'a Unit> {
    let have: BTreeSet<u64> = earlier.iter().flat_map(|units| units.keys().copied()).collect();
    later.iter().filter(|(hash, _)| !have.contains(hash)).map(|(_, unit)| unit).collect()
}

fn packages() -> Vec<String> {
    let crates = std::fs::read_dir(root().join("crates")).expect("the crates");
    let name = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.expect("a crate").file_name().into_string().expect("UTF-8")
    };
    let mut names: Vec<String> = crates.map(|e| format!("powergs-{}", name(e))).collect();
    names.sort();
    names
}

const REMEDY: &str = "missing in crates/unify/Cargo.toml";

#[test]
fn tests_compile_no_library_again_after_a_run() {
    let (Some(run), Some(test)) = (units("build --release"), units("test --release")) else {
        return;
    };
    assert!(run.values().filter(|unit| unit.library).count() > 10, "libraries are recognised");
    let again = compiled_again(&test, &[&run]);
    none(again.iter().filter(|u| u.library).map(|u| format!("{}: {REMEDY}", u.text)).collect());
}

#[test]
fn tests_of_one_package_compile_nothing_after_those_of_all() {
    let mut findings = Vec::new();
    for profile in ["", " --release"] {
        let Some(all) = units(&format!("test{profile}")) else { continue };
        for package in packages() {
            let Some(one) = units(&format!("test{profile} -p {package}")) else { continue };
            let again = compiled_again(&one, &[&all]);
            let found = again.iter().map(|u| format!("-p {package}: {}: {REMEDY}", u.text));
            findings.extend(found);
        }
    }
    none(findings);
}

#[test]
fn the_laboratory_compiles_its_own_crates_alone() {
    let lab = units("test --release -p powergs-lab -p powergs-gates -p powergs-datapath");
    let (Some(test), Some(lab)) = (units("test --release"), lab) else { return };
    let ours = ["lab/powergs-lab", "lab/gates", "lab/datapath"];
    let again = compiled_again(&lab, &[&test]).into_iter();
    let own = |unit: &&Unit| ours.iter().any(|folder| unit.package.contains(folder));
    let again = again.filter(|unit| unit.library && !own(unit));
    none(again.map(|u| format!("{}: {REMEDY}", u.text)).collect());
}

#[test]
fn the_python_wheel_compiles_one_crate_of_ours() {
    let wheel = units("build --release -p powergs-python --lib");
    let (Some(run), Some(wheel)) = (units("build --release"), wheel) else { return };
    let again = compiled_again(&wheel, &[&run]);
    none(again.iter().filter(|u| u.library).map(|u| format!("{}: {REMEDY}", u.text)).collect());
}

#[test]
fn the_library_alone_has_no_command_line_and_no_drawing() {
    let names = |args: &str| -> Option<BTreeSet<String>> {
        let name = |unit: Unit| Some(unit.package.split_once('#')?.1.split_once('@')?.0.to_owned());
        Some(units(args)?.into_values().filter_map(name).collect())
    };
    let program = names("build --release -p powergs-sim");
    let library = names("build --release -p powergs-sim --lib --no-default-features");
    let (Some(program), Some(library)) = (program, library) else { return };
    assert!(program.contains("clap_builder") && library.contains("powergs-core"), "{library:?}");
    let unwanted =
        ["clap", "clap_builder", "indicatif", "ctrlc", "plotters", "tiny-skia", "krilla"];
    none(unwanted.into_iter().filter(|&n| library.contains(n)).map(str::to_owned).collect());
}
