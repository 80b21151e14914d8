//! The arm's command watchdog: follow fresh commands, coast over short gaps,
//! brake on silence, hold.
//!
//! - Before the first command the arm holds its home.
//! - A tick without a new command goes on at the commanded velocity.
//! - When the newest accepted command is older than the stop policy allows, the
//!   arm brakes on a ramp within its limits, from the last setpoint, and holds.
//! - A command further than [`MAX_STEP`] (plus what the velocity limit allows
//!   since the last setpoint) from the setpoint in force is refused and counted.
//! - After a brake, and from another controller, the first command has to go on
//!   from the setpoint in force within the joint's limits. A controller that
//!   slept through the brake is refused until it begins where the arm is.

use cell_model::ramp::{self, RampState};
use cell_model::stop::{PhysicsFlags, Stop, physics_stop};
use cell_model::{JointSpec, Robot};
use ipc_types::{ArmCommand, Validate};
use rmp::JointLimits;
use serde::{Deserialize, Serialize};

use crate::settings::TICK_S;
use crate::violations;

/// Furthest a command may be from the setpoint in force (rad or m).
pub const MAX_STEP: f64 = 0.05;

/// Which command was accepted last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Accepted {
    pub(crate) generation: u32,
    pub(crate) seq: u64,
    pub(crate) tick: u64,
}

/// Where setpoints come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Source {
    /// Home or a finished ramp: gravity is compensated here.
    Own,
    /// The controller.
    Commands,
}

/// One joint, as plain numbers for the snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Point {
    position: f64,
    velocity: f64,
    acceleration: f64,
}

/// State of the watchdog of one arm.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Watchdog {
    source: Source,
    /// In force, by controlled joint.
    setpoint: Vec<Point>,
    /// Last accepted command, or the ramp's last output.
    anchor: Vec<Point>,
    /// Feed-forward of the last accepted command (N·m or N).
    efforts: Vec<f64>,
    accepted: Option<Accepted>,
    /// Tick at which the scene was reset: commands that answer it or an earlier
    /// one are about the scene before.
    reset_at: Option<u64>,
    /// Commands refused since the start.
    pub(crate) refused: u64,
    /// Limits broken by accepted commands or measured positions.
    pub(crate) violations: u64,
    /// A body of the arm was disabled by the engine.
    pub(crate) fault: bool,
}

/// What a tick does with the arm.
pub(crate) struct Verdict {
    /// The stop policy's word.
    pub(crate) stop: Stop,
    /// The command is new and was accepted.
    pub(crate) accepted: bool,
    /// Setpoints come from here, not from commands: feed-forward has to be
    /// computed for them.
    pub(crate) own: bool,
}

impl Watchdog {
    /// Holding `home` (rad or m by controlled joint).
    pub(crate) fn new(home: &[f64]) -> Self {
        let points: Vec<Point> = home
            .iter()
            .map(|&position| Point {
                position,
                ..Point::default()
            })
            .collect();
        Self {
            source: Source::Own,
            anchor: points.clone(),
            setpoint: points,
            efforts: vec![0.0; home.len()],
            accepted: None,
            reset_at: None,
            refused: 0,
            violations: 0,
            fault: false,
        }
    }

    /// The command in force.
    pub(crate) fn accepted(&self) -> Option<Accepted> {
        self.accepted
    }

