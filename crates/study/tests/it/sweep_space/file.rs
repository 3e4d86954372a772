//! The form of a sweep file.

use powergs_study::sweep::SweepFile;
use powergs_study::sweep::file::{Method, ZipValues};
use proptest::prelude::*;

#[test]
fn what_is_left_out_has_its_default() {
    let file = SweepFile::parse("question = \"Why?\"\nbase = \"gscore\"").expect("a sweep");
    assert!(file.axes.is_empty() && file.traces.is_empty() && file.energy.is_empty());
    assert_eq!(file.objectives.minimize, ["power_w.mean", "area_mm2"]);
    assert_eq!(file.objectives.maximize, ["fps.mean"]);
    assert_eq!((file.display_fps, file.sampling.method), (60.0, Method::Grid));
}

#[test]
fn keys_may_be_quoted_dotted_or_nested() {
    let text = r#"
question = "?"
base = "gscore"
set = { "vru.cores" = 4, vru.latency = 8, ccu = { units = 2, batch = 8 } }
[[axes]]
zip = { "geometry.tile" = [8, 16], geometry = { chunk = { from = 64, to = 128, factor = 2 } } }
"#;
    let file = SweepFile::parse(text).expect("a sweep");
    let keys: Vec<&str> = file.set.0.iter().map(|(key, _)| key.as_str()).collect();
    assert_eq!(keys, ["vru.cores", "vru.latency", "ccu.units", "ccu.batch"]);
    let zip = file.axes[0].zip.as_ref().expect("a zip");
    assert!(
        matches!(&zip.0[0], (key, ZipValues::List(l)) if key == "geometry.tile" && l.len() == 2)
    );
    assert!(matches!(&zip.0[1], (key, ZipValues::Range(_)) if key == "geometry.chunk"));
}

#[track_caller]
fn wrong(text: &str, parts: &[&str]) {
    let error = SweepFile::parse(text).expect_err("a mistake").to_string();
    for part in parts {
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn mistakes_in_the_form_have_a_line() {
    wrong("base = \"gscore\"", &["missing key `question`"]);
    wrong("question = \"?\"\nbase = 3", &["line 2", "`base` must be a text"]);
    let axis = "question = \"?\"\nbase = \"gscore\"\n[[axes]]\n";
    wrong(&format!("{axis}kee = \"vru.cores\""), &["line 4", "did you mean `key`?"]);
    wrong(&format!("{axis}values = 3"), &["line 4", "is a list"]);
    wrong(
        "question = \" \"\nbase = \"gscore\"\n[sampling]\nmethod = \"soboll\"\npoints = 0",
        &["did you mean \"sobol\"?", "line 5", "at least 1"],
    );
    wrong("question = \" \"\nbase = \"gscore\"", &["line 1", "`question` is empty"]);
    let twice = "question = \"?\"\nbase = \"gscore\"\n\
                 [[energy]]\nlabel = \"a\"\ntable = \"paper\"\n\
                 [[energy]]\nlabel = \"a\"\ntable = \"paper\"";
    wrong(twice, &["line 7", "a second table with the label `a`"]);
    wrong(&format!("{axis}zip = {{ vru.cores = 3 }}"), &["must be a list or a range"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_text_makes_it_panic(text in "\\PC{0,120}") {
        let _ = SweepFile::parse(&text).map_err(|e| e.to_string());
    }

    #[test]
    fn no_values_make_it_panic(
        key in prop::sample::select(vec![
            "set", "axes", "derived", "constraints", "sampling", "objectives", "energy", "traces",
            "display-fps", "display",
        ]),
        value in prop::sample::select(vec![
            "1", "-1", "nan", "1e999", "\"x\"", "[]", "[[]]", "{}", "[{}]", "{ a = 1 }",
            "{ a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r.s = 1 }", "[{ key = \"vru.cores\" }]",
            "[{ values = [1] }]", "[{ zip = { a = { from = 1 } } }]", "{ method = 1 }",
            "[{ range = { from = 1, to = 2, count = 1 } }]", "1979-05-27", "true", "[\"(\"]",
        ])
    ) {
        let text = format!("question = \"?\"\nbase = \"gscore\"\n{key} = {value}");
        let _ = SweepFile::parse(&text).map_err(|e| e.to_string());
    }
}
