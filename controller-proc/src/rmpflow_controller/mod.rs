//! RMPflow as a controller: it integrates its own state, so its command never jumps, and
//! resolves within the limits of the robot.

use cell_model::Cell;
use ipc_types::{TICK_S, WorldState};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rmp::{
    CollisionParameters, CspaceTargetParameters, JointLimits, MotionState, RmpFlow, TargetId,
};

pub use crate::error::RmpFlowError;

use crate::controller::{Controller, Setpoint};
use crate::held_object::HeldObject;
use crate::planning::planner::PlannedArm;
use crate::planning::{Moment, PlanGoal, Planning};
use crate::robot_state::RobotState;
use crate::surroundings::{Among, Surroundings};

mod checkpoint;

/// Speed below which a joint is at rest (rad/s or m/s).
const STANDSTILL: f64 = 1.0e-6;
/// Clearance that is reported without an obstacle (m).
// Finite, as all numbers of a message have to be.
const NO_OBSTACLE_M: f64 = 1.0e3;

/// Mode of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// Following the setpoint.
    Follow,
    /// Ending the motion within the limits.
    Brake,
    /// At rest: stays where it stopped, and still evades obstacles.
    Stay,
}

/// A target of the tool in the base frame (m).
#[derive(Clone, Copy, Debug, Default)]
struct Target {
    position: Option<Vector3<f64>>,
    orientation: Option<UnitQuaternion<f64>>,
}

/// Gains of posture and obstacles.
#[derive(Clone, Copy, Debug)]
struct Gains {
    own: (CspaceTargetParameters, CollisionParameters),
    /// Gains while a path leads the arm.
    path: (CspaceTargetParameters, CollisionParameters),
    is_following: bool,
}

/// The arm's motion.
pub struct RmpFlowController {
    flow: RmpFlow,
    tool: TargetId,
    state: MotionState,
    limits: JointLimits,
    default_posture: Vec<f64>,
    posture: Vec<f64>,
    /// Position and orientation of the tool that the policies have.
    target: Target,
    surroundings: Surroundings,
    held: HeldObject,
    planning: Planning,
    /// Whether paths lead the arm with any goal.
    always_plans: bool,
    gains: Gains,
    tick: u64,
    mode: Mode,
    tool_pose: Isometry3<f64>,
    min_clearance: f64,
    clipped_joints: u64,
}

impl RmpFlowController {
    /// The motion of the cell's arm number `arm` among fixtures and objects that
    /// are obstacles and the other arms.
    ///
    /// # Errors
    ///
    /// [`RmpFlowError`] if the cell has no arm of this number, or the robot's files contradict
    /// each other.
    pub fn new(cell: &Cell, arm: usize) -> Result<Self, RmpFlowError> {
        let spec = cell.arms.get(arm).ok_or(RmpFlowError::NoSuchArm(arm))?;
        let robot = &spec.robot;
        // Limits are checked once, here: the resolve relies on them in each cycle.
        let limits = robot.limits();
        limits
            .validate(robot.arm_joints.len())
            .map_err(|source| RmpFlowError::Limits {
                robot: robot.name.clone(),
                source,
            })?;
        let Among {
            flow,
            tool,
            surroundings,
            capacity,
        } = Among::new(cell, arm, spec)?;
        Ok(Self {
            tool,
            state: MotionState::at_rest(&spec.home),
            limits,
            default_posture: robot.default_joint_positions.clone(),
            posture: robot.default_joint_positions.clone(),
            target: Target::default(),
            surroundings,
            held: HeldObject::new(cell, arm),
            planning: Planning::new(PlannedArm::new(robot)?, capacity),
            always_plans: spec.planner,
            gains: Gains {
                own: (robot.rmpflow.cspace_target, robot.rmpflow.collision),
                path: plan::led(&robot.rmpflow),
                is_following: false,
            },
            tick: 0,
            // Until the first goal the arm stays where it is.
            mode: Mode::Stay,
            tool_pose: Isometry3::identity(),
            min_clearance: NO_OBSTACLE_M,
            clipped_joints: 0,
            flow,
        })
    }

