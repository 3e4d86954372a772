//! Co-design: spaces, records, the five ways, whole runs on a tiny scene.

mod alternate;
mod compare;
mod model;
mod names;
mod run;
mod space;
