//! What a sweep hands out of a design gives the numbers of its row: the commands and machine files
//! of a page and of `sweep show` are run as a user would, by a shell.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_powergs-sim");

/// Columns of a row, and where the JSON of `replay` has them.
const NUMBERS: [(&str, &str); 7] = [
    ("frame_time_ms.mean", "/aggregate/frame_time_ms/mean"),
    ("frame_time_ms.p99", "/aggregate/frame_time_ms/p99"),
    ("power_w.mean", "/aggregate/power_w/total/mean"),
    ("energy_pj.mean", "/aggregate/energy_pj/total/mean"),
    ("energy_pj.dram", "/aggregate/energy_pj/dram/mean"),
    ("dram_read_bytes", "/aggregate/dram_read_bytes/mean"),
    ("deadline_missed_frac", "/aggregate/deadline_missed/mean"),
];

type Row = BTreeMap<String, String>;

/// A folder with two traces, one of them with a name that a shell would take apart.
struct Bench {
    home: TempDir,
}

/// The second trace.
const SPACED: &str = "traces/it's other.bin";

impl Bench {
    fn new() -> Bench {
        let bench = Bench { home: tempfile::tempdir().expect("a folder") };
        for folder in ["traces", "study/machines"] {
            fs::create_dir_all(bench.path(folder)).expect("made");
        }
        let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
        fs::copy(demo, bench.path("traces/demo.bin")).expect("the demo trace");
        bench.run(&["synth", "demo", "--points", "400", "-o", "s.ply", "--cameras", "c.json"]);
        let views = ["--cameras", "c.json", "--size", "64x48", "--frames", "0..2"];
        bench.run(&[&["extract", "s.ply", "-o", SPACED][..], &views].concat());
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.home.path().join(name)
    }

    fn file(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("written");
    }

