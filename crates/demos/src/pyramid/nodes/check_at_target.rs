//! `CheckObjectAtTarget`: whether the cube stands where it was set down.

use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use behavior::{Status, Str};
use nalgebra::Vector3;

use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::keys::Recovery;
use crate::pyramid::targets::Numbers;

/// See the module.
struct CheckObjectAtTarget {
    object: In<Str>,
    target: In<Numbers>,
    xy_tolerance: In<f64>,
    recover_on_failure: In<bool>,
    recovery: Recovery,
}

/// The node type.
pub(in crate::pyramid) fn node_type() -> NodeType<PyramidHost> {
    NodeType::new(
        "CheckObjectAtTarget",
        "Succeeds when an object stands at a target, in the right layer, and no \
         hand holds it.",
        CheckObjectAtTarget::new,
    )
    .aliases(&["FrankaCheckObjectAtTarget"])
    .keywords(&["verify", "place", "goal"])
    .input::<Str>("object", "name of the object")
    .input::<Numbers>("target", "pose of its centre: x y z (m) and w x y z, world")
    .input_or("xy_tolerance", 0.05, "distance in the plane at most (m)")
    .within(1.0e-4, 10.0)
    .input_or(
        "recover_on_failure",
        false,
        "runs and asks for a recovery instead of failing",
    )
}

impl CheckObjectAtTarget {
    fn new(binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            object: binder.input("object")?,
            target: binder.input("target")?,
            xy_tolerance: binder.input("xy_tolerance")?,
            recover_on_failure: binder.input("recover_on_failure")?,
            recovery: Recovery::bind(binder)?,
        })
    }
}

impl Leaf<PyramidHost> for CheckObjectAtTarget {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let name = cx.get(&self.object)?;
        let [x, y, z, ..] = cx.get(&self.target)?;
        let tolerance = cx.get(&self.xy_tolerance)?;
        let layer = cx.world.setup.numbers.layer_height_m;
        let cube = cx.world.setup.cube_named(name.as_str());
        let stands = cube.is_some_and(|cube| {
            !cx.world.is_held(cube)
                && cx.world.cube_position(cube).is_some_and(|position| {
                    let offset = position - Vector3::new(x, y, z);
                    offset.xy().norm() <= tolerance && offset.z.abs() < 0.5 * layer
                })
        });
        if stands {
            return Ok(Status::Success);
        }
        if !cx.get(&self.recover_on_failure)? {
            return Ok(Status::Failure);
        }
        self.recovery
            .request(cx, format_args!("{name} did not stay where it was put"))?;
        Ok(Status::Running)
    }
}
