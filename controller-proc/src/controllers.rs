//! The controllers that can move an arm, chosen by [`ipc_types::ArmGoal::selector`].
//!
//! RMPflow has number 0 and always exists. Each other controller gives joint positions, cycle
//! by cycle; a [`Follower`](crate::follower::Follower) behind it keeps the limits, so it
//! cannot command a motion that the robot cannot make. It does not consider obstacles.

use std::sync::Arc;

use cell_model::Cell;
use ipc_types::TICK_S;
use nalgebra::{DMatrix, Isometry3, Matrix6, UnitQuaternion, Vector3, Vector6};
use rmp::{RmpFlow, TargetId};

use crate::controller::{Controller, Setpoint};
use crate::error::RmpFlowError;
use crate::robot_state::{JointSpace, RobotState};

pub use ipc_types::decision::PLANNED;

/// Number of RMPflow.
pub const RMPFLOW: u32 = 0;
/// Number of the joint-space PD controller.
pub const JOINT_PD: u32 = 1;
/// Number of the Cartesian line.
pub const LINE: u32 = 2;

/// The arm that a controller is created for.
#[derive(Clone, Debug)]
pub struct ArmContext<'a> {
    /// The cell.
    pub cell: &'a Cell,
    /// Index of the arm.
    pub arm: usize,
    /// Names of its controlled joints, in the order of commands.
    pub joints: JointSpace,
}

