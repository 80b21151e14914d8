//! A parallel gripper: width and force in, finger targets out.

use cell_model::ParallelGripper;
use ipc_types::GripperCommand;
use serde::{Deserialize, Serialize};

use crate::arm::multibody::DriveTarget;
use crate::engine::settings::TICK_S;

/// Lead of the target over the finger, besides the one that the force needs (m): reopening
/// does not wait for the target to return from inside the object.
const LEAD_M: f64 = 0.002;

/// State of one gripper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct GripperDrive {
    /// Present target of the fingers (m, half a width).
    target: f64,
    /// Final target of the fingers (m, half a width).
    wanted: f64,
    /// Force limit per finger (N).
    force: f64,
}

impl GripperDrive {
    /// The drive of an arm without a gripper.
    pub(crate) const NONE: Self = Self {
        target: 0.0,
        wanted: 0.0,
        force: 0.0,
    };

    /// Open, with each finger at `finger` (m, half a width).
    pub(crate) fn new(gripper: &ParallelGripper, finger: f64) -> Self {
        Self {
            target: finger,
            wanted: finger,
            force: gripper.default_force,
        }
    }

    /// Takes the gripper part of an accepted command. A force of zero means the
    /// gripper's own.
    pub(crate) fn command(&mut self, command: &GripperCommand, gripper: &ParallelGripper) {
        self.wanted = 0.5 * command.width.clamp(0.0, gripper.max_width);
        let force = if command.force > 0.0 {
            command.force
        } else {
            gripper.default_force
        };
        self.force = force.min(gripper.max_force);
    }

    /// One tick: drive target of both fingers for their measured position (m).
    pub(crate) fn step(
        &mut self,
        gripper: &ParallelGripper,
        stiffness: f64,
        measured: f64,
    ) -> DriveTarget {
        let reach = gripper.speed * TICK_S;
        let lead = self.force / stiffness + LEAD_M;
        // A closed hand presses objects of any thickness with its force: its target is as far
        // behind the middle as the force needs.
        let wanted = if self.wanted > 0.0 {
            self.wanted
        } else {
            -lead
        };
        let step = (wanted - self.target).clamp(-reach, reach);
        // Bounded lead: a blocked finger would otherwise collect target, and open late by it.
        let target = (self.target + step).clamp(measured - lead, measured + lead);
        // No target velocity at the goal: the damping would drive the fingers past it.
        let velocity = if step.abs() < reach {
            0.0
        } else {
            step / TICK_S
        };
        self.target = target.clamp(wanted.min(0.0), 0.5 * gripper.max_width);
        DriveTarget {
            position: self.target,
            velocity,
            effort: 0.0,
            gravity: 0.0,
            max_effort: self.force,
            by_effort: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HAND: ParallelGripper = ParallelGripper {
        finger_joints: [7, 8],
        max_width: 0.08,
        default_force: 20.0,
        max_force: 70.0,
        speed: 0.1,
        pad_friction: 1.0,
    };

    fn command(width: f64, force: f64) -> GripperCommand {
        GripperCommand {
            width,
            force,
            suction: 0,
            reserved: 0,
        }
    }

    #[test]
    fn fingers_are_led_at_their_speed_and_force_is_limited() {
        let mut drive = GripperDrive::new(&HAND, 0.04);
        drive.command(&command(0.0, 500.0), &HAND);
        let target = drive.step(&HAND, 2_000.0, 0.04);
        assert!((target.position - 0.0399).abs() < 1e-12 && (target.velocity + 0.1).abs() < 1e-12);
        assert_eq!(target.max_effort, 70.0);
        drive.command(&command(0.0, 0.0), &HAND);
        assert_eq!(drive.step(&HAND, 2_000.0, 0.04).max_effort, 20.0);
    }

    #[test]
    fn a_blocked_finger_opens_at_once() {
        let mut drive = GripperDrive::new(&HAND, 0.04);
        drive.command(&command(0.0, 20.0), &HAND);
        for _ in 0..1_000 {
            drive.step(&HAND, 2_000.0, 0.025);
        }
        let closed = drive.step(&HAND, 2_000.0, 0.025).position;
        assert!((closed - 0.013).abs() < 1e-9, "{closed}");
        drive.command(&command(0.08, 20.0), &HAND);
        let ticks = (0..1_000)
            .take_while(|_| drive.step(&HAND, 2_000.0, 0.025).position < 0.025)
            .count();
        assert!(ticks <= 121, "{ticks}");
    }
}
