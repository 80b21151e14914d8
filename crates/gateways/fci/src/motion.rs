//! A step of a motion, and the rules of the robot for it.

use cell_model::ramp::RampState;
use nalgebra::{Isometry3, Vector6};
use serde::{Deserialize, Serialize};

use crate::JOINTS;
use crate::bytes::single;
use crate::error::Error;
use crate::kinematics::Kinematics;
use crate::limits::{ANGULAR, CYCLE_S, JointLimit, LINEAR, TOLERANCE, TORQUE_RATE};

/// Kind of the commands of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Generator {
    JointPosition,
    JointVelocity,
    CartesianPose,
    CartesianVelocity,
    /// Torques alone.
    None,
}

impl Generator {
    pub(crate) fn of(number: u32) -> Option<Self> {
        Some(match number {
            0 => Self::JointPosition,
            1 => Self::JointVelocity,
            2 => Self::CartesianPose,
            3 => Self::CartesianVelocity,
            4 => Self::None,
            _ => return None,
        })
    }

    fn is_cartesian(self) -> bool {
        matches!(self, Self::CartesianPose | Self::CartesianVelocity)
    }
}

/// A value that breaks a rule of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Broken {
    /// The error that it is.
    pub error: Error,
    /// The joint, from 0; `None` for a value of the end effector.
    pub joint: Option<usize>,
    /// The value.
    pub value: f64,
    /// Its limit.
    pub limit: f64,
    /// Unit of both.
    pub unit: &'static str,
}

/// What a cycle's motion starts from.
pub(crate) struct Before<'a> {
    pub(crate) limits: &'a [JointLimit; JOINTS],
    pub(crate) kinematics: &'a Kinematics,
    /// End effector in the flange frame.
    pub(crate) end_effector: &'a Isometry3<f64>,
    /// Joints as commanded last.
    pub(crate) joints: &'a [RampState; JOINTS],
    /// Positions of the joints as measured (rad).
    pub(crate) measured: &'a [f64; JOINTS],
    /// Pose of the end effector as commanded last.
    pub(crate) tool: &'a Tool,
    /// Whether this is the first command of the motion.
    pub(crate) is_first: bool,
}

/// The commanded motion of the end effector in the base frame.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Tool {
    pub(crate) pose: Isometry3<f64>,
    pub(crate) twist: Vector6<f64>,
    pub(crate) acceleration: Vector6<f64>,
}

impl Tool {
    pub(crate) fn at(pose: Isometry3<f64>) -> Self {
        Self {
            pose,
            twist: Vector6::zeros(),
            acceleration: Vector6::zeros(),
        }
    }
}

/// Rounding of a position of the end effector by a state, seen in its jerk: two numbers of 24
/// bits below 1 m, divided by the cube of a cycle.
const ROUNDING: [f64; 3] = [6.0e-5, 0.12, 240.0];

pub(crate) fn check_tool(before: &Before<'_>, tool: &Tool, by_pose: bool) -> Result<(), Broken> {
    let jerk = (tool.acceleration - before.tool.acceleration) / CYCLE_S;
    let errors = [
        Error::CARTESIAN_VELOCITY_LIMIT,
        Error::CARTESIAN_VELOCITY_DISCONTINUITY,
        Error::CARTESIAN_ACCELERATION_DISCONTINUITY,
    ];
    for (order, values) in [tool.twist, tool.acceleration, jerk].iter().enumerate() {
        let parts = [
            (values.fixed_rows::<3>(0).norm(), LINEAR[order], "m"),
            (values.fixed_rows::<3>(3).norm(), ANGULAR[order], "rad"),
        ];
        for (value, limit, base) in parts {
            // Twists need no room: they are divided by the cycle once less, so their rounding is
            // below the tolerance.
            let room = if by_pose { 2.0 * ROUNDING[order] } else { 0.0 };
            if value <= limit * (1.0 + TOLERANCE) + room {
                continue;
            }
            // A jump of the first command is a wrong start, as with joints.
            let is_start = before.is_first && by_pose;
            return Err(Broken {
                error: if is_start {
                    Error::CARTESIAN_START_POSE
                } else {
                    errors[order]
                },
                joint: None,
                value,
                limit,
                unit: unit(base, order),
            });
        }
    }
    Ok(())
}

fn unit(base: &str, order: usize) -> &'static str {
    match (base, order) {
        ("m", 0) => "m/s",
        ("m", 1) => "m/s²",
        ("m", _) => "m/s³",
        (_, 0) => "rad/s",
        (_, 1) => "rad/s²",
        _ => "rad/s³",
    }
}

/// Errors of joints by the broken limit: position, velocity, acceleration, jerk.
fn errors_of(generator: Generator) -> [Error; 4] {
    if generator.is_cartesian() {
        [
            Error::CARTESIAN_JOINT_POSITION,
            Error::CARTESIAN_JOINT_VELOCITY,
            Error::CARTESIAN_JOINT_VELOCITY_DISCONTINUITY,
            Error::CARTESIAN_JOINT_ACCELERATION_DISCONTINUITY,
        ]
    } else {
        [
            Error::POSITION_LIMIT,
            Error::VELOCITY_LIMIT,
            Error::VELOCITY_DISCONTINUITY,
            Error::ACCELERATION_DISCONTINUITY,
        ]
    }
}

