//! Published claims on made-up results: those that hold, those that do not, those that cannot be
//! said.

use powergs_chart::Format;
use powergs_lab::claims::page::{document, json, words};
use powergs_lab::claims::{ClaimTable, Number, Run, Tally, Unit, Verdict, check};
use powergs_optimize::fit::OptimumPlace;
use powergs_optimize::foveated::{LevelState, Method};
use powergs_optimize::results::{ModelRecord, Results};
use powergs_optimize::role::Baseline;

use crate::foveated_run::run;

fn labelled(label: &str, results: Results) -> Run {
    Run { label: label.into(), results }
}

/// What a run says alone.
fn alone(results: &Results) -> ClaimTable {
    check(&[labelled("one", results.clone())])
}

#[track_caller]
fn verdict(book: &ClaimTable, id: &str) -> (Verdict, String) {
    let row = book.rows.iter().find(|r| r.id == id).unwrap_or_else(|| panic!("no claim {id}"));
    (row.verdict, words(&row.findings[0].here))
}

/// A change of the run makes the claim fail, and the text has the number.
#[track_caller]
fn fails(id: &str, text: &str, change: impl Fn(&mut Results)) {
    let mut results = run();
    assert_eq!(verdict(&alone(&results), id).0, Verdict::Yes, "{id} must hold before");
    change(&mut results);
    let (verdict, here) = verdict(&alone(&results), id);
    assert_eq!(verdict, Verdict::No, "{id}: {here}");
    assert!(here.contains(text), "{id}: {here}");
}

#[test]
fn the_published_powers_agree_with_every_claim_that_one_run_can_check() {
    let book = alone(&run());
    for row in &book.rows {
        let expected = match row.id {
            "5" | "9" => Verdict::Unchecked,
            _ => Verdict::Yes,
        };
        assert_eq!(row.verdict, expected, "{}: {:?}", row.id, row.findings);
    }
    let ids: Vec<&str> = book.rows.iter().map(|r| r.id).collect();
    let order = [
        "1", "2", "3", "4a", "4b", "4c", "5", "9", "11", "12", "15a", "15b", "16", "17", "19a",
        "19b", "19c", "20a", "20b", "21a", "21b", "21c", "21d", "23", "24", "25", "26", "27a",
        "27b", "28a", "28b", "29",
    ];
    assert_eq!(ids, order);
    assert_eq!(book.agreed(0), (30, 30));
}

#[test]
fn claims_fail_with_their_numbers() {
    let ours = |r: &mut Results, change: &dyn Fn(&mut f64, &mut f64)| {
        for f in r.foveated.iter_mut().filter(|f| f.method == Method::PowerGs) {
            change(&mut f.display_w, &mut f.render_w);
        }
    };
    fails("1", "2.0 % more", |r| ours(r, &|d, _| *d = 0.8896 + 0.02));
    fails("2", "% less", |r| ours(r, &|d, _| *d = 0.8));
    fails("15a", "more", |r| ours(r, &|d, _| *d += 0.3));
    fails("20a", "HVSQ 5.00 against 2.10 e-5", |r| ours(r, &|_, w| *w += 0.1));
    fails("28a", "Gaussians in level 1", |r| ours(r, &|_, w| *w = 0.2));
    fails("28b", "W", |r| ours(r, &|d, _| *d = 0.3));
    fails("12", "times", |r| ours(r, &|d, _| *d = 0.6));
    fails("19a", "at 2.66", |r| ours(r, &|d, _| *d = 0.4));
    fails("20b", "70 against 78 FPS", |r| r.foveated[0].fps = Some(70.0));
    fails("21b", "9.00, none e-5; level 1 2.10", |r| {
        r.models.iter_mut().find(|m| m.name == "level3-optimum").unwrap().test.hvsq = Some(9e-5);
    });
    fails("21c", "level 1 2.10", |r| r.foveated[0].hvsq[2] = Some(9e-5));
    fails("21d", "R3: 9.00 against 5.00", |r| r.foveated[0].hvsq[2] = Some(9e-5));
    fails("21a", "without", |r| r.foveated[3].hvsq[1] = Some(1e-5));
    fails("27a", "-50.0, +0.6, -6.2 %", |r| r.mean_change.as_mut().unwrap().level_1[0] = -50.0);
    fails("27a", "+3.00", |r| r.mean_change.as_mut().unwrap().level_1[2] = 3.0);
    fails("3", "0.2000", |r| r.fits[0].mre_render = Some(0.2));
    fails("4c", "most pruned", |r| r.fits[0].optimum_place = Some(OptimumPlace::MostPruned));
    fails("4c", "of 0.00 to 0.80", |r| r.fits[0].optimum_rho = Some(0.79));
    fails("24", "more", |r| {
        r.models.iter_mut().find(|m| m.name == "optimum").unwrap().render_w = 0.5;
    });
    fails("17", "not beaten: lightgs-66", |r| {
        r.models.iter_mut().find(|m| m.name == "lightgs-66").unwrap().test.psnr_db = Some(40.0);
    });
    fails("25", "2 of 3", |r| {
        r.models.iter_mut().find(|m| m.sweep_lambda == Some(0.2)).unwrap().test.psnr_db =
            Some(30.0);
    });
    for off in [2.0, -0.3] {
        fails("26", "4 of 5", |r| {
            (r.models[1].steered_db, r.models[1].iterations) = (Some(off), 1000);
        });
    }
    fails("4a", "R²", |r| r.models[2].render_w = 0.2);
    fails("4b", "-", |r| r.models[1].display_w = 0.5);
    fails("23", "W", |r| r.models[0].render_w = 0.01);
}

