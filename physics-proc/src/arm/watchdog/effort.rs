//! Commands of efforts in place of joint positions.

use cell_model::Robot;
use cell_model::ramp::RampState;
use ipc_types::ArmCommand;
use ipc_types::arm::DriveMode;
use serde::{Deserialize, Serialize};

use super::point::commanded;
use super::{Accepted, Source, Watchdog};

/// How drives follow a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Mode {
    /// To its joint positions.
    Position,
    /// By its efforts alone.
    Effort,
}

impl Watchdog {
    /// Whether the drives give the efforts of the command alone.
    pub(crate) fn is_by_effort(&self) -> bool {
        self.mode == Mode::Effort && self.source == Source::Commands
    }

    /// Takes over a command of efforts; `false` for one of positions. The setpoint becomes the
    /// measured joint positions: the arm brakes from there, and the next command of positions
    /// continues from there.
    pub(super) fn takes_efforts(
        &mut self,
        command: &ArmCommand,
        id: Accepted,
        robot: &Robot,
    ) -> bool {
        if command.drive_mode != DriveMode::Effort.code() {
            return false;
        }
        for (index, spec) in robot.arm_specs().enumerate() {
            let measured = commanded(command, index);
            self.setpoint[index] = RampState {
                position: measured.position.clamp(spec.lower, spec.upper),
                velocity: measured.velocity.clamp(-spec.velocity, spec.velocity),
                acceleration: 0.0,
            };
            self.efforts[index] = command.joint_efforts[index];
        }
        self.anchor.clone_from(&self.setpoint);
        self.accepted = Some(id);
        self.mode = Mode::Effort;
        self.settled = false;
        self.astray = false;
        self.source = Source::Commands;
        true
    }
}
