//! Mistakes that are found before the first point runs.

use std::sync::Arc;

use powergs_core::run::files::EmbeddedFiles;
use powergs_study::sweep::{Space, SweepFile};
use proptest::prelude::*;

#[track_caller]
fn wrong(lines: &str, parts: &[&str]) {
    let text = format!("question = \"?\"\nbase = \"gscore\"\n{lines}");
    let file = SweepFile::parse(&text).unwrap_or_else(|e| panic!("{e}"));
    let error = match Space::new(&file, Arc::new(EmbeddedFiles)) {
        Ok(space) => panic!("a space of {} points", space.proposed()),
        Err(error) => error.to_string(),
    };
    for part in parts {
        assert!(error.contains(part), "{part}\n{error}");
    }
}

#[track_caller]
fn right(lines: &str) {
    let text = format!("question = \"?\"\nbase = \"gscore\"\n{lines}");
    let file = SweepFile::parse(&text).unwrap_or_else(|e| panic!("{e}"));
    Space::new(&file, Arc::new(EmbeddedFiles)).map(drop).unwrap_or_else(|e| panic!("{e}\n{text}"));
}

fn axis(key: &str, values: &str) -> String {
    format!("[[axes]]\nkey = \"{key}\"\nvalues = {values}\n")
}

#[test]
fn unknown_keys_have_a_suggestion() {
    wrong(&axis("vru.core", "[1]"), &["line 4", "unknown key `vru.core`", "`vru.cores`?"]);
    wrong(&axis("cores", "[1]"), &["did you mean `vru.cores`?"]);
    wrong(&axis("dram:timing.brust", "[1]"), &["did you mean `dram:timing.burst`?"]);
    wrong(&axis("energy:actions.alpha.enrgy", "[1]"), &["`energy:actions.alpha.energy`?"]);
    wrong("set = { vru.coers = 3 }", &["line 3", "did you mean `vru.cores`?"]);
    wrong("[derived]\nvru.coers = \"3\"", &["line 4", "did you mean `vru.cores`?"]);
}

#[test]
fn unknown_keys_hide_nothing() {
    let text = "question = \"?\"\nbase = \"gscore\"\nauthor = \"me\"\n".to_owned()
        + &axis("vru.core", "[1]")
        + "[sampling]\nsead = 3\n";
    let (file, problems) = SweepFile::parse_around(&text).expect("a sweep");
    let files = Arc::new(EmbeddedFiles);
    let error = Space::whole(&file, problems, files).err().expect("mistakes").to_string();
    for part in ["3 problems", "`author`", "`vru.cores`?", "did you mean `seed`?"] {
        assert!(error.contains(part), "{part}\n{error}");
    }
    assert!(SweepFile::parse(&text).is_err());
    // What is missing is nothing that a space could be made without.
    assert!(SweepFile::parse_around("question = \"?\"\nbasis = \"gscore\"").is_err());
}

#[test]
fn all_mistakes_come_at_once() {
    let lines =
        axis("vru.core", "[1]") + &axis("clock", "[800]") + "[derived]\nvru.latency = \"(\"";
    let parts = ["3 problems", "line 4", "line 8", "line 10", "missing at the end"];
    wrong(&lines, &parts);
}

#[test]
fn values_must_fit_their_key() {
    wrong(&axis("clock", "[\"1 GHz\", 800]"), &["line 5", "`clock` is a frequency", "GHz"]);
    wrong(&axis("clock", "[\"1 GB/s\"]"), &["unknown unit `GB/s` for a frequency"]);
    wrong(&axis("vru.cores", "[1, 0]"), &["`vru.cores` must be at least 1, not 0"]);
    wrong(&axis("vru.cores", "[1.5]"), &["must be a whole number"]);
    wrong(&axis("geometry.test", "[\"obbb\"]"), &["did you mean \"obb\"?"]);
    wrong(&axis("vru.tile-overlap", "[1]"), &["must be true or false"]);
    wrong(&axis("vru.cores", "[4, 8, 4]"), &["4 appears twice"]);
    wrong(&axis("clock", "[\"1 GHz\", \"1000 MHz\"]"), &["appears twice"]);
    wrong(&axis("vru.cores", "[]"), &["an axis without a value"]);
    wrong(&axis("dram.device", "[\"lpddr4\"]"), &["no DRAM device `lpddr4`"]);
    wrong(&axis("machine", "[\"gscoer\"]"), &["did you mean `gscore`?"]);
}

