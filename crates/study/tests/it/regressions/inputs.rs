//! What sweep files name, and parts that they switch off.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::sync::Arc;

use powergs_core::machine::Machine;
use powergs_core::run::files::DiskFiles;
use powergs_core::stage::hardware;
use powergs_energy::hardware::Does;
use powergs_study::sweep::{Space, SweepFile};

/// A sweep of `gscore` whose file lies in a folder.
fn sweep(lines: &str, folder: Option<&Path>) -> SweepFile {
    let text = format!("question = \"?\"\nbase = \"gscore\"\n{lines}");
    let mut file = SweepFile::parse(&text).unwrap_or_else(|e| panic!("{e}"));
    file.folder = folder.map(Path::to_path_buf);
    file
}

fn space(file: &SweepFile) -> Result<Space, String> {
    Space::new(file, Arc::new(DiskFiles)).map_err(|e| e.to_string())
}

const CORES: &str = "[[axes]]\nkey = \"vru.cores\"\nvalues = [2, 4]\n";

#[test]
fn parts_were_switched_off_in_replay_only() {
    let gscore = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        Machine::parse_with("base = \"gscore\"\nname = \"gscore\"", &sets).expect("a machine")
    };
    let keys = |machine: &Machine| {
        let mut table = machine.stated();
        table.remove("description");
        table
    };
    let set = "[set]\nfovea = \"none\"\n\"pixels.impl\" = \"warped\"\n";
    let made = space(&sweep(&format!("{set}{CORES}"), None)).expect("a space");
    let sets = ["fovea=none", "pixels.impl=warped", "vru.cores=2"];
    let design = made.design(0).expect("a design");
    assert_eq!(keys(&design.machine), keys(&gscore(&sets)));
    for set in [
        "\"stereo.impl\" = \"shared\"",
        "\"gsu.impl\" = \"shared\"\n\"record.entry-bitmap\" = false\n\"binning.impl\" = \"free\"",
    ] {
        let lines = format!("[set]\nfovea = \"none\"\n{set}\n{CORES}");
        assert!(space(&sweep(&lines, None)).is_ok(), "{set}");
    }
    // A part that is not there is taken away in vain, which is no mistake.
    let lines = format!("[set]\ncache = \"none\"\n{CORES}");
    assert!(space(&sweep(&lines, None)).is_ok());
    // Beside a machine that has it; and the axis may be called as the part.
    let two = "[[axes]]\nname = \"fovea\"\n\
               variants = [{ name = \"yes\" }, { name = \"no\", set = { fovea = \"none\" } }]\n";
    let when = format!("{two}{CORES}when = \"fovea == 'no'\"\n");
    let made = space(&sweep(&when, None)).expect("a space");
    let with = made.design(0).expect("a design");
    let without = made.design(2).expect("a design");
    assert_ne!(with.timing_id, without.timing_id);
    assert_eq!(keys(&without.machine), keys(&gscore(&["fovea=none", "vru.cores=2"])));
    let said = space(&sweep("[set]\nfovea = 3\n", None)).err().expect("a number");
    assert!(said.contains("line 4") && said.contains("`fovea` is a table"), "{said}");
}

#[test]
fn mistakes_that_were_typed_were_shown_at_line_1_of_the_file() {
    let mut file = sweep(CORES, None);
    file.set.0.push(("vru.coers".to_owned(), 8.into()));
    file.typed.push("vru.coers=8".to_owned());
    let said = space(&file).err().expect("no such key");
    assert!(said.contains("in --set vru.coers=8: unknown key"), "{said}");
    let mut file = sweep(CORES, None);
    file.set.0.push(("vru.cores".to_owned(), 8.into()));
    file.typed.push("vru.cores=8".to_owned());
    let said = space(&file).err().expect("twice");
    assert!(said.contains("`vru.cores` is set here and by `--set`"), "{said}");
}

