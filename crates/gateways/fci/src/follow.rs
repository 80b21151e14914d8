//! From a command of a client to joint setpoints.

use cell_model::ramp::RampState;
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3, Vector6};

use crate::JOINTS;
use crate::datagram::{Elbow, RobotCommand};
use crate::error::Error;
use crate::kinematics::{Joints, smallest};
use crate::limits::{CYCLE_S, TOLERANCE};
use crate::motion::{Before, Broken, Generator, Tool, check, check_tool};

/// Rounding of positions by a state, seen through the inverse kinematics (rad).
const START_ROUNDING: f64 = 1.0e-6;

/// Joints and end effector after `command`.
pub(crate) fn follow(
    before: &Before<'_>,
    generator: Generator,
    command: &RobotCommand,
) -> Result<([RampState; JOINTS], Tool), Broken> {
    let mut tool = *before.tool;
    let joints = match generator {
        Generator::JointPosition => positions(before, &command.positions),
        Generator::JointVelocity => velocities(before, &command.velocities),
        Generator::CartesianPose => {
            let pose = pose_of(&command.pose)?;
            tool = moved(before.tool, &pose);
            check_tool(before, &tool, true)?;
            check_elbow(before, command)?;
            by_pose(before, &pose, elbow_step(before, command))?
        }
        Generator::CartesianVelocity => {
            let twist = Vector6::from(command.twist);
            tool = led(before.tool, &twist);
            check_tool(before, &tool, false)?;
            check_elbow(before, command)?;
            by_twist(before, &twist, elbow_step(before, command))
        }
        Generator::None => *before.joints,
    };
    if generator != Generator::None {
        check(before, generator, &joints)?;
    }
    Ok((joints, tool))
}

/// The start at rest where the first command of positions or poses is, if that is between the
/// commanded and the measured pose: clients of libfranka 0.21 begin at the measured one.
pub(crate) fn start(
    before: &Before<'_>,
    generator: Generator,
    command: &RobotCommand,
) -> Option<([RampState; JOINTS], Tool)> {
    let positions = match generator {
        Generator::JointPosition => command.positions,
        Generator::CartesianPose => {
            let pose = pose_of(&command.pose).ok()?;
            let (at, end) = (at(before), before.end_effector);
            let elbow = elbow_step(before, command);
            before.kinematics.solve((&at, elbow), end, &pose)?.into()
        }
        _ => return None,
    };
    let joints = before.joints.iter().zip(before.measured).zip(&positions);
    let mut off = joints.map(|((last, measured), wanted)| {
        (wanted - last.position).abs() - (measured - last.position).abs()
    });
    if !off.all(|off| off <= START_ROUNDING) {
        return None;
    }
    let joints = positions.map(|position| RampState {
        position,
        ..RampState::default()
    });
    Some((joints, rest(before, &joints)))
}

/// The end effector at rest.
pub(crate) fn rest(before: &Before<'_>, joints: &[RampState; JOINTS]) -> Tool {
    let positions = Joints::from_fn(|joint, _| joints[joint].position);
    Tool::at(before.kinematics.flange(&positions) * before.end_effector)
}

fn positions(before: &Before<'_>, wanted: &[f64; JOINTS]) -> [RampState; JOINTS] {
    std::array::from_fn(|joint| {
        let last = before.joints[joint];
        let velocity = (wanted[joint] - last.position) / CYCLE_S;
        RampState {
            position: wanted[joint],
            velocity,
            acceleration: (velocity - last.velocity) / CYCLE_S,
        }
    })
}

fn velocities(before: &Before<'_>, wanted: &[f64; JOINTS]) -> [RampState; JOINTS] {
    std::array::from_fn(|joint| {
        let last = before.joints[joint];
        RampState {
            position: last.position + wanted[joint] * CYCLE_S,
            velocity: wanted[joint],
            acceleration: (wanted[joint] - last.velocity) / CYCLE_S,
        }
    })
}

fn at(before: &Before<'_>) -> Joints {
    Joints::from_fn(|joint, _| before.joints[joint].position)
}

/// How far joint 3 moves in this cycle for the commanded elbow (rad).
fn elbow_step(before: &Before<'_>, command: &RobotCommand) -> f64 {
    let now = before.joints[2].position;
    // A jump is left to the checks of the joints.
    command.elbow.map_or(0.0, |elbow| elbow.position - now)
}

