//! Conditions about the cell. A condition has no state.

use nalgebra::Vector3;

use crate::geometry;
use crate::world::World;

/// An object nearer to its place than this is in it (m).
pub const PLACE_TOLERANCE_M: f64 = 0.02;
/// An object is upright when its z axis is nearer to the vertical (rad).
const UPRIGHT_RAD: f64 = 0.2;

/// A condition. Objects, places and sensors are indices of the
/// [`Setup`](crate::Setup).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// The gripper holds this object, or with `None` any.
    Holding(Option<usize>),
    /// The object is in a slot of the place and in no gripper, nearer than the
    /// tolerance in the plane (m).
    At {
        /// The object.
        object: usize,
        /// The place.
        place: usize,
        /// See above.
        tolerance_m: f64,
    },
    /// The object is at a point (m, world frame) and in no gripper, nearer than the
    /// tolerance in the plane (m) and less than half of its height above or below.
    AtPoint {
        /// The object.
        object: usize,
        /// Where its centre belongs.
        point: [f64; 3],
        /// See above.
        tolerance_m: f64,
    },
    /// The object's centre is at least that high and near the TCP.
    Lifted {
        /// The object.
        object: usize,
        /// Lowest height, world frame (m).
        above_m: f64,
        /// Largest distance from the TCP (m).
        within_m: f64,
    },
    /// No slot of the place is free.
    Full {
        /// The place.
        place: usize,
        /// As above.
        tolerance_m: f64,
    },
    /// The object's centre is below this height (m), or it is no longer in the cell.
    Fallen {
        /// The object.
        object: usize,
        /// The height, world frame.
        below_m: f64,
    },
    /// The arm reaches the object.
    Reachable(usize),
    /// The object does not move.
    AtRest(usize),
    /// No other object is on top of it; those in grippers do not count.
    Uncovered(usize),
    /// The object's z axis points up.
    Upright(usize),
    /// The sensor sees something.
    Sensor(usize),
    /// The gripper is open, or the suction off.
    GripperOpen,
    /// The operator has started the task.
    Started,
}

impl Condition {
    /// Whether the condition holds now. A condition about an object that is not in the cell
    /// does not.
    pub fn holds(&self, world: &World<'_>) -> bool {
        match *self {
            Self::Holding(object) => match object {
                Some(object) => world.held() == Some(object),
                None => world.held().is_some(),
            },
            Self::At {
                object,
                place,
                tolerance_m,
            } => world.slot_of(object, place, tolerance_m).is_some(),
            Self::AtPoint {
                object,
                point,
                tolerance_m,
            } => world.is_at(object, point.into(), tolerance_m),
            Self::Lifted {
                object,
                above_m,
                within_m,
            } => world.position(object).is_some_and(|position| {
                position.z >= above_m && (position - world.tcp_position()).norm() <= within_m
            }),
            Self::Full { place, tolerance_m } => {
                // No object has this index, so none is excluded from the occupied slots.
                world.free_slot(usize::MAX, place, tolerance_m).is_none()
            }
            Self::Fallen { object, below_m } => {
                let position = world.position(object);
                // An object that is parked has no position but is known: it fell out and was
                // cleared.
                let known = world.observation.object(object).is_some();
                known && position.is_none_or(|position| position.z < below_m)
            }
            Self::Reachable(object) => {
                let position = world.position(object);
                position.is_some_and(|position| world.reaches(position))
            }
            Self::AtRest(object) => world.object(object).is_some() && world.is_at_rest(object),
            Self::Uncovered(object) => world.object(object).is_some() && !world.is_covered(object),
            Self::Upright(object) => world.object(object).is_some_and(|pose| {
                let up = geometry::rotation(pose.orientation_wxyz) * Vector3::z();
                up.z > libm::cos(UPRIGHT_RAD)
            }),
            Self::Sensor(sensor) => {
                let sensors = &world.observation.equipment().sensors;
                sensors.get(sensor).is_some_and(|object| *object > 0)
            }
            Self::GripperOpen => world.is_open(),
            Self::Started => world.job.started,
        }
    }
}
