//! Requests of the operator: which component executes which request.

use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{OperatorRequest, Validate};

use super::World;
use crate::operator::requests::accepted;

impl World {
    /// Executes a request of the operator; returns the code of the answer and a sentence for the
    /// person. Pause, resume, step, script and end are refused here: they belong to the process
    /// around the world.
    pub fn execute_request(
        &mut self,
        action: OperatorAction,
        request: &OperatorRequest,
    ) -> (ReplyCode, String) {
        if action == OperatorAction::Reset {
            let reset = self.reset();
            return self.operator.answer_to_reset(reset);
        }
        // Once, before any request reads a number: a pose that is not finite would reach the
        // engine.
        if let Err(invalid) = request.validate() {
            return (ReplyCode::OutOfRange, invalid.to_string());
        }
        let (engine, arms) = (&mut self.engine, &self.arms);
        let operator = &mut self.operator;
        match action {
            OperatorAction::Ping => accepted(),
            OperatorAction::Drag => operator.start_drag(engine, request),
            OperatorAction::Target => operator.set_target(arms, request),
            OperatorAction::Joints => operator.set_joints(engine, arms, request),
            OperatorAction::Break => operator.set_breakpoint(request),
            OperatorAction::Gripper => operator.command_gripper(engine, arms, request),
            OperatorAction::TaskStart => operator.start_task(),
            OperatorAction::TaskReset => operator.reset_task(),
            OperatorAction::TaskPause => operator.pause_task(true),
            OperatorAction::TaskResume => operator.pause_task(false),
            OperatorAction::DropParts => {
                let dropped = self.equipment.drop_parts(engine, request.count);
                operator.count_drop(dropped)
            }
            OperatorAction::AddBin => {
                let bin = (self.tick, request.count == 1);
                let added = self.equipment.add_bin(engine, &self.grippers, bin);
                operator.count_bin(added)
            }
            OperatorAction::Reset
            | OperatorAction::Pause
            | OperatorAction::Resume
            | OperatorAction::Step
            | OperatorAction::ScriptDone
            | OperatorAction::Speed
            | OperatorAction::End => (
                ReplyCode::NotInThisCell,
                "the world has no clock of its own".to_owned(),
            ),
        }
    }
}