#[test]
fn ranges_must_make_sense() {
    let range = |range: &str| format!("[[axes]]\nkey = \"vru.cores\"\nrange = {range}");
    wrong(&range("{ from = 8, to = 1, step = 1 }"), &["line 5", "goes upwards"]);
    wrong(&range("{ from = 1, to = 8 }"), &["a range has one of `step`"]);
    wrong(&range("{ from = 1, to = 8, step = 0 }"), &["`step` must be above zero"]);
    wrong(&range("{ from = 1, to = 8, step = 1, count = 3 }"), &["a range has one of"]);
    wrong(&range("{ from = 1, to = \"8 KiB\", step = 1 }"), &["`to`: `vru.cores` must be a whole"]);
    let test = "[[axes]]\nkey = \"geometry.test\"\nrange = { from = 1, to = 2, step = 1 }";
    wrong(test, &["is not a number: list its `values`"]);
    let fine = "[[axes]]\nkey = \"dram.efficiency\"\nrange = { from = 0.1, to = 1, step = 1e-7 }";
    wrong(fine, &["more than 100000 values"]);
    let zero = "[[axes]]\nkey = \"gating.residual\"\nrange = { from = 0, to = 1, factor = 2 }";
    wrong(zero, &["start above zero"]);
}

#[test]
fn axes_must_have_one_form_and_keys_one_master() {
    wrong("[[axes]]\nkey = \"vru.cores\"", &["line 3", "exactly one of"]);
    wrong("[[axes]]\nvalues = [1]", &["has a `key`"]);
    wrong("[[axes]]\nvariants = [{ name = \"a\" }]", &["has a `name`"]);
    let zip = "[[axes]]\nzip = { vru.cores = [1, 2], ccu.units = [1, 2, 4] }";
    wrong(zip, &["`vru.cores` has 2 values and `ccu.units` has 3"]);
    let two = axis("vru.cores", "[1, 2]") + "[derived]\nvru.cores = \"2\"";
    wrong(&two, &["`vru.cores` is set here and by `derived`"]);
    let two = axis("vru.cores", "[1, 2]") + &axis("vru.cores", "[4]");
    wrong(&two, &["a second axis called `vru.cores`", "set here and by axis `vru.cores`"]);
    let variants =
        "[[axes]]\nname = \"vru.cores\"\nvariants = [{ name = \"a\" }, { name = \"a\" }]";
    wrong(variants, &["a second variant `a`"]);
}

#[test]
fn names_in_expressions_must_be_known() {
    let cores = axis("vru.cores", "[1, 2]");
    let with = |line: &str| format!("{line}\n{cores}");
    wrong(&with("constraints = [\"vru.core < 3\"]"), &["line 3", "did you mean `vru.cores`?"]);
    wrong(&with("constraints = [\"area_mm < 3\"]"), &["did you mean `area_mm2`?"]);
    wrong(&with("constraints = [\"1 < 3\"]"), &["no name in it"]);
    wrong(&with("constraints = [\"fps.mean > 60\"]"), &["is a result", "pareto --where"]);
    wrong(&with("constraints = [\"geometry.test > 3\"]"), &["a text where a number is wanted"]);
    wrong(&with("constraints = [\"vru.cores + 1\"]"), &["a condition is true or false"]);
    let circle = "[derived]\nvru.latency = \"vru.recurrence\"\nvru.recurrence = \"vru.latency\"";
    wrong(&format!("{cores}{circle}"), &["need each other: a circle"]);
    wrong(&format!("{cores}[derived]\nvru.latency = \"area_mm2\""), &["not in `derived`"]);
    wrong(
        &format!(
            "{}when = \"ccu.units > 1\"\n{}",
            axis("vru.cores", "[1, 2]"),
            axis("ccu.units", "[1, 2]")
        ),
        &["`ccu.units` is decided by the axis `ccu.units`", "change their order"],
    );
}

#[test]
fn axes_that_change_nothing_are_told_why() {
    let mapping = axis("dram.mapping", "[\"RoBaCoCh\", \"mop\"]");
    let flat = |axis: &str| format!("set = {{ dram.model = \"bandwidth\" }}\n{axis}");
    wrong(&flat(&mapping), &["changes nothing", "`dram.model` is `bandwidth`"]);
    wrong(&axis("cache.ways", "[4, 8]"), &["changes nothing", "give `cache.capacity`"]);
    wrong(&axis("gating.residual", "[0.2, 0.3]"), &["changes nothing", "give `gating.units`"]);
    wrong(&axis("description", "[\"a\", \"b\"]"), &["names move reports only"]);
    let timing = axis("dram:timing.activate-to-read", "[20, 29]");
    wrong(&flat(&timing), &["takes only the peak rate"]);
    let tables = "[[energy]]\nlabel = \"a\"\ntable = \"gscore-28nm\"\n";
    let both = format!("{tables}{}", axis("energy", "[\"gscore-28nm\", \"gscore-7nm\"]"));
    wrong(&both, &["changes nothing", "[[energy]] says which"]);
    let never = format!("{}when = \"ccu.units > 100\"", axis("vru.cores", "[1, 2]"));
    wrong(&never, &["line 6", "holds at none of the points"]);
}

