//! The numbers of a run. Each is declared once, in [`SETTINGS`]: flags of the command line,
//! keywords of Python and lines of `run.toml` are made from that.

use std::fmt;

use serde::Serialize;

use super::invalid::{Invalid, in_range};
use super::lambda::LambdaRule;
use super::schedule::Schedule;

/// Weights of the display term, without unit.
const WEIGHT: Kind = Kind::Real(1e-6, 1e6);
/// Iterations.
const COUNT: Kind = Kind::Count(1, 10_000_000);

/// Which views decide whether a model passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Gate {
    /// Views held out of training for this.
    Validation,
    /// The test views, as the published code does: what it reports it has also selected on.
    Test,
}

impl Choice for Gate {
    const ALL: &'static [(Gate, &'static str, &'static str)] = &[
        (Gate::Validation, "validation", "Views taken from the training views for this"),
        (Gate::Test, "test", "The test views: what is reported was also selected on"),
    ];
}

/// At which size views gate and test, where power is counted at another one than models train at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum GateSize {
    /// That of the power: a model is as good as it is said to be where its watts are counted.
    Priced,
    /// That of the training.
    Trained,
}

impl Choice for GateSize {
    const ALL: &'static [(GateSize, &'static str, &'static str)] = &[
        (
            GateSize::Priced,
            "priced",
            "That of the power: watts and decibels are of the same images",
        ),
        (
            GateSize::Trained,
            "trained",
            "That of the training, where looks are cheaper: it says little of the size that is \
             shown",
        ),
    ];
}

/// How what there is above the target is spent on the display.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Dimming {
    /// By gains of the colour channels, when a model is trained.
    Gains,
    /// By a display term in the loss, whose λ follows this rule.
    Term(LambdaRule),
}

impl Choice for Dimming {
    const ALL: &'static [(Dimming, &'static str, &'static str)] = &[
        (Dimming::Gains, "gains", "Colour channels are scaled once a model is trained"),
        (
            Dimming::Term(LambdaRule::Damped),
            "damped",
            "By a display term, lambda by the slack that there is, with an eye on the trend",
        ),
        (
            Dimming::Term(LambdaRule::Published),
            "published",
            "By a display term, lambda in full steps as the published code; begin with --lambda \
             0.01",
        ),
    ];
}

impl Dimming {
    /// The rule of λ of a fine-tune that has a display term whatever this says.
    pub fn rule(self) -> LambdaRule {
        match self {
            Dimming::Gains => LambdaRule::Damped,
            Dimming::Term(rule) => rule,
        }
    }
}

/// What a setting can say.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// A whole number from the first to the second.
    Count(u64, u64),
    /// A number from the first to the second.
    Real(f64, f64),
    /// One of these names, each with what it means.
    Name(fn() -> Vec<(&'static str, &'static str)>),
}

/// What a setting says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// A whole number.
    Count(u64),
    /// A number.
    Real(f64),
    /// A name.
    Name(&'static str),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Count(n) => n.fmt(f),
            Value::Real(x) => x.fmt(f),
            Value::Name(name) => name.fmt(f),
        }
    }
}

/// What else is to be known of a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// The short help has it too.
    Common,
    /// Help lists it before others of its part.
    First,
    /// It follows from others where it is not given.
    Follows,
    /// It changes no number of a run.
    Harmless,
}

/// A field of [`Settings`], as it is declared.
#[derive(Debug)]
pub struct Setting {
    /// Its name in [`Settings`] and in Python.
    pub key: &'static str,
    /// What its field says about it, line by line; after an empty line, what only readers of the
    /// library need.
    text: &'static [&'static str],
    /// The part of a run that it belongs to, a heading of help.
    pub part: &'static str,
    /// Its flag without dashes, and its key in `run.toml`.
    pub flag: &'static str,
    /// What stands for its value in help.
    pub value_name: &'static str,
    /// What it can say.
    pub kind: Kind,
    marks: &'static [Mark],
    get: fn(&Settings) -> Value,
    set: fn(&mut Settings, Value) -> Option<()>,
}

impl Setting {
    /// Whether it has a mark.
    pub fn is(&self, mark: Mark) -> bool {
        self.marks.contains(&mark)
    }

    /// What help says about it.
    pub fn help(&self) -> String {
        let lines = self.text.iter().map(|line| line.trim());
        lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
    }

    /// What it says in `settings`.
    pub fn of(&self, settings: &Settings) -> Value {
        (self.get)(settings)
    }

    /// The value of this name.
    ///
    /// # Errors
    /// [`Invalid::Kind`]: there is none.
    pub fn named(&self, name: &str) -> Result<Value, Invalid> {
        let names = if let Kind::Name(names) = self.kind { names() } else { Vec::new() };
        let found = names.into_iter().find(|known| known.0 == name);
        found.map(|(name, _)| Value::Name(name)).ok_or_else(|| self.other_kind())
    }

