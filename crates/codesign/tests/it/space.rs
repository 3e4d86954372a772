//! Space files: what is wrong is said with its line.

use powergs_codesign::machines::Machines;
use powergs_codesign::space::SpaceFile;

fn wrong(text: &str) -> String {
    SpaceFile::parse(text).expect_err("a mistake").to_string()
}

#[test]
fn mistakes_are_told_with_their_lines() {
    let cases = [
        ("[model]\nrho = []\n", "line 2", "is empty"),
        ("[model]\nrho = [0.0, 1.0]\n", "line 2", "below 1"),
        ("[model]\nrho = [0.5, 0.5]\n", "line 2", "twice"),
        ("[model]\nrho = [0.5]\nsh-degree = [4]\n", "line 3", "0 to 3"),
        ("[model]\nrho = [0.5]\ncodebook = [1]\n", "line 3", "0 for none, or 2 to 65536"),
        (
            "[model]\nrho = [0.5]\n[[model.formats]]\nname = \"a-cb16\"\n",
            "line 3",
            "`a-cb16` ends as the name of a model with a codebook",
        ),
        ("[model]\nrho = [0.5]\ncodebook = [64, 64]\n", "line 3", "64 appears twice"),
        (
            "[model]\nrho = [0.5]\n[machine.set]\ncodebook.entries = 64\n",
            "",
            "give its sizes as `model.codebook`",
        ),
        ("[model]\nrho = [0.5]\nrhos = [1]\n", "line 3", "rhos"),
        (
            "[model]\nrho = [0.5]\n\n[[model.formats]]\nname = \"a\"\nscale = \"e9m1\"\n",
            "line 6",
            "e9m1",
        ),
        ("[model]\nrho = [0.5]\n[budget]\narea = \"0 mm2\"\n", "line 4", "holds no machine"),
        ("[model]\nrho = [0.5]\n[budget]\narea = 4\n", "line 4", "mm2"),
        ("[machine]\nbase = \"gscore\"\n", "", "model"),
        (
            "[model]\nrho = [0.5]\n[[machine.axes]]\nkey = \"record.position\"\nvalues = []\n",
            "",
            "follows from `model.formats`",
        ),
        (
            "[model]\nrho = [0.5]\n[machine.set]\nrecord.numbers = \"e5m7\"\n",
            "",
            "change the picture",
        ),
        (
            "[model]\nrho = [0.5]\n[[machine.axes]]\nkey = \"machine\"\nvalues = [\"edge\"]\n",
            "",
            "one base machine",
        ),
    ];
    for (text, line, words) in cases {
        let message = wrong(text);
        assert!(message.contains(line) && message.contains(words), "{text}\n{message}");
    }
}

#[test]
fn formats_have_names_of_their_own_and_differ() {
    let formats = |a: &str, b: &str| {
        format!("[model]\nrho = [0.0]\n[[model.formats]]\n{a}\n[[model.formats]]\n{b}\n")
    };
    let same = formats("name = \"a\"\nscale = \"e5m3\"", "name = \"b\"\nscale = \"e5m3\"");
    assert!(wrong(&same).contains("are the same"));
    let twice = formats("name = \"a\"", "name = \"a\"\nscale = \"e5m3\"");
    assert!(wrong(&twice).contains("appears twice"));
    assert!(wrong(&formats("name = \"a b\"", "name = \"c\"")).contains("letters"));
}

const SPACE: &str = "\
# A comment.
[model]
rho = [0.0]

[machine]
base = \"gscore\"
constraints = [
  \"vru.cores > 1\",
]

[[machine.axes]]
key = \"vru.coers\"
values = [1, 2]
";

#[test]
fn axes_of_the_machine_are_told_with_the_lines_of_the_space() {
    let file = SpaceFile::parse(SPACE).expect("its form is right");
    let machines = Machines::open(&file.machine, SPACE, "space.toml").expect("a machine");
    let model = powergs_codesign::model::ModelPoint::dense(3);
    let sweep = machines.sweep(&model, powergs_core::machine::DramModel::Calibrated);
    let files = std::sync::Arc::new(powergs_core::run::files::DiskFiles);
    let error = powergs_study::sweep::Space::new(&sweep, files).err().expect("an unknown key");
    let message = error.to_string();
    assert!(message.contains("vru.cores") && message.contains("line 12"), "{message}");
}

#[test]
fn a_machine_without_a_base_is_gscore_with_three_tables() {
    for text in [
        "[model]\nrho = [0.0]\n",
        "[model]\nrho = [0.0]\n\n[[machine.axes]]\nkey = \"vru.cores\"\nvalues = [1, 2]\n",
    ] {
        let file = SpaceFile::parse(text).expect("a space");
        let machines = Machines::open(&file.machine, text, "space.toml").expect("a machine");
        assert_eq!(machines.base.machine().name, "gscore");
        let model = powergs_codesign::model::ModelPoint::dense(3);
        let sweep = machines.sweep(&model, powergs_core::machine::DramModel::Calibrated);
        let labels: Vec<&str> = sweep.energy.iter().map(|e| e.label.as_str()).collect();
        assert_eq!(labels, ["gscore-28nm", "gscore-rtl-7nm", "gscore-28nm-flat"]);
    }
}