type Make = Arc<dyn Fn(&ArmContext<'_>) -> Result<Box<dyn Controller>, RmpFlowError> + Send + Sync>;

/// Number, name and controller.
pub(crate) type Made = (u32, &'static str, Box<dyn Controller>);

/// The controllers of a program. Cheap to clone.
#[derive(Clone)]
pub struct Controllers {
    list: Vec<(u32, &'static str, Make)>,
}

impl Default for Controllers {
    /// The built-in ones: [`JOINT_PD`] and [`LINE`], beside RMPflow.
    fn default() -> Self {
        Self { list: Vec::new() }
            .with(JOINT_PD, "joint_pd", |_| Ok(Box::new(Posture)))
            .with(LINE, "line", |context| Ok(Box::new(Line::new(context)?)))
    }
}

impl Controllers {
    /// Adds a controller under a number other than [`RMPFLOW`] and [`PLANNED`]; a later one
    /// of the same number takes its place.
    #[must_use]
    pub fn with(
        mut self,
        selector: u32,
        name: &'static str,
        make: impl Fn(&ArmContext<'_>) -> Result<Box<dyn Controller>, RmpFlowError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        // A user's controller replaces a built-in one, but never RMPflow: a hold needs it.
        self.list.retain(|(known, ..)| *known != selector);
        if selector != RMPFLOW && selector != PLANNED {
            self.list.push((selector, name, Arc::new(make)));
        }
        self
    }

    /// Makes all of them for an arm: number, name and controller.
    ///
    /// # Errors
    /// The first that cannot be made.
    pub(crate) fn make(&self, cell: &Cell, arm: usize) -> Result<Vec<Made>, RmpFlowError> {
        let spec = cell.arms.get(arm).ok_or(RmpFlowError::NoSuchArm(arm))?;
        let joints = JointSpace::new(spec.robot.arm_joint_names()).unwrap_or_default();
        let context = ArmContext { cell, arm, joints };
        let made = self.list.iter().map(|(selector, name, make)| {
            let controller = make(&context)?;
            Ok((*selector, *name, controller))
        });
        made.collect()
    }
}

/// Joint-space PD to the posture of the goal for the joints that it names; the others brake.
/// The law itself is in the follower.
struct Posture;

impl Controller for Posture {
    fn reset(&mut self, _estimated: &RobotState) -> bool {
        true
    }

    fn forward(&mut self, _estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        Some(setpoint.joints)
    }
}

/// Speed of the TCP on a line (m/s).
const LINE_SPEED_M_S: f64 = 0.15;
/// Speed at which the TCP turns (rad/s).
const LINE_TURN_RAD_S: f64 = 0.6;
/// Damping of the inverse kinematics: singular poses are passed slowly.
const LINE_DAMPING: f64 = 0.05;
/// Gain of the inverse kinematics (1/s).
const LINE_GAIN: f64 = 20.0;

/// Moves the TCP along a straight line from its present pose to the target, turning it evenly,
/// by damped least squares (Nakamura and Hanafusa, 1986).
struct Line {
    flow: RmpFlow,
    tool: TargetId,
    jacobian: DMatrix<f64>,
    joints: usize,
    /// Joint velocities of an arm at rest.
    rest: Vec<f64>,
    /// Commanded joint positions, then position (m) and rotation (w x y z) of the point on the
    /// line.
    memory: Vec<f64>,
}

impl Line {
    fn new(context: &ArmContext<'_>) -> Result<Self, RmpFlowError> {
        let cell = context.cell;
        let spec = cell.arms.get(context.arm);
        let spec = spec.ok_or(RmpFlowError::NoSuchArm(context.arm))?;
        let robot = &spec.robot;
        let setup = |source| RmpFlowError::Setup {
            robot: robot.name.clone(),
            source,
        };
        // Kinematics alone are needed, so without obstacles.
        let mut flow = robot.motion_policies(0).map_err(setup)?;
        let tool = flow
            .add_target_frame(robot.tcp_frame_name())
            .map_err(setup)?;
        let joints = robot.arm_joints.len();
        let mut memory = spec.home.clone();
        // The length is constant from here on: it is part of the layout of the checkpoint.
        memory.resize(joints, 0.0);
        memory.extend([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        Ok(Self {
            flow,
            tool,
            jacobian: DMatrix::zeros(6, joints),
            joints,
            rest: vec![0.0; joints],
            memory,
        })
    }

    fn pose(&mut self) -> Option<Isometry3<f64>> {
        let positions = self.memory.get(..self.joints)?;
        self.flow.target_frame_pose_at(self.tool, positions).ok()?
    }

    fn point(&self) -> Option<Isometry3<f64>> {
        let [x, y, z, w, i, j, k] = self.memory.get(self.joints..)? else {
            return None;
        };
        let rotation = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(*w, *i, *j, *k));
        Some(Isometry3::from_parts(
            Vector3::new(*x, *y, *z).into(),
            rotation,
        ))
    }

    fn set_point(&mut self, pose: &Isometry3<f64>) {
        let (p, q) = (pose.translation.vector, pose.rotation);
        let values = [p.x, p.y, p.z, q.w, q.i, q.j, q.k];
        for (slot, value) in self.memory.iter_mut().skip(self.joints).zip(values) {
            *slot = value;
        }
    }

    /// Moves the point on the line towards the target by one cycle.
    fn advance(&mut self, setpoint: &Setpoint) -> Option<Isometry3<f64>> {
        let point = self.point()?;
        // Without a target the point stays, and the arm with it.
        let Some(position) = setpoint.position else {
            return Some(point);
        };
        let way = position - point.translation.vector;
        let step = (LINE_SPEED_M_S * TICK_S / way.norm().max(1.0e-9)).min(1.0);
        let wanted = setpoint.orientation.unwrap_or(point.rotation);
        let turn = point.rotation.rotation_to(&wanted).scaled_axis();
        let turn = turn * (LINE_TURN_RAD_S * TICK_S / turn.norm().max(1.0e-9)).min(1.0);
        let next = Isometry3::from_parts(
            (point.translation.vector + way * step).into(),
            UnitQuaternion::from_scaled_axis(turn) * point.rotation,
        );
        self.set_point(&next);
        Some(next)
    }

    /// Velocity of the tool towards `goal`, as weights of the rows of the Jacobian: the joint
    /// velocities are its transpose times these.
    fn towards(&mut self, goal: &Isometry3<f64>) -> Option<Vector6<f64>> {
        let here = self.pose()?;
        let positions = self.memory.get(..self.joints)?;
        self.flow.evaluate(positions, &self.rest).ok()?;
        self.flow
            .target_frame_jacobian(self.tool, &mut self.jacobian)
            .ok()?;
        let off = goal.translation.vector - here.translation.vector;
        let turn = here.rotation.rotation_to(&goal.rotation).scaled_axis();
        let error = Vector6::new(off.x, off.y, off.z, turn.x, turn.y, turn.z);
        // The damping keeps the matrix regular where the Jacobian is singular.
        let mut square = Matrix6::identity() * (LINE_DAMPING * LINE_DAMPING);
        for column in self.jacobian.column_iter() {
            let column = column.fixed_rows::<6>(0);
            square += column * column.transpose();
        }
        Some(square.cholesky()?.solve(&(error * LINE_GAIN)))
    }
}

impl Controller for Line {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        let n = self.joints;
        for (slot, position) in self.memory.iter_mut().zip(estimated.positions.first(n)) {
            *slot = *position;
        }
        let Some(pose) = self.pose() else {
            return false;
        };
        self.set_point(&pose);
        true
    }

    fn forward(&mut self, _estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        let goal = self.advance(setpoint)?;
        let weights = self.towards(&goal)?;
        let mut wanted = RobotState::EMPTY;
        let columns = self.memory.iter_mut().zip(self.jacobian.column_iter());
        for (joint, (slot, column)) in columns.enumerate() {
            *slot += column.dot(&weights) * TICK_S;
            wanted.positions.set(joint, *slot);
        }
        Some(wanted)
    }

    fn memory(&mut self) -> &mut [f64] {
        &mut self.memory
    }
}