    /// The error of a value that it cannot have.
    pub fn other_kind(&self) -> Invalid {
        let wanted = match self.kind {
            Kind::Count(..) => "a whole number, 0 or more".to_owned(),
            Kind::Real(..) => "a number".to_owned(),
            Kind::Name(names) => names().into_iter().map(|n| n.0).collect::<Vec<_>>().join(" or "),
        };
        Invalid::Kind { key: self.key, wanted }
    }
}

/// What a field of [`Settings`] can be.
trait SettingField: Sized {
    fn value(&self) -> Value;
    /// Nothing where the value is of another kind.
    fn read(value: Value) -> Option<Self>;
}

impl SettingField for u32 {
    fn value(&self) -> Value {
        Value::Count((*self).into())
    }

    fn read(value: Value) -> Option<u32> {
        u64::read(value)?.try_into().ok()
    }
}

impl SettingField for u64 {
    fn value(&self) -> Value {
        Value::Count(*self)
    }

    fn read(value: Value) -> Option<u64> {
        if let Value::Count(n) = value { Some(n) } else { None }
    }
}

impl SettingField for f32 {
    fn value(&self) -> Value {
        Value::Real((*self).into())
    }

    fn read(value: Value) -> Option<f32> {
        f64::read(value).map(|x| x as f32)
    }
}

impl SettingField for f64 {
    fn value(&self) -> Value {
        Value::Real(*self)
    }

    fn read(value: Value) -> Option<f64> {
        match value {
            Value::Count(n) => Some(n as f64),
            Value::Real(x) => Some(x),
            Value::Name(_) => None,
        }
    }
}

/// One of several, each with its name and what it means.
trait Choice: Copy + PartialEq + 'static {
    const ALL: &'static [(Self, &'static str, &'static str)];
}

impl<C: Choice> SettingField for C {
    fn value(&self) -> Value {
        let own = C::ALL.iter().find(|(choice, ..)| choice == self);
        Value::Name(own.expect("each has a name").1)
    }

    fn read(value: Value) -> Option<C> {
        let Value::Name(name) = value else { return None };
        C::ALL.iter().find(|known| known.1 == name).map(|(choice, ..)| *choice)
    }
}

const fn names<C: Choice>() -> Kind {
    Kind::Name(|| C::ALL.iter().map(|(_, name, what)| (*name, *what)).collect())
}

