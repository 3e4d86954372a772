//! From arguments and the sweep file to a question.

use super::ParetoArgs;
use crate::cli::{Exit, Failure, OrExit};
use powergs_study::analysis::{Goal, Misses, Named, Objective, Question, Scope, SweepFacts};
use powergs_study::sweep::expr::Expr;
use toml::{Table, Value};

/// What the arguments ask, and where they say nothing, the sweep file.
pub(super) fn question(args: &ParetoArgs, facts: &SweepFacts) -> Result<Question, Failure> {
    let asked = facts.question();
    let given = objectives(&args.minimize, &args.maximize);
    let budget = args.budget.map(|watts| format!("power_w.mean <= {}", watts.0));
    let condition = match (&args.condition, budget) {
        (Some(given), Some(budget)) => {
            // What is wrong is said of what was written.
            Expr::parse(given).or_exit(Exit::Usage, "--where")?;
            Some(format!("({given}) && {budget}"))
        }
        (given, budget) => given.clone().or(budget),
    };
    let condition = condition.as_deref().map(Expr::parse).transpose();
    let condition = condition.or_exit(Exit::Usage, "--where")?;
    Ok(Question {
        objectives: if given.is_empty() { asked.objectives.clone() } else { given },
        condition,
        budget_w: args.budget.map(|watts| watts.0),
        scope: match args.scope.as_str() {
            "mean" => Scope::Mean,
            "worst" => Scope::Worst,
            label => Scope::Trace(label.to_owned()),
        },
        energy_table: args.energy_table.clone(),
        colour: args.colour.clone(),
        design: named(&args.design)?,
        top: usize::from(args.top),
        misses: if args.include_misses { Misses::Included } else { asked.misses },
        epsilon: args.epsilon.unwrap_or(asked.epsilon),
        ..asked
    })
}

/// A question as a file, so that the same question is known again.
pub(super) fn noted(question: &Question) -> String {
    let of = |goal: Goal| {
        let own = question.objectives.iter().filter(move |o| o.goal == goal);
        Value::from(own.map(|o| o.name.clone()).collect::<Vec<String>>())
    };
    let design = match &question.design {
        Named::Baseline => "baseline".to_owned(),
        Named::Point(point) => point.to_string(),
        Named::Id(id) => id.clone(),
    };
    let scope = match &question.scope {
        Scope::Mean => "mean",
        Scope::Worst => "worst",
        Scope::Trace(label) => label.as_str(),
    };
    let mut table = Table::new();
    let mut put = |key: &str, value: Value| drop(table.insert(key.to_owned(), value));
    put("minimize", of(Goal::Minimize));
    put("maximize", of(Goal::Maximize));
    question.condition.iter().for_each(|condition| put("where", condition.text().into()));
    question.budget_w.iter().for_each(|watts| put("budget-w", (*watts).into()));
    put("scope", scope.into());
    question.energy_table.iter().for_each(|label| put("energy-table", label.as_str().into()));
    question.colour.iter().for_each(|column| put("colour", column.as_str().into()));
    put("design", design.into());
    put("include-misses", (question.misses == Misses::Included).into());
    put("epsilon", question.epsilon.into());
    put("top", (question.top as i64).into());
    format!("# What this report answers.\n{table}")
}

/// The expressions of a list: commas within brackets or quotes belong to an expression.
fn items(list: &str) -> Vec<&str> {
    let (mut depth, mut quote) = (0_usize, None);
    let mut is_separator = |c: char| {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"' | '`') => quote = Some(c),
            (None, '(') => depth += 1,
            (None, ')') => depth = depth.saturating_sub(1),
            (None, _) => return c == ',' && depth == 0,
        }
        false
    };
    list.split(&mut is_separator).map(str::trim).filter(|item| !item.is_empty()).collect()
}

fn objectives(minimize: &[String], maximize: &[String]) -> Vec<Objective> {
    // Pieces between commas, some of which are within an expression.
    let (minimize, maximize) = (minimize.join(","), maximize.join(","));
    let minimize = items(&minimize).into_iter().map(Objective::minimize);
    minimize.chain(items(&maximize).into_iter().map(Objective::maximize)).collect()
}

/// Digits of a hash that name a design at least; fewer are the number of a point.
const DIGITS_MIN: usize = 6;

fn named(text: &str) -> Result<Named, Failure> {
    let plain = text.trim_start_matches('#');
    if plain == "baseline" {
        return Ok(Named::Baseline);
    }
    let hex = plain.len() >= DIGITS_MIN && plain.len() <= 32;
    let hex = hex && plain.chars().all(|c| c.is_ascii_hexdigit());
    match plain.parse() {
        // A whole hash may have decimal digits only; no space has that many points.
        Ok(point) if plain.len() < 16 => Ok(Named::Point(point)),
        _ if hex => Ok(Named::Id(plain.to_lowercase())),
        _ => {
            let what = format!(
                "--design {text}: name a point (12), at least {DIGITS_MIN} digits of an id, or \
                 baseline"
            );
            Err(Failure::new(Exit::Usage, what))
        }
    }
}
