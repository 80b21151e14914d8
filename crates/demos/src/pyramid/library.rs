//! The node types a behaviour of this demo may name.

use std::sync::Arc;

use behavior::tree::Library;

use super::host::PyramidHost;
use super::nodes;
use super::setup::PyramidSetup;

/// The eleven node types, for the job of `setup`. Each is also known by its name
/// in older files.
pub fn library(setup: &Arc<PyramidSetup>) -> Library<PyramidHost> {
    Library::default()
        .with(nodes::reset::node_type(setup))
        .with(nodes::acquire::node_type(setup))
        .with(nodes::recover::node_type(setup))
        .with(nodes::calibrate::node_type(setup))
        .with(nodes::move_to::node_type())
        .with(nodes::gripper::node_type())
        .with(nodes::check_lifted::node_type())
        .with(nodes::check_at_target::node_type())
        .with(nodes::release_center::node_type(setup))
        .with(nodes::mark_placed::node_type(setup))
        .with(nodes::check_complete::node_type(setup))
}
