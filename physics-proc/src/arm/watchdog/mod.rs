//! The arm's command watchdog: it follows fresh commands, coasts over short gaps, brakes on
//! silence, and holds.
//!
//! The accident to prevent is a step of the setpoint: commands that each were near the
//! setpoint, and did not continue from each other, broke limits of joints up to four times in
//! a run on a busy machine (ADR 0014). The rules:
//!
//! - Before the first command the arm holds its home.
//! - A tick without a new command continues at the commanded velocity. With the next command
//!   the setpoint returns to the commanded path within the acceleration limit.
//! - If the newest accepted command is older than the stop policy allows, the arm brakes on a
//!   ramp within its limits, from the last setpoint, and holds.
//! - A command farther than [`MAX_STEP`] (plus the distance that the velocity limit allows
//!   since the last setpoint) from the setpoint in force is refused and counted.
//! - After a brake, and from another controller, each command has to continue from the
//!   setpoint in force within the joint's limits, until it is certain that the commands
//!   continue from each other. A controller restarts at every state that reports the arm as
//!   stopped, and several such first commands may be in flight.
//! - A first command that does not continue from the setpoint is refused, and the arm brakes
//!   until one is accepted: the state reports the stop, and the controller restarts from it.
//!
//! All ages are ticks, so a replay decides as the run did (ADR 0002). All fields are part of
//! the snapshot: a successor that lacks one would accept a command that this one refuses.

use cell_model::Robot;
use cell_model::ramp::{self, RampState};
use cell_model::stop::{PhysicsFlags, Stop, physics_stop};
use ipc_types::arm::{StopAction, StopCause};
use ipc_types::{ArmCommand, Validate};
use rmp::JointLimits;
use serde::{Deserialize, Serialize};

use crate::arm::catch_up::{catch_up, coast};
use crate::arm::violations;
use crate::engine::settings::TICK_S;

mod effort;
mod point;

use effort::Mode;

use point::{advance_one, commanded, limited, same_motion};

/// Largest difference between the acceleration that a command states and the one that it
/// makes, as a share of the acceleration limit: the next commands are then within the jerk
/// limit.
const SAME_ACCELERATION: f64 = 1.0e-7;

/// Largest distance of a command from the setpoint in force (rad or m).
// A coarse bound against wrong numbers: the motion itself is limited by `catch_up` and
// `limited`, and what breaks a limit of the joint is counted.
pub const MAX_STEP: f64 = 0.05;

/// Which command was accepted last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Accepted {
    pub(crate) generation: u32,
    pub(crate) seq: u64,
    pub(crate) tick: u64,
    /// The start of physics that it answers; 0 if it names none.
    physics: u32,
}

/// Origin of the setpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Source {
    /// Home or a finished ramp: gravity is compensated here.
    Own,
    /// The controller.
    Commands,
}

/// An arm with a joint outside its limits for this long is faulty (ticks).
// A shorter excess is only counted. Half a second means that something stronger than the drive
// pushes, which a reset of the scene ends.
const MAX_OUTSIDE_TICKS: u32 = 500;

/// State of the watchdog of one arm.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Watchdog {
    source: Source,
    /// In force, by controlled joint.
    setpoint: Vec<RampState>,
    /// Last accepted command, or the ramp's last output.
    anchor: Vec<RampState>,
    /// Feed-forward of the last accepted command (N·m or N).
    efforts: Vec<f64>,
    accepted: Option<Accepted>,
    /// How the drives follow the accepted command.
    mode: Mode,
    /// Tick at which the scene was reset: commands that answer this tick or an earlier one
    /// belong to the previous scene.
    reset_at: Option<u64>,
    /// Tick of the last state that reported the arm as stopped.
    stopped_at: Option<u64>,
    /// Whether the setpoint in force moves as the sender of the accepted command computes.
    settled: bool,
    /// The controller started from another setpoint: the arm is stopped until a command starts
    /// from this one.
    astray: bool,
    /// Commands refused since the start.
    pub(crate) refused: u64,
    /// Limits broken by accepted commands or measured positions.
    pub(crate) violations: u64,
    /// Ticks in a row with a measured joint outside its limits.
    outside_ticks: u32,
    /// The engine disabled a body of the arm, or a joint stayed outside its limits.
    pub(crate) fault: bool,
}

/// Result of a tick for the arm.
pub(crate) struct WatchdogOutput {
    /// Action and cause by the stop policy.
    pub(crate) stop: Stop,
    /// The command is new and was accepted.
    pub(crate) accepted: bool,
    /// Setpoints are computed here, not commanded: their feed-forward has to be computed as
    /// well.
    pub(crate) own: bool,
}

impl Watchdog {
    /// Holding `home` (rad or m by controlled joint).
    pub(crate) fn new(home: &[f64]) -> Self {
        let points: Vec<RampState> = home
            .iter()
            .map(|&position| RampState {
                position,
                ..RampState::default()
            })
            .collect();
        Self {
            source: Source::Own,
            anchor: points.clone(),
            setpoint: points,
            efforts: vec![0.0; home.len()],
            accepted: None,
            mode: Mode::Position,
            reset_at: None,
            stopped_at: None,
            settled: false,
            astray: false,
            refused: 0,
            violations: 0,
            outside_ticks: 0,
            fault: false,
        }
    }

