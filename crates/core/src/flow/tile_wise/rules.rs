//! Unit rules: how a crate outside gives a machine a unit with another timing rule.
//!
//! A [`UnitRule`] replaces the timing rule, and if it wants the action counts, of one kind of unit:
//! it says for how many cycles a piece of work occupies the unit, for how many more the banks of
//! its buffers hold it up, and which actions the work is.
//! [`TileWise::rules`](super::TileWise::rules) holds one [`Rule`] for each kind of unit: the
//! built-in one, or one that was [registered](register) and that the machine file names:
//! `rules.vru = "dual-issue"`. Where nothing is registered there is no such table.
//!
//! | unit | a piece of work | when the rule is asked |
//! |---|---|---|
//! | [`Ccu`] | a [`Batch`](super::batch::Batch) of records | when the batch enters the unit |
//! | [`Qsu`] | the [`Keys`](super::qsu::Keys) of a job, with `passes` = 1 | when a pass begins |
//! | [`Bsu`] | the [`Sort`](super::bsu::Sort) of a chunk | when the chunk is issued |
//! | [`Vru`] | the [`Render`](super::vru::Render) of a chunk; a tile's last names it | as the BSU |
//!
//! **What a rule can replace.** Busy cycles, bank stalls and on-chip actions of each piece of work,
//! as any function of the work and of the unit's resolved parameters (its table of the machine
//! file, record sizes, banks).
//!
//! **What it cannot replace.** How many units there are and what they take of the area and the
//! leakage; buffers and what is allocated in them; DRAM requests and their bytes; the order of
//! events, and how far units overlap (the [`pipeline`](super::pipeline)); the functional result,
//! such as which chunks a tile loads; the way of units through sub-tiles, where they are followed
//! ([`Render::run`](super::vru::Render::run) says what a chunk took; a rule of the VRU may ignore
//! it, and queues then count for nothing between chunks). A rule sees one piece of work at a time
//! and keeps no state:
//! it must return the same for the same arguments.
//!
//! Accounts close as for built-in units: `busy + stalls + idle = instances * frame`, and on-chip
//! actions are charged once for each piece of work. Actions are charged from the totals of the
//! frame, not in the order of time: a CCU is charged one batch with all records of the frame, a QSU
//! every job with all of its passes, a VRU every chunk without its tile and then every tile with an
//! empty chunk. What a rule charges must not depend on how work is divided.
//!
//! A rule that breaks its contract ends in a [`RuleError`], never in a report.

use std::borrow::Cow;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::flow::tile_wise::bsu::Bsu;
use crate::flow::tile_wise::ccu::Ccu;
use crate::flow::tile_wise::qsu::Qsu;
use crate::flow::tile_wise::vru::Vru;
use crate::kernel::unit::Unit;
use crate::stage::{DRAM_READ, DRAM_WRITE, RegisterError, stage};
use powergs_energy::action::ActionCounts;

/// The rule of a unit of kind `U`. Every method has the built-in rule as its default.
pub trait UnitRule<U: Unit>: Send + Sync {
    /// Identifies the rule together with its parameters: `half-rate`, `dual-issue-4`. It stands for
    /// the rule wherever timings are compared, hashed or cached, so that two rules that time
    /// differently must have different names.
    fn name(&self) -> &str;

    /// Cycles for which `work` occupies `unit`, at least 1.
    fn cycles(&self, unit: &U, work: &U::Work) -> u64 {
        unit.cycles(work)
    }

    /// Further cycles for which `work` waits for the banks of the unit's buffers.
    fn bank_stalls(&self, unit: &U, work: &U::Work) -> u64 {
        unit.bank_stalls(work)
    }

    /// Charges the on-chip actions of `work`. DRAM bytes must not be charged.
    fn charge(&self, unit: &U, work: &U::Work, actions: &mut ActionCounts) {
        unit.charge(work, actions);
    }
}

/// A kind of unit that rules can be registered for.
pub trait RuledUnit: Unit + 'static {
    /// The rules from outside.
    fn registered() -> &'static RuleShelf<Self>;
}

/// Rules by name.
pub type RuleShelf<U> = Mutex<Vec<Arc<dyn UnitRule<U>>>>;

macro_rules! ruled {
    ($($unit:ty),*) => {
        $(impl RuledUnit for $unit {
            fn registered() -> &'static RuleShelf<$unit> {
                static SHELF: RuleShelf<$unit> = Mutex::new(Vec::new());
                &SHELF
            }
        })*

        /// Whether there is any rule from outside.
        pub(super) fn any_registered() -> bool {
            [$(!shelf::<$unit>().is_empty()),*].into_iter().any(|is_there| is_there)
        }
    };
}
ruled!(Ccu, Qsu, Bsu, Vru);

