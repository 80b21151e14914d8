//! `MarkCubePlaced`: the cube is part of the stack now.

use std::sync::Arc;

use behavior::Status;
use behavior::board::{Access, Fault, In, Out};
use behavior::tree::{BindError, Binder, Leaf, NodeType};

use crate::pyramid::cubes::{self, CubeState, Cubes};
use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::keys::{self, Recovery};
use crate::pyramid::setup::PyramidSetup;
use crate::pyramid::targets::{Targets, has};

/// See the module.
struct MarkCubePlaced {
    required_count: In<i64>,
    cubes: Cubes,
    targets: Targets,
    recovery: Recovery,
    complete: Out<bool>,
}

/// The node type.
pub(in crate::pyramid) fn node_type(setup: &Arc<PyramidSetup>) -> NodeType<PyramidHost> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "MarkCubePlaced",
        "Adds the cube to the arm's stack if it is seen to stand there, and \
         tells when the stack is complete. Once more changes nothing.",
        move |binder| MarkCubePlaced::new(&setup, binder),
    )
    .aliases(&["FrankaMarkCubePlaced"])
    .keywords(&["count", "done", "placed"])
    .input_or("required_count", 3_i64, "cubes of a complete stack")
    .within(1.0, 16.0)
}

impl MarkCubePlaced {
    fn new(setup: &PyramidSetup, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let complete = keys::stack_complete(keys::robot(binder)?.as_str());
        Ok(Self {
            required_count: binder.input("required_count")?,
            cubes: Cubes::bind(setup, binder)?,
            targets: Targets::bind(binder)?,
            recovery: Recovery::bind(binder)?,
            complete: keys::shared(binder, &complete, false, Access::Write)?,
        })
    }
}

impl Leaf<PyramidHost> for MarkCubePlaced {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let Some(cube) = self.cubes.current(cx)? else {
            return Ok(Status::Failure);
        };
        let goal = self.targets.object_goal(cx)?;
        if cx.world.is_held(cube) || !cubes::is_at(cx.world, cube, goal) {
            return Ok(Status::Failure);
        }
        let (arm, name) = (self.cubes.me(), cx.world.setup.cube_name(cube));
        if self.targets.is_aside(cx)? {
            self.cubes.set_state(cx, cube, CubeState::Available)?;
            cx.world
                .out
                .log(format_args!("[aside] {arm}: {name} is out of the way"));
        } else {
            let stack = self.cubes.mark_placed(cx, cube)?;
            if has(stack, cx.get(&self.required_count)?) {
                cx.set(&self.complete, true)?;
            }
            cx.world.out.log(format_args!(
                "[placed] {arm}: {name} is number {}",
                stack.len()
            ));
        }
        self.cubes.set_current(cx, None)?;
        self.recovery.clear(cx)?;
        Ok(Status::Success)
    }
}