#[test]
fn another_table_of_the_same_name_priced_a_sweep() {
    let home = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(home.path().join(name), text).expect("a file");
    let dear = "[actions]\nalpha = { energy = \"5 pJ\", source = \"A10\" }\n";
    write("mine.toml", &format!("base = \"gscore-28nm\"\nname = \"of-the-sweep\"\n{dear}"));
    write("machine.toml", "base = \"gscore\"\nname = \"of-the-sweep\"\nclock = \"500 MHz\"\n");
    write("display.toml", "base = \"oled-powergs\"\nname = \"of-the-sweep\"\n");
    let table = "[[energy]]\nlabel = \"mine\"\ntable = \"mine.toml\"\n";
    let named = |lines: &str| {
        let file = sweep(&format!("{lines}{CORES}"), Some(home.path()));
        space(&file).unwrap_or_else(|e| panic!("{e}")).design(0).expect("a design")
    };
    let is_ours = |name: &str| assert_eq!(name, "of-the-sweep");
    is_ours(&named(table).prices[0].table.value.name);
    is_ours(&named("set = { energy = \"mine.toml\" }\n").prices[0].table.value.name);
    let axis = "[[axes]]\nkey = \"energy\"\nvalues = [\"mine.toml\", \"gscore-16nm\"]\n";
    is_ours(&named(axis).prices[0].table.value.name);
    let axis = "[[axes]]\nkey = \"machine\"\nvalues = [\"machine.toml\", \"gscore\"]\n";
    is_ours(&named(axis).machine.name);
    let display = named("display = \"display.toml\"\n").display.expect("a display");
    is_ours(&display.value.name);
    // A file of the working folder is none of the sweep.
    for lines in [
        "[[energy]]\nlabel = \"a\"\ntable = \"Cargo.toml\"\n",
        "display = \"Cargo.toml\"\n",
        "set = { dram.device = \"Cargo.toml\" }\n",
        "[[axes]]\nkey = \"energy\"\nvalues = [\"gscore-28nm\", \"Cargo.toml\"]\n",
    ] {
        let file = sweep(&format!("{lines}{CORES}"), Some(home.path()));
        let said = space(&file).err().expect(lines);
        assert!(said.contains("in the working folder is not taken"), "{lines}{said}");
    }
}

/// A reference table of Accelergy in which everything costs 1 pJ.
fn reference_table() -> String {
    let mut components: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for (id, unit) in hardware().units() {
        let works = hardware().actions().filter_map(|(_, does)| match does {
            Does::Work(stage, work) if stage == id => Some(work.key),
            _ => None,
        });
        components.entry(unit.key.replace('-', "_")).or_default().extend(works.chain(["leak"]));
    }
    for (_, buffer) in hardware().buffers() {
        let actions = ["read", "write", "leak"];
        components.entry(buffer.name.replace('-', "_")).or_default().extend(actions);
    }
    components.insert("dram".into(), ["read", "write", "leak", "refresh"].into());
    let mut text = "ERT:\n  version: '0.4'\n  tables:\n".to_owned();
    for (name, actions) in components {
        text += &format!("  - name: chip.{name}\n    actions:\n");
        for action in actions {
            let action = action.replace('-', "_");
            text += &format!("    - name: {action}\n      energy: 1\n");
        }
    }
    text
}

#[test]
fn sweeps_did_not_read_tables_of_accelergy() {
    let home = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = home.path().join(name);
        fs::write(&path, text).expect("a file");
        path.display().to_string()
    };
    write("prices.yaml", &reference_table());
    let machine = "base = \"gscore\"\nname = \"mine\"\nenergy = \"prices.yaml\"\n";
    let machine = write("mine.toml", machine);
    let clocks = "[[axes]]\nkey = \"clock\"\nvalues = [\"500 MHz\", \"1 GHz\"]\n";
    let mut of_machine = sweep(clocks, Some(home.path()));
    of_machine.base = machine;
    let table = "[[energy]]\nlabel = \"mine\"\ntable = \"prices.yaml\"\n";
    let of_table = sweep(&format!("{table}{clocks}"), Some(home.path()));
    let axis = "[[axes]]\nkey = \"energy\"\nvalues = [\"prices.yaml\", \"gscore-28nm\"]\n";
    let of_axis = sweep(&format!("{axis}{clocks}"), Some(home.path()));
    for file in [of_machine, of_table, of_axis] {
        let space = space(&file).unwrap_or_else(|e| panic!("{e}"));
        let leakage = [0, 1].map(|point| {
            let design = space.design(point).expect("a design");
            design.prices[0].prices.as_ref().expect("prices").leakage_w()
        });
        // It is so much a cycle.
        assert!((leakage[1] / leakage[0] - 2.0).abs() < 1e-9, "{leakage:?}");
    }
}
