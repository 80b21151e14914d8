//! The controller: leaves, their sum, and the two kinds of steps.

use std::collections::BTreeMap;

use nalgebra::Vector3;

pub use crate::ball::MAX_CARRIED;
pub use crate::targets::TargetId;

use crate::ball::Ball;
use crate::groups::Group;
use crate::kinematics::Kinematics;
use crate::leaves::Floor;
use crate::leaves::collision::Constants;
use crate::leaves::joint_limit::Range;
use crate::pullback::Pullback;
use crate::resolve::cell::CellResolve;
use crate::resolve::cholesky::Cholesky;
use crate::resolve::exact;
use crate::self_collision::SelfCollision;
use crate::setup;
use crate::simd::Path;
use crate::state::{check_dt, check_values};
use crate::targets::TargetFrame;
use crate::{
    Chain, ClipFlags, CollisionParameters, CspaceTargetParameters, FlowError, JointLimits,
    MotionState, ObstacleSet, Outcome, RmpFlowParameters, Root, SetupError,
};

/// A sphere of the robot that keeps away from obstacles.
#[derive(Debug, Clone, PartialEq)]
pub struct CollisionSphere {
    /// Name of the frame that carries it.
    pub frame: String,
    /// Centre in that frame, m.
    pub center: Vector3<f64>,
    /// Radius, m, >= 0.
    pub radius: f64,
}

/// Data to build an [`RmpFlow`] from.
#[derive(Debug, Clone, Copy)]
pub struct RmpFlowSetup<'a> {
    /// The robot.
    pub chain: &'a Chain,
    /// The controlled joints in the order of every joint vector.
    pub joint_names: &'a [String],
    /// Default positions by joint name (rad or m): the posture of the controlled joints, and
    /// the constant positions of all others. A joint that is not named is at zero, moved into
    /// its limits.
    pub default_positions: &'a BTreeMap<String, f64>,
    /// Spheres that keep away from obstacles.
    pub spheres: &'a [CollisionSphere],
    /// Parts that keep away from each other in [`RmpFlow::step_cell`].
    pub self_collision: SelfCollisionSetup<'a>,
    /// The tuning.
    pub parameters: &'a RmpFlowParameters,
    /// Capacity of obstacles.
    pub obstacle_capacity: usize,
}

/// The parts of a robot that keep away from each other: the spheres of two frames, unless
/// one joint carries both.
#[derive(Debug, Clone, Copy, Default)]
pub struct SelfCollisionSetup<'a> {
    /// The spheres; with none the robot does not keep away from itself.
    pub spheres: &'a [CollisionSphere],
    /// Pairs of frames that may touch, in either order.
    pub ignore: &'a [(String, String)],
}

/// The nearest approach of the robot's spheres to an enabled obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// Signed distance of the surfaces, m.
    pub distance: f64,
    /// Index of the sphere in [`RmpFlowSetup::spheres`]; those beyond are the
    /// carried ones, see [`RmpFlow::carry`].
    pub sphere: usize,
}

/// Report on one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepReport {
    /// Nearest approach before the step; `None` without obstacles or spheres.
    pub clearance: Option<Clearance>,
    /// Least distance of two parts of the robot that keep away from each other, before the
    /// step (m); infinite if none are within 0.25 m, and for `step_exact`.
    pub self_clearance: f64,
    /// Which limits were active; always clear for `step_exact`.
    pub clips: ClipFlags,
    /// Result of the resolve. In `step_cell`, `Shortened` means that a limit was active,
    /// `Singular` that the joints braked instead.
    pub outcome: Outcome,
}

/// The controller. After construction nothing allocates, except errors and
/// [`RmpFlow::add_target_frame`].
#[derive(Debug, Clone)]
pub struct RmpFlow {
    pub(crate) chain: Chain,
    pub(crate) parameters: RmpFlowParameters,
    pub(crate) constants: Constants,
    pub(crate) kinematics: Kinematics,
    pub(crate) ranges: Vec<Range>,
    pub(crate) posture: Vec<f64>,
    /// By id; a removed one leaves its place empty.
    pub(crate) targets: Vec<Option<TargetFrame>>,
    pub(crate) balls: Vec<Ball>,
    pub(crate) groups: Vec<Group>,
    /// Spheres on the tool; the capacity is never exceeded.
    pub(crate) carried: Vec<Ball>,
    pub(crate) carried_groups: Vec<Group>,
    /// Frame that carries them.
    pub(crate) carrier: Option<TargetId>,
    pub(crate) body_groups: Vec<Group>,
    /// Capsules of the tuning around the base.
    pub(crate) body: ObstacleSet,
    pub(crate) self_collision: SelfCollision,
    pub(crate) obstacles: ObstacleSet,
    /// Scratch: obstacles near some spheres.
    pub(crate) near: Vec<usize>,
    pub(crate) path: Path,
    pub(crate) pullback: Pullback,
    pub(crate) root: Root,
    pub(crate) clearance: Option<Clearance>,
    pub(crate) factor: Cholesky,
    pub(crate) scratch: Vec<f64>,
    pub(crate) acceleration: Vec<f64>,
    pub(crate) cell: CellResolve,
}

impl RmpFlow {
    /// Builds a controller with its posture at the default positions, no target
    /// frame and no obstacle, at rest in its default configuration.
    ///
    /// # Errors
    /// [`SetupError`] for names the robot does not have and numbers out of range.
    pub fn new(setup: &RmpFlowSetup) -> Result<Self, SetupError> {
        setup::build(setup)
    }

    /// Number of controlled joints.
    pub fn joint_count(&self) -> usize {
        self.posture.len()
    }