    fn run(&self, arguments: &[&str]) -> String {
        let mut program = Command::new(PROGRAM);
        program.current_dir(self.home.path()).args(arguments).env_remove("POWERGS_SHARD");
        let ran = program.output().expect("the program");
        assert!(ran.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&ran.stderr));
        String::from_utf8(ran.stdout).expect("text")
    }

    /// The JSON of a `replay` that is offered, run by a shell.
    fn replayed(&self, line: &str) -> Value {
        let line = line.strip_prefix("powergs-sim replay ").expect("a replay");
        let line = format!("\"$PROGRAM\" replay {line} --what-if 0 --json -q --out r --force");
        let mut shell = Command::new("sh");
        shell.current_dir(self.home.path()).args(["-c", &line]).env("PROGRAM", PROGRAM);
        let ran = shell.output().expect("a shell");
        assert!(ran.status.success(), "{line}: {}", String::from_utf8_lossy(&ran.stderr));
        serde_json::from_slice(&ran.stdout).expect("JSON")
    }

    fn rows(&self, sweep: &str) -> Vec<Row> {
        let table = csv::Reader::from_path(self.path(sweep).join("results.csv"));
        table.expect("results").deserialize().map(Result::unwrap).collect()
    }

    /// The designs of a page.
    fn page(&self, folder: &str) -> Value {
        let page = fs::read_to_string(self.path(folder).join("report.html")).expect("a page");
        let (_, data) = page.split_once("id=\"designs\">").expect("designs");
        serde_json::from_str(data.split_once("</script>").expect("an end").0).expect("JSON")
    }

    /// Runs the commands of a design, and its machine file, and compares with its rows.
    #[track_caller]
    fn check(&self, sweep: &str, point: &str, table: &str, commands: &[String], file: &str) {
        let all = self.rows(sweep);
        let own = |row: &&Row| row["point"] == point && row["energy_table"] == table;
        let rows: Vec<&Row> = all.iter().filter(own).filter(|r| r["scope"] == "trace").collect();
        let mean = all.iter().filter(own).find(|r| r["scope"] == "mean").expect("a mean");
        self.file("taken.toml", file);
        let lines = file.lines().filter_map(|line| line.strip_prefix("# powergs-sim"));
        let of_file: Vec<String> = lines
            .map(|line| format!("powergs-sim{line}").replace(" FILE", " taken.toml"))
            .collect();
        assert_eq!(commands.len(), rows.len(), "one command a trace: {commands:?}");
        assert_eq!(of_file.len(), rows.len(), "one line a trace: {file}");
        let mut seen = vec![Vec::new(); NUMBERS.len()];
        for ((row, command), of_file) in rows.iter().zip(commands).zip(&of_file) {
            for line in [command, of_file] {
                let json = self.replayed(line);
                for ((name, pointer), seen) in NUMBERS.iter().zip(&mut seen) {
                    let number = json.pointer(pointer).and_then(Value::as_f64);
                    let number = number.unwrap_or_else(|| panic!("no {pointer}"));
                    same(&format!("{sweep} #{point} {name} of {line}"), number, &row[*name]);
                    seen.push(number);
                }
            }
        }
        // Times, powers and energies of the aggregate are means; every number was seen twice.
        for ((name, _), seen) in NUMBERS.iter().zip(seen).filter(|((n, _), _)| !n.contains(".p")) {
            let of_all = seen.iter().sum::<f64>() / seen.len() as f64;
            same(&format!("{sweep} #{point} {name} of all traces"), of_all, &mean[*name]);
        }
    }

    /// Checks what a page offers of the designs at these places.
    #[track_caller]
    fn check_page(&self, sweep: &str, table: &str, places: impl Iterator<Item = usize>) {
        let page = self.page(&format!("{sweep}/analysis"));
        for place in places {
            let label = page["names"][place][0].as_str().expect("a name");
            let point = &point_of(label);
            let offer = &page["offers"][place];
            let text = |value: &Value| value.as_str().expect("a text").to_owned();
            let replay = &page["replays"][offer["replay"].as_u64().expect("a place") as usize];
            let all = |key: &str| replay[key].as_array().expect("a list").iter().map(text);
            let (words, others) = (text(&offer["words"]), text(&offer["others"]));
            let commands: Vec<String> =
                all("commands").map(|line| format!("{line} {words}")).collect();
            let head: String = all("comments").map(|line| format!("{line} {others}\n")).collect();
            self.check(sweep, point, table, &commands, &(head + &text(&offer["file"])));
        }
    }

    /// Checks what `sweep show` offers of a design.
    #[track_caller]
    fn check_shown(&self, sweep: &str, table: &str, point: &str) {
        let name = if point.is_empty() { "baseline" } else { point };
        let json = self.run(&["sweep", "show", name, sweep, "--json"]);
        let json: Value = serde_json::from_str(&json).expect("JSON");
        let lines = json["commands"].as_array().expect("commands").iter();
        let lines: Vec<String> = lines.map(|l| l.as_str().expect("a text").to_owned()).collect();
        let file = self.run(&["sweep", "show", name, sweep, "--toml"]);
        self.check(sweep, point, table, &lines, &file);
    }
}

/// The column `point` of a design of this name: `#4 knee` is 4, the base machine has none.
fn point_of(name: &str) -> String {
    let first = name.split(' ').next().unwrap_or_default();
    if first == "baseline" { String::new() } else { first.trim_start_matches('#').to_owned() }
}

/// The number that a table has, but for the rounding of a mean.
#[track_caller]
fn same(what: &str, number: f64, cell: &str) {
    let row: f64 = cell.parse().unwrap_or_else(|_| panic!("{what}: `{cell}`"));
    let difference = (number - row).abs();
    assert!(difference <= 1e-13 * row.abs(), "{what}: {number}, the row has {row}");
}

#[test]
fn a_command_of_a_page_has_the_rate_and_the_frames_of_its_sweep() {
    let bench = Bench::new();
    bench.file(
        "rate.toml",
        "question = \"Which?\"\nbase = \"gscore\"\ndisplay-fps = 90\n\
         [[axes]]\nkey = \"vru.cores\"\nvalues = [1, 2]\n\
         [[axes]]\nkey = \"buffers.feature.capacity\"\nvalues = [\"64 KiB\", \"128 KiB\"]\n",
    );
    let trace = "traces/demo.bin";
    bench.run(&["sweep", "rate.toml", "--traces", trace, "--frames", "..1", "--out", "a", "-q"]);
    bench.check_page("a", "gscore-28nm", 0..4);
    bench.check_shown("a", "gscore-28nm", "3");
    let page = bench.page("a/analysis");
    assert_eq!(page["base"], "gscore");
    assert_eq!(page["trace"], trace);
}

