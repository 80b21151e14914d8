//! `CheckObjectLifted`: whether the cube came up with the hand.

use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use behavior::{Status, Str};

use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::keys::Recovery;

/// See the module.
struct CheckObjectLifted {
    object: In<Str>,
    min_height: In<f64>,
    max_distance: In<f64>,
    recover_on_failure: In<bool>,
    recovery: Recovery,
}

/// The node type.
pub(in crate::pyramid) fn node_type() -> NodeType<PyramidHost> {
    NodeType::new(
        "CheckObjectLifted",
        "Succeeds when an object is high enough and near the TCP.",
        CheckObjectLifted::new,
    )
    .aliases(&["FrankaCheckObjectLifted"])
    .keywords(&["verify", "grasp", "height"])
    .input::<Str>("object", "name of the object")
    .input_or("min_height", 0.15, "height of its centre at least (m)")
    .within(-10.0, 10.0)
    .input_or(
        "max_distance",
        0.05,
        "distance from the TCP at most (m); 0.15 from the origin of the hand's \
         own frame",
    )
    .within(0.0, 10.0)
    .input_or(
        "recover_on_failure",
        false,
        "runs and asks for a recovery instead of failing",
    )
}

impl CheckObjectLifted {
    fn new(binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            object: binder.input("object")?,
            min_height: binder.input("min_height")?,
            max_distance: binder.input("max_distance")?,
            recover_on_failure: binder.input("recover_on_failure")?,
            recovery: Recovery::bind(binder)?,
        })
    }
}

impl Leaf<PyramidHost> for CheckObjectLifted {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let name = cx.get(&self.object)?;
        let cube = cx.world.setup.cube_named(name.as_str());
        let height = cube.and_then(|c| cx.world.cube_position(c)).map(|p| p.z);
        let distance = cube.and_then(|c| cx.world.distance_to_tcp(c));
        let (low, far) = (cx.get(&self.min_height)?, cx.get(&self.max_distance)?);
        if height.is_some_and(|z| z >= low) && distance.is_some_and(|d| d <= far) {
            return Ok(Status::Success);
        }
        if !cx.get(&self.recover_on_failure)? {
            return Ok(Status::Failure);
        }
        self.recovery
            .request(cx, format_args!("{name} did not come up with the hand"))?;
        Ok(Status::Running)
    }
}