    /// The posture (c-space attractor), rad or m.
    pub fn posture(&self) -> &[f64] {
        &self.posture
    }

    /// Sets the posture, rad or m.
    ///
    /// # Errors
    /// [`SetupError::Length`] or [`SetupError::NotFinite`]; nothing is changed.
    pub fn set_posture(&mut self, posture: &[f64]) -> Result<(), SetupError> {
        check_values("posture", posture, self.joint_count())?;
        self.posture.copy_from_slice(posture);
        Ok(())
    }

    /// Sets the gains of posture and obstacles from the next evaluation on. Allocates nothing.
    ///
    /// # Errors
    /// [`SetupError`] for a value that is not allowed; nothing is changed.
    pub fn set_gains(
        &mut self,
        cspace_target: CspaceTargetParameters,
        collision: CollisionParameters,
    ) -> Result<(), SetupError> {
        // Validated as a whole tuning; a refused one leaves the old gains in force.
        let before = (self.parameters.cspace_target, self.parameters.collision);
        (self.parameters.cspace_target, self.parameters.collision) = (cspace_target, collision);
        if let Err(error) = self.parameters.validate() {
            (self.parameters.cspace_target, self.parameters.collision) = before;
            return Err(error.into());
        }
        self.constants = Constants::new(&collision);
        Ok(())
    }

    /// The obstacles.
    pub fn obstacles(&self) -> &ObstacleSet {
        &self.obstacles
    }

    /// The obstacles, to be moved, enabled and disabled between steps.
    pub fn obstacles_mut(&mut self) -> &mut ObstacleSet {
        &mut self.obstacles
    }

    /// Sums all leaves at joint positions `q` (rad or m) and velocities `qd`
    /// (rad/s or m/s), by the published formulas to the letter: in penetration
    /// and outside buffered limits their weights have a pole and turn negative.
    /// [`RmpFlow::step_cell`] takes such distances as zero.
    ///
    /// # Errors
    /// [`SetupError::Length`] or [`SetupError::NotFinite`].
    pub fn evaluate(&mut self, q: &[f64], qd: &[f64]) -> Result<&Root, SetupError> {
        let joints = self.joint_count();
        check_values("joint positions", q, joints)?;
        check_values("joint velocities", qd, joints)?;
        self.sum_leaves(q, qd, Floor::None);
        Ok(&self.root)
    }

    /// The sum of the last evaluation.
    pub fn root(&self) -> &Root {
        &self.root
    }

    /// Nearest approach found by the last evaluation.
    pub fn clearance(&self) -> Option<Clearance> {
        self.clearance
    }

    /// Resolves the last evaluation as published: `M^-1 f` within the trust region
    /// on the norm. rad/s^2 or m/s^2.
    pub fn resolve_exact(&mut self) -> (&[f64], Outcome) {
        let outcome = exact::resolve(
            &mut self.factor,
            &mut self.scratch,
            &self.root.metric,
            &self.root.force,
            self.parameters.canonical_resolve.max_acceleration_norm,
            &mut self.acceleration,
        );
        (&self.acceleration, outcome)
    }

    /// Evaluates, resolves exactly and integrates `state` by `dt` seconds with
    /// explicit Euler: the positions move with the old velocities.
    ///
    /// # Errors
    /// [`FlowError`]; `state` is left as it is.
    pub fn step_exact(
        &mut self,
        state: &mut MotionState,
        dt: f64,
    ) -> Result<StepReport, FlowError> {
        check_dt(dt)?;
        state.check(self.joint_count())?;
        self.sum_leaves(&state.positions, &state.velocities, Floor::None);
        let (_, outcome) = self.resolve_exact();
        state.integrate(&self.acceleration, dt);
        Ok(StepReport {
            clearance: self.clearance,
            self_clearance: f64::INFINITY,
            clips: ClipFlags::default(),
            outcome,
        })
    }

    /// Evaluates, resolves within `limits` and integrates `state` by `dt` seconds
    /// with explicit Euler. `state` must hold the previous command.
    ///
    /// # Errors
    /// [`FlowError`]; `state` is left as it is.
    pub fn step_cell(
        &mut self,
        state: &mut MotionState,
        limits: &JointLimits,
        dt: f64,
    ) -> Result<StepReport, FlowError> {
        check_dt(dt)?;
        state.check(self.joint_count())?;
        limits.validate(self.joint_count())?;
        self.sum_leaves(&state.positions, &state.velocities, Floor::Contact);
        // After the sum, and here only: the published step has no self-collision leaf.
        let self_clearance = self.self_collision.add(&self.kinematics, &mut self.root);
        let (clips, solved) =
            self.cell
                .resolve(&self.root, state, limits, dt, &mut self.acceleration);
        // The state integrates what was resolved, so it stays within the limits to the last
        // bit.
        state.integrate(&self.acceleration, dt);
        let outcome = match (solved, clips.is_clear()) {
            (false, _) => Outcome::Singular,
            (true, true) => Outcome::Free,
            (true, false) => Outcome::Shortened,
        };
        Ok(StepReport {
            clearance: self.clearance,
            self_clearance,
            clips,
            outcome,
        })
    }

    /// The joints at their lower and at their upper bound after the last
    /// [`RmpFlow::step_cell`], bit per joint: the start of the next resolve.
    pub fn active_bounds(&self) -> (u64, u64) {
        self.cell.active_bounds()
    }

    /// Sets the start of the next resolve: with the same one it takes the same steps, to the
    /// last bit.
    pub fn set_active_bounds(&mut self, lower: u64, upper: u64) {
        self.cell.set_active_bounds(lower, upper);
    }
}