/// A table of prices with this base and these changed keys.
fn table(label: &str, base: &str, set: &str) -> String {
    let set = if set.is_empty() { String::new() } else { format!("set = {{ {set} }}\n") };
    format!("[[energy]]\nlabel = \"{label}\"\ntable = \"{base}\"\n{set}")
}

/// Bytes of DRAM have no price where commands have one: a table that changes it is no other table.
#[test]
fn tables_that_change_nothing_are_told_why() {
    let dear = "dram.flat.read.energy = \"80 pJ/B\"";
    let (own, changed) = (table("a", "gscore-28nm", ""), table("b", "gscore-28nm", dear));
    let both = format!("{own}{changed}{}", axis("vru.cores", "[2, 4]"));
    let parts = [
        "line 6",
        "`b` prices every design as `a` does",
        "`dram.device` of the table is true",
        "-flat`",
    ];
    wrong(&both, &parts);
    wrong(
        &table("b", "gscore-28nm", dear),
        &["line 6", "`dram.flat.read.energy` changes no price"],
    );
    wrong(&format!("{own}{}", own.replace("\"a\"", "\"c\"")), &["as `a` does; drop one"]);
    // One of two keys.
    let mixed = format!("{dear}, actions.alpha.energy = \"9 pJ\"");
    let mixed = format!("{own}{}", table("b", "gscore-28nm", &mixed));
    wrong(&mixed, &["`dram.flat.read.energy` changes no price"]);
    // With bytes that have a price each of these is a table of its own.
    let flat = |set: &str| table(if set.is_empty() { "a" } else { "b" }, "gscore-28nm-flat", set);
    right(&format!("{}{}", flat(""), flat(dear)));
    let rate =
        "{ dram.model = \"bandwidth\", dram.device = \"none\", dram.bandwidth = \"50 GB/s\" }";
    right(&format!("set = {rate}\n{own}{changed}"));
    // Some of the designs are enough.
    let device = "{ name = \"device\", set = { } }";
    let variants = format!("[{device}, {{ name = \"rate\", set = {rate} }}]");
    let memory = format!("[[axes]]\nname = \"memory\"\nvariants = {variants}\n");
    right(&format!("{own}{changed}{memory}"));
    // Without commands that are counted a byte has the price of the device.
    wrong(&format!("set = {{ dram.model = \"bandwidth\" }}\n{own}{changed}"), &["as `a` does"]);
    // A value that the table has anyway may be repeated.
    let repeated = table("b", "gscore-28nm-flat", "dram.flat.read.energy = \"10.88 pJ/B\"");
    right(&repeated);
}

#[test]
fn settings_that_change_nothing_are_told_why() {
    let cores = axis("vru.cores", "[2, 4]");
    let set = |set: &str| format!("set = {{ {set} }}\n{cores}");
    wrong(
        &set("cache.ways = 8"),
        &["line 3", "`cache.ways` changes nothing", "give `cache.capacity`"],
    );
    wrong(&set("gating.residual = 0.3"), &["give `gating.units`"]);
    wrong(
        &set("\"energy:dram.flat.read.energy\" = \"80 pJ/B\""),
        &["changes nothing", "`dram.device` of the table is true"],
    );
    let tables = table("a", "gscore-28nm", "");
    let named = format!("set = {{ energy = \"gscore-7nm\" }}\n{tables}{cores}");
    wrong(&named, &["`energy` changes nothing", "[[energy]] says which"]);
    let scale = "energy = \"gscore-28nm-flat\", \"dram:energy.scale\" = 1.0";
    wrong(&set(scale), &["`dram:energy.scale` changes nothing", "prices bytes"]);
    for alive in [
        "cache.ways = 8, cache.capacity = \"64 KiB\"",
        "\"dram:energy.scale\" = 1.0",
        "clock = \"900 MHz\"",
        // What the file has anyway, and names.
        "clock = \"1000 MHz\"",
        "cache.ways = 4",
        "description = \"mine\"",
    ] {
        right(&set(alive));
    }
    // It counts at some points of the space.
    let capacities = axis("cache.capacity", "[\"0 B\", \"64 KiB\"]");
    right(&format!("set = {{ cache.ways = 8 }}\n{capacities}"));
}

