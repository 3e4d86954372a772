//! Charts, sentences, pages and the command, from a table made by hand.

use powergs_chart::{Format, Style};
use powergs_testkit::charts::covered;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use powergs_sim::analysis::{Analysis, Objective, Question, Table};
use powergs_sim::report::sweep::{self, Measure, Provenance};
use predicates::prelude::*;

use support::Sweep;

#[path = "../../crates/study/tests/it/analysis/support.rs"]
mod support;

fn question() -> Question {
    Question::of(vec![
        Objective::minimize("energy_pj.mean"),
        Objective::minimize("area_mm2"),
        Objective::maximize("fps.mean"),
    ])
}

/// Draws all charts into the folder of build products, for people to look at; PNGs are slow and
/// made on demand.
fn draw(name: &str, table: &Table, question: &Question) -> Vec<(&'static str, String)> {
    let analysis = Analysis::of(table, question).expect("an answer");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep_charts").join(name);
    fs::create_dir_all(&folder).expect("a folder");
    let charts = sweep::charts(&analysis);
    let mut drawn = Vec::new();
    for chart in &charts {
        let svg = chart.svg(Style::default()).expect("SVG");
        for nonsense in [">NaN", ">inf", ">-0<"] {
            assert!(!svg.contains(nonsense), "{name}/{}: {nonsense}", chart.name);
        }
        assert!(sweep::is_file_name(&format!("{}.svg", chart.name)));
        assert_eq!(covered(chart), Vec::<String>::new(), "{name}");
        if std::env::var_os("RUN_SLOW_TESTS").is_some() {
            let png = chart.png(Style::default()).expect("PNG");
            fs::write(folder.join(format!("{}.png", chart.name)), png).expect("written");
        }
        drawn.push((chart.name, svg));
    }
    let commands = vec!["a <b>".into()];
    let title = format!("Sweep {name}");
    let provenance = Provenance { title, commands, ..Provenance::default() };
    let page = sweep::document(&analysis, &charts, None, &provenance);
    fs::write(folder.join("report.html"), page.html().expect("HTML")).expect("written");
    fs::write(folder.join("summary.md"), page.markdown(Format::Png)).expect("written");
    fs::write(folder.join("terminal.txt"), page.terminal(80)).expect("written");
    drawn
}

/// What a terminal shows.
fn printed(analysis: &Analysis) -> String {
    sweep::document(analysis, &[], None, &Provenance::default()).terminal(80)
}

