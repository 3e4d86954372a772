//! The published claims, checked on finished runs: each with the published number, ours, and
//! whether sign and order agree. What a claim expects of a small scene is fixed here, before
//! anything is measured; a claim that does not hold is shown with its numbers.
//!
//! Source: `powergs`; the numbering is ours and follows the paper from its abstract to its project
//! page.

mod colours;
pub mod command;
mod curves;
mod facts;
mod fovea;
pub mod page;
mod pairs;
mod periphery;
mod plain;
mod sentence;

pub use sentence::{Number, Part, Sentence, Unit};

use std::collections::BTreeMap;

use powergs_optimize::results::Results;

/// A finished run.
#[derive(Debug, Clone)]
pub struct Run {
    /// What it is called in the answer.
    pub label: String,
    /// What it found.
    pub results: Results,
}

/// What a run says about a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

/// How the verdicts of scenes become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// More than half of the scenes that can be checked agree.
    Most,
    /// One scene that agrees is enough: claims of the best case.
    Any,
}

impl Rule {
    fn verdict(self, agree: usize, checked: usize) -> Verdict {
        let holds = match self {
            Rule::Most => 2 * agree > checked,
            Rule::Any => agree > 0,
        };
        match checked {
            0 => Verdict::Unchecked,
            _ if holds => Verdict::Yes,
            _ => Verdict::No,
        }
    }
}

/// Who is asked.
#[derive(Clone, Copy)]
enum Asks {
    /// Each run.
    Each(fn(&Results) -> Answer),
    /// All of one ratio together.
    Together(fn(&[&Run]) -> Answer),
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

/// What one run, or all of one ratio together, say about a claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The run; `None` for all together.
    pub run: Option<String>,
    /// The ratio that the run has, as in [`Tally::ratio`].
    pub ratio: Option<f64>,
    /// Our numbers, or why there are none.
    pub here: Sentence,
    /// Whether sign and order agree.
    pub verdict: Verdict,
}

/// How many scenes of one ratio agree with a claim. A scene agrees if all of its runs do that can
/// be checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tally {
    /// Display power over rendering power of the dense model, as it was asked for; `None` for runs
    /// with the panel as it is.
    pub ratio: Option<f64>,
    /// Scenes that agree.
    pub agree: usize,
    /// Scenes that could be checked.
    pub checked: usize,
    /// All of them together.
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
    /// What the runs say, by ratio.
    pub findings: Vec<Finding>,
    /// The scenes of each ratio, as in [`ClaimTable::ratios`].
    pub tallies: Vec<Tally>,
    /// The scenes of all ratios together.
    pub verdict: Verdict,
}

/// All claims.
#[derive(Debug, Clone, PartialEq)]
pub struct ClaimTable {
    /// A line about each run: its name, what it is and which regions count.
    pub runs: Vec<(String, String)>,
    /// The ratios of the runs, ascending, then those that are as they are ([`Tally::ratio`]).
    pub ratios: Vec<Option<f64>>,
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

/// The runs of one ratio.
struct Group<'a> {
    ratio: Option<f64>,
    runs: Vec<&'a Run>,
}

/// What was asked for with `--display-ratio`, in hundredths; `None` for a panel as it is.
fn ratio_of(r: &Results) -> Option<f64> {
    let ratio = r.display_to_render.filter(|_| r.display_scale != 1.0)?;
    Some((100.0 * ratio).round() / 100.0)
}

/// Runs by ratio, ascending; those with the panel as it is last.
fn groups(runs: &[Run]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for run in runs {
        let ratio = ratio_of(&run.results);
        match groups.iter_mut().find(|group| group.ratio == ratio) {
            Some(group) => group.runs.push(run),
            None => groups.push(Group { ratio, runs: vec![run] }),
        }
    }
    let key = |group: &Group<'_>| group.ratio.unwrap_or(f64::INFINITY);
    groups.sort_by(|a, b| key(a).total_cmp(&key(b)));
    groups
}

/// Checks everything.
pub fn check(runs: &[Run]) -> ClaimTable {
    let groups = groups(runs);
    let lines = runs.iter().map(|run| (run.label.clone(), facts::about(&run.results)));
    ClaimTable {
        runs: lines.collect(),
        ratios: groups.iter().map(|group| group.ratio).collect(),
        rows: checks().into_iter().map(|c| row(c, &groups)).collect(),
    }
}

fn row(check: &Check, groups: &[Group<'_>]) -> Row {
    let (mut findings, mut tallies) = (Vec::new(), Vec::new());
    for group in groups {
        // Which scene each finding is of; one for all runs together.
        let found: Vec<(&str, Finding)> = match check.asks {
            Asks::Each(ask) => {
                let of = |run: &Run| finding(Some(&run.label), group.ratio, ask(&run.results));
                group.runs.iter().map(|run| (run.results.scene.as_str(), of(run))).collect()
            }
            Asks::Together(ask) => vec![("", finding(None, group.ratio, ask(&group.runs)))],
        };
        let mut scenes: BTreeMap<&str, bool> = BTreeMap::new();
        for (scene, finding) in &found {
            if finding.verdict != Verdict::Unchecked {
                *scenes.entry(scene).or_insert(true) &= finding.verdict == Verdict::Yes;
            }
        }
        let (agree, checked) = (scenes.values().filter(|&&agrees| agrees).count(), scenes.len());
        let verdict = check.rule.verdict(agree, checked);
        tallies.push(Tally { ratio: group.ratio, agree, checked, verdict });
        findings.extend(found.into_iter().map(|(_, finding)| finding));
    }
    let sum = |of: fn(&Tally) -> usize| tallies.iter().map(of).sum();
    let verdict = check.rule.verdict(sum(|t| t.agree), sum(|t| t.checked));
    let Check { id, what, published, expects, .. } = *check;
    Row { id, what, published, expects, findings, tallies, verdict }
}

fn finding(run: Option<&String>, ratio: Option<f64>, answer: Answer) -> Finding {
    let run = run.cloned();
    match answer {
        Ok(Here { text, holds, why }) => {
            let verdict = if holds { Verdict::Yes } else { Verdict::No };
            let here = match why.filter(|_| !holds) {
                Some(why) => text.then("; ", why),
                None => text,
            };
            Finding { run, ratio, here, verdict }
        }
        Err(why) => Finding { run, ratio, here: why.into(), verdict: Verdict::Unchecked },
    }
}

impl ClaimTable {
    /// Claims that agree on most scenes, and those that could be checked, with the runs of the
    /// ratio at a position of [`ClaimTable::ratios`].
    pub fn agreed(&self, ratio: usize) -> (usize, usize) {
        let verdicts = || self.rows.iter().filter_map(|row| Some(row.tallies.get(ratio)?.verdict));
        let count = |verdict: Verdict| verdicts().filter(|v| *v == verdict).count();
        let yes = count(Verdict::Yes);
        (yes, yes + count(Verdict::No))
    }
}
