//! What was once wrong.

mod scenes;