#[test]
fn a_base_in_another_folder_and_a_table_of_the_sweep_are_found() {
    let bench = Bench::new();
    bench.file(
        "study/machines/it's mine.toml",
        "base = \"gscore\"\nname = \"mine\"\n[dram.second-master]\nrate = \"1 GB/s\"\n",
    );
    bench.file(
        "study/own.toml",
        r#"
question = "Which memory?"
base = "machines/it's mine.toml"
display = "oled-powergs"
set = { ccu.units = 2 }

[[energy]]
label = "own"
table = "gscore-28nm-flat"
set = { dram.flat.read.energy = "5 pJ/B" }

[[axes]]
key = "vru.cores"
values = [2, 4]

[[axes]]
name = "memory"
variants = [
  { name = "as it is", set = { } },
  { name = "slow; $(x) 'q'", set = { "dram:timing.read-data" = 60, "vru.units-per-core" = 8 } },
]
"#,
    );
    bench.run(&["sweep", "study/own.toml", "--traces", SPACED, "--out", "b", "-q"]);
    bench.check_page("b", "own", 0..4);
    bench.check_shown("b", "own", "3");
    let file = bench.page("b/analysis")["offers"][0]["file"].as_str().expect("a file").to_owned();
    assert!(file.starts_with("base = \"study/machines/it's mine.toml\"\n"), "{file}");
    assert!(file.contains("name = \"it-s-mine-"), "{file}");
}

#[test]
fn a_row_of_two_traces_has_two_commands_with_the_model_that_made_it() {
    let bench = Bench::new();
    bench.file(
        "models.toml",
        "question = \"Which?\"\nbase = \"gscore\"\n\
         [[axes]]\nkey = \"vru.cores\"\nvalues = [1, 2, 4, 8]\n\
         [[axes]]\nkey = \"ccu.units\"\nvalues = [1, 2, 4]\n\
         [[axes]]\nkey = \"gsu.queue\"\nvalues = [1, 2]\n",
    );
    let traces = ["--traces", "traces/demo.bin", SPACED, "--frames", "0..1"];
    let sweep = [&["sweep", "models.toml", "--out", "c", "-q", "--confirm", "2"][..], &traces];
    bench.run(&sweep.concat());
    let model = |point: &str| {
        let rows = bench.rows("c").into_iter();
        let mut own = rows.filter(|row| row["point"] == point && row["scope"] == "mean");
        own.next().expect("a row")["dram_model"].clone()
    };
    let page = bench.page("c/analysis");
    let point = |place: usize| point_of(page["names"][place][0].as_str().expect("a name"));
    let places = 0..page["names"].as_array().expect("names").len();
    let of_model = |wanted: &str| places.clone().find(|&place| model(&point(place)) == wanted);
    let (banked, calibrated) = (of_model("banked"), of_model("calibrated"));
    let both = [banked.expect("a confirmed design"), calibrated.expect("another one")];
    bench.check_page("c", "gscore-28nm", both.into_iter());
    bench.check_shown("c", "gscore-28nm", &point(both[0]));
    bench.check_shown("c", "gscore-28nm", &point(both[1]));
    // The machine goes on with its own model, whatever stood in for it.
    for place in both {
        let file = page["offers"][place]["file"].as_str().expect("a file");
        assert!(!file.contains("calibrated") && !file.contains("model"), "{file}");
        let name = page["names"][place][0].as_str().expect("a name");
        let name = name.split(' ').next().unwrap_or_default().trim_start_matches('#');
        let file = bench.run(&["sweep", "show", name, "c", "--toml"]);
        assert!(file.contains("model = \"banked\""), "{file}");
    }
    // The page says how the sweep was run, so that it can be run again.
    let text = fs::read_to_string(bench.path("c/analysis/summary.md")).expect("a page");
    let line = format!(
        "powergs-sim sweep models.toml --traces traces/demo.bin '{}' --frames 0..1 --confirm 2",
        SPACED.replace('\'', r"'\''")
    );
    assert!(text.contains(&line), "{line}\n{text}");
}