/// Declares [`Settings`] and [`SETTINGS`]. A line has the field, its default, its part, its flag,
/// what stands for its value in help, what it can say, and marks.
macro_rules! settings {
    ($($(#[doc = $text:literal])+ $key:ident: $type:ty = $default:expr, $part:literal,
       $flag:literal, $value_name:literal, $kind:expr $(, $mark:ident)*;)+) => {
        /// The numbers of a run.
        #[derive(Debug, Clone, PartialEq, Serialize)]
        pub struct Settings {
            $($(#[doc = $text])+ pub $key: $type,)+
        }

        impl Settings {
            /// What the program takes where it is not told otherwise.
            pub const DEFAULT: Settings = Settings { $($key: $default,)+ };
        }

        /// All settings, in the order of their fields.
        pub static SETTINGS: &[Setting] = &[$(Setting {
            key: stringify!($key),
            text: &[$($text),+],
            part: $part,
            flag: $flag,
            value_name: $value_name,
            kind: $kind,
            marks: &[$(Mark::$mark),*],
            get: |settings| settings.$key.value(),
            set: |settings, value| {
                settings.$key = SettingField::read(value)?;
                Some(())
            },
        },)+];
    };
}

settings! {
    /// Iterations of a sample of a list; of the default five, half as many, and four times as many
    /// for the rendering end
    iterations: u32 = 1000, "Search", "iterations", "N", COUNT, First, Common;
    /// Iterations of the first sample, relative to the others
    first_effort: f64 = 1.0, "Search", "first-effort", "FACTOR", Kind::Real(0.1, 100.0);
    /// With photos and a share as the target: iterations of the model that it is a share of
    ///
    /// It is trained without the gate views. Targets that are shares are shares of what it has
    /// then, so they do not follow [`Settings::iterations`]: the same share is the same quality,
    /// however long a search is.
    held_out_iterations: u32 = 1000, "Search", "held-out-iterations", "N", COUNT, First;
    /// Iterations of the final model [default: twice those of a sample]
    ///
    /// Also of comparisons that are not given those of a search.
    final_iterations: u32 = 2000, "Search", "final-iterations", "N", COUNT, Follows;
    /// Iterations of the fine-tunes of levels 2 to 4, relative to those of level 1
    level_effort: f64 = 0.5, "Foveation", "level-effort", "FACTOR", Kind::Real(0.01, 100.0);
    /// Iterations between checks of the quality
    interval: u32 = 10, "Search", "interval", "N", COUNT;
    /// The share of a fine-tune in which lambda is adjusted; then it rests
    adjust_share: f64 = 0.9, "Search", "adjust-share", "SHARE", Kind::Real(0.01, 1.0);
    /// First lambda times the display power of the dense model, at 3 dB to spare: what the display
    /// term of the loss begins with
    ///
    /// Without unit: the term of an image that needs the display power of the dense model. λ, in
    /// 1/W, is this over that power. The damped rule begins there with 3 dB to spare or more, and
    /// with less in proportion to the shift of colours that it pays for.
    display_weight: f64 = 0.05, "Search", "lambda", "WEIGHT", WEIGHT;
    /// As --lambda, at the beginning of level 2 (with --dimming damped or published)
    ///
    /// HVSQ, the distance there, is a smaller number than L1.
    level_display_weight: f64 = 0.005, "Foveation", "level-lambda", "WEIGHT", WEIGHT;
    /// How quality above the target is spent on the display
    dimming: Dimming = Dimming::Gains, "Search", "dimming", "DIMMING", names::<Dimming>();
    /// The quality has settled when it is less than this above the target, decibels
    epsilon_db: f64 = 0.05, "Quality", "epsilon-db", "DB", Kind::Real(0.0, 100.0);
    /// Limit of opacities whenever Gaussians are pruned; 1 for none, 0.5 as the published code
    opacity_cap: f32 = 1.0, "Search", "opacity-cap", "ALPHA", Kind::Real(0.01, 1.0);
    /// Factor on all learning rates
    rate_scale: f64 = 1.0, "Search", "rate-scale", "FACTOR", Kind::Real(1e-6, 1e3);
    /// Learning rates at the end of a fine-tune, relative to its beginning; 1 as the published code
    ///
    /// A cosine between.
    rate_end: f64 = 0.1, "Search", "rate-end", "FACTOR", Kind::Real(0.0, 1.0);
    /// Seed of the order of training views
    seed: u64 = 1, "Search", "seed", "S", Kind::Count(0, u64::MAX);
    /// Iterations between checkpoints
    checkpoint_every: u32 = 250, "Search", "checkpoint-every", "N", COUNT, Harmless;
    /// Views that decide whether a model passes; `test` as the published code does
    gate: Gate = Gate::Validation, "Views", "gate", "GATE", names::<Gate>();
    /// Image size that models are judged at, by gate and test views
    gate_size: GateSize = GateSize::Priced, "Views", "gate-size", "SIZE", names::<GateSize>();
}

impl Settings {
    /// The defaults with these in their place, checked.
    ///
    /// # Errors
    /// [`Invalid::Kind`], [`Invalid::Range`]: the first value that its setting cannot have.
    pub fn with(given: &[(&Setting, Value)]) -> Result<Settings, Invalid> {
        let mut settings = Settings::DEFAULT;
        for (setting, value) in given {
            (setting.set)(&mut settings, *value).ok_or_else(|| setting.other_kind())?;
        }
        if !given.iter().any(|(setting, _)| setting.is(Mark::Follows)) {
            settings.final_iterations = settings.iterations.saturating_mul(2);
        }
        settings.check()?;
        Ok(settings)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Invalid::Range`]: the first that is out of its range.
    pub fn check(&self) -> Result<(), Invalid> {
        for setting in SETTINGS {
            match (setting.kind, setting.of(self)) {
                (Kind::Count(low, high), Value::Count(n)) => {
                    in_range(setting.key, n as f64, low as f64, high as f64)?;
                }
                (Kind::Real(low, high), Value::Real(x)) => in_range(setting.key, x, low, high)?,
                // A choice is of a type that has no others.
                _ => {}
            }
        }
        Ok(())
    }

    /// How the samples of a level (0 for level 1) are chosen, and the iterations of one.
    pub fn budget(&self, schedule: &Schedule, level: u8) -> (Schedule, u32) {
        if level == 0 {
            return (schedule.clone(), self.iterations);
        }
        let (plan, share) = schedule.upper(self.level_effort);
        (plan, share_of(self.iterations, share))
    }

    /// Iterations of the final model of a level.
    pub(crate) fn final_budget(&self, level: u8) -> u32 {
        let share = if level == 0 { 1.0 } else { self.level_effort };
        share_of(self.final_iterations, share)
    }
}

/// A share of a number of iterations, at least 1.
pub(crate) fn share_of(iterations: u32, share: f64) -> u32 {
    ((f64::from(iterations) * share).round() as u32).max(1)
}
