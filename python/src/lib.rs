//! The Python package `powergs`: the library of `powergs-sim` in Python's manners.
//!
//! There is no logic here: arguments become values of the library, its values become objects, and
//! long calls run without the interpreter's lock ([`watch`]).

mod arrays;
mod cameras;
mod chart;
mod codesign;
mod commands;
mod error;
mod experiments;
mod explain;
mod frames;
mod machine;
mod optimize;
mod picture;
mod report;
mod scene;
mod space;
mod sweep;
mod table;
mod trace;
mod value;
mod watch;

use powergs_base::build::{self, Build};
use pyo3::prelude::*;

/// Everything of `powergs` that is compiled.
#[pymodule]
fn _powergs(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let (major, minor) = powergs_frame::trace::VERSION;
    let models = powergs_core::sim::MODEL_VERSION;
    build::is(Build { commit: env!("POWERGS_COMMIT"), models, traces: [major, minor] });
    module.add("__version__", build::TOOL_VERSION)?;
    module.add("__build__", build::line())?;
    module.add("__model_version__", powergs_core::sim::MODEL_VERSION)?;
    module.add_class::<cameras::Camera>()?;
    module.add_class::<cameras::Cameras>()?;
    module.add_class::<chart::Chart>()?;
    module.add_class::<codesign::Codesigned>()?;
    module.add_class::<experiments::Comparison>()?;
    module.add_class::<explain::Explanation>()?;
    module.add_class::<machine::Machine>()?;
    module.add_class::<optimize::Optimized>()?;
    module.add_class::<report::Bottleneck>()?;
    module.add_class::<report::Report>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<space::AskedSpace>()?;
    module.add_class::<sweep::Front>()?;
    module.add_class::<sweep::SweepResult>()?;
    module.add_class::<table::Table>()?;
    module.add_class::<trace::Trace>()?;
    module.add_function(wrap_pyfunction!(cameras::_camera, module)?)?;
    module.add_function(wrap_pyfunction!(chart::_chart, module)?)?;
    module.add_function(wrap_pyfunction!(codesign::codesign, module)?)?;
    module.add_function(wrap_pyfunction!(commands::_commands, module)?)?;
    module.add_function(wrap_pyfunction!(commands::_csv, module)?)?;
    module.add_function(wrap_pyfunction!(commands::_main, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::compare, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::dram, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::validate, module)?)?;
    module.add_function(wrap_pyfunction!(explain::explain, module)?)?;
    module.add_function(wrap_pyfunction!(machine::_machine, module)?)?;
    module.add_function(wrap_pyfunction!(machine::names, module)?)?;
    module.add_function(wrap_pyfunction!(optimize::optimize, module)?)?;
    module.add_function(wrap_pyfunction!(picture::display_power, module)?)?;
    module.add_function(wrap_pyfunction!(picture::png, module)?)?;
    module.add_function(wrap_pyfunction!(picture::quality, module)?)?;
    module.add_function(wrap_pyfunction!(report::_report, module)?)?;
    module.add_function(wrap_pyfunction!(scene::synth, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::_front, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::_gathered, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::_sweep_axes, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::_sweep_file, module)?)?;
    module.add_function(wrap_pyfunction!(table::_table, module)?)?;
    Ok(())
}
