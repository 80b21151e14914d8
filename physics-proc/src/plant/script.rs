//! The script of a run: which lines are due, and the requests that they become.

use cell_model::cells::script::{GripperWord, ScriptAction};
use cell_run::script_report::ScriptReply;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{Decision, GripperGoal, OperatorRequest, Pose, TICK_NS, Text};

use super::Plant;

/// The policy that moves to the operator's target, paused or not.
const FOLLOWS: &str = "follow";

impl Plant {
    /// Executes the lines that are due, up to one for the launcher.
    pub(super) fn run_script(&mut self, decision: Option<&Decision>) {
        let tick = self.world.tick();
        // Phases are noted before lines are taken: a line `at_phase` is due in the tick of the
        // change.
        if let Some(decision) = decision {
            self.script.observe(
                tick,
                decision.phase.as_str(),
                decision.phase_entry,
                &self.arms,
            );
        }
        // A line for the launcher stops the script: the order of lines is kept.
        while self.waiting.is_none() {
            let Some((line, action)) = self.script.next_due(tick) else {
                return;
            };
            if action.is_for_launcher() {
                if let ScriptAction::Pause { .. } = action {
                    // The launcher's answer ends it.
                    self.pause();
                }
                self.waiting = Some((line, action));
            } else {
                let reply = self.execute_line(&action, decision);
                self.note_script(line, &action, reply);
            }
        }
    }

    fn execute_line(
        &mut self,
        action: &ScriptAction,
        decision: Option<&Decision>,
    ) -> Result<(), String> {
        let policy = decision.map_or("", |decision| decision.policy.as_str());
        // Before the first decision the policy is the one of the command line.
        let policy = if policy.is_empty() {
            &self.policy
        } else {
            policy
        };
        // A target for an arm that the task moves would be overwritten by the next decision.
        let led = action.leads() && policy != FOLLOWS && !self.world.operator_leads();
        if led {
            return Err("the task leads the arm; `task_pause` gives it to the operator".to_owned());
        }
        let request = self.request_of(action);
        let request = request.ok_or_else(|| "this cell has no such object or arm".to_owned())?;
        let accepted = self.accepted;
        let reply = self.answer_request(&request);
        // A line is run again by the successor's own script: it must not be repeated as a request
        // with a number as well.
        self.accepted = accepted;
        match ReplyCode::from_code(reply.code) {
            Some(ReplyCode::Accepted) => Ok(()),
            _ => Err(reply.message.as_str().to_owned()),
        }
    }

    /// Keeps the reply to a line.
    pub(super) fn note_script(
        &mut self,
        line: u32,
        action: &ScriptAction,
        reply: Result<(), String>,
    ) {
        self.replies.push(ScriptReply {
            line,
            at_s: (self.world.tick() * TICK_NS) as f64 * 1.0e-9,
            action: action.name(),
            accepted: reply.is_ok(),
            reason: reply.err(),
        });
    }

    fn request_of(&self, action: &ScriptAction) -> Option<OperatorRequest> {
        let mut request = OperatorRequest::zeroed_at_identity();
        // A line of the script becomes an operator's request, so both have the same checks.
        let code = match action {
            ScriptAction::Drag { object, to, for_s } => {
                request.object = index_of(&self.objects, object)?;
                request.pose.position = *to;
                request.seconds = *for_s;
                OperatorAction::Drag
            }
            ScriptAction::Gripper { to, arm } => {
                request.arm = *arm;
                request.count = match to {
                    GripperWord::Open => GripperGoal::Open.code(),
                    GripperWord::Close => GripperGoal::Close.code(),
                };
                OperatorAction::Gripper
            }
            ScriptAction::Target {
                position,
                orientation_wxyz,
                arm,
            } => {
                request.arm = *arm;
                let present = || self.world.present_orientation(*arm);
                request.pose = unit(*position, orientation_wxyz.or_else(present)?);
                OperatorAction::Target
            }
            ScriptAction::DropParts { count } => {
                request.count = *count;
                OperatorAction::DropParts
            }
            ScriptAction::AddBin { flipped } => {
                request.count = u32::from(*flipped);
                OperatorAction::AddBin
            }
            ScriptAction::TaskStart {} => OperatorAction::TaskStart,
            ScriptAction::TaskPause {} => OperatorAction::TaskPause,
            ScriptAction::TaskResume {} => OperatorAction::TaskResume,
            ScriptAction::TaskReset {} => OperatorAction::TaskReset,
            ScriptAction::Pause { .. } => OperatorAction::Pause,
            ScriptAction::Resume {} => OperatorAction::Resume,
            ScriptAction::Reset {} => OperatorAction::Reset,
            ScriptAction::Speed { to } => {
                request.seconds = *to;
                OperatorAction::Speed
            }
            ScriptAction::Break { name, remove } => {
                request.name = Text::new(name);
                request.count = u32::from(!remove);
                OperatorAction::Break
            }
            // Lines for the launcher never arrive here; see `run_script`.
            _ => return None,
        };
        request.action = code.code();
        Some(request)
    }
}

/// The pose with a normalised orientation: people type rounded numbers.
fn unit(position: [f64; 3], orientation_wxyz: [f64; 4]) -> Pose {
    let length = orientation_wxyz.iter().map(|q| q * q).sum::<f64>().sqrt();
    Pose {
        position,
        orientation_wxyz: orientation_wxyz.map(|q| q / length),
    }
}

fn index_of(names: &[String], name: &str) -> Option<u32> {
    let index = names.iter().position(|n| n == name)?;
    u32::try_from(index).ok()
}
