//! Where somebody looks.

mod levels;
mod stream;
