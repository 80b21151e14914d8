//! Pose and Jacobian of the flange of an arm of seven revolute joints.

use cell_model::Robot;
use cell_model::robots::robot::joint_motion;
use nalgebra::{Isometry3, Matrix6, SMatrix, SVector, Vector6};
use rmp::Joint;

use crate::JOINTS;
use crate::hand::FLANGE_M;

/// Joint values of the arm.
pub(crate) type Joints = SVector<f64, JOINTS>;
/// Derivatives of position and orientation by joint, in the base frame.
pub(crate) type Jacobian = SMatrix<f64, 6, JOINTS>;

/// Damping of the inverse kinematics, in the square: regular at singular poses, and below
/// 1e-6 of the motion elsewhere.
const DAMPING: f64 = 1.0e-6;
/// Iterations of the inverse kinematics: a step of 1 ms needs two.
const ITERATIONS: usize = 8;
/// The joint that chooses among the positions that have the same pose of the tool.
const ELBOW: usize = 2;
/// How much less it moves than the others where they can give the motion: without a command for
/// the elbow it stays where it is.
const ELBOW_WEIGHT: f64 = 100.0;
/// Error at which the inverse kinematics ends (m, rad).
const ENOUGH: f64 = 1.0e-12;

/// The kinematics of an arm.
#[derive(Clone, Debug)]
pub(crate) struct Kinematics {
    joints: Vec<Joint>,
    /// Flange in the frame of the last joint.
    flange: Isometry3<f64>,
}

impl Kinematics {
    /// Of `robot`, whose controlled joints are a serial chain.
    pub(crate) fn new(robot: &Robot) -> Self {
        let joints = robot.arm_joints.iter();
        Self {
            joints: joints
                .filter_map(|&joint| robot.chain.joints().get(joint).cloned())
                .collect(),
            flange: Isometry3::translation(0.0, 0.0, FLANGE_M),
        }
    }

    /// Pose of the flange in the base frame.
    pub(crate) fn flange(&self, positions: &Joints) -> Isometry3<f64> {
        let mut pose = Isometry3::identity();
        for (joint, position) in self.joints.iter().zip(positions) {
            pose *= joint.origin * joint_motion(joint, *position);
        }
        pose * self.flange
    }

    /// Jacobian at a point that the flange carries, and its pose in the base frame.
    pub(crate) fn jacobian(
        &self,
        positions: &Joints,
        end_effector: &Isometry3<f64>,
    ) -> (Jacobian, Isometry3<f64>) {
        let mut jacobian = Jacobian::zeros();
        let mut pose = Isometry3::identity();
        for (index, (joint, position)) in self.joints.iter().zip(positions).enumerate() {
            pose *= joint.origin * joint_motion(joint, *position);
            let axis = pose.rotation * joint.axis;
            let origin = pose.translation.vector;
            // The position of the joint, for now: its lever arm needs the end effector.
            let mut column = jacobian.column_mut(index);
            column.fixed_rows_mut::<3>(0).copy_from(&origin);
            column.fixed_rows_mut::<3>(3).copy_from(&axis);
        }
        pose *= self.flange * end_effector;
        for index in 0..JOINTS {
            let mut column = jacobian.column_mut(index);
            let origin = column.fixed_rows::<3>(0).into_owned();
            let axis = column.fixed_rows::<3>(3).into_owned();
            let linear = axis.cross(&(pose.translation.vector - origin));
            column.fixed_rows_mut::<3>(0).copy_from(&linear);
        }
        (jacobian, pose)
    }

    /// Joint positions near `start` with the end effector at `goal`, and joint 3 moved by `elbow`
    /// (rad). `None` where it cannot be reached.
    pub(crate) fn solve(
        &self,
        (start, elbow): (&Joints, f64),
        end_effector: &Isometry3<f64>,
        goal: &Isometry3<f64>,
    ) -> Option<Joints> {
        let mut positions = *start;
        let mut error = f64::INFINITY;
        let mut elbow = elbow;
        for _ in 0..ITERATIONS {
            let (jacobian, pose) = self.jacobian(&positions, end_effector);
            let twist = difference(&pose, goal);
            error = twist.amax();
            if error < ENOUGH && elbow == 0.0 {
                break;
            }
            // The elbow is moved once: each further iteration would add the same step.
            positions += smallest(&jacobian, &twist, std::mem::take(&mut elbow))?;
        }
        // A micrometre or microradian: beyond it the pose is not followed.
        (error < 1.0e-6).then_some(positions)
    }
}

/// The smallest joint motion that gives `twist` (weighted and damped least squares; Nakamura and
/// Hanafusa, 1986), with joint 3 near `elbow`.
pub(crate) fn smallest(jacobian: &Jacobian, twist: &Vector6<f64>, elbow: f64) -> Option<Joints> {
    let mut weighted = *jacobian;
    weighted.column_mut(ELBOW).scale_mut(1.0 / ELBOW_WEIGHT);
    let square = weighted * jacobian.transpose() + Matrix6::identity() * DAMPING;
    let rest = twist - jacobian.column(ELBOW) * elbow;
    let mut motion = weighted.transpose() * square.cholesky()?.solve(&rest);
    motion[ELBOW] += elbow;
    Some(motion)
}

/// The motion from `here` to `there` in the base frame: linear, then angular.
fn difference(here: &Isometry3<f64>, there: &Isometry3<f64>) -> Vector6<f64> {
    let linear = there.translation.vector - here.translation.vector;
    let angular = here.rotation.rotation_to(&there.rotation).scaled_axis();
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}
