//! Motions as node types.

use std::sync::Arc;

use behavior::Str;
use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, NodeType};
use behavior::value::Numbers;
use ipc_types::Pose;

use super::names::{Named, is_given, object, place_named};
use super::way::{self, WayPorts};
use super::{ARM, Context, Made, poses, seconds};
use crate::geometry;
use crate::motion::{MoveTo, Target};
use crate::setup::Setup;
use crate::skill::Station;
use crate::world::World;

/// `MoveTo`: a pose, an object, or a place.
pub(super) fn move_to(setup: &Arc<Setup>) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    let node_type = NodeType::new(
        "MoveTo",
        "Brings the TCP to an object, with an object in the gripper to the next \
         free slot of a place, or to a pose. Fails when that takes too long, when \
         the object moves away, or when the object in the gripper is lost.",
        move |binder| {
            let target = Where::bind(binder, &setup)?;
            let above = binder.input::<f64>("above_m")?;
            let timeout = binder.input::<f64>("timeout_s")?;
            let movement = binder.input::<f64>("move_tolerance_m")?;
            let way = WayPorts::bind(binder, &setup)?;
            Ok(Made(move |cx: &Context<'_, '_>| {
                let Some(skill) = target.skill(cx, cx.get(&above)?)? else {
                    return Ok(None);
                };
                Ok(Some(MoveTo {
                    timeout: seconds(cx.get(&timeout)?),
                    move_tolerance_m: cx.get(&movement)?,
                    way: way.get(cx)?,
                    ..skill
                }))
            }))
        },
    )
    .keywords(&["move", "reach", "go", "approach", "motion", "pose", "line"])
    .drives(ARM)
    .input_or("object", Str::EMPTY, "object to move to, or to bring")
    .input_or(
        "place",
        Str::EMPTY,
        "place to bring the object in the gripper to",
    )
    .input_or(
        "pose",
        Numbers::default(),
        "TCP x y z (m), or that and w x y z, world frame; straight down without",
    )
    .input_or(
        "above_m",
        0.0,
        "height above that (m); 0 is exact and straight",
    )
    .within(0.0, 2.0)
    .input_or(
        "move_tolerance_m",
        0.05,
        "fails when the object moved further in the plane (m)",
    )
    .within(1.0e-3, 10.0)
    .input_or("timeout_s", 10.0, "fails after this (s)")
    .within(0.1, 3600.0);
    way::ports(node_type)
}

/// The target of a `MoveTo`.
#[derive(Clone, Copy)]
enum Where {
    Object(Named),
    Place(Named, Named),
    Pose(In<Numbers>),
}

impl Where {
    #[allow(clippy::result_large_err, reason = "happens at load, once")]
    fn bind(binder: &mut Binder<'_>, setup: &Setup) -> Result<Self, BindError> {
        let given = ["object", "place"].map(|port| is_given(binder, port));
        let pose = is_given(binder, "pose");
        if let Some(port) = ["object", "place"]
            .into_iter()
            .zip(given)
            .find(|(_, is)| *is && pose)
        {
            // A warning, not an error: the file is valid, and the motion follows the object.
            let message = format!("'pose' is not used beside '{}'; drop one of them", port.0);
            binder.warn("unused_pose", message);
        }
        match given {
            [true, true] => Ok(Self::Place(
                object(binder, setup)?,
                place_named(binder, setup)?,
            )),
            [true, false] => Ok(Self::Object(object(binder, setup)?)),
            [false, true] => Err(BindError::Host(
                "MoveTo with a 'place' needs the 'object' it brings there".to_owned(),
            )),
            [false, false] => {
                let pose = binder.input::<Numbers>("pose")?;
                if let In::Literal(numbers) = pose
                    && !matches!(numbers.as_slice().len(), 3 | 7)
                {
                    return Err(BindError::Host(
                        "MoveTo needs an 'object', an 'object' and a 'place', or a 'pose' of 3 \
                         or 7 numbers"
                            .to_owned(),
                    ));
                }
                if let In::Literal(numbers) = pose {
                    poses::check(binder, setup, "pose", numbers.as_slice());
                }
                Ok(Self::Pose(pose))
            }
        }
    }

    fn skill(&self, cx: &Context<'_, '_>, above_m: f64) -> Result<Option<MoveTo>, Fault> {
        Ok(match self {
            Self::Object(object) => object.get(cx)?.map(|o| MoveTo::object(o, above_m)),
            Self::Place(object, place) => {
                let both = object.get(cx)?.zip(place.get(cx)?);
                both.map(|(object, place)| MoveTo::place(object, place, above_m))
            }
            Self::Pose(pose) => tcp_pose(cx.get(pose)?.as_slice(), cx.world).map(|mut pose| {
                pose.position[2] += above_m;
                MoveTo::new(Target::Pose(pose))
            }),
        })
    }
}

/// The pose of 3 or 7 numbers. Three numbers are a position, with the tool straight down and
/// not turned.
pub(super) fn tcp_pose(numbers: &[f64], world: &World<'_>) -> Option<Pose> {
    match *numbers {
        [x, y, z] => Some(Pose {
            position: [x, y, z],
            orientation_wxyz: world.tool().down(0.0),
        }),
        // A quaternion near zero has no direction: the node fails.
        [.., w, i, j, k] if poses::length([w, i, j, k]) < poses::NO_LENGTH => None,
        [x, y, z, w, i, j, k] => {
            let unit = geometry::rotation([w, i, j, k]);
            Some(Pose {
                position: [x, y, z],
                orientation_wxyz: [unit.w, unit.i, unit.j, unit.k],
            })
        }
        _ => None,
    }
}

/// `Up`: straight up.
pub(super) fn up() -> NodeType<Station> {
    NodeType::new(
        "Up",
        "Moves straight up from where the arm is. With 'holding' it keeps the \
         gripper closed, and fails when that object is lost.",
        |binder| {
            let by = binder.input::<f64>("by_m")?;
            let holding = binder.input::<Str>("holding")?;
            Ok(Made(move |cx: &Context<'_, '_>| {
                let skill = MoveTo::up(cx.get(&by)?);
                let name = cx.get(&holding)?;
                if name.is_empty() {
                    return Ok(Some(skill));
                }
                let object = cx.world.setup.object(name.as_str());
                Ok(object.map(|object| skill.holding(object)))
            }))
        },
    )
    .keywords(&["lift", "retract", "rise"])
    .drives(ARM)
    .input_or("by_m", 0.1, "how far (m)")
    .within(0.0, 2.0)
    .input_or(
        "holding",
        Str::EMPTY,
        "object that has to stay in the gripper",
    )
}
