//! The published claims, checked on finished runs: each with the published number, ours, and
//! whether sign and order agree. What a claim expects of a small scene is fixed here, before
//! anything is measured; a claim that does not hold is shown with its numbers.
//!
//! Source: `powergs`; the numbering is ours and follows the paper from its abstract to its project
//! page.

mod colours;
mod curves;
mod facts;
mod fovea;
mod pairs;
mod periphery;
mod plain;
mod sentence;

pub use sentence::{Number, Part, Sentence, Unit};

use super::results::Results;

/// A finished run.
#[derive(Debug, Clone)]
pub struct Run {
    /// What it is called in the answer.
    pub label: String,
    /// What it found.
    pub results: Results,
}

/// What a run says about a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Sign and order agree.
    Yes,
    /// They do not.
    No,
    /// It cannot be said.
    Unchecked,
}

impl Verdict {
    /// The name in every output.
    pub const fn name(&self) -> &'static str {
        match self {
            Verdict::Yes => "yes",
            Verdict::No => "no",
            Verdict::Unchecked => "not checkable",
        }
    }
}

/// Our number for a claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Here {
    /// The numbers.
    text: Sentence,
    /// Whether sign and order agree.
    holds: bool,
    /// Why not, where it follows from the results.
    why: Option<Sentence>,
}

/// Numbers, or why there are none.
type Answer = Result<Here, String>;

fn here(text: Sentence, holds: bool) -> Answer {
    Ok(Here { text, holds, why: None })
}

/// How the verdicts of runs become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// Every run that can be checked agrees.
    All,
    /// One run that agrees is enough: claims of the best case.
    Any,
}

/// Who is asked.
#[derive(Clone, Copy)]
enum Asks {
    /// Each run.
    Each(fn(&Results) -> Answer),
    /// All together.
    Together(fn(&[Run]) -> Answer),
}

/// A claim and how it is checked.
struct Check {
    id: &'static str,
    what: &'static str,
    published: &'static str,
    expects: &'static str,
    rule: Rule,
    asks: Asks,
}

/// What one run, or all together, say about a claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The run; `None` for all together.
    pub run: Option<String>,
    /// Our numbers, or why there are none.
    pub here: Sentence,
    /// Whether sign and order agree.
    pub verdict: Verdict,
}

/// A claim with everything that is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its number; letters tell parts apart.
    pub id: &'static str,
    /// What is claimed.
    pub what: &'static str,
    /// The published number.
    pub published: &'static str,
    /// What sign and order would have to be here.
    pub expects: &'static str,
    /// What the runs say.
    pub findings: Vec<Finding>,
    /// All of them together.
    pub verdict: Verdict,
}

/// All claims.
#[derive(Debug, Clone, PartialEq)]
pub struct ClaimTable {
    /// A line about each run: its name, what it is and which regions count.
    pub runs: Vec<(String, String)>,
    /// Those that can be checked with the right runs.
    pub rows: Vec<Row>,
}

/// Claims that no run of this program can check: number, what, why.
pub const LEFT_OUT: [(&str, &str, &str); 8] = [
    ("6", "a learned proxy model is next to useless", "not published: no data"),
    ("7", "0.3 W for the display and 1 W for rendering are budgets of AR", "context: cited"),
    ("8", "0.53 pJ a FLOP, 0.24 and 10.88 pJ a byte, 60 FPS", "constants: the table `paper`"),
    ("10", "2.5 hours of optimisation, once", "hardware: a desktop GPU"),
    ("13", "nobody sees a difference from FR-Render and FR-Display", "people: a study with 9"),
    ("14", "fewer artifacts than LightGaussian", "people: a study with 9"),
    ("18", "13.7x less rendering power on a mobile GPU", "hardware: a mobile GPU"),
    ("22", "the filter costs 10 % of the time, our training 60 % more", "hardware: a mobile GPU"),
];

/// All checks, by number.
fn checks() -> Vec<&'static Check> {
    let groups = [
        curves::CHECKS,
        fovea::CHECKS,
        periphery::CHECKS,
        plain::CHECKS,
        colours::CHECKS,
        pairs::CHECKS,
    ];
    let mut all: Vec<&Check> = groups.into_iter().flatten().collect();
    let number = |id: &str| {
        let digits = id.trim_end_matches(|c: char| c.is_ascii_lowercase());
        (digits.parse::<u32>().unwrap_or(u32::MAX), id.to_owned())
    };
    all.sort_by_key(|check| number(check.id));
    all
}

/// Checks everything.
pub fn check(runs: &[Run]) -> ClaimTable {
    let lines = runs.iter().map(|run| (run.label.clone(), facts::about(&run.results)));
    ClaimTable { runs: lines.collect(), rows: checks().into_iter().map(|c| row(c, runs)).collect() }
}

fn row(check: &Check, runs: &[Run]) -> Row {
    let findings: Vec<Finding> = match check.asks {
        Asks::Each(ask) => {
            let of = |run: &Run| finding(Some(run.label.clone()), ask(&run.results));
            runs.iter().map(of).collect()
        }
        Asks::Together(ask) => vec![finding(None, ask(runs))],
    };
    let count = |verdict: Verdict| findings.iter().filter(|f| f.verdict == verdict).count();
    let (yes, no) = (count(Verdict::Yes), count(Verdict::No));
    let verdict = match (yes, no, check.rule) {
        (0, 0, _) => Verdict::Unchecked,
        (_, 0, _) => Verdict::Yes,
        (1.., _, Rule::Any) => Verdict::Yes,
        (_, _, Rule::All | Rule::Any) => Verdict::No,
    };
    let Check { id, what, published, expects, .. } = *check;
    Row { id, what, published, expects, findings, verdict }
}

fn finding(run: Option<String>, answer: Answer) -> Finding {
    match answer {
        Ok(Here { text, holds, why }) => {
            let verdict = if holds { Verdict::Yes } else { Verdict::No };
            let here = match why.filter(|_| !holds) {
                Some(why) => text.then("; ", why),
                None => text,
            };
            Finding { run, here, verdict }
        }
        Err(why) => Finding { run, here: why.into(), verdict: Verdict::Unchecked },
    }
}

impl ClaimTable {
    /// Claims that agree, and those that could be checked.
    pub fn agreed(&self) -> (usize, usize) {
        let count = |verdict: Verdict| self.rows.iter().filter(|r| r.verdict == verdict).count();
        let yes = count(Verdict::Yes);
        (yes, yes + count(Verdict::No))
    }
}
