//! One cube in transfer: the memory of all three policies, and the arm's motion in each phase.

use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use robocell_skills::Step;
use robocell_skills::fingers::Ways;
use robocell_skills::geometry::{nearest_quarter, plane_distance};
use robocell_skills::world::Drive;
use robocell_task::job::Placement;
use robocell_task::{PolicyTime, TraceEvent};
use serde::{Deserialize, Serialize};

use super::obstruction;
use super::phase::{Phase, PhaseStatus};
use super::turn::{Turn, forget_held};

/// A destination nearer than this in the plane is beside the pick-up (m).
const BESIDE_M: f64 = 0.2;
/// A wrist turned farther than this (rad) starts again at the nearest quarter: its joint would
/// reach a limit after more turns in one direction.
const MAX_TURN_RAD: f64 = 1.8;

/// One cube in transfer, between two decisions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transfer {
    /// Index of the cube in the order.
    pub cube: usize,
    /// The phase in progress.
    pub phase: Phase,
    /// Destination of the cube.
    pub destination: Placement,
    /// The destination is final: the cube goes back, or out of the way.
    pub aborted: bool,
    /// The motion or grip of the phase.
    step: Step,
    /// Pose of the cube at the start of the phase, and from GRASP on at the grip; its turn is
    /// that of the tool around it.
    anchor: Placement,
}

impl Transfer {
    /// A transfer before its first phase.
    pub fn new(turn: &Turn<'_>, cube: usize, destination: Placement, aborted: bool) -> Self {
        Self {
            cube,
            phase: Phase::PreGrasp,
            destination,
            aborted,
            step: Step::default(),
            anchor: turn.placement(cube),
        }
    }

    /// Starts or restarts the pick-up at the observed cube.
    pub fn aim(&mut self, turn: &mut Turn<'_>) {
        self.look(turn);
        self.enter(Phase::PreGrasp, turn);
    }

    /// Chooses the turn of the tool around the observed cube. Every other attempt uses the
    /// other grasp.
    pub fn look(&mut self, turn: &Turn<'_>) {
        let object = turn.object(self.cube);
        let seen = turn.placement(self.cube);
        let failures = turn.world.attempts(object).pick;
        let ways = Ways::around(object, seen, 0.0, &turn.world);
        let yaw = ways.choose(failures % 2 == 1);
        self.anchor = Placement { yaw, ..seen };
    }

    /// Starts `phase`.
    pub fn enter(&mut self, phase: Phase, turn: &mut Turn<'_>) {
        // Frozen from GRASP on: a held cube moves with the hand, and LIFT would chase it.
        if phase <= Phase::Grasp {
            self.anchor.position = turn.placement(self.cube).position;
        }
        self.phase = phase;
        self.step = Step::default();
        turn.world.begin(&mut self.step);
        // The part of the memory from which a policy of another kind can resume.
        let object = turn.object(self.cube);
        forget_held(turn.world.job);
        if phase.holding() {
            turn.world.job.held = Some(object);
            turn.world.job.destination = Some(self.destination);
            turn.world.job.aborted = self.aborted;
        // Released: failed pick-ups count in a row.
        } else if phase == Phase::Release
            && let Some(attempts) = turn.world.attempts_mut(object)
        {
            attempts.pick = 0;
        }
    }

    /// Sends the arm to the target of this phase; returns the state of the phase.
    pub fn drive(&mut self, turn: &mut Turn<'_>) -> PhaseStatus {
        turn.phase = Some(self.phase);
        let spec = &turn.stack.spec;
        let gripper = if self.phase.closed() {
            GripperGoal::Close
        } else {
            GripperGoal::Open
        };
        // Finer where the fingers meet a cube.
        let tolerance_m = if self.phase.low() {
            spec.precise_tolerance_m
        } else {
            spec.travel_tolerance_m
        };
        let drive = Drive {
            tolerance_m,
            angle_rad: spec.orientation_tolerance_rad,
            settle: PolicyTime::from_seconds(spec.settle_s),
            ..Drive::travel(self.target(turn), gripper)
        };
        let drive = drive.near(Some(turn.object(self.cube)));
        // The time of the phase is that before this command, so its first decision has lasted
        // zero.
        let lasted = turn.world.begin(&mut self.step);
        let settled = turn.world.drive(&mut self.step, &drive);
        let open = turn.world.is_open();
        self.phase.status(spec, lasted, settled, open)
    }

    /// The TCP in this phase: above the observed cube, its grip or its destination, and at it
    /// in the low phases.
    fn target(&mut self, turn: &Turn<'_>) -> Pose {
        let spec = &turn.stack.spec;
        let at = match self.phase {
            Phase::PreGrasp | Phase::Approach => {
                let seen = turn.placement(self.cube);
                // Re-chosen in each decision: a cube that turns under the fingers takes the
                // tool with it.
                let wound = self.anchor.yaw.abs() > MAX_TURN_RAD;
                let reference = if wound { 0.0 } else { self.anchor.yaw };
                self.anchor.yaw = nearest_quarter(seen.yaw, reference);
                Placement {
                    yaw: self.anchor.yaw,
                    ..seen
                }
            }
            Phase::Grasp => self.anchor,
            Phase::Lift => self.lift_from(),
            _ => self.destination,
        };
        let above_m = if self.phase.low() {
            0.0
        } else {
            spec.clearance_m
        };
        let pose = turn.world.grip_pose(turn.object(self.cube), at, above_m);
        let position = Vector3::from(pose.position) + Vector3::from(spec.grasp_offset_m);
        Pose {
            position: position.into(),
            ..pose
        }
    }

