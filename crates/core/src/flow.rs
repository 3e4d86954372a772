//! Dataflows: ways in which Gaussians become pixels.
//!
//! A dataflow says which tables a machine file has, which stages a machine is made of, and how a
//! frame goes through it. A machine file names its dataflow (`dataflow = "tile-wise"`); everything
//! around it (sessions, sweeps, what-if, sensitivity, the optimiser, Python) works on any of them.

use std::any::{Any, TypeId};
use std::fmt;

use serde_json::Value;
use toml::Spanned;
use toml::de::DeTable;

use crate::machine::check::Contradiction;
use crate::machine::{Machine, Optional};
use crate::stage::StageDecl;
use powergs_base::config::suggest::nearest;

pub mod tile_wise;

/// A dataflow.
pub trait Dataflow: Sync {
    /// The name in machine files.
    fn key(&self) -> &'static str;

    /// What it is, in one sentence.
    fn means(&self) -> &'static str;

    /// The stages that its machines may have.
    fn stages(&self) -> &'static [&'static StageDecl];

    /// The schema of its tables in a machine file: an object.
    fn schema(&self) -> Value;

    /// Its tables, from a machine file that has been held against the schema.
    ///
    /// # Errors
    /// Whatever is wrong with them.
    fn read(&self, tables: Spanned<DeTable<'_>>) -> Result<Tables, toml::de::Error>;

    /// The same from plain values.
    ///
    /// # Errors
    /// Whatever is wrong with them.
    fn from_table(&self, tables: toml::Table) -> Result<Tables, toml::de::Error>;

    /// Parts that its machines may not have.
    fn optional(&self) -> &'static [Optional];

    /// Keys of a machine that contradict each other.
    fn contradictions(&self, machine: &Machine) -> Vec<Contradiction>;

    /// Everything in its tables that decides timing, as bytes.
    fn timing(&self, machine: &Machine) -> Vec<u8>;
}

/// The dataflows of this program.
pub const FLOWS: [&dyn Dataflow; 1] = [&tile_wise::TileWiseFlow];

/// The dataflow of machine files that name none.
pub const DEFAULT: &str = "tile-wise";

/// The dataflow with a name.
///
/// # Errors
/// There is none: the nearest name, and all of them.
pub fn named(name: &str) -> Result<&'static dyn Dataflow, String> {
    FLOWS.into_iter().find(|flow| flow.key() == name).ok_or_else(|| {
        let names: Vec<&str> = FLOWS.iter().map(|flow| flow.key()).collect();
        let near = nearest(name, names.iter().copied());
        let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        format!("no dataflow `{name}`{near}: there are {}", names.join(", "))
    })
}

/// The tables of one dataflow.
pub trait FlowTables: Any + fmt::Debug + Send + Sync {
    /// Their dataflow.
    fn flow(&self) -> &'static dyn Dataflow;

    /// The table of this type; `None` where the dataflow has none.
    fn table(&self, of: TypeId) -> Option<&dyn Any>;

    /// As a machine file has them.
    fn to_toml(&self) -> toml::Table;

    /// The same once more.
    fn boxed(&self) -> Box<dyn FlowTables>;

    /// Whether they are the same.
    fn equals(&self, other: &dyn FlowTables) -> bool;
}

/// The tables of the dataflow of a machine.
#[derive(Debug)]
pub struct Tables(Box<dyn FlowTables>);

impl Clone for Tables {
    fn clone(&self) -> Tables {
        Tables(self.0.boxed())
    }
}

impl PartialEq for Tables {
    fn eq(&self, other: &Tables) -> bool {
        self.0.equals(&*other.0)
    }
}

impl Tables {
    /// These tables.
    pub fn new(tables: impl FlowTables) -> Tables {
        Tables(Box::new(tables))
    }

    /// Their dataflow.
    pub fn flow(&self) -> &'static dyn Dataflow {
        self.0.flow()
    }

    /// As a machine file has them.
    pub fn to_toml(&self) -> toml::Table {
        self.0.to_toml()
    }

    /// The table of a type; `None` where the dataflow has none.
    pub fn get<T: 'static>(&self) -> Option<&T> {
        let all: &dyn Any = &*self.0;
        let whole = all.downcast_ref();
        whole.or_else(|| self.0.table(TypeId::of::<T>())?.downcast_ref())
    }

    /// All tables of a dataflow, to be changed; `None` where they are of another.
    pub fn all_mut<T: FlowTables>(&mut self) -> Option<&mut T> {
        let all: &mut dyn Any = &mut *self.0;
        all.downcast_mut()
    }
}

/// What [`FlowTables`] is for a struct of tables, each of a type of its own.
#[macro_export]
macro_rules! flow_tables {
    ($tables:ty, $flow:expr, [$($table:ident),* $(,)?]) => {
        impl $crate::flow::FlowTables for $tables {
            fn flow(&self) -> &'static dyn $crate::flow::Dataflow {
                &$flow
            }

            fn table(&self, of: std::any::TypeId) -> Option<&dyn std::any::Any> {
                let all: &[&dyn std::any::Any] = &[$(&self.$table),*];
                all.iter().copied().find(|table| (**table).type_id() == of)
            }

            fn to_toml(&self) -> toml::Table {
                let table = toml::Table::try_from(self);
                table.expect("tables of a machine have only tables, numbers and strings")
            }

            fn boxed(&self) -> Box<dyn $crate::flow::FlowTables> {
                Box::new(self.clone())
            }

            fn equals(&self, other: &dyn $crate::flow::FlowTables) -> bool {
                let other: &dyn std::any::Any = other;
                other.downcast_ref::<Self>().is_some_and(|other| self == other)
            }
        }
    };
}

pub use flow_tables;