    /// Position, velocity and acceleration in force, by controlled joint.
    pub(crate) fn setpoint(&self) -> impl Iterator<Item = RampState> + '_ {
        self.setpoint.iter().map(|p| ramp_state(*p))
    }

    /// Feed-forward of the command in force.
    pub(crate) fn efforts(&self) -> &[f64] {
        &self.efforts
    }

    /// After a reset of the scene at `tick`: counts go on, and commands that
    /// answer the scene before are not taken.
    pub(crate) fn carry_over(&mut self, before: &Self, tick: u64) {
        self.refused = before.refused;
        self.violations = before.violations;
        self.reset_at = Some(tick);
    }

    /// Decides for the tick that follows `tick`. `command` is the newest one
    /// there is, of any age.
    pub(crate) fn update(
        &mut self,
        tick: u64,
        command: Option<&ArmCommand>,
        robot: &Robot,
        limits: &JointLimits,
    ) -> Verdict {
        let accepted = command.is_some_and(|command| self.take(tick, command, robot));
        let age = self
            .accepted
            .map(|accepted| tick.saturating_sub(accepted.tick));
        let stop = physics_stop(PhysicsFlags {
            command_age_ticks: age,
            quarantined: self.fault,
        });
        if stop.stops_motion() {
            self.brake(limits);
        } else if !accepted && self.source == Source::Commands {
            self.coast(robot);
        }
        Verdict {
            stop,
            accepted,
            own: self.source == Source::Own,
        }
    }

    /// Accepts a new and sound command.
    fn take(&mut self, tick: u64, command: &ArmCommand, robot: &Robot) -> bool {
        let header = &command.header;
        let id = Accepted {
            generation: header.generation,
            seq: header.seq,
            tick: header.tick,
        };
        // A command of the future answers a run that was set back.
        if self.fault
            || self.accepted == Some(id)
            || self.reset_at.is_some_and(|reset| id.tick <= reset)
            || id.tick > tick
        {
            return false;
        }
        let fresh = tick - id.tick <= cell_model::stop::COMMAND_AGE_TICKS;
        let sound =
            command.joint_count as usize == self.setpoint.len() && command.validate().is_ok();
        let goes_on = |id: Accepted| self.follows_on(id) || self.begins_here(command, robot);
        if !fresh || !sound || !self.is_near(command, robot, tick) || !goes_on(id) {
            self.refused += u64::from(fresh);
            return false;
        }
        self.follow(command, id, robot);
        true
    }

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

    /// Whether the command's sender is the one the arm follows.
    fn follows_on(&self, id: Accepted) -> bool {
        let same = |last: Accepted| last.generation == id.generation;
        self.source == Source::Commands && self.accepted.is_some_and(same)
    }

    /// Whether the command is one tick after the setpoint in force.
    fn begins_here(&self, command: &ArmCommand, robot: &Robot) -> bool {
        robot.arm_specs().enumerate().all(|(index, spec)| {
            let before = ramp_state(self.setpoint[index]);
            let position = command.joint_positions[index];
            let velocity = command.joint_velocities[index];
            !violations::advance(&before, position, velocity, 1.0, spec).1
        })
    }

    fn follow(&mut self, command: &ArmCommand, id: Accepted, robot: &Robot) {
        // Commands between this and the last one were overtaken, not skipped.
        let steps = match self.accepted {
            Some(last) if self.follows_on(id) => {
                id.seq.saturating_sub(last.seq).clamp(1, 20) as f64
            }
            _ => {
                self.anchor.clone_from(&self.setpoint);
                1.0
            }
        };
        for (index, spec) in robot.arm_specs().enumerate() {
            let (position, velocity) = (
                command.joint_positions[index],
                command.joint_velocities[index],
            );
            let before = ramp_state(self.anchor[index]);
            let (after, broken) = violations::advance(&before, position, velocity, steps, spec);
            self.violations += u64::from(broken);
            self.anchor[index] = point(after);
            self.setpoint[index] = limited(self.setpoint[index], after, steps, spec);
            self.efforts[index] = command.joint_efforts[index];
        }
        self.accepted = Some(id);
        self.source = Source::Commands;
    }

    /// One tick without a command: constant velocity, within the joint's range.
    fn coast(&mut self, robot: &Robot) {
        for (setpoint, spec) in self.setpoint.iter_mut().zip(robot.arm_specs()) {
            let next = ramp_state(*setpoint).coast(spec.jerk, TICK_S);
            *setpoint = Point {
                position: next.position.clamp(spec.lower, spec.upper),
                ..point(next)
            };
        }
    }

    /// One tick of the brake ramp.
    fn brake(&mut self, limits: &JointLimits) {
        self.source = Source::Own;
        let mut joints: Vec<RampState> = self.setpoint().collect();
        ramp::brake_all(&mut joints, limits, TICK_S);
        self.setpoint = joints.into_iter().map(point).collect();
        self.anchor.clone_from(&self.setpoint);
    }
}

/// The drive's own limits: the setpoint follows the command no faster than the
/// velocity limit and stays within the joint's range. A command within limits
/// passes unchanged.
fn limited(before: Point, command: RampState, steps: f64, spec: &JointSpec) -> Point {
    let reach = spec.velocity * (1.0 + 1.0e-6) * TICK_S * steps;
    let position = command
        .position
        .clamp(before.position - reach, before.position + reach);
    Point {
        position: position.clamp(spec.lower, spec.upper),
        velocity: command.velocity.clamp(-spec.velocity, spec.velocity),
        acceleration: command
            .acceleration
            .clamp(-spec.acceleration, spec.acceleration),
    }
}

fn point(state: RampState) -> Point {
    Point {
        position: state.position,
        velocity: state.velocity,
        acceleration: state.acceleration,
    }
}

fn ramp_state(point: Point) -> RampState {
    RampState {
        position: point.position,
        velocity: point.velocity,
        acceleration: point.acceleration,
    }
}