pub(crate) fn check(
    before: &Before<'_>,
    generator: Generator,
    after: &[RampState; JOINTS],
) -> Result<(), Broken> {
    let by_position = matches!(
        generator,
        Generator::JointPosition | Generator::CartesianPose
    );
    let errors = errors_of(generator);
    let joints = before.joints.iter().zip(after).zip(before.limits);
    for (joint, ((last, next), limit)) in joints.enumerate() {
        let broken = |error, value: f64, limit, unit| Broken {
            error,
            joint: Some(joint),
            value,
            limit,
            unit,
        };
        let [_, acceleration, jerk] = smaller(by_position, last, next);
        // Not `>`: a value that is not a number is above every limit.
        let is_above = |value: f64, limit: f64| !(value.abs() <= limit * (1.0 + TOLERANCE));
        let jumps = is_above(acceleration, limit.acceleration);
        // A jump of the first command is a wrong start, also where it breaks other limits.
        if jumps && before.is_first && generator == Generator::JointPosition {
            let off = next.position - last.position;
            return Err(broken(Error::START_POSE, off, 0.0, "rad from the start"));
        }
        if !limit.allows(next.position) {
            let end = limit.nearest_end(next.position);
            return Err(broken(errors[0], next.position, end, "rad"));
        }
        // At the last position: libfranka's rate limiter takes the limit at `q_d` of the state.
        let top = limit.velocity_at(last.position, next.velocity);
        // libfranka widens this limit by the same number.
        if next.velocity.abs() > top + TOLERANCE + f64::from(f32::EPSILON) / CYCLE_S {
            return Err(broken(errors[1], next.velocity, top, "rad/s"));
        }
        if jumps {
            return Err(broken(
                errors[2],
                acceleration,
                limit.acceleration,
                "rad/s²",
            ));
        }
        if is_above(jerk, limit.jerk) {
            return Err(broken(errors[3], jerk, limit.jerk, "rad/s³"));
        }
    }
    Ok(())
}

/// Checks that the arm can be at rest in the cycle after the last command of a motion, with which
/// it is at `before`.
// The robot takes the derivatives of a motion across its end, too: a client that ends while the arm
// moves gets an error of discontinuity, and not a limit of its own.
pub(crate) fn check_end(before: &Before<'_>, generator: Generator) -> Result<(), Broken> {
    if generator.is_cartesian() {
        let tool = Tool {
            acceleration: -before.tool.twist / CYCLE_S,
            ..Tool::at(before.tool.pose)
        };
        check_tool(before, &tool, generator == Generator::CartesianPose)?;
    }
    let at_rest = before.joints.map(|joint| RampState {
        position: joint.position,
        ..RampState::default()
    });
    check(before, generator, &at_rest)
}

/// Velocity, acceleration and jerk from `last` to `next`. A state has numbers of 24 bits: a
/// client that continues from a state is judged by these, one that continues from its own
/// numbers by those, whichever is less.
fn smaller(by_position: bool, last: &RampState, next: &RampState) -> [f64; 3] {
    let own = rates(next, last);
    if !by_position {
        return own;
    }
    let round = |value: f64| f64::from(single(value));
    let sent = RampState {
        position: round(last.position),
        velocity: round(last.velocity),
        acceleration: round(last.acceleration),
    };
    let of_state = rates(next, &sent);
    std::array::from_fn(|order| {
        if own[order].abs() < of_state[order].abs() {
            own[order]
        } else {
            of_state[order]
        }
    })
}

fn rates(next: &RampState, last: &RampState) -> [f64; 3] {
    let velocity = (next.position - last.position) / CYCLE_S;
    let acceleration = (velocity - last.velocity) / CYCLE_S;
    [
        velocity,
        acceleration,
        (acceleration - last.acceleration) / CYCLE_S,
    ]
}

/// Checks commanded torques against those of the last cycle.
pub(crate) fn check_torques(
    limits: &[JointLimit; JOINTS],
    last: &[f64; JOINTS],
    wanted: &[f64; JOINTS],
) -> Result<(), Broken> {
    let joints = limits.iter().zip(last).zip(wanted);
    for (joint, ((limit, last), wanted)) in joints.enumerate() {
        let rate = (wanted - last) / CYCLE_S;
        let (error, value, limit, unit) = if !(wanted.abs() <= limit.torque * (1.0 + TOLERANCE)) {
            (Error::TORQUE_RANGE, *wanted, limit.torque, "N·m")
        } else if !(rate.abs() <= TORQUE_RATE * (1.0 + TOLERANCE)) {
            (Error::TORQUE_DISCONTINUITY, rate, TORQUE_RATE, "N·m/s")
        } else {
            continue;
        };
        return Err(Broken {
            error,
            joint: Some(joint),
            value,
            limit,
            unit,
        });
    }
    Ok(())
}
