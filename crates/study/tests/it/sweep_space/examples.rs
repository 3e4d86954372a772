//! The sweeps that come with the program.

use std::sync::Arc;

use powergs_base::config::embedded::SWEEPS;
use powergs_core::run::files::EmbeddedFiles;
use powergs_study::sweep::file::{Method, Sampling};
use powergs_study::sweep::sample::select;
use powergs_study::sweep::{Rejected, Space, SweepFile};

fn spaces() -> impl Iterator<Item = (&'static str, SweepFile, Space)> {
    SWEEPS.iter().map(|sweep| {
        let file = SweepFile::parse(sweep.text).unwrap_or_else(|e| panic!("{}: {e}", sweep.name));
        let space = Space::new(&file, Arc::new(EmbeddedFiles));
        let space = space.unwrap_or_else(|e| panic!("{}: {e}", sweep.name));
        (sweep.name, file, space)
    })
}

#[test]
fn they_ask_a_question_and_have_a_moderate_size() {
    for (name, file, space) in spaces() {
        assert!(file.question.ends_with('?'), "{name}: {}", file.question);
        let n = space.proposed();
        assert!((100..=600).contains(&n), "{name} has {n} points");
    }
}

/// A few points of each are designs, so that a small run of it shows something.
#[test]
fn a_small_sample_of_each_is_mostly_designs() {
    for (name, _, space) in spaces() {
        let sampling = Sampling { method: Method::Sobol, points: Some(16), ..Sampling::default() };
        let mut designs = 0;
        for index in select(space.lattice(), &sampling) {
            match space.design(index) {
                Ok(_) => designs += 1,
                Err(Rejected::Duplicate { .. } | Rejected::Constraint { .. }) => {}
                Err(other) => panic!("{name}, point {index}: {other}"),
            }
        }
        assert!(designs >= 6, "{name}: {designs} designs of 16 points");
    }
}
