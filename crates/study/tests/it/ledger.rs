//! The ledger: entered once, never changed, and what predictions come to.

use std::process::Command;

use powergs_study::validate::{
    BASELINE, Judged, LEDGER, PUBLISHED, Row, RowStanding, Tables, WORKLOADS, definition, judge,
};

const HEAD: &str = "row,definition,entered,model,status,null,null_how,family,counts,why\n";

fn tables() -> Tables {
    Tables::parse(PUBLISHED, WORKLOADS, BASELINE).expect("the tables that come with the program")
}

/// One published number, as machines and workloads that there are have it.
fn one(published: f64) -> Tables {
    let head = PUBLISHED.lines().next().expect("a head");
    let row = format!("mine,GPUs,w,lego,gscore,,fps,{published},20%,known_gap,mechanism,,me,why");
    Tables::parse(&format!("{head}\n{row}\n"), WORKLOADS, "id,workload,ours\n").expect("a row")
}

fn entry(row: &Row, entered: &str, rest: &str) -> String {
    format!("{},{:016x},{entered},15,{rest}\n", row.id, definition(row))
}

fn refused(tables: Tables, entries: &str) -> String {
    tables.with_ledger(&format!("{HEAD}{entries}")).expect_err(entries).to_string()
}

#[test]
fn every_row_is_entered_once_and_before_it_is_changed() {
    let all = Tables::embedded();
    assert_eq!(all.ledger.entries().len(), all.rows.len());
    for row in &all.rows {
        let entry = all.ledger.of(row).unwrap_or_else(|| panic!("{}", row.id));
        assert!(entry.model <= powergs_core::sim::MODEL_VERSION, "{}", row.id);
    }
    // Without its entry a row is refused, and so is one that is another question by now.
    let first = LEDGER.lines().nth(1).expect("an entry");
    let without = LEDGER.replacen(&format!("{first}\n"), "", 1);
    let error = tables().with_ledger(&without).expect_err("a row without an entry").to_string();
    assert!(error.contains("ledger.csv") && error.contains("append one"), "{error}");
    let error = refused(one(100.0), &entry(&one(120.0).rows[0], "2026-11-29", GOOD));
    assert!(error.contains("no entry with this definition"), "{error}");
}

const GOOD: &str = "prediction,50,half,mine,yes,nobody looked";

#[test]
fn what_makes_no_entry_is_refused() {
    let row = |rest: &str| entry(&one(100.0).rows[0], "2026-11-29", rest);
    assert!(one(100.0).with_ledger(&format!("{HEAD}{}", row(GOOD))).is_ok());
    for (rest, because) in [
        ("enforced,50,half,mine,yes,why", "prediction or calibrated"),
        ("prediction,,,mine,yes,why", "without the mechanism"),
        ("prediction,50,half,mine,maybe,why", "yes or no"),
        ("prediction,50,half,,yes,why", "family"),
        ("prediction,50,half,mine,yes,", "why"),
        ("prediction,inf,half,mine,yes,why", "finite"),
    ] {
        let error = refused(one(100.0), &row(rest));
        assert!(error.contains(because), "{rest}: {error}");
    }
    for day in ["", "yesterday", "2026-1-2", "29.11.2026"] {
        let error = refused(one(100.0), &entry(&one(100.0).rows[0], day, GOOD));
        assert!(error.contains("must be a day"), "{day}: {error}");
    }
    // A status is given once: neither twice, nor as a prediction after a look.
    let twice = row(GOOD) + &row("calibrated,50,half,mine,yes,why");
    assert!(refused(one(100.0), &twice).contains("given once"));
    let changed = entry(&one(120.0).rows[0], "2026-11-28", GOOD) + &row(GOOD);
    assert!(refused(one(100.0), &changed).contains("must be calibrated"));
    let changed = entry(&one(120.0).rows[0], "2026-11-28", GOOD)
        + &row("calibrated,50,half,mine,yes,another value was published");
    let ledger = one(100.0).with_ledger(&format!("{HEAD}{changed}")).expect("a ledger").ledger;
    assert_eq!(ledger.of(&one(100.0).rows[0]).expect("an entry").standing, RowStanding::Calibrated);
}

/// A prediction of one hundred, whose null says fifty.
fn comes_to(ours: f64) -> powergs_study::validate::Evidence {
    let tables = one(100.0);
    let text = format!("{HEAD}{}", entry(&tables.rows[0], "2026-11-29", GOOD));
    let tables = tables.with_ledger(&text).expect("a ledger");
    let parts = [("lego".to_owned(), ours)].into();
    let judged = [judge(&tables.rows[0], Some(&parts), None)];
    tables.ledger.standing(&judged)
}

#[test]
fn a_prediction_counts_where_it_is_near_and_its_null_is_not() {
    let near = comes_to(90.0);
    assert_eq!((near.predictions, near.inside, near.within_quarter), (1, 1, 1));
    assert!(near.families[0].is_evidence);
    // It is near its tolerance, and no nearer than half of what its null is away.
    let far = comes_to(60.0);
    assert_eq!((far.predictions, far.inside, far.within_quarter), (1, 0, 0));
    assert!(!far.families[0].is_evidence);
    let error = far.error.expect("an error");
    assert!((error - 100.0 / 60.0).abs() < 1e-9, "{error}");
    assert_eq!(far.worst[0].row, "mine");
    // A miss stays in the count, however far.
    assert_eq!(comes_to(1e-3).predictions, 1);
    // A null that is as good makes nothing evidence.
    let tables = one(100.0);
    let same = "prediction,95,linear,mine,yes,nobody looked";
    let text = format!("{HEAD}{}", entry(&tables.rows[0], "2026-11-29", same));
    let tables = tables.with_ledger(&text).expect("a ledger");
    let parts = [("lego".to_owned(), 96.0)].into();
    let judged = [judge(&tables.rows[0], Some(&parts), None)];
    assert!(!tables.ledger.standing(&judged).families[0].is_evidence);
}

#[test]
fn rows_of_one_experiment_count_once() {
    let tables = Tables::embedded();
    let of = |row| {
        let parts = tables.before(row);
        judge(row, parts, parts)
    };
    let judged: Vec<Judged> = tables.rows.iter().map(of).collect();
    let found = tables.ledger.standing(&judged);
    let rows: usize = found.families.iter().map(|family| family.rows).sum();
    assert_eq!(rows as u64, found.predictions);
    assert!(found.families.len() < rows && found.of_worth().count() < found.families.len());
    assert!(found.inside < found.predictions && found.calibrated_missed > 0);
    for family in &found.families {
        assert!(family.worst >= family.error * (1.0 - 1e-12), "{}", family.name);
    }
}

/// Nothing that was committed is ever changed: each version of the file begins with the one before.
#[test]
fn the_file_is_append_only() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let git = |arguments: &[&str]| {
        let output = Command::new("git").current_dir(root).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    const FILE: &str = "tests/validation/ledger.csv";
    // Sources without their history have nothing to be compared with.
    let Some(commits) = git(&["log", "--reverse", "--format=%H", "--", FILE]) else { return };
    let mut before = String::new();
    for commit in commits.lines() {
        let Some(text) = git(&["show", &format!("{commit}:{FILE}")]) else { continue };
        assert!(text.starts_with(&before), "{commit} changes what was entered before");
        before = text;
    }
    assert!(LEDGER.starts_with(&before), "what was entered is changed: append instead");
}
