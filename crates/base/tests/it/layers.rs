//! Files that say only what differs from another one.

use powergs_base::config::Embedded;
use powergs_base::config::embedded::{DRAM, ENERGY, MACHINES, SYNTH};
use powergs_base::config::error::Place;
use powergs_base::config::layer::{base_of, on, on_embedded, without_places};
use toml::Table;

const BASE: &str = "\
# A machine.

name = \"base\"
description = \"what others begin with\"
clock = \"1 GHz\"                  # [a]

# What it renders with.
[vru]
cores = 4                        # [b]
buffer = { capacity = \"8 KiB\", word = \"32 B\" }  # [c]

[cache]
ways = 2
[cache.banks]
count = 3

[[unit]]
n = 1
[[unit]]
n = 2
";

fn table(text: &str) -> Table {
    text.parse().unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// `over` on [`BASE`].
fn merged(over: &str) -> String {
    on("base", BASE, "", over).expect("a good base")
}

#[test]
fn values_take_the_place_of_those_of_the_base_with_their_comments() {
    let over = "\
# Mine.

base = \"base\"
name = \"mine\"
cache.ways = 8                   # [mine]

[vru]
# Said below.
buffer = { word = \"64 B\" }
queue = 2

[new]
key = [
  1, # one
  2,
]
";
    let text = merged(over);
    let wanted = "\
# Mine.

name = \"mine\"
description = \"on base\"
clock = \"1 GHz\"                  # [a]

# What it renders with.
[vru]
cores = 4                        # [b]
# Said below.
buffer = { capacity = \"8 KiB\", word = \"64 B\" }
queue = 2

[cache]
ways = 8                         # [mine]
[cache.banks]
count = 3

[[unit]]
n = 1
[[unit]]
n = 2

[new]
key = [
  1, # one
  2,
]
";
    assert_eq!(without_places(&text), wanted);
    // A line knows where it was written, however many files it went through.
    let last = "base = \"mine\"\nname = \"last\"\n[vru]\nqueue = 3\n";
    let twice = on("mine", &text, "", last).expect("a good base");
    for (line, file, number) in [
        ("queue = 3", None, 4),
        ("ways = 8 ", Some("mine"), 5),
        ("  2,", Some("mine"), 15),
        ("count = 3", Some("base"), 15),
    ] {
        let at = twice.find(line).unwrap_or_else(|| panic!("{line}\n{twice}"));
        let Place::File { file: in_file, line: found, .. } = Place::of(&twice, at..at + 1) else {
            panic!("{line}\n{twice}");
        };
        assert_eq!((in_file.as_deref(), found), (file, number), "{line}\n{twice}");
    }
}

#[test]
fn lists_are_replaced_whole_and_tables_may_be_taken_away() {
    let text = merged("base = \"base\"\nname = \"a\"\n[[unit]]\nn = 9\n");
    assert_eq!(table(&text)["unit"], toml::Value::Array(vec![toml::Value::Table(table("n = 9"))]));
    let text = merged("base = \"base\"\nname = \"a\"\nunit = [{ n = 7 }]\n");
    assert_eq!(table(&text)["unit"], toml::Value::Array(vec![toml::Value::Table(table("n = 7"))]));
    let below = "name = \"below\"\nunit = [{ n = 1 }]\n[vru]\ncores = 1\n";
    let text = on("below", below, "", "base = \"below\"\nname = \"a\"\n[[unit]]\nn = 3\n");
    let text = text.expect("a good base");
    assert_eq!(table(&text)["unit"], toml::Value::Array(vec![toml::Value::Table(table("n = 3"))]));
    let text = merged("base = \"base\"\nname = \"a\"\ncache = \"none\"\n");
    assert!(!table(&text).contains_key("cache"), "{text}");
    let text = merged("base = \"base\"\nname = \"a\"\n[vru]\nbuffer = \"none\"\n");
    assert_eq!(table(&text)["vru"], toml::Value::Table(table("cores = 4")));
    // A whole table on one line.
    let text = merged("base = \"base\"\nname = \"a\"\nvru = { cores = 2, x.y = 1 }\n");
    assert_eq!(table(&text)["vru"]["cores"], toml::Value::Integer(2), "{text}");
    assert_eq!(table(&text)["vru"]["x"]["y"], toml::Value::Integer(1), "{text}");
    assert_eq!(table(&text)["vru"]["buffer"]["word"].as_str(), Some("32 B"), "{text}");
}

#[test]
fn files_of_the_program_are_found_and_circles_are_not_walked() {
    const FILES: &[Embedded] = &[
        Embedded { name: "base", text: BASE },
        Embedded { name: "next", text: "base = \"base\"\nname = \"next\"\nclock = \"2 GHz\"\n" },
        Embedded { name: "round", text: "base = \"about\"\nname = \"round\"\n" },
        Embedded { name: "about", text: "base = \"round\"\nname = \"about\"\n" },
    ];
    let text = on_embedded("base = \"next\"\nname = \"a\"\n[vru]\ncores = 1\n", FILES).unwrap();
    let found = table(&text);
    assert_eq!(found["clock"].as_str(), Some("2 GHz"));
    assert_eq!(found["vru"]["cores"].as_integer(), Some(1));
    assert_eq!(base_of(&text), None, "{text}");
    let fails = |text: &str| on_embedded(text, FILES).unwrap_err().to_string();
    let circle = fails("name = \"a\"\nbase = \"round\"\n");
    assert!(circle.starts_with("line 2, column 1: `base` goes round in a circle:"), "{circle}");
    let unknown = fails("base = \"nxt\"\n");
    assert!(unknown.contains("did you mean `next`?"), "{unknown}");
    let own = "base = \"base\"\nname = \"a\"\n";
    let broken = on("base", "name = \"base\"\nclock = 1 GHz\n", "", own).unwrap_err();
    assert!(broken.starts_with("line 2 of base: not valid TOML"), "{broken}");
    let many: String = (0..3000).map(|i| format!("k{i} = {i}\n")).collect();
    let many = on("base", &many, "", own).unwrap_err();
    assert!(many.contains("base has more than 2000 keys"), "{many}");
    // Lines that nobody can have, and paths that no comment can hold.
    let odd = on("a\nb", "#line 18446744073709551615 x\nk = 1\n", "", own).expect("a base");
    assert_eq!(table(&odd)["k"].as_integer(), Some(1), "{odd}");
    // What is no TOML is for its reader.
    assert_eq!(on_embedded("base = ", FILES).unwrap(), "base = ");
    assert_eq!(on_embedded("a = 1", FILES).unwrap(), "a = 1");
}

#[test]
fn every_file_on_a_base_is_complete_and_says_nothing_twice() {
    for files in [MACHINES, ENERGY, DRAM, SYNTH] {
        for file in files.iter().filter(|file| base_of(file.text).is_some()) {
            let whole =
                on_embedded(file.text, files).unwrap_or_else(|e| panic!("{}: {e}", file.name));
            assert!(table(&whole).len() > 3, "{}", file.name);
            let keys = |text: &str| text.lines().filter(|line| line.contains(" = ")).count();
            assert!(2 * keys(file.text) < keys(&whole), "{}: more than half of it", file.name);
        }
    }
}

#[test]
fn no_text_makes_it_panic() {
    let pieces = [
        "base = \"base\"\n",
        "[vru]\n",
        "[[unit]]\n",
        "a = 1\n",
        "a.b = { c = 1 }\n",
        "#line 3 x\n",
        "[vru.buffer]\n",
        "vru = \"none\"\n",
        "x = [\n",
        "]\n",
        "\"q \\\" # \" = 2 # c\n",
        "unit = []\n",
        "name = '''\n",
        "'''\n",
        "[a.b]\n",
        "é = \"ü\"\n",
    ];
    let mut state = 7_u64;
    for _ in 0..20_000 {
        let mut text = String::new();
        for _ in 0..6 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            text.push_str(pieces[(state >> 33) as usize % pieces.len()]);
        }
        let whole = merged(&text);
        if let Ok(own) = text.parse::<Table>() {
            // A value where the base has a table, or the reverse, is for the reader to refuse.
            let _ = (own, whole.parse::<Table>().is_ok());
        }
    }
}