    /// Takes the poses of all that may move, for arm `arm`: the other arms, the objects of
    /// `object_mask`, and the object on the tool.
    pub fn observe(&mut self, state: &WorldState, arm: usize, object_mask: u64) {
        self.tick = state.header.tick;
        // The held object first: as an obstacle it would repel the arm that holds it.
        if let Some(arm) = state.arms().get(arm) {
            self.held.observe(state, arm, &mut self.flow, self.tool);
        }
        let (held, set) = (self.held.object(), self.flow.obstacles_mut());
        self.surroundings.observe_arms(state.arms(), set);
        self.surroundings
            .observe_objects(state.objects(), object_mask, held, set);
    }

    /// Sets whether paths lead the arm around obstacles; if the cell has a planner for the arm
    /// they always do.
    pub fn follow_paths(&mut self, follow: bool) {
        self.planning.set_on(follow || self.always_plans);
    }

    /// TCP of the integrated state in the base frame.
    pub fn tool_pose(&self) -> Isometry3<f64> {
        self.tool_pose
    }

    /// TCP in the base frame at the positions of `joints`.
    pub(crate) fn tool_pose_at(&mut self, joints: &RobotState) -> Isometry3<f64> {
        let positions = joints.positions.first(self.state.positions.len());
        let pose = self.flow.target_frame_pose_at(self.tool, positions);
        pose.ok().flatten().unwrap_or(self.tool_pose)
    }

    /// Smallest distance of a sphere from an obstacle in the last cycle (m).
    pub fn min_clearance(&self) -> f64 {
        self.min_clearance
    }

    /// Joints held back by a limit in the last cycle, bit per joint.
    pub fn clipped_joints(&self) -> u64 {
        self.clipped_joints
    }

    fn apply(&mut self, setpoint: &Setpoint) -> Result<(), rmp::SetupError> {
        let mut fixtures = setpoint.obstacle_mask;
        // Fixtures that are not solid guide motion policies around something; paths need no
        // such guide (ADR 0021).
        if self.planning.is_following() {
            fixtures &= self.surroundings.solid_mask();
        }
        self.surroundings
            .mask_fixtures(fixtures, self.flow.obstacles_mut());
        // A hold gives the path up: after it the arm may be at any place.
        if setpoint.hold {
            self.planning.clear();
            self.set_gains()?;
            return self.hold();
        }
        self.mode = Mode::Follow;
        // A joint without a wanted position tends to the default posture, not to its last one.
        for (joint, slot) in self.posture.iter_mut().enumerate() {
            let wanted = setpoint.joints.positions.get(joint);
            *slot = wanted
                .or(self.default_posture.get(joint).copied())
                .unwrap_or(*slot);
        }
        let joints = match setpoint.goal {
            None if self.planning.is_on() => self.joint_goal()?,
            _ => None,
        };
        self.plan(setpoint.goal.or(joints).as_ref())?;
        let goal = Target {
            position: setpoint.position,
            orientation: setpoint.orientation,
        };
        let Some((next, is_end)) = self.planning.lead(&self.state.positions) else {
            self.flow.set_posture(&self.posture)?;
            return self.lead(goal);
        };
        self.flow.set_posture(next)?;
        let pose = self.flow.target_frame_pose_at(self.tool, next)?;
        let on_path = Target {
            position: pose.map(|pose| pose.translation.vector),
            orientation: pose.map(|pose| pose.rotation),
        };
        // At the end of the path the goal itself attracts the tool, with its corridor.
        self.lead(if is_end { goal } else { on_path })
    }

    /// The goal of an arm whose joints go to the posture.
    fn joint_goal(&mut self) -> Result<Option<PlanGoal>, rmp::SetupError> {
        let pose = self.flow.target_frame_pose_at(self.tool, &self.posture)?;
        Ok(pose.map(|pose| PlanGoal {
            pose,
            approach: Vector3::zeros(),
            by_joints: true,
        }))
    }

