//! Which crate may depend on which, and which module of a crate on which.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use super::{lexer, none, root, sources};

/// A name, and the names it may use.
type Row = (&'static str, &'static [&'static str]);

/// Crates of this workspace that a crate may depend on. The root package may use everything.
const CRATES: [Row; 20] = [
    // A manifest without code: features of other packages.
    ("unify", &[]),
    ("base", &["unify"]),
    ("frame", &["base"]),
    // Memory devices, for anybody: knows no accelerator.
    ("dram", &["base"]),
    // What actions cost, never on which tile; the prices of a DRAM device are the device's.
    ("energy", &["base", "dram", "frame"]),
    ("core", &["base", "dram", "energy", "frame"]),
    // Picture files: knows no scene and no chart.
    ("pixels", &["unify"]),
    ("scene", &["base", "frame", "pixels"]),
    ("raster", &["base", "frame", "scene"]),
    // A display is a term of the training loss.
    ("quality", &["base", "frame"]),
    // Renders frames as a run asks for them.
    ("views", &["base", "frame", "core", "scene", "raster"]),
    // Puts machines on frames that others render.
    ("study", &["base", "dram", "energy", "frame", "core", "scene"]),
    // A trainer that renders, measures quality, asks the simulator for watts, and rounds to the
    // numbers of a machine.
    ("optimize", &["base", "energy", "frame", "core", "scene", "raster", "quality"]),
    // Trains with the one and sweeps with the other.
    ("codesign", &["base", "core", "scene", "views", "study", "optimize"]),
    // Charts as values: knows nothing of what they show.
    ("chart", &["base", "pixels"]),
    // It shows values that others return and calls nothing that counts: neither raster nor scene.
    (
        "report",
        &[
            "base", "dram", "energy", "frame", "pixels", "core", "study", "optimize", "codesign",
            "chart",
        ],
    ),
    // What the hardware of `rtl/` computes, bit for bit: knows numbers and nothing else of ours.
    ("datapath", &["base", "unify"]),
    // Gates of mapped units and what their toggles cost: knows no unit and no machine.
    ("gates", &["unify"]),
    // Runs real work through both: nothing of the simulator may depend on these three.
    (
        "powergs-lab",
        &[
            "base", "frame", "core", "scene", "raster", "quality", "optimize", "chart", "report",
            "sim", "datapath", "gates", "testkit",
        ],
    ),
    // For tests, and for benches that the laboratory builds.
    ("testkit", &["base", "frame", "scene", "chart"]),
];

/// Packages that only one crate may depend on: a terminal, arguments and charts stay out of the
/// simulator.
const BOUND: [(&str, &str); 11] = [
    ("clap", "."),
    ("clap_complete", "."),
    ("indicatif", "."),
    ("ctrlc", "."),
    ("anyhow", "."),
    ("plotters", "chart"),
    ("plotters-backend", "chart"),
    ("tiny-skia", "chart"),
    ("krilla", "chart"),
    ("skrifa", "chart"),
    ("png", "pixels"),
];

/// Modules that a module may use, inside the crates that hold several. A module without a row
/// stands above the others and may use all of them.
const MODULES: [(&str, &[Row]); 4] = [
    ("base", &[("quantity", &[]), ("config", &["quantity"]), ("picture", &[])]),
    (
        "frame",
        &[
            ("scene", &[]),
            ("splat", &["scene"]),
            // Where a viewer looks: knows no picture and no model.
            ("fovea", &["scene", "splat"]),
            ("trace", &["scene", "splat", "fovea"]),
            ("display", &["fovea"]),
        ],
    ),
    (
        "core",
        &[
            ("workload", &[]),
            // What machines are made of and how frames go through them: when and how often, never
            // at what cost. Stages declare themselves.
            // It knows a memory and units, by number, and no machine.
            ("kernel", &[]),
            ("machine", &["flow", "kernel", "stage"]),
            ("flow", &["workload", "kernel", "machine", "stage"]),
            ("stage", &["flow", "kernel", "machine"]),
            ("sim", &["workload", "flow", "kernel", "machine", "stage"]),
        ],
    ),
    ("study", &[("sweep", &[]), ("analysis", &["sweep", "speedup"]), ("validate", &[])]),
];

/// The packages that each crate is built with; `.` is the root package.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let mut folders = vec![(".".to_owned(), root().to_owned())];
    for parent in ["crates", "lab"] {
        for entry in fs::read_dir(root().join(parent)).expect("the crates") {
            let path = entry.expect("a crate").path();
            let name = path.file_name().expect("a name").to_str().expect("UTF-8").to_owned();
            if path.is_dir() {
                folders.push((name, path));
            }
        }
    }
    let read = |(name, folder): (String, std::path::PathBuf)| {
        let text = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
        let manifest: toml::Table = text.parse().expect("TOML");
        let tables = ["dependencies", "build-dependencies"];
        let tables = tables.into_iter().filter_map(|key| manifest.get(key)?.as_table());
        (name, tables.flat_map(|table| table.keys().cloned()).collect())
    };
    folders.into_iter().map(read).collect()
}

#[test]
fn crates_depend_only_on_what_they_may() {
    let mut findings = Vec::new();
    for (name, packages) in dependencies().iter().filter(|(name, _)| *name != ".") {
        let Some((_, allowed)) = CRATES.iter().find(|(folder, _)| folder == name) else {
            findings.push(format!("{name}: a new crate; give it a row in the table"));
            continue;
        };
        let ours = packages.iter().filter_map(|package| package.strip_prefix("powergs-"));
        for other in ours.filter(|other| !allowed.contains(other)) {
            findings.push(format!("{name} depends on {other}"));
        }
    }
    none(findings);
}

#[test]
fn terminals_and_charts_stay_out_of_the_simulator() {
    let mut findings = Vec::new();
    for (name, packages) in dependencies() {
        for (package, owner) in BOUND {
            // The laboratory is a program, too.
            let may = name == owner || name == "powergs-lab";
            if !may && packages.contains(package) {
                findings.push(format!("{name} depends on {package}, which is for {owner} alone"));
            }
        }
    }
    none(findings);
}

#[test]
fn modules_import_only_what_they_may() {
    let mut findings = Vec::new();
    for source in sources().iter().filter(|s| s.is_library()) {
        let Some((_, table)) = MODULES.iter().find(|(name, _)| Some(*name) == source.folder())
        else {
            continue;
        };
        let module = source.modules()[0];
        let Some((_, allowed)) = table.iter().find(|(name, _)| *name == module) else { continue };
        for other in lexer::crate_paths(&source.code) {
            if other != module && !allowed.contains(&other.as_str()) {
                findings.push(format!("{}: uses {other}", source.path.display()));
            }
        }
    }
    none(findings);
}

/// The dataflows of the core.
const FLOWS: [&str; 4] = ["tile_wise", "resident", "gpu", "recorded"];

#[test]
fn maps_name_every_dataflow() {
    let mut findings = Vec::new();
    for map in ["ARCHITECTURE.md", "crates/core/README.md"] {
        let text = fs::read_to_string(root().join(map)).expect("a map");
        let missing = FLOWS.iter().filter(|flow| !text.contains(&format!("`{flow}`")));
        findings.extend(missing.map(|flow| format!("{map}: does not name `{flow}`")));
    }
    none(findings);
}

/// Only `flow.rs` names dataflows: none imports another, and what runs them knows none.
#[test]
fn dataflows_stand_apart() {
    let mut findings = Vec::new();
    let core = sources().iter().filter(|s| s.is_library() && s.folder() == Some("core"));
    for source in core {
        let modules = source.modules();
        let own = match modules[..] {
            ["flow"] | ["lib"] => continue,
            ["flow", own, ..] => Some(own),
            _ => None,
        };
        for other in FLOWS.iter().filter(|other| own != Some(**other)) {
            let named = ["flow::", "super::", "self::"].map(|path| format!("{path}{other}"));
            let is_named = |path: &&String| {
                // As a whole name, and not as that of a module of the same flow.
                let ends =
                    |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
                source.code.split(path.as_str()).skip(1).any(ends)
            };
            if named.iter().any(|path| is_named(&path)) {
                findings.push(format!("{}: names {other}", source.path.display()));
            }
        }
    }
    none(findings);
}

#[test]
fn the_tables_name_what_exists() {
    for (folder, table) in MODULES {
        for (name, allowed) in table {
            for module in allowed.iter().chain([name]) {
                let path = root().join(format!("crates/{folder}/src/{module}.rs"));
                assert!(path.exists(), "{folder} has no module {module}");
            }
        }
    }
    for (folder, allowed) in CRATES {
        for name in allowed.iter().chain([&folder]) {
            let exists = |parent: &str| root().join(parent).join(name).exists();
            let is_program = *name == "sim";
            assert!(is_program || exists("crates") || exists("lab"), "there is no crate {name}");
        }
    }
}
