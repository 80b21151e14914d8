//! The extension module `robocell._core`: tasks in Python on the bus of a cell or in
//! this process. Its classes are documented in the Python package.

#![allow(
    clippy::needless_pass_by_value,
    reason = "Python passes its arguments by value"
)]
#![allow(
    clippy::redundant_closure_for_method_calls,
    reason = "the path of a method of `World` has one lifetime only"
)]

mod about;
mod arm;
mod command;
mod decision;
mod inner;
mod many;
mod moment;
mod outside;
mod picture;
mod policy;
mod program;
mod recording;
mod sim;
mod skill;
mod tree;
mod work;

use pyo3::prelude::*;

/// The native part of `robocell`.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<moment::Moment>()?;
    module.add_class::<arm::Arm>()?;
    module.add_class::<skill::Skill>()?;
    module.add_class::<work::Status>()?;
    module.add_class::<sim::Sim>()?;
    module.add_class::<tree::FileTree>()?;
    module.add_function(wrap_pyfunction!(many::step_all, module)?)?;
    module.add_function(wrap_pyfunction!(many::observe_all, module)?)?;
    module.add_function(wrap_pyfunction!(program::task_main, module)?)?;
    module.add_function(wrap_pyfunction!(about::wire_schema, module)?)?;
    module.add_function(wrap_pyfunction!(recording::read_recording, module)?)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    Ok(())
}
