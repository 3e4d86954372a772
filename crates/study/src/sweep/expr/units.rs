//! Numbers with a unit beside statistics, which say their unit in their name.
//!
//! In `energy_pj.mean <= 2 mJ` the literal is converted to picojoules, the unit of the name; a
//! literal that has no such unit is an error.

use super::{ExprError, Function, Node, What, visit};
use crate::sweep::measure::Measure;
use crate::sweep::unit::Unit;

/// The measure of a column, and how many of its unit are in one of [`Measure`].
fn of_name(name: &str) -> Option<(Measure, f64)> {
    Unit::of_column(name)?.measure()
}

/// Brings numbers with units to the units of the names beside them. A chain of operators is as deep
/// as it is long, so nothing here calls itself.
pub(super) fn fit(text: &str, root: &mut Node) -> Result<(), ExprError> {
    let mut open = vec![root];
    while let Some(node) = open.pop() {
        match &mut node.what {
            What::Value(_) | What::Measured(..) | What::Name(_) => {}
            What::Not(inner) | What::Minus(inner) => open.push(inner),
            What::Call(_, arguments) => open.extend(arguments.iter_mut().rev()),
            What::Two(two, sides) => {
                if two.compares() {
                    let [left, right] = sides.as_mut();
                    convert(text, left, right)?;
                    convert(text, right, left)?;
                    mixed(text, left, right)?;
                }
                open.extend(sides.iter_mut().rev());
            }
        }
    }
    Ok(())
}

fn convert(text: &str, name: &Node, literal: &mut Node) -> Result<(), ExprError> {
    let name = match &name.what {
        // A mean has the unit of its values.
        What::Call(Function::Mean, arguments) => &arguments[0],
        _ => name,
    };
    let What::Name(name) = &name.what else { return Ok(()) };
    let (Some((measure, per_base)), What::Measured(number, has)) = (of_name(name), &literal.what)
    else {
        return Ok(());
    };
    if measure != *has {
        let message = format!("`{name}` is {}, and this is {}", measure.name(), has.name());
        return Err(ExprError::new(text, &literal.span, message));
    }
    literal.what = What::Value(super::Value::Number(number * per_base));
    Ok(())
}

/// A unit on one side and a statistic somewhere in the same comparison.
fn mixed(text: &str, left: &Node, right: &Node) -> Result<(), ExprError> {
    let (mut statistic, mut literal) = (None, None);
    for side in [left, right] {
        visit(side, &mut |node| match &node.what {
            What::Name(name) if of_name(name).is_some() => statistic = Some(name.clone()),
            What::Measured(..) => literal = Some(node.span.clone()),
            _ => {}
        });
    }
    let (Some(statistic), Some(span)) = (statistic, literal) else { return Ok(()) };
    let message = format!(
        "`{statistic}` has its unit in its name and counts in it: compare it alone, or write this \
         number in that unit, without one"
    );
    Err(ExprError::new(text, &span, message))
}
