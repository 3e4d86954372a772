//! Readers, prices, files and the simulator on small circuits, and the committed netlists of the
//! units against functional models.

mod ccu;
mod characterise;
mod file;
mod liberty;
mod price;
mod rendering;
mod simulator;
mod sorting;
mod toy;
mod unit;