    /// The base of LIFT: the position of the grip, or the height of a higher destination right
    /// beside it, since a cube at the foot of the stack would knock the stack over on a slanted
    /// path up.
    fn lift_from(&self) -> Placement {
        let (from, to) = (self.anchor.position, self.destination.position);
        let beside = plane_distance(from.into(), to.into()) < BESIDE_M;
        let [x, y, z] = from;
        let z = if beside { z.max(to[2]) } else { z };
        Placement {
            position: [x, y, z],
            ..self.anchor
        }
    }

    /// Whether the cube moved away, in the plane, before it was gripped.
    pub fn cube_moved(&self, turn: &Turn<'_>) -> bool {
        let seen = turn.position(self.cube);
        let distance = plane_distance(seen, self.anchor.position.into());
        self.phase < Phase::Grasp && distance > turn.stack.spec.move_tolerance_m
    }

    /// Whether the cube, not gripped yet, is off the table or out of reach.
    pub fn cube_gone(&self, turn: &Turn<'_>) -> bool {
        let gone = turn.fallen(self.cube) || !turn.reachable(self.cube);
        self.phase < Phase::Grasp && gone
    }

    /// Whether the cube has to be in the gripper and is not.
    pub fn dropped(&self, turn: &Turn<'_>) -> bool {
        self.phase.holding() && turn.dropped(self.cube)
    }

    /// Whether the cube is at its destination, so that it does not have to be lifted any more.
    pub fn is_there(&self, turn: &Turn<'_>) -> bool {
        let goal = Vector3::from(self.destination.position);
        let offset = turn.position(self.cube) - goal;
        offset.norm() < turn.stack.spec.goal_tolerance_m
    }

    /// Whether the cube cannot go onto the stack any longer.
    pub fn destination_lost(&self, turn: &Turn<'_>) -> bool {
        !self.aborted && obstruction::destination_lost(turn, self.cube)
    }

    /// Turns the transfer back: the cube goes to its own spawn, or to another free one if its
    /// own is occupied.
    pub fn abort(&mut self, turn: &mut Turn<'_>) {
        let name = turn.name(self.cube);
        turn.world.job.counters.aborts += 1;
        turn.world.out.event(
            TraceEvent::Abort,
            format_args!("[abort] the stack is broken, {name} is returned to its spawn"),
        );
        self.destination = obstruction::free_spawn(turn, self.cube);
        self.aborted = true;
    }

    /// Records that the phase is over; `phase` is its name in the log.
    pub fn note_end(
        &self,
        phase: impl std::fmt::Display,
        status: PhaseStatus,
        turn: &mut Turn<'_>,
    ) {
        let (name, why) = (turn.name(self.cube), status.reason().unwrap_or("?"));
        let line = format_args!("[{name}] {phase} done ({why})");
        turn.world.out.transition(line);
        // Judged after RETRACT: before it the fingers could still move the cube.
        if self.phase == Phase::Retract && !self.aborted {
            turn.note_placed(self.cube);
        }
    }

    /// After missed decisions, or after the operator led the arm: makes a cube in the gripper
    /// the transfer if `memory` does not have it. Returns whether it did.
    pub fn reconcile(memory: &mut Option<Self>, turn: &mut Turn<'_>) -> bool {
        // The cube of the memory is in the gripper, or was; `dropped` decides that. Only the
        // settling starts again, since the arm may have been moved.
        if let Some(transfer) = memory.as_mut().filter(|t| t.phase >= Phase::Grasp) {
            transfer.step.settled = None;
            return false;
        }
        // Nothing is held: a stale `held` would make another policy resume a transfer without a
        // cube.
        let Some((mut transfer, phase)) = Self::in_gripper(turn) else {
            forget_held(turn.world.job);
            return false;
        };
        let name = turn.name(transfer.cube);
        turn.world.job.counters.recoveries += 1;
        turn.world.job.done = false;
        turn.world.out.event(
            TraceEvent::Recover,
            format_args!("[resume] {name} is in the gripper"),
        );
        transfer.enter(phase, turn);
        *memory = Some(transfer);
        true
    }

    /// The transfer of the cube in the gripper, and its phase. The cube is that of the fingers'
    /// contacts in physics, or else that of the checkpoint, if it is near the TCP. A checkpoint
    /// with the same cube also has its destination.
    fn in_gripper(turn: &Turn<'_>) -> Option<(Self, Phase)> {
        let of_object = |object| turn.cubes().find(|cube| turn.object(*cube) == object);
        let job = &*turn.world.job;
        let remembered = job.held.and_then(of_object);
        let cube = turn.world.held().and_then(of_object).or(remembered)?;
        if turn.dropped(cube) {
            return None;
        }
        let known = job.destination.filter(|_| remembered == Some(cube));
        let destination = known.unwrap_or(turn.goal(cube));
        let mut transfer = Self::new(turn, cube, destination, known.is_some() && job.aborted);
        // The fingers are around the cube already, from whichever side.
        let turned = turn.world.tool_yaw();
        transfer.anchor.yaw = nearest_quarter(transfer.anchor.yaw, turned);
        // LIFT aims above the grip by the clearance, so a cube that is lifted already is kept
        // at its height.
        let spec = &turn.stack.spec;
        let height = &mut transfer.anchor.position[2];
        *height = (*height - spec.clearance_m).max(spec.base_height_m);
        let phase = if transfer.is_there(turn) {
            Phase::Lower
        } else {
            Phase::Lift
        };
        Some((transfer, phase))
    }
}
