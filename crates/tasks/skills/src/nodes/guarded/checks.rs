//! `CheckObjectLifted` and `CheckObjectAtTarget`: conditions that may request a recovery.

use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, Library, NodeType};
use behavior::{Status, Str};

use super::Context;
use crate::condition::Condition;
use crate::shared::Recovery;
use crate::skill::Station;

/// A condition about an object, created from its ports in every tick.
struct Checked<F> {
    object: In<Str>,
    recover_on_failure: In<bool>,
    recovery: Recovery,
    make: F,
    /// Reason in the log if the condition does not hold.
    otherwise: &'static str,
}

impl<F> Checked<F> {
    fn new(binder: &mut Binder<'_>, otherwise: &'static str, make: F) -> Result<Self, BindError> {
        Ok(Self {
            object: binder.input("object")?,
            recover_on_failure: binder.input("recover_on_failure")?,
            recovery: Recovery::bind(binder)?,
            make,
            otherwise,
        })
    }
}

impl<F> Leaf<Station> for Checked<F>
where
    F: Fn(&Context<'_, '_>, usize) -> Result<Condition, Fault> + Send + 'static,
{
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let name = cx.get(&self.object)?;
        let object = cx.world.setup.object(name.as_str());
        let condition = object.map(|object| (self.make)(cx, object)).transpose()?;
        if condition.is_some_and(|condition| condition.holds(cx.world)) {
            return Ok(Status::Success);
        }
        // Running after a request: the tree's guard has to take over first, or the branch that
        // failed would end before its recovery.
        if !cx.get(&self.recover_on_failure)? {
            return Ok(Status::Failure);
        }
        let why = self.otherwise;
        self.recovery.request(cx, format_args!("{name} {why}"))?;
        Ok(Status::Running)
    }
}

pub(super) fn add(library: Library<Station>) -> Library<Station> {
    library.with(lifted()).with(at_target())
}

fn about(node_type: NodeType<Station>) -> NodeType<Station> {
    node_type
        .input::<Str>("object", "name of the object")
        .input_or(
            "recover_on_failure",
            false,
            "runs and asks for a recovery instead of failing",
        )
}

fn lifted() -> NodeType<Station> {
    let node_type = NodeType::new(
        "CheckObjectLifted",
        "Succeeds when an object is high enough and near the TCP.",
        |binder| {
            let low = binder.input::<f64>("min_height")?;
            let far = binder.input::<f64>("max_distance")?;
            let make = move |cx: &Context<'_, '_>, object| {
                Ok(Condition::Lifted {
                    object,
                    above_m: cx.get(&low)?,
                    within_m: cx.get(&far)?,
                })
            };
            Checked::new(binder, "was not lifted", make)
        },
    )
    .aliases(&["FrankaCheckObjectLifted"])
    .keywords(&["verify", "grasp", "height"]);
    about(node_type)
        .input_or("min_height", 0.15, "height of its centre at least (m)")
        .within(-10.0, 10.0)
        .input_or("max_distance", 0.05, "distance from the TCP at most (m)")
        .within(0.0, 10.0)
}

fn at_target() -> NodeType<Station> {
    let node_type = NodeType::new(
        "CheckObjectAtTarget",
        "Succeeds when an object is at a target, in the right layer, and in no \
         gripper.",
        |binder| {
            let target = binder.input::<[f64; 7]>("target")?;
            let tolerance = binder.input::<f64>("xy_tolerance")?;
            let make = move |cx: &Context<'_, '_>, object| {
                let [x, y, z, ..] = cx.get(&target)?;
                Ok(Condition::AtPoint {
                    object,
                    point: [x, y, z],
                    tolerance_m: cx.get(&tolerance)?,
                })
            };
            Checked::new(binder, "did not stay where it was placed", make)
        },
    )
    .aliases(&["FrankaCheckObjectAtTarget"])
    .keywords(&["verify", "place", "goal"]);
    about(node_type)
        .input::<[f64; 7]>("target", "pose of its centre: x y z (m) and w x y z, world")
        .input_or("xy_tolerance", 0.05, "distance in the plane at most (m)")
        .within(1.0e-4, 10.0)
}
