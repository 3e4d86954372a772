//! What tables and pages of foveated runs said that was not so.

use powergs_chart::Format;
use powergs_optimize::foveated::{LevelState, Method};
use powergs_optimize::results::Results;
use powergs_report::optimize::foveated::{Show, document, foveated_csv};

use crate::foveated_run::run;

/// A row of `foveated.csv`, by the names of its columns.
fn row(results: &Results, method: &str) -> std::collections::BTreeMap<String, String> {
    let text = foveated_csv(results);
    let mut reader = csv::Reader::from_reader(&text[..]);
    let names = reader.headers().unwrap().clone();
    let rows = reader.records().map(|record| {
        let record = record.unwrap();
        let cells: Vec<(String, String)> =
            names.iter().zip(&record).map(|(n, c)| (n.to_owned(), c.to_owned())).collect();
        cells.into_iter().collect::<std::collections::BTreeMap<_, _>>()
    });
    let mut rows = rows.collect::<Vec<_>>().into_iter();
    rows.find(|row| row["method"] == method).expect("a row of that method")
}

fn page(results: &Results) -> String {
    let show = Show { results, fits: Vec::new(), album: None };
    document(&show, &[]).markdown(Format::Png)
}

#[test]
fn the_filter_of_rtgs_d22_did_not_count_in_its_quality_and_it_passed_without_it() {
    let mut results = run();
    let d22 = row(&results, "RTGS+D22");
    assert_eq!((d22["test_psnr_db"].as_str(), d22["test_ssim"].as_str()), ("24.5", "0.79"));
    let plain = row(&results, "FR-Render");
    assert_ne!(plain["test_psnr_db"], d22["test_psnr_db"]);
    // Models that are shown filtered are held to no target.
    assert_eq!((plain["state_l1"].as_str(), d22["state_l1"].as_str()), ("passed", ""));
    assert!(page(&results).contains("held to none"));
    // Results of before have nothing in place of what is wrong.
    results.foveated.iter_mut().for_each(|f| f.filtered = None);
    assert_eq!(row(&results, "RTGS+D22")["test_psnr_db"], "");
}

#[test]
fn levels_that_could_not_be_pruned_passed_without_a_word() {
    let mut results = run();
    assert!(!page(&results).contains("got nowhere"));
    for f in &mut results.foveated {
        if f.method == Method::PowerGs && f.variant == "H" {
            f.gaussians = [3000, 2000, 2000, 2000];
            f.states[3] = LevelState::Passed;
        }
    }
    let text = page(&results).split_whitespace().collect::<Vec<_>>().join(" ");
    let says = "PowerGS-H: levels 3 and 4 keep all 2000 Gaussians of the level before";
    assert!(text.contains(says), "{text}");
    assert!(text.contains("FR-Render-H reaches 1000 and 1000"), "{text}");
}
