//! Configuration files: TOML that is checked against the schema of the type it becomes.
//!
//! The type's own documentation is the one source: it makes the JSON schema for editors, the
//! "did you mean", the ranges that are checked, and what `explain` prints. All problems of a file
//! are reported at once, each with its line.

pub mod assumptions;
pub mod document;
pub mod embedded;
pub mod error;
pub mod inert;
pub mod knob;
pub mod layer;
pub mod references;
pub mod schema;
pub mod suggest;

pub use document::{Config, ELSEWHERE, parse};
pub use embedded::Embedded;
pub use error::{ConfigError, Place, Problem};
pub use schema::{KeyDoc, key_docs, key_docs_of, schema_of};
