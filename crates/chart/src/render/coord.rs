//! Axes as plotters knows them.

use std::ops::Range;

use plotters::coord::combinators::{IntoLogRange, LogCoord};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;

use crate::{Axis, Scale};

/// An axis of a panel with the ticks that have room.
pub(crate) struct Coord {
    inner: Inner,
    /// Its values, ascending.
    range: Range<f64>,
    /// Ticks with their labels; empty ones have no room.
    pub labels: Vec<(f64, String)>,
}

enum Inner {
    Linear(RangedCoordf64),
    Log(LogCoord<f64>),
}

impl Coord {
    /// For an axis that goes across the page, or up it.
    pub(crate) fn new(axis: &Axis, upright: bool) -> Coord {
        let range = axis.scale.low()..axis.scale.high();
        let inner = match &axis.scale {
            Scale::Linear { low, high } => Inner::Linear((*low..*high).into()),
            Scale::Log { low, high } => Inner::Log((*low..*high).log_scale().into()),
            // The first name is at the top.
            Scale::Names(_) if upright => Inner::Linear((range.end..0.0).into()),
            Scale::Names(_) => Inner::Linear((0.0..range.end).into()),
        };
        let names = matches!(axis.scale, Scale::Names(_));
        let labels = if axis.shown && !names { axis.labels() } else { Vec::new() };
        Coord { inner, range, labels }
    }
}

impl Ranged for Coord {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        // What is off the axis is drawn at its end.
        let value = if value.is_nan() { self.range.start } else { *value };
        let value = value.clamp(self.range.start, self.range.end);
        match &self.inner {
            Inner::Linear(inner) => inner.map(&value, limit),
            Inner::Log(inner) => inner.map(&value, limit),
        }
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            return Vec::new();
        }
        self.labels.iter().map(|l| l.0).collect()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Coord {
    fn format_ext(&self, value: &f64) -> String {
        self.labels.iter().find(|l| l.0 == *value).map_or(String::new(), |l| l.1.clone())
    }
}
