//! `CalibratePlaceTargets`: shifts the place by how the cube lies in the hand.

use std::sync::Arc;

use behavior::Status;
use behavior::board::Fault;
use behavior::tree::{BindError, Binder, Leaf, NodeType};

use crate::pyramid::cubes::Cubes;
use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::keys::Recovery;
use crate::pyramid::setup::PyramidSetup;
use crate::pyramid::targets::{Targets, goal_of};

/// See the module.
struct CalibratePlaceTargets {
    cubes: Cubes,
    targets: Targets,
    recovery: Recovery,
}

/// The node type.
pub(in crate::pyramid) fn node_type(setup: &Arc<PyramidSetup>) -> NodeType<PyramidHost> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "CalibratePlaceTargets",
        "Compares the stack with what is seen, and shifts and turns the targets \
         of the place by how the cube lies in the hand.",
        move |binder| CalibratePlaceTargets::new(&setup, binder),
    )
    .aliases(&["FrankaCalibratePlaceTargets"])
    .keywords(&["offset", "hand", "place"])
}

impl CalibratePlaceTargets {
    fn new(setup: &PyramidSetup, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            cubes: Cubes::bind(setup, binder)?,
            targets: Targets::bind(binder)?,
            recovery: Recovery::bind(binder)?,
        })
    }
}

impl Leaf<PyramidHost> for CalibratePlaceTargets {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let current = self.cubes.current(cx)?;
        let Some(cube) = current.filter(|_| cx.world.cube_in_hand() == current) else {
            self.recovery
                .request(cx, format_args!("nothing in the hand to be placed"))?;
            return Ok(Status::Running);
        };
        let stack = self.cubes.compare(cx)?;
        let goal = match cx.world.arm_setup() {
            Some(arm) => goal_of(cx.world, arm, stack, cube),
            None => return Ok(Status::Failure),
        };
        Ok(if self.targets.calibrate(cx, cube, goal)? {
            Status::Success
        } else {
            Status::Failure
        })
    }
}