    /// Counts a tick in which `outside` joints were measured outside their limits. Drives do
    /// not move them there: something stronger pushes.
    pub(crate) fn count_outside(&mut self, outside: u64) {
        self.violations += outside;
        self.outside_ticks = match outside {
            0 => 0,
            _ => self.outside_ticks.saturating_add(1),
        };
        self.fault |= self.outside_ticks >= MAX_OUTSIDE_TICKS;
    }

    /// The command in force.
    pub(crate) fn accepted(&self) -> Option<Accepted> {
        self.accepted
    }

    /// Position, velocity and acceleration in force, by controlled joint.
    pub(crate) fn setpoint(&self) -> impl Iterator<Item = RampState> + '_ {
        self.setpoint.iter().copied()
    }

    /// Feed-forward of the command in force.
    pub(crate) fn efforts(&self) -> &[f64] {
        &self.efforts
    }

    /// After a reset of the scene at `tick`: counts continue, and commands that answer the
    /// previous scene are refused.
    pub(crate) fn carry_over(&mut self, before: &Self, tick: u64) {
        self.refused = before.refused;
        self.violations = before.violations;
        self.reset_at = Some(tick);
    }

    /// Decides for the tick that follows `tick`. `command` is the newest one received, of any
    /// age.
    pub(crate) fn update(
        &mut self,
        tick: u64,
        command: Option<&ArmCommand>,
        robot: &Robot,
        limits: &JointLimits,
    ) -> WatchdogOutput {
        let accepted = command.is_some_and(|command| self.accept(tick, command, robot));
        // The age is that of the accepted command, not of the received one: a stream of
        // refused commands has to stop the arm as silence does.
        let age = self
            .accepted
            .map(|accepted| tick.saturating_sub(accepted.tick));
        let mut stop = physics_stop(PhysicsFlags {
            command_age_ticks: age,
            quarantined: self.fault,
        });
        // Reported as a hold, so that the controller learns of it from the state and restarts
        // here. Without this its refused commands would stop nothing while the last accepted
        // one is fresh.
        if self.astray && !stop.stops_motion() {
            stop = Stop {
                action: StopAction::Hold,
                cause: StopCause::CommandLost,
            };
        }
        // `tick + 1` is the state in which the stop is published: a command that answers an
        // earlier one cannot know of it.
        if stop.stops_motion() {
            self.stopped_at = Some(tick + 1);
            self.brake(limits);
        } else if !accepted && self.source == Source::Commands {
            self.coast(tick, robot);
        }
        WatchdogOutput {
            stop,
            accepted,
            own: self.source == Source::Own,
        }
    }

    /// Accepts a command that is new and sound; `true` if it did.
    fn accept(&mut self, tick: u64, command: &ArmCommand, robot: &Robot) -> bool {
        let header = &command.header;
        let id = Accepted {
            generation: header.generation,
            seq: header.seq,
            tick: header.tick,
            physics: header.answered().unwrap_or(0),
        };
        // A command that answers a later tick belongs to a run that was set back.
        // Not counted as refused: the command was judged before, or is about another scene.
        if self.fault
            || self.accepted == Some(id)
            || self.reset_at.is_some_and(|reset| id.tick <= reset)
            || id.tick > tick
        {
            return false;
        }
        // An old command is dropped without a count: it is late, not wrong.
        let fresh = tick - id.tick <= cell_model::stop::COMMAND_AGE_TICKS;
        let sound =
            command.joint_count as usize == self.setpoint.len() && command.validate().is_ok();
        if fresh && sound && self.takes_efforts(command, id, robot) {
            return true;
        }
        let starts = !self.follows_on(id);
        let continues = fresh
            && sound
            && if starts {
                self.starts_at_setpoint(command, robot)
            } else {
                self.is_near(command, robot, tick)
            };
        // Only a sound, fresh one stops the arm: damaged or late commands are left to the age
        // limit.
        if !continues {
            self.refused += u64::from(fresh);
            self.astray |= fresh && sound && starts;
            return false;
        }
        if starts {
            self.start_at_setpoint(command, robot);
        }
        self.follow(command, id, robot);
        true
    }

    // The gap is bounded: after a long silence the allowed step would otherwise grow without
    // limit, and 20 ticks cover the age at which the arm brakes.
    fn is_near(&self, command: &ArmCommand, robot: &Robot, tick: u64) -> bool {
        let gap = self.accepted.map_or(1, |accepted| {
            tick.saturating_sub(accepted.tick).clamp(1, 20)
        });
        let joints = self
            .setpoint
            .iter()
            .zip(&command.joint_positions)
            .zip(robot.arm_specs());
        let mut steps = joints.map(|((point, position), spec)| {
            (position - point.position).abs() - spec.velocity * gap as f64 * TICK_S
        });
        steps.all(|step| step <= MAX_STEP)
    }

    /// Whether the command continues from the accepted one: it has the same sender, which has
    /// not restarted between the two and computes the motion of this arm. It restarts its motion
    /// for each start of physics. A sender that
    /// answers each state once cannot send more commands than there were states, unless
    /// physics was set back.
    fn follows_on(&self, id: Accepted) -> bool {
        let on = |last: Accepted| {
            (last.generation, last.physics) == (id.generation, id.physics)
                && self.stopped_at.is_none_or(|stopped| last.tick >= stopped)
                && id.seq.saturating_sub(last.seq) <= id.tick.saturating_sub(last.tick)
        };
        self.source == Source::Commands && self.settled && self.accepted.is_some_and(on)
    }

    /// Whether the command is within the limits as the next tick after the setpoint in force.
    fn starts_at_setpoint(&self, command: &ArmCommand, robot: &Robot) -> bool {
        let joints = robot.arm_specs().enumerate();
        joints
            .zip(&self.setpoint)
            .all(|((joint, spec), before)| !advance_one(before, command, joint, spec).1)
    }

    /// Makes the setpoint the predecessor of the command, which continues from it.
    fn start_at_setpoint(&mut self, command: &ArmCommand, robot: &Robot) {
        let joints = robot.arm_specs().enumerate();
        // If the stated acceleration is the one made here, the sender computes the same motion
        // and its next command continues from this one; else each command is checked against
        // the setpoint.
        self.settled = joints.zip(&self.setpoint).all(|((joint, spec), before)| {
            let made = advance_one(before, command, joint, spec).0.acceleration;
            let differs = (made - command.joint_accelerations[joint]).abs();
            differs <= SAME_ACCELERATION * spec.acceleration
        });
        self.anchor.clone_from(&self.setpoint);
        self.accepted = None;
    }

    fn follow(&mut self, command: &ArmCommand, id: Accepted, robot: &Robot) {
        // Commands between this one and the last were overtaken, not lost.
        let last = self.accepted.map_or(id.seq, |last| last.seq);
        let steps = id.seq.saturating_sub(last).max(1) as f64;
        for (index, spec) in robot.arm_specs().enumerate() {
            let before = self.anchor[index];
            let commanded = commanded(command, index);
            let (after, broken) = violations::advance(&before, &commanded, steps, spec);
            // Judged against the commanded path, not against the setpoint, which may be behind
            // it after a gap: the controller is not to blame for late messages.
            self.violations += u64::from(broken);
            // On the path the setpoint is the command itself, to the bit. After a gap it
            // approaches the path, since a jump back onto it would break the acceleration
            // limit.
            let is_next = !broken && steps <= 1.0;
            let is_on_path = is_next && same_motion(&self.setpoint[index], &self.anchor[index]);
            self.anchor[index] = after;
            self.setpoint[index] = if is_on_path {
                limited(self.setpoint[index], after, spec)
            } else {
                catch_up(&self.setpoint[index], &after, spec)
            };
            self.efforts[index] = command.joint_efforts[index];
        }
        self.accepted = Some(id);
        self.mode = Mode::Position;
        self.astray = false;
        self.source = Source::Commands;
    }

    /// Moves the setpoint to the measured positions while the drives have no power, so that
    /// the next controller starts there.
    pub(crate) fn rest_at(&mut self, positions: impl Iterator<Item = f64>) {
        self.source = Source::Own;
        for (setpoint, position) in self.setpoint.iter_mut().zip(positions) {
            *setpoint = RampState {
                position,
                ..RampState::default()
            };
        }
        self.anchor.clone_from(&self.setpoint);
    }

    /// One tick without a command.
    fn coast(&mut self, tick: u64, robot: &Robot) {
        // Counted from the answered tick: the first missing command keeps the acceleration,
        // later ones take it back.
        let answered = self.accepted.map_or(tick, |accepted| accepted.tick);
        let in_a_row = tick.saturating_sub(answered);
        for (setpoint, spec) in self.setpoint.iter_mut().zip(robot.arm_specs()) {
            *setpoint = coast(setpoint, in_a_row, spec);
        }
    }

    /// One tick of the brake ramp.
    fn brake(&mut self, limits: &JointLimits) {
        self.source = Source::Own;
        // From the setpoint, not from the measured state, whose tracking error would be a step
        // of the acceleration.
        ramp::brake_all(&mut self.setpoint, limits, TICK_S);
        // After late commands the way to the limit may be shorter than that of the brake: the
        // joint would be driven against its stop.
        let ends = limits.lower.iter().zip(&limits.upper);
        for (joint, (lower, upper)) in self.setpoint.iter_mut().zip(ends) {
            joint.position = joint.position.max(*lower).min(*upper);
        }
        // The next command is judged from where the ramp is now.
        self.anchor.clone_from(&self.setpoint);
    }
}