    /// Requests a path or a reason if one is needed, and takes an answer.
    fn plan(&mut self, goal: Option<&PlanGoal>) -> Result<(), rmp::SetupError> {
        self.planning.update(&Moment {
            tick: self.tick,
            goal,
            tool: &self.tool_pose,
            state: &self.state,
            posture: &self.posture,
            held: self.held.balls(),
            obstacles: self.flow.obstacles(),
            solid_mask: self.surroundings.solid_mask(),
        });
        self.set_gains()
    }

    // Only at a switch: setting them validates and computes the constants of the leaf again.
    fn set_gains(&mut self) -> Result<(), rmp::SetupError> {
        let is_following = self.planning.is_following();
        if is_following != self.gains.is_following {
            let gains = self.gains;
            let (posture, collision) = if is_following { gains.path } else { gains.own };
            self.flow.set_gains(posture, collision)?;
            self.gains.is_following = is_following;
        }
        Ok(())
    }

    /// Its plans.
    pub(crate) fn planning(&self) -> &Planning {
        &self.planning
    }

    /// Its plans.
    pub(crate) fn planning_mut(&mut self) -> &mut Planning {
        &mut self.planning
    }

    fn lead(&mut self, target: Target) -> Result<(), rmp::SetupError> {
        self.flow.set_position_target(self.tool, target.position)?;
        self.target.position = target.position;
        self.flow
            .set_orientation_target(self.tool, target.orientation)?;
        self.target.orientation = target.orientation;
        Ok(())
    }

    /// Ends the motion, then stays at the pose where it ended.
    fn hold(&mut self) -> Result<(), rmp::SetupError> {
        if self.mode == Mode::Follow {
            self.mode = Mode::Brake;
        }
        let stands = self.state.velocities.iter().all(|v| v.abs() < STANDSTILL);
        if self.mode == Mode::Brake && stands {
            self.mode = Mode::Stay;
            self.stay()?;
        }
        Ok(())
    }

    // The posture is the present one too, or the arm would drift towards its default at rest.
    fn stay(&mut self) -> Result<(), rmp::SetupError> {
        let pose = self
            .flow
            .target_frame_pose_at(self.tool, &self.state.positions)?;
        self.flow.set_posture(&self.state.positions)?;
        self.lead(Target {
            position: pose.map(|p| p.translation.vector),
            orientation: pose.map(|p| p.rotation),
        })
    }

    fn step(&mut self) -> Result<(), rmp::FlowError> {
        // The brake is computed without policies: obstacles must not delay a stop.
        if self.mode == Mode::Brake {
            let clips = rmp::brake(&mut self.state, &self.limits, TICK_S)?;
            self.clipped_joints = clips.acceleration | clips.jerk;
        } else {
            let report = self.flow.step_cell(&mut self.state, &self.limits, TICK_S)?;
            self.min_clearance = report.clearance.map_or(NO_OBSTACLE_M, |c| c.distance);
            let clips = report.clips;
            // Reported, since a clipped joint means that the limits shaped the motion.
            self.clipped_joints =
                clips.position | clips.velocity | clips.acceleration | clips.jerk | clips.conflict;
        }
        if let Some(pose) = self
            .flow
            .target_frame_pose_at(self.tool, &self.state.positions)?
        {
            self.tool_pose = pose;
        }
        Ok(())
    }
}

impl Controller for RmpFlowController {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        let n = self.state.positions.len();
        self.state
            .positions
            .copy_from_slice(estimated.positions.first(n));
        self.state
            .velocities
            .copy_from_slice(estimated.velocities.first(n));
        self.state
            .accelerations
            .copy_from_slice(estimated.accelerations.first(n));
        // A motion in progress is ended within the limits, until a goal arrives.
        self.mode = Mode::Brake;
        self.planning.clear();
        let pose = self
            .flow
            .target_frame_pose_at(self.tool, &self.state.positions);
        if let Ok(Some(pose)) = pose {
            self.tool_pose = pose;
        }
        true
    }

    fn forward(&mut self, _estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        self.apply(setpoint).ok()?;
        self.step().ok()?;
        let mut command = RobotState::EMPTY;
        command.positions.set_from(0, &self.state.positions);
        command.velocities.set_from(0, &self.state.velocities);
        command.accelerations.set_from(0, &self.state.accelerations);
        Some(command)
    }
}