fn names(drawn: &[(&'static str, String)]) -> Vec<&'static str> {
    drawn.iter().map(|d| d.0).collect()
}

#[test]
fn three_objectives_and_three_axes_have_all_charts() {
    let drawn = draw("three", &Sweep::default().table(), &question());
    let first = ["front", "front_2", "front_3", "speedup", "energy_front"];
    let expected = [&first[..], &["keys", "stability"]].concat();
    assert_eq!(names(&drawn), expected);
    let front = &drawn[0].1;
    for text in ["knee #", "baseline", "area, mm²", "frame rate, FPS"] {
        assert!(front.contains(text), "{text}");
    }
}

#[test]
fn two_axes_make_a_heatmap_and_one_a_curve() {
    let two = Sweep { tests: vec!["obb"], ..Sweep::default() };
    let pair = Question::of(vec![Objective::minimize("area_mm2"), Objective::maximize("fps.mean")]);
    let drawn = draw("two", &two.table(), &pair);
    assert!(drawn.iter().any(|d| d.0 == "keys" && d.1.contains("What the two axes do")));
    let one = Sweep { tests: vec!["obb"], kib: vec![64], ..Sweep::default() };
    let drawn = draw("one", &one.table(), &pair);
    assert!(drawn.iter().any(|d| d.0 == "keys" && d.1.contains("What the axis does")));
}

/// One design, one table, one trace: whatever has no meaning is left out, nothing breaks.
#[test]
fn a_single_design() {
    let sweep = Sweep {
        cores: vec![4],
        kib: vec![64],
        tests: vec!["obb"],
        tables: vec![("t", 10.0, 1.0)],
        traces: vec![("garden", 1.0, 1.0)],
        baseline: false,
    };
    let table = sweep.table();
    assert_eq!(
        names(&draw("single", &table, &question())),
        ["front", "front_2", "front_3", "energy_front"]
    );
    let one = Question::of(vec![Objective::maximize("fps.mean")]);
    assert_eq!(names(&draw("single_one", &table, &one)), ["energy_front"]);
    let analysis = Analysis::of(&table, &one).expect("an answer");
    let text = printed(&analysis);
    assert!(text.contains("It is the best in every objective"), "{text}");
    assert!(text.contains("One energy table and one trace"), "{text}");
}

/// Ten thousand designs and four objectives, a condition, hostile labels.
#[test]
fn a_large_sweep_stays_drawable() {
    let sweep = Sweep {
        cores: (1..=50).collect(),
        kib: (1..=50).map(|k| 8 * k).collect(),
        tables: vec![("lpddr4 <b>&|*", 10.88, 1.0)],
        traces: vec![("a \"garden\" with a very long name, longer than any column", 1.0, 1.0)],
        ..Sweep::default()
    };
    let mut wide = question();
    wide.objectives.push(Objective::minimize("dram_bytes.mean"));
    wide.condition = Some(
        powergs_sim::sweep::expr::Expr::parse("frame_time_ms.p99 <= 20").expect("an expression"),
    );
    wide.colour = Some("geometry.test".into());
    let drawn = draw("large", &sweep.table(), &wide);
    assert!(drawn.iter().all(|d| d.1.len() < 4_000_000), "browsers open them");
}

#[test]
fn the_terminal_keeps_to_80_columns() {
    let table = Sweep::default().table();
    let text = printed(&Analysis::of(&table, &question()).expect("an answer"));
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    for part in ["simulated, 1 failed, 1 excluded", "Knee: #", "Baseline: ", "Rankings under"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

/// The sentence of the knee has the numbers of the table.
#[test]
fn the_reason_of_the_knee_is_arithmetic() {
    let text = "point,is_baseline,id,status,reason,energy_table,trace,scope,a,frames,fps.mean,\
                area_mm2\n\
                0,false,a,ok,,t,,mean,1,4,10,1\n\
                1,false,b,ok,,t,,mean,2,4,90,1.5\n\
                2,false,c,ok,,t,,mean,3,4,100,4\n";
    let table = Table::read(text.as_bytes(), |_| true).expect("a table");
    let pair = Question::of(vec![Objective::minimize("area_mm2"), Objective::maximize("fps.mean")]);
    let analysis = Analysis::of(&table, &pair).expect("an answer");
    let text = printed(&analysis).split_whitespace().collect::<Vec<_>>().join(" ");
    for sentence in [
        "Knee: #1 (a=2): area 1.50 mm², frame rate 90.0 FPS.",
        "50 % more area than #0, the best in area, buys 9.00 times the frame rate.",
        "10 % less frame rate than #2, the best in frame rate, buys 63 % less area.",
        "Frame rate: from #0 to #1 each mm² buys 160 FPS; from #1 to #2 only 4.00 FPS, 40.0 times",
    ] {
        assert!(text.contains(sentence), "{sentence}\n{text}");
    }
}

#[test]
fn the_html_report_is_one_file_and_escapes() {
    let sweep =
        Sweep { tables: vec![("<script>", 10.0, 1.0), ("b", 60.0, 1.0)], ..Sweep::default() };
    let table = sweep.table();
    let mut question = question();
    question.text = "Which <units> & why?".into();
    let analysis = Analysis::of(&table, &question).expect("an answer");
    let charts = sweep::charts(&analysis);
    let commands = vec!["powergs-sim sweep 'a<b'".to_owned()];
    let title = "Sweep units".into();
    let provenance = Provenance { title, commands, ..Provenance::default() };
    let html = sweep::document(&analysis, &charts, None, &provenance).html().expect("HTML");
    assert!(html.contains("Which &lt;units&gt; &amp; why?"));
    // The program's own script, and the designs.
    assert_eq!(html.matches("<script").count(), 2, "labels are text");
    assert_eq!(html.matches("<svg").count(), 2 * charts.len(), "for wide screens and narrow ones");
    // Names of XML dialects are no addresses that a browser opens.
    let plain = html.replace("http://www.w3.org/2000/svg", "");
    for network in ["http://", "https://", "src=", "@import", "url(", "fetch(", "import("] {
        assert!(!plain.contains(network), "{network}");
    }
    assert!(html.contains("@media print") && html.contains("powergs-sim sweep "));
}

#[test]
fn values_have_units_that_fit() {
    let text = |name: &str, x: f64| Measure::of(name).text(x);
    assert_eq!(text("energy_pj.mean", 2.5e9), "2.50 mJ");
    assert_eq!(text("frame_time_ms.p99", 16.6), "16.6 ms");
    assert_eq!(text("area_mm2", 3.956), "3.96 mm²");
    assert_eq!(text("units.vru.busy_frac", 0.5), "50.0 %");
    assert_eq!(text("dram_bytes", 3.2e6), "3.20 MB");
    assert_eq!(text("edp_pj_s", 1e9), "1.00 mJs");
    assert_eq!(text("fps.mean", f64::NAN), "-");
    assert_eq!(Measure::of("frame_time_ms.p99").words, "frame time, p99");
    assert_eq!(Measure::of("units.vru.busy_frac").words, "units.vru.busy_frac");
}

#[test]
fn names_are_as_short_as_they_are_clear() {
    let names = [
        ("buffers.sorting.capacity", "sorting.capacity"),
        ("buffers.feature.capacity", "feature.capacity"),
        ("geometry.chunk", "chunk"),
        ("vru.cores", "cores"),
        ("ccu.units", "ccu.units"),
        ("vru.units-per-core", "units-per-core"),
        ("sorters", "sorters"),
    ];
    assert_eq!(sweep::short_names(&names.map(|n| n.0)), names.map(|n| n.1));
}

fn program(arguments: &[&str]) -> assert_cmd::assert::Assert {
    Command::new(env!("CARGO_BIN_EXE_powergs-sim")).arg("pareto").args(arguments).assert()
}

fn folder() -> tempfile::TempDir {
    let root = tempfile::tempdir().expect("a folder");
    fs::write(root.path().join("results.csv"), Sweep::default().csv()).expect("written");
    let sweep = "question = \"Which units?\"\nbase = \"gscore\"\n\
                 [objectives]\nminimize = [\"area_mm2\"]\nmaximize = [\"fps.mean\"]\n";
    fs::write(root.path().join("sweep.toml"), sweep).expect("written");
    let finished = "state = \"0\"\nresults = \"0\"\nok = 50\ninvalid = 0\nfailed = 1\n\
                    excluded = 13\nanswered = true\n\
                    free = [{ axis = \"vru.cores\", is-policy = false }]\n";
    fs::write(root.path().join("finished.toml"), finished).expect("written");
    root
}

#[test]
fn the_command_writes_its_folder_again_and_again() {
    let root = folder();
    let dir = root.path().to_string_lossy().into_owned();
    let csv = root.path().join("front.csv");
    program(&[&dir, "--csv", &csv.to_string_lossy()])
        .code(0)
        .stdout(predicate::str::contains("question: Which units?"))
        .stdout(predicate::str::contains("Without a price in the energy tables"))
        .stdout(predicate::str::contains("minimize area_mm2, maximize fps.mean"));
    let analysis = root.path().join("analysis");
    for name in ["pareto.csv", "summary.md", "report.html", "front.png", "stability.svg"] {
        assert!(analysis.join(name).is_file(), "{name}");
    }
    let rows = fs::read_to_string(analysis.join("pareto.csv")).expect("rows");
    assert_eq!(rows, fs::read_to_string(&csv).expect("rows"));
    assert!(rows.starts_with("role,misses_display_rate,same_as,point,is_baseline,"));
    assert!(rows.lines().any(|l| l.starts_with("knee,")) && rows.contains("\nbaseline,"));
    let json = program(&[&dir, "--json", "--where", "vru.cores >= 4", "--design", "3"]).code(0);
    let json: serde_json::Value = serde_json::from_slice(&json.get_output().stdout).expect("JSON");
    assert_eq!(json["points"]["excluded"], 13, "as the sweep says");
    assert_eq!(json["named"]["design"]["point"], 3);
    assert_eq!(json["named"]["meets_condition"], false);
    assert!(json["knee"]["design"]["values"]["fps.mean"].as_f64().is_some());
    assert_eq!(json["stability"]["rankings"], 5);
}

/// A table in which the slow designs draw least.
fn slow_and_fast(fps: [f64; 3]) -> tempfile::TempDir {
    let root = tempfile::tempdir().expect("a folder");
    let mut text = String::from(
        "point,is_baseline,id,status,reason,energy_table,trace,scope,vru.cores,frames,\
         frame_time_ms.mean,frame_time_ms.max,fps.mean,fps.min,deadline_missed_frac,\
         power_w.mean,area_mm2\n",
    );
    for (i, fps) in fps.into_iter().enumerate() {
        let (ms, late, cores) = (1e3 / fps, u8::from(fps < 60.0), 1 << i);
        text += &format!(
            "{i},false,{i:x},ok,,t,,mean,{cores},4,{ms},{ms},{fps},{fps},{late},0.{cores},{cores}\n"
        );
    }
    fs::write(root.path().join("results.csv"), text).expect("written");
    let sweep = "question = \"Which is enough?\"\nbase = \"gscore\"\n";
    fs::write(root.path().join("sweep.toml"), sweep).expect("written");
    root
}

#[test]
fn a_design_below_the_display_rate_is_no_answer() {
    let root = slow_and_fast([31.0, 70.0, 90.0]);
    let dir = root.path().to_string_lossy().into_owned();
    let asked = [dir.as_str(), "--minimize", "power_w.mean,area_mm2"];
    program(&asked)
        .code(0)
        .stdout(predicate::str::contains("Knee: #1"))
        .stdout(predicate::str::contains("1 design misses 60 FPS"));
    let rows = fs::read_to_string(root.path().join("analysis/pareto.csv")).expect("rows");
    assert!(rows.contains("\nknee,false,,1,"), "{rows}");
    let all: Vec<&str> = asked.iter().copied().chain(["--include-misses"]).collect();
    program(&all)
        .code(0)
        .stdout(predicate::str::contains("Knee: #0"))
        .stdout(predicate::str::contains("missed"));
    let rows = fs::read_to_string(root.path().join("analysis-2/pareto.csv")).expect("rows");
    assert!(rows.contains("\nknee,true,,0,"), "{rows}");
}

#[test]
fn where_no_design_reaches_the_rate_the_answer_begins_with_it() {
    let root = slow_and_fast([21.0, 31.0, 41.5]);
    let dir = root.path().to_string_lossy().into_owned();
    program(&[&dir]).code(0).stdout(predicate::str::contains(
        "No design reaches 60 FPS in every frame. The fastest, #2, does 41.5 FPS",
    ));
}

#[test]
fn objectives_are_columns_keys_and_expressions() {
    let root = folder();
    let dir = root.path().to_string_lossy().into_owned();
    let smallest = "buffers.feature.capacity";
    program(&[&dir, "--minimize", smallest, "--where", "fps.mean >= 60"])
        .code(0)
        .stdout(predicate::str::contains("buffers.feature.capacity 16 KiB"));
    let product = "area_mm2 * frame_time_ms.p99";
    program(&[&dir, "--minimize", product]).code(0).stdout(predicate::str::contains(product));
    let energy = program(&[&dir, "--minimize", "energy"]).code(2);
    energy.stderr(predicate::str::contains("did you mean `energy_pj.mean`?"));
    let rate = program(&[&dir, "--where", "fps.mean > 60 FPS"]).code(2);
    rate.stderr(predicate::str::contains("leave `FPS` out"));
}

#[test]
fn noise_is_a_share_or_in_percent() {
    let root = slow_and_fast([61.0, 70.0, 90.0]);
    let dir = root.path().to_string_lossy().into_owned();
    let one = "--maximize=fps.mean";
    program(&[&dir, one, "--epsilon", "0.1%", "--json"]).code(0);
    let json = program(&[&dir, one, "--epsilon", "40 %", "--json"]).code(0);
    let json: serde_json::Value = serde_json::from_slice(&json.get_output().stdout).expect("JSON");
    assert_eq!(json["front"][0]["same_as"], serde_json::json!([0, 1]));
    program(&[&dir, "--epsilon", "2"]).code(2).stderr(predicate::str::contains("0.1%"));
}

#[test]
fn the_command_says_what_is_wrong() {
    let root = folder();
    let dir = root.path().to_string_lossy().into_owned();
    let cases: [(&[&str], i32, &str); 8] = [
        (&["--minimize", "aera_mm2"], 2, "did you mean `area_mm2`?"),
        (&["--where", "area_mm2 <="], 2, "--where: column"),
        (&["--where", "area_mm2 < 0"], 1, "none of 50 designs meets the condition"),
        (&["--energy-table", "x"], 2, "there are lpddr4, hbm2"),
        (&["--scope", "attic"], 2, "no trace `attic`"),
        (&["--design", "nine"], 2, "--design nine: name a point"),
        (&["--design", "999"], 2, "no design `999`"),
        (&["--top", "0"], 2, "1..=1000"),
    ];
    for (arguments, code, text) in cases {
        let all: Vec<&str> =
            std::iter::once(dir.as_str()).chain(arguments.iter().copied()).collect();
        program(&all).code(code).stderr(predicate::str::contains(text));
    }
    assert!(!root.path().join("analysis").exists(), "nothing is half written");
    program(&["no/such/folder"]).code(3).stderr(predicate::str::contains("no such folder"));
    let other = tempfile::tempdir().expect("a folder");
    let place = other.path().to_string_lossy().into_owned();
    program(&[&place]).code(3).stderr(predicate::str::contains("there is no results.csv"));
    fs::write(other.path().join("state.toml"), "").expect("written");
    program(&[&place]).code(3).stderr(predicate::str::contains("--resume"));
    fs::write(root.path().join("results.csv"), "a,b\n1\n").expect("written");
    program(&[&dir]).code(3).stderr(predicate::str::contains("results.csv"));
}