fn shelf<U: RuledUnit>() -> MutexGuard<'static, Vec<Arc<dyn UnitRule<U>>>> {
    U::registered().lock().unwrap_or_else(PoisonError::into_inner)
}

/// The rule of the unit itself, in machine files.
const BUILT_IN_NAME: &str = "built-in";

/// Adds a rule that machine files may name, which must be done before any is read.
///
/// # Errors
/// [`RegisterError::Taken`]: there is a rule of this name for the unit.
pub fn register<U: RuledUnit>(rule: impl UnitRule<U> + 'static) -> Result<(), RegisterError> {
    let mut shelf = shelf::<U>();
    let is_taken =
        |name: &str| name == BUILT_IN_NAME || shelf.iter().any(|other| other.name() == name);
    if is_taken(rule.name()) {
        let unit = stage(U::STAGE).key;
        return Err(RegisterError::Rule { unit, name: rule.name().to_owned() });
    }
    shelf.push(Arc::new(rule));
    Ok(())
}

/// The rule in force for one kind of unit: the built-in one, or one from outside the crate.
///
/// Two rules are equal when their names are, and `{:?}` prints the name.
pub struct Rule<U: Unit>(Option<Arc<dyn UnitRule<U>>>);

impl<U: Unit> Rule<U> {
    /// The rule of the unit itself.
    pub(crate) const BUILT_IN: Rule<U> = Rule(None);

    /// A custom rule.
    pub fn new(rule: impl UnitRule<U> + 'static) -> Self {
        Rule(Some(Arc::new(rule)))
    }

    /// The name of the rule; `None` for the built-in one.
    pub(crate) fn name(&self) -> Option<&str> {
        self.0.as_deref().map(UnitRule::name)
    }

    /// Busy cycles and bank stalls of `work`, without checks.
    fn raw_times(&self, unit: &U, work: &U::Work) -> (u64, u64) {
        match &self.0 {
            None => unit.times(work),
            Some(rule) => (rule.cycles(unit, work), rule.bank_stalls(unit, work)),
        }
    }

    /// Busy cycles of `work`, for sums outside of the pipeline.
    pub(super) fn cycles(&self, unit: &U, work: &U::Work) -> u64 {
        match &self.0 {
            None => unit.cycles(work),
            Some(rule) => rule.cycles(unit, work).clamp(1, CYCLES_MAX),
        }
    }

    /// Busy cycles and bank stalls of `work`. Those of a rule from outside are checked: after a
    /// violation every piece of work takes one cycle.
    #[inline]
    pub(super) fn times(&self, unit: &U, work: &U::Work, check: &mut RuleCheck) -> (u64, u64) {
        match &self.0 {
            None => unit.times(work),
            Some(rule) => check.times::<U>(rule.name(), self.raw_times(unit, work)),
        }
    }

    /// Charges the on-chip actions of `work`; those of a rule from outside are checked.
    #[inline]
    pub(super) fn charge(
        &self,
        unit: &U,
        work: &U::Work,
        actions: &mut ActionCounts,
        check: &mut RuleCheck,
    ) {
        match &self.0 {
            None => unit.charge(work, actions),
            Some(rule) => {
                let mut own = ActionCounts::default();
                rule.charge(unit, work, &mut own);
                check.charge::<U>(rule.name(), &own, actions);
            }
        }
    }
}

impl<U: Unit> Clone for Rule<U> {
    fn clone(&self) -> Self {
        Rule(self.0.clone())
    }
}

impl<U: Unit> Default for Rule<U> {
    fn default() -> Self {
        Rule::BUILT_IN
    }
}

impl<U: Unit> PartialEq for Rule<U> {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl<U: Unit> fmt::Debug for Rule<U> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            None => f.write_str("built-in"),
            Some(name) => write!(f, "{name:?}"),
        }
    }
}

impl<U: Unit> Serialize for Rule<U> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name().unwrap_or(BUILT_IN_NAME))
    }
}

impl<'de, U: RuledUnit> Deserialize<'de> for Rule<U> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let name = String::deserialize(from)?;
        if name == BUILT_IN_NAME {
            return Ok(Rule::BUILT_IN);
        }
        let found = shelf::<U>().iter().find(|rule| rule.name() == name).cloned();
        found.map(|rule| Rule(Some(rule))).ok_or_else(|| {
            let unit = stage(U::STAGE).words;
            serde::de::Error::custom(format!("no timing rule `{name}` of the {unit}"))
        })
    }
}

impl<U: RuledUnit> JsonSchema for Rule<U> {
    fn schema_name() -> Cow<'static, str> {
        format!("Rule_{}", stage(U::STAGE).key).into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let own = shelf::<U>();
        let names: Vec<&str> =
            [BUILT_IN_NAME].into_iter().chain(own.iter().map(|rule| rule.name())).collect();
        json_schema!({ "type": "string", "enum": names })
    }
}

