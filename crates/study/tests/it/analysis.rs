//! Pareto fronts, knees, marginal values and the stability of rankings.

mod conditions;
mod confirmation;
mod front;
mod stability;
mod support;
mod table;
mod whole;