#[test]
fn axes_of_prices_that_nobody_pays_change_nothing() {
    let read = axis("energy:dram.flat.read.energy", "[\"10 pJ/B\", \"64 pJ/B\"]");
    wrong(&read, &["changes nothing", "`dram.device` of the table is true"]);
    right(&format!("set = {{ energy = \"gscore-28nm-flat\" }}\n{read}"));
    let scale = axis("dram:energy.scale", "[0.5, 1.0]");
    right(&scale);
    let flat = format!("set = {{ energy = \"gscore-28nm-flat\" }}\n{scale}");
    wrong(&flat, &["changes nothing", "prices bytes"]);
}

#[test]
fn an_empty_space_says_what_excludes_how_many() {
    let lines = format!(
        "constraints = [\"vru.cores >= 4\", \"area_mm2 < 0.1\"]\n{}{}",
        axis("vru.cores", "[1, 2, 4]"),
        axis("buffers.feature.capacity", "[\"1 KiB\", \"256 KiB\"]"),
    );
    wrong(
        &lines,
        &[
            "none of the 6 points is a design",
            "4 excluded by constraint `vru.cores >= 4`",
            "1 excluded by constraint `area_mm2 < 0.1`",
            "1 invalid: `buffers.feature.capacity`",
        ],
    );
}

#[test]
fn other_files_must_be_there() {
    wrong(
        "[[energy]]\nlabel = \"a\"\ntable = \"gscore-29nm\"",
        &["line 5", "did you mean `gscore-28nm`?"],
    );
    wrong("display = \"oled\"", &["no display preset `oled`"]);
    wrong(&axis("display:scale", "[1, 2]"), &["there is no display"]);
    let changed = "[[energy]]\nlabel = \"a\"\ntable = \"gscore-28nm\"\n\
                   set = { actions.alpha.energy = \"0 pJ\" }";
    wrong(changed, &["as changed", "`actions.alpha.energy` is zero"]);
    let text = "question = \"?\"\nbase = \"gscoree\"";
    let file = SweepFile::parse(text).expect("a sweep");
    let error = Space::new(&file, Arc::new(EmbeddedFiles)).err().expect("no base").to_string();
    assert!(error.contains("line 2") && error.contains("did you mean `gscore`?"), "{error}");
}

#[test]
fn absurd_sizes_are_refused() {
    let long = "range = { from = 1, to = 6300, step = 1 }";
    let keys =
        ["vru.latency", "vru.blend-stall", "gsu.qsu-latency", "gsu.bsu-latency", "ccu.latency"];
    let lines: String = keys.map(|key| format!("[[axes]]\nkey = \"{key}\"\n{long}\n")).concat();
    wrong(&lines, &["more than 2^63 points"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whatever stands in a file that has the right form, its space is there or has an error.
    #[test]
    fn no_space_panics(
        key in prop::sample::select(vec![
            "vru.cores", "clock", "geometry.test", "machine", "energy", "dram:timing.burst",
            "energy:sram.macros[].read", "dram:mapping.fields", "display:scale", "vru", "", ".",
            "energy:", "vru.cores.x",
        ]),
        values in prop::sample::select(vec![
            "[1, 2]", "[\"1 GHz\"]", "[[1], [2]]", "[nan]", "[-1, 9223372036854775807]", "[1e300]",
            "[\"\", \"../../etc/passwd\"]", "[true, false]", "[{ a = 1 }]", "[\"neo\"]",
        ]),
        expression in prop::sample::select(vec![
            "vru.cores > 1", "1 / 0 > vru.cores", "x", "area_mm2 / 0 < 1", "energy:name == 'a'",
            "display:scale > 1", "vru.cores == 'a'", "'a'", "machine == 'neo'",
        ]),
    ) {
        let text = format!(
            "question = \"?\"\nbase = \"gscore\"\nconstraints = [{expression:?}]\n\
             [[axes]]\nkey = {key:?}\nvalues = {values}\n\
             [derived]\nvru.latency = {expression:?}"
        );
        if let Ok(file) = SweepFile::parse(&text) {
            let _ = Space::new(&file, Arc::new(EmbeddedFiles)).map_err(|e| e.to_string());
        }
    }
}