/// The `[rules]` table: timing rules from outside of this program.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct UnitRules {
    /// Of the culling and conversion units.
    pub ccu: Rule<Ccu>,
    /// Of the quick sorting units.
    pub qsu: Rule<Qsu>,
    /// Of the bitonic sorting units.
    pub bsu: Rule<Bsu>,
    /// Of the rendering units.
    pub vru: Rule<Vru>,
}

impl UnitRules {
    /// Whether all are built in.
    pub(super) fn are_built_in(&self) -> bool {
        self.names().is_empty()
    }

    /// The rules that are not built in, in pipeline order: the name of the unit and that of the
    /// rule. Whatever identifies a timing must contain them.
    pub fn names(&self) -> Vec<(&'static str, &str)> {
        let all = [
            (Ccu::STAGE, self.ccu.name()),
            (Qsu::STAGE, self.qsu.name()),
            (Bsu::STAGE, self.bsu.name()),
            (Vru::STAGE, self.vru.name()),
        ];
        all.into_iter().filter_map(|(unit, name)| Some((stage(unit).key, name?))).collect()
    }
}

/// How a rule broke its contract.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RuleError {
    /// A piece of work in no time: units are busy for at least a cycle with each.
    #[error("rule `{rule}` of the {unit} returns 0 cycles for a piece of work; return at least 1")]
    NoCycles {
        /// Name of the unit.
        unit: &'static str,
        /// Name of the rule.
        rule: String,
    },
    /// All pieces of work of a frame together take longer than is believed.
    #[error(
        "rule `{rule}` of the {unit} brings the cycles of one frame above {most}; look for an \
         overflow in it"
    )]
    TooLong {
        /// Name of the unit.
        unit: &'static str,
        /// Name of the rule.
        rule: String,
        /// The bound, cycles.
        most: u64,
    },
    /// DRAM bytes are counted by the pipeline.
    #[error(
        "rule `{rule}` of the {unit} charges DRAM bytes; charge actions inside of the chip only"
    )]
    DramBytes {
        /// Name of the unit.
        unit: &'static str,
        /// Name of the rule.
        rule: String,
    },
    /// More actions of a kind than are believed.
    #[error(
        "rule `{rule}` of the {unit} brings the count of an action above {most}; look for an \
         overflow in it"
    )]
    TooMany {
        /// Name of the unit.
        unit: &'static str,
        /// Name of the rule.
        rule: String,
        /// The bound.
        most: u64,
    },
}

/// Most cycles that custom rules may take in a frame, all pieces of work together: 18
/// minutes at 1 GHz. Sums over units and conversions of time stay exact within it.
const CYCLES_MAX: u64 = 1 << 40;

/// Most actions of one kind in a stage of a frame.
const COUNT_MAX: u64 = 1 << 60;

/// Checks the results of custom rules in one frame, and keeps the first violation.
#[derive(Debug)]
pub(super) struct RuleCheck {
    /// Cycles that may still be asked for.
    left: u64,
    most: u64,
    pub error: Option<RuleError>,
}

impl RuleCheck {
    /// For a frame on a machine of `instances` units of all kinds.
    pub(crate) fn new(instances: u64) -> Self {
        let most = CYCLES_MAX.min((1 << 62) / instances.max(1));
        Self { left: most, most, error: None }
    }

    fn times<U: Unit>(&mut self, rule: &str, (cycles, stalls): (u64, u64)) -> (u64, u64) {
        if self.error.is_some() {
            return (1, 0);
        }
        let (unit, left) = (
            stage(U::STAGE).key,
            cycles.checked_add(stalls).and_then(|c| self.left.checked_sub(c)),
        );
        self.error = match left {
            _ if cycles == 0 => Some(RuleError::NoCycles { unit, rule: rule.to_owned() }),
            None => Some(RuleError::TooLong { unit, rule: rule.to_owned(), most: self.most }),
            Some(left) => {
                self.left = left;
                return (cycles, stalls);
            }
        };
        (1, 0)
    }

    fn charge<U: Unit>(&mut self, rule: &str, own: &ActionCounts, actions: &mut ActionCounts) {
        if self.error.is_some() {
            return;
        }
        let unit = stage(U::STAGE).key;
        if own.total(DRAM_READ) > 0 || own.total(DRAM_WRITE) > 0 {
            self.error = Some(RuleError::DramBytes { unit, rule: rule.to_owned() });
        } else if !actions.add_within(own, COUNT_MAX) {
            self.error = Some(RuleError::TooMany { unit, rule: rule.to_owned(), most: COUNT_MAX });
        }
    }
}