/// Checks the elbow of a command. Its velocity, acceleration and jerk are those of joint 3, which
/// has the same limits.
fn check_elbow(before: &Before<'_>, command: &RobotCommand) -> Result<(), Broken> {
    let Some(elbow) = command.elbow else {
        return Ok(());
    };
    let broken = |error, joint, value, limit, unit| Broken {
        error,
        joint: Some(joint),
        value,
        limit,
        unit,
    };
    let sign = Elbow::of(&before.joints.map(|joint| joint.position)).sign;
    if elbow.sign != sign {
        let unit = "as the flip direction of the elbow";
        return Err(broken(Error::ELBOW_SIGN, 3, elbow.sign, sign, unit));
    }
    let limit = &before.limits[2];
    if !limit.allows(elbow.position) {
        let end = limit.nearest_end(elbow.position);
        return Err(broken(Error::ELBOW_LIMIT, 2, elbow.position, end, "rad"));
    }
    let step = elbow_step(before, command);
    // The longest step of one cycle from rest.
    let is_near = step.abs() <= limit.acceleration * (1.0 + TOLERANCE) * CYCLE_S * CYCLE_S;
    if before.is_first && !is_near {
        let unit = "rad from the start";
        return Err(broken(Error::START_ELBOW, 2, step, 0.0, unit));
    }
    Ok(())
}

fn by_pose(
    before: &Before<'_>,
    pose: &Isometry3<f64>,
    elbow: f64,
) -> Result<[RampState; JOINTS], Broken> {
    let found = before
        .kinematics
        .solve((&at(before), elbow), before.end_effector, pose);
    let found = found.ok_or(Broken {
        error: Error::CARTESIAN_JOINT_POSITION,
        joint: None,
        value: pose.translation.vector.norm(),
        // The reach in the maker's data sheet.
        limit: 0.855,
        unit: "m from the base, reached by no joint positions",
    })?;
    Ok(positions(before, &found.into()))
}

fn by_twist(before: &Before<'_>, twist: &Vector6<f64>, elbow: f64) -> [RampState; JOINTS] {
    let (jacobian, _) = before.kinematics.jacobian(&at(before), before.end_effector);
    let found = smallest(&jacobian, twist, elbow / CYCLE_S).unwrap_or_default();
    velocities(before, &found.into())
}

/// The pose in a message, column-major.
pub(crate) fn pose_of(numbers: &[f64; 16]) -> Result<Isometry3<f64>, Broken> {
    let matrix = Matrix3::from_fn(|row, column| numbers[4 * column + row]);
    let off = (matrix * matrix.transpose() - Matrix3::identity()).amax();
    let bottom = [numbers[3], numbers[7], numbers[11], numbers[15] - 1.0];
    let off = bottom
        .iter()
        .fold(off, |worst, value| worst.max(value.abs()));
    // Numbers of a state have 24 bits.
    if !(off < 1.0e-5) || matrix.determinant() < 0.0 {
        return Err(Broken {
            error: Error::INVALID_FRAME,
            joint: None,
            value: off,
            limit: 1.0e-5,
            unit: "off a rigid transformation",
        });
    }
    let rotation = Rotation3::from_matrix_unchecked(matrix);
    Ok(Isometry3::from_parts(
        Vector3::new(numbers[12], numbers[13], numbers[14]).into(),
        UnitQuaternion::from_rotation_matrix(&rotation),
    ))
}

fn moved(last: &Tool, pose: &Isometry3<f64>) -> Tool {
    let linear = (pose.translation.vector - last.pose.translation.vector) / CYCLE_S;
    let turn = last.pose.rotation.rotation_to(&pose.rotation).scaled_axis() / CYCLE_S;
    let twist = Vector6::new(linear.x, linear.y, linear.z, turn.x, turn.y, turn.z);
    Tool {
        pose: *pose,
        twist,
        acceleration: (twist - last.twist) / CYCLE_S,
    }
}

fn led(last: &Tool, twist: &Vector6<f64>) -> Tool {
    let linear = twist.fixed_rows::<3>(0) * CYCLE_S;
    let angular = twist.fixed_rows::<3>(3) * CYCLE_S;
    Tool {
        pose: Isometry3::from_parts(
            (last.pose.translation.vector + linear).into(),
            UnitQuaternion::from_scaled_axis(angular.into_owned()) * last.pose.rotation,
        ),
        twist: *twist,
        acceleration: (twist - last.twist) / CYCLE_S,
    }
}
