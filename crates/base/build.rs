//! Lists the files of `arch-configs/`, so that a new one is compiled in without being named here.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// The folders, each with the file that its list begins with: the default, or the example that
/// explanations quote.
const FOLDERS: [(&str, &str); 6] = [
    ("machines", "gscore"),
    ("energy", "gscore-28nm"),
    ("display", "oled-powergs"),
    ("dram", "lpddr4-3200-x16x8"),
    ("sweeps", "gscore-units"),
    ("synth", "demo"),
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by Cargo"));
    for (folder, first) in FOLDERS {
        let path = Path::new("arch-configs").join(folder);
        println!("cargo::rerun-if-changed={}", path.display());
        let list = list(&path, first);
        fs::write(out.join(folder).with_extension("rs"), list).expect("OUT_DIR can be written");
    }
}

/// The expression of a folder's list: `first`, then the others by name.
fn list(folder: &Path, first: &str) -> String {
    let stem = |path: PathBuf| path.file_stem()?.to_str().map(str::to_owned);
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut names: Vec<String> = paths
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .filter_map(stem)
        .collect();
    names.sort_by_key(|name| (name != first, name.clone()));
    assert_eq!(names.first().map(String::as_str), Some(first), "{}", folder.display());
    let folder = folder.display();
    let embedded = |name: &String| {
        // The crate's own folder, wherever it is: what is written does not depend on the machine.
        let path = format!("concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/{folder}/{name}.toml\")");
        format!("Embedded {{ name: \"{name}\", text: include_str!({path}) }},\n")
    };
    format!("&[\n{}]\n", names.iter().map(embedded).collect::<String>())
}
