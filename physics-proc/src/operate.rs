//! Requests of people.

use ipc_types::equipment::SupplyRefusal;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{GripperGoal, OperatorRequest, Validate};

use crate::convert;
use crate::drag::Drag;
use crate::world::World;

/// An answer: a code, and what to tell the person (empty when accepted).
type Reply = (ReplyCode, String);

impl World {
    /// Acts on a request. Pause, resume, step, script and end belong to the
    /// process around the world and are refused here.
    pub fn operate(&mut self, action: OperatorAction, request: &OperatorRequest) -> Reply {
        if let Err(invalid) = request.validate() {
            return (ReplyCode::OutOfRange, invalid.to_string());
        }
        match action {
            OperatorAction::Ping => accepted(),
            OperatorAction::Reset => self.reset_scene(),
            OperatorAction::Drag => self.drag(request),
            OperatorAction::Target => self.target(request),
            OperatorAction::Gripper => self.gripper(request),
            OperatorAction::TaskStart => self.start_task(),
            OperatorAction::TaskReset => self.reset_task(),
            OperatorAction::TaskPause => self.pause_task(true),
            OperatorAction::TaskResume => self.pause_task(false),
            OperatorAction::DropParts => self.operator_drops(request.count),
            OperatorAction::AddBin => self.operator_adds(request.count == 1),
            OperatorAction::Pause
            | OperatorAction::Resume
            | OperatorAction::Step
            | OperatorAction::ScriptDone
            | OperatorAction::End => (
                ReplyCode::NotInThisCell,
                "the world has no clock of its own".to_owned(),
            ),
        }
    }

    fn reset_scene(&mut self) -> Reply {
        match self.reset() {
            Ok(()) => accepted(),
            Err(error) => (ReplyCode::OutOfRange, error.to_string()),
        }
    }

    fn drag(&mut self, request: &OperatorRequest) -> Reply {
        let object = request.object as usize;
        let here = self.object_pose(object).filter(|_| self.is_here(object));
        let Some(pose) = here else {
            let count = self.objects.len();
            return (
                ReplyCode::UnknownObject,
                format!("object {object} is not here; this cell has {count}"),
            );
        };
        let target = request.pose.position;
        let far = target.iter().any(|x| x.abs() > 20.0);
        if far || request.seconds < 0.0 {
            return (
                ReplyCode::OutOfRange,
                "the place must be within 20 m and the time not negative".to_owned(),
            );
        }
        self.memory.drags.retain(|drag| drag.object != object);
        self.memory
            .drags
            .push(Drag::new(object, &pose, target, request.seconds));
        self.memory.drags.sort_by_key(|drag| drag.object);
        accepted()
    }

    fn arm_of(&self, request: &OperatorRequest) -> Result<u32, Reply> {
        if (request.arm as usize) < self.arms.len() {
            return Ok(request.arm);
        }
        let message = format!(
            "arm {} is not here; this cell has {}",
            request.arm,
            self.arms.len()
        );
        Err((ReplyCode::UnknownArm, message))
    }

    fn target(&mut self, request: &OperatorRequest) -> Reply {
        let arm = match self.arm_of(request) {
            Ok(arm) => arm,
            Err(reply) => return reply,
        };
        let panel = &mut self.memory.panel;
        // The panel speaks for one arm at a time: the hand of the one before
        // keeps what it was told, and that word is not for this one.
        if panel.target_arm != arm {
            panel.gripper = GripperGoal::Keep.code();
        }
        panel.target_arm = arm;
        panel.target_position = request.pose.position;
        panel.target_orientation_wxyz = request.pose.orientation_wxyz;
        count(&mut panel.target_seq)
    }

    fn gripper(&mut self, request: &OperatorRequest) -> Reply {
        let arm = match self.arm_of(request) {
            Ok(arm) => arm,
            Err(reply) => return reply,
        };
        if self
            .arms
            .get(arm as usize)
            .is_none_or(|arm| arm.robot.gripper.is_none() && arm.robot.suction.is_none())
        {
            return (
                ReplyCode::NotInThisCell,
                "this arm has no gripper".to_owned(),
            );
        }
        // Nor is the target of the arm before: this one stays where it is.
        if self.memory.panel.target_arm != arm {
            let here = convert::to_wire(&self.finite_tcp(arm as usize));
            let panel = &mut self.memory.panel;
            panel.target_arm = arm;
            panel.target_position = here.position;
            panel.target_orientation_wxyz = here.orientation_wxyz;
        }
        self.memory.panel.gripper = request.count;
        count(&mut self.memory.panel.gripper_seq)
    }

    fn operator_drops(&mut self, parts: u32) -> Reply {
        let Some(dispenser) = &self.equipment.dispenser else {
            let message = "this cell has no dispenser".to_owned();
            return (ReplyCode::NotInThisCell, message);
        };
        let parts = match parts {
            0 => dispenser.table.per_drop,
            parts => parts,
        };
        let left = self.parts_left();
        if left == 0 {
            let message = "no part is left; a reset of the scene brings them back".to_owned();
            return (ReplyCode::OutOfRange, message);
        }
        if parts > left {
            let message = format!("{parts} parts were asked for and {left} are left");
            return (ReplyCode::OutOfRange, message);
        }
        self.memory.equipment.dispenser.ask(parts);
        count(&mut self.memory.panel.drop_parts)
    }

    fn operator_adds(&mut self, flipped: bool) -> Reply {
        if self.equipment.supply.is_none() {
            let message = "this cell has no conveyor that brings bins".to_owned();
            return (ReplyCode::NotInThisCell, message);
        }
        let message = match self.add_bin(flipped) {
            Ok(()) => return count(&mut self.memory.panel.add_bin),
            Err(SupplyRefusal::NoneLeft) => "every bin is in the cell",
            Err(SupplyRefusal::TooManyWaiting) => "enough bins wait on the belt",
            Err(SupplyRefusal::CoolDown) => "the last bin came a moment ago; ask again",
            Err(SupplyRefusal::PlaceTaken | SupplyRefusal::None) => {
                "something stands where the bin would come"
            }
        };
        (ReplyCode::OutOfRange, message.to_owned())
    }

    fn start_task(&mut self) -> Reply {
        self.memory.panel.task_started = true;
        count(&mut self.memory.panel.task_start)
    }

    fn reset_task(&mut self) -> Reply {
        self.memory.panel.task_started = false;
        self.memory.panel.task_paused |= self.reset_pauses;
        count(&mut self.memory.panel.task_reset)
    }

    fn pause_task(&mut self, paused: bool) -> Reply {
        self.memory.panel.task_paused = paused;
        accepted()
    }
}

fn accepted() -> Reply {
    (ReplyCode::Accepted, String::new())
}

/// Counts a request; 0 stays "never".
fn count(counter: &mut u32) -> Reply {
    *counter = counter.checked_add(1).unwrap_or(1);
    accepted()
}
