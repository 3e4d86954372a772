//! `results.json`: round trip, other versions, damage.

use powergs_optimize::results::{Results, ResultsError};
use powergs_optimize::role::RoleKind;

use crate::foveated_run::run;

#[test]
fn results_are_read_back_as_they_were_written() {
    let results = run();
    let text = results.to_json();
    assert_eq!(Results::parse(&text).unwrap(), results);
    assert_eq!(results.to_json(), text);
    assert!(text.ends_with("}\n"));
}

/// One spelling in every output; older files spelt it with an underscore.
#[test]
fn a_held_out_model_has_one_name() {
    let mut results = run();
    results.models[1].role = RoleKind::HeldOut;
    let text = results.to_json();
    assert!(text.contains("\"role\": \"held-out\"") && RoleKind::HeldOut.name() == "held-out");
    let older = text.replace("\"role\": \"held-out\"", "\"role\": \"held_out\"");
    assert_eq!(Results::parse(&older).unwrap(), results);
}

#[track_caller]
fn refused(text: &str, says: &str) {
    let message = Results::parse(text).unwrap_err().to_string();
    assert!(message.contains(says), "{message}");
}

#[test]
fn every_truncation_is_an_error_that_says_so() {
    let text = run().to_json();
    // The last one is the closing brace; only the line feed may be missing.
    let end = text.trim_end().len();
    for cut in (0..end).step_by(211).chain([end - 1]) {
        let error = Results::parse(&text[..cut]).unwrap_err();
        assert!(matches!(error, ResultsError::Truncated { .. }), "{cut}: {error}");
    }
    assert!(Results::parse(&text[..end]).is_ok());
}

#[test]
fn other_files_and_other_versions_are_refused() {
    let text = run().to_json();
    refused("", "truncated");
    refused("[]", "format");
    refused("{}", "no results");
    refused("{\"format\": \"glTF\", \"version\": 1}", "no results");
    refused("\u{feff}{}", "line 1, column 1");
    refused(&text.replace("\"version\": 1", "\"version\": 2"), "version 2, this program reads 1");
    refused(&text.replace("\"version\": 1", "\"version\": -1"), "format");
    refused(&"[".repeat(1 << 20), "recursion");
}

#[test]
fn values_that_cannot_be_are_named() {
    let text = run().to_json();
    refused(&text.replacen("\"fps\": 60.0", "\"fps\": \"fast\"", 1), "invalid type");
    refused(&text.replacen("\"fps\": 60.0", "\"fps\": 1e999", 1), "number out of range");
    refused(&text.replacen("\"scene\": \"bicycle\",", "", 1), "missing field `scene`");
    let wrong = |change: &dyn Fn(&mut Results), says: &str| {
        let mut results = run();
        change(&mut results);
        refused(&results.to_json(), says);
    };
    wrong(&|r| r.variants.clear(), "`variants`: is empty");
    wrong(&|r| r.models[3].level = 0, "`models[3].level`");
    wrong(&|r| r.models[3].level = 200, "`models[3].level`");
    wrong(&|r| r.models[2].variant = "X".into(), "`models[2].variant`");
    wrong(&|r| r.models[2].render_w = -1.0, "power is negative");
    wrong(&|r| r.foveated[1].jobs[3] = "gone".into(), "`foveated[1].jobs`");
    wrong(&|r| r.foveated[1].variant = "X".into(), "`foveated[1].variant`");
    wrong(&|r| r.foveated[1].display_w = -0.1, "`foveated[1]`");
    // Not a number is null, which a power cannot be.
    wrong(&|r| r.models[2].render_w = f64::NAN, "invalid type: null");
}