#[test]
fn a_sample_that_was_cut_off_says_nothing_about_lambda() {
    let mut results = run();
    (results.models[1].steered_db, results.models[1].iterations) = (Some(2.0), 999);
    let (cut_off, here) = verdict(&alone(&results), "26");
    assert_eq!(cut_off, Verdict::Unchecked, "{here}");
    assert!(here.contains("1 sample ended off the target"), "{here}");
    // The rendering end has no λ, and may be far above the target.
    results.models[1].steered_db = None;
    assert_eq!(verdict(&alone(&results), "26").0, Verdict::Yes);
    results.models.iter_mut().for_each(|m| m.steered_db = None);
    let (priced, here) = verdict(&alone(&results), "26");
    assert_eq!(priced, Verdict::Unchecked, "{here}");
    assert!(here.contains("priced anew"), "{here}");
}

#[test]
fn a_failing_claim_names_levels_that_fell_back() {
    let mut results = run();
    results.foveated[0].states[2] = LevelState::Fallback;
    results.foveated[0].hvsq[2] = Some(9e-5);
    let (_, here) = verdict(&alone(&results), "21d");
    assert!(here.contains("L3 of PowerGS-H missed the target"), "{here}");
}

#[test]
fn scenes_are_counted_for_each_ratio() {
    // Claim 24: at 0.38 two scenes of three agree, one of them with two runs; at 2.66 none of one.
    let one = |scene: &str, ratio: f64, holds: bool| {
        let mut results = run();
        results.scene = scene.into();
        (results.display_to_render, results.display_scale) = (Some(ratio + 0.0004), 2.0);
        if !holds {
            let render = |m: &&mut ModelRecord| m.baseline == Some(Baseline::RenderOnly);
            results.models.iter_mut().filter(render).for_each(|m| m.render_w = 1e-3);
        }
        Run { label: format!("{scene}-{ratio}-{holds}"), results }
    };
    let runs = [
        one("c", 2.66, false),
        one("a", 0.38, true),
        one("b", 0.38, true),
        one("b", 0.38, true),
        one("c", 0.38, false),
    ];
    let book = check(&runs);
    assert_eq!(book.ratios, [Some(0.38), Some(2.66)]);
    let row = book.rows.iter().find(|row| row.id == "24").unwrap();
    let tally = |i: usize| {
        let Tally { ratio, agree, checked, verdict } = row.tallies[i];
        (ratio, agree, checked, verdict)
    };
    assert_eq!(tally(0), (Some(0.38), 2, 3, Verdict::Yes));
    assert_eq!(tally(1), (Some(2.66), 0, 1, Verdict::No));
    assert_eq!(row.verdict, Verdict::No, "two of four are not most");
    let page = document(&book).markdown(Format::Png);
    assert!(page.contains("At a display-to-render ratio of 0.38 "), "{page}");
    assert!(page.contains("**2 of 3** | 0 of 1"), "{page}");
    assert!(page.contains("c-2.66-false"), "{page}");
    // Half of the scenes are not most of them; in a claim of the best case one is enough.
    let half = check(&[one("a", 0.38, true), one("b", 0.38, false)]);
    let verdict = |id: &str| half.rows.iter().find(|row| row.id == id).unwrap().verdict;
    assert_eq!((verdict("24"), verdict("1")), (Verdict::No, Verdict::Yes));
}

#[test]
fn what_is_missing_is_said_with_the_flag_that_makes_it() {
    let mut plain = run();
    plain.screen = None;
    plain.foveated.clear();
    plain.mean_change.as_mut().unwrap().regions = None;
    let book = alone(&plain);
    for id in ["1", "2", "11", "12", "15a", "16", "17", "20a", "21b", "27b", "28a"] {
        let (verdict, here) = verdict(&book, id);
        assert_eq!(verdict, Verdict::Unchecked, "{id}");
        assert!(here.contains("--foveated"), "{id}: {here}");
    }
    assert_eq!(verdict(&book, "23").0, Verdict::Yes);
    assert!(book.runs[0].1.contains("--foveated"), "{}", book.runs[0].1);
    let mut lonely = run();
    lonely.foveated.retain(|f| f.method == Method::PowerGs);
    lonely.models.retain(|m| m.baseline.is_none() && m.sweep_lambda.is_none());
    let book = alone(&lonely);
    for (id, flag) in [("15a", "--baselines"), ("20a", "--baselines"), ("25", "--study lambda")] {
        let (verdict, here) = verdict(&book, id);
        assert_eq!(verdict, Verdict::Unchecked, "{id}");
        assert!(here.contains(flag), "{id}: {here}");
    }
    assert!(book.runs[0].1.contains("--baselines"), "{}", book.runs[0].1);
    assert_eq!(verdict(&book, "2").0, Verdict::Yes);
}

#[test]
fn a_run_whose_jobs_were_not_done_is_not_checkable_and_no_panic() {
    let mut empty = run();
    empty.models.clear();
    empty.fits.clear();
    empty.foveated.clear();
    empty.mean_change = None;
    let book = alone(&empty);
    assert_eq!(book.agreed(0), (0, 0));
    // No power at all.
    let mut dark = run();
    for m in &mut dark.models {
        (m.display_w, m.render_w) = (0.0, 0.0);
    }
    for f in &mut dark.foveated {
        (f.display_w, f.render_w) = (0.0, 0.0);
    }
    let text = document(&alone(&dark)).terminal(80);
    assert!(!text.contains("inf") && !text.contains("NaN"), "{text}");
}

#[test]
fn runs_are_put_together_by_the_rule_of_the_claim() {
    let (good, mut bad) = (run(), run());
    bad.scene = "toy".into();
    bad.fits[0].optimum_place = Some(OptimumPlace::MostPruned);
    bad.fits[0].mre_display = Some(0.5);
    bad.models[0].gaussians = 100;
    bad.models[0].render_w = 0.2;
    let book = check(&[labelled("a", good), labelled("b", bad)]);
    // One scene is enough for the minimum; the fits must all be good.
    assert_eq!(verdict(&book, "4c").0, Verdict::Yes);
    assert_eq!(verdict(&book, "3").0, Verdict::No);
    let (nine, here) = verdict(&book, "9");
    assert_eq!(nine, Verdict::Yes);
    assert!(here.contains("3.5 : 1"), "{here}");
}

#[test]
fn twelve_samples_are_compared_with_five_of_the_same_scene() {
    let (few, mut many) = (run(), run());
    for i in 0..7 {
        let mut sample = many.models[1].clone();
        sample.name = format!("sample-1{i}");
        many.models.push(sample);
    }
    many.fits[0].optimum_rho = Some(0.69);
    let pair = |many: &Results| check(&[labelled("a", few.clone()), labelled("b", many.clone())]);
    assert_eq!(verdict(&pair(&many), "5").0, Verdict::Yes);
    // One without an optimum is not the one to compare.
    let mut none = few.clone();
    none.fits[0].optimum_rho = None;
    let runs = [labelled("0", none), labelled("a", few.clone()), labelled("b", many.clone())];
    assert_eq!(verdict(&check(&runs), "5").0, Verdict::Yes);
    many.fits[0].optimum_rho = Some(0.4);
    let (no, here) = verdict(&pair(&many), "5");
    assert_eq!(no, Verdict::No, "{here}");
    assert!(here.contains("0.620 of 5") && here.contains("0.400 of 12"), "{here}");
    many.scene = "another".into();
    assert_eq!(verdict(&pair(&many), "5").0, Verdict::Unchecked);
}

#[test]
fn the_answer_fits_a_terminal_and_says_what_cannot_be_simulated() {
    let book = check(&[labelled("snow-fr", run()), labelled("a-very-long-name-of-a-run", run())]);
    let text = document(&book).terminal(80);
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    assert!(text.contains("30 of 30 claims agree on most scenes, 2"), "{text}");
    assert!(text.contains("R1, R2, R3; no view shows R4"), "{text}");
    assert!(text.contains("nobody sees a difference"), "{text}");
    let page = document(&book).markdown(Format::Png);
    assert_eq!(page.matches("\n| 21a |").count(), 1 + 2, "a claim, and what each run says of it");
    let value = json(&book);
    assert_eq!(value["by_display_ratio"][0]["agree"], 30);
    assert_eq!(value["claims"].as_array().unwrap().len(), 32);
    assert!(value["claims"][6]["agrees"].is_null());
}

#[test]
fn findings_have_their_numbers_as_numbers() {
    let book = alone(&run());
    let finding = |id: &str| &book.rows.iter().find(|r| r.id == id).unwrap().findings[0].here;
    let numbers = |id: &str| finding(id).numbers().collect::<Vec<Number>>();
    let [saved] = numbers("1")[..] else { panic!("{:?}", finding("1")) };
    assert_eq!(saved.unit, Unit::Saved);
    assert_eq!(words(finding("1")), format!("{:.1} % less (PowerGS-L)", 100.0 * saved.value));
    let powers: Vec<f64> = numbers("23").iter().map(|n| n.value).collect();
    assert_eq!(powers.len(), 4);
    assert!((powers[0] - 0.98).abs() < 1e-12 && numbers("23")[0].unit == Unit::Watts);
}
